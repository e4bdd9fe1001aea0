//! The ways to a centre that the study compares.

use anyhow::Result;
use concentric::{Covariance, Position, Settings, Target, TargetSpec};
use glam::DMat2;

use super::{bound::Bounds, cell::Cell};

/// How the library is asked; every way is run once a frame and serves several methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run {
    /// The ratio of the radii is given.
    Given,
    /// It is measured.
    Measured,
}

impl Run {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Given, Self::Measured];

    /// What the library is told.
    ///
    /// # Errors
    /// A ratio that the library refuses.
    pub fn settings(self, cell: &Cell) -> Result<Settings> {
        Ok(Settings::new(match self {
            Self::Given => TargetSpec::ring(cell.ratio as f32)?,
            Self::Measured => TargetSpec::any(),
        }))
    }
}

/// A way to a centre.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Its name in tables, and for `--method`.
    pub name: &'static str,
    /// How the library is asked.
    pub run: Run,
    /// The centre, and the covariance reported with it.
    pub pick: fn(&Target) -> Option<(Position, Covariance)>,
    /// The least covariance there is for it.
    pub bound: fn(&Bounds) -> DMat2,
}

/// The method that the goals are set for.
pub const MAIN: &str = "exact";

/// Every method, in the order of the tables.
pub const METHODS: [Method; 4] = [
    Method {
        name: "none",
        run: Run::Given,
        pick: |target| target.circles.first().map(|outer| (outer.ellipse.centre, outer.covariance)),
        bound: |bounds| bounds.outer,
    },
    Method {
        name: "eq7",
        run: Run::Given,
        pick: |target| Some((target.eq7, target.covariance)),
        bound: |bounds| bounds.centre,
    },
    Method {
        name: MAIN,
        run: Run::Given,
        pick: |target| Some((target.exact, target.covariance)),
        bound: |bounds| bounds.centre,
    },
    Method {
        name: "exact-any",
        run: Run::Measured,
        pick: |target| Some((target.exact, target.covariance)),
        bound: |bounds| bounds.centre,
    },
];
