//! The ways to a centre that the study compares.

use anyhow::Result;
use concentric::{Compensation, Position, Settings, Target, TargetSpec};
use glam::DMat2;

use super::{bound::Bounds, cell::Cell};

/// How the library is asked; every way is run once a frame and serves several methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run {
    /// The ratio of the radii is given.
    Given(Compensation),
    /// It is measured.
    Measured(Compensation),
}

impl Run {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Given(Compensation::Exact),
        Self::Given(Compensation::None),
        Self::Given(Compensation::Auto),
        Self::Measured(Compensation::Exact),
    ];

    /// What the library is told.
    ///
    /// # Errors
    /// A ratio that the library refuses.
    pub fn settings(self, cell: &Cell) -> Result<Settings> {
        let (spec, compensation) = match self {
            Self::Given(compensation) => (TargetSpec::ring(cell.ratio as f32)?, compensation),
            Self::Measured(compensation) => (TargetSpec::any(), compensation),
        };
        Ok(Settings::new(spec).compensation(compensation))
    }
}

/// A way to a centre.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Its name in tables, and for `--method`.
    pub name: &'static str,
    /// How the library is asked.
    pub run: Run,
    /// The centre; its covariance is that of the target.
    pub centre: fn(&Target) -> Position,
    /// The least covariance there is for it.
    pub bound: fn(&Bounds) -> DMat2,
}

/// The method that the goals are set for.
pub const MAIN: &str = "exact";

/// Every method, in the order of the tables. Eq. (7) has the covariance of the exact form: they differ by far less.
pub const METHODS: [Method; 5] = [
    Method {
        name: "none",
        run: Run::Given(Compensation::None),
        centre: |target| target.centre,
        bound: |bounds| bounds.outer,
    },
    Method {
        name: "eq7",
        run: Run::Given(Compensation::Exact),
        centre: |target| target.eq7,
        bound: |bounds| bounds.centre,
    },
    Method {
        name: MAIN,
        run: Run::Given(Compensation::Exact),
        centre: |target| target.centre,
        bound: |bounds| bounds.centre,
    },
    Method {
        name: "auto",
        run: Run::Given(Compensation::Auto),
        centre: |target| target.centre,
        bound: |bounds| bounds.centre,
    },
    Method {
        name: "exact-any",
        run: Run::Measured(Compensation::Exact),
        centre: |target| target.centre,
        bound: |bounds| bounds.centre,
    },
];
