//! The ways to a centre that the study compares.

use anyhow::Result;
use concentric::{
    Camera, Compensation, Distortion, Effort, Image, Position, Settings, Target, TargetSpec, coplanar::pool,
    refine::polish,
};
use glam::DMat2;

use super::{bound::Bounds, cell::Cell};
use crate::render;

/// How the library is asked; every way is run once a frame and serves several methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The form of the centre.
    pub compensation: Compensation,
    /// What is done for its accuracy.
    pub effort: Effort,
    /// What it is told.
    pub told: Told,
    /// What comes after.
    pub after: After,
}

/// What the library is told besides the form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// Nothing: the ratio of the radii is measured.
    Nothing,
    /// The ratio of the radii.
    Ratio,
    /// The ratio and the camera.
    Camera,
}

/// What is done with the targets of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum After {
    /// Nothing.
    Rows,
    /// Each is refined on the pixels; it stays as it was where that fails.
    Refined,
    /// Those of a board share the correction.
    Pooled,
}

impl Run {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::EXACT,
        Self { compensation: Compensation::None, ..Self::EXACT },
        Self { compensation: Compensation::Auto, ..Self::EXACT },
        Self { told: Told::Nothing, ..Self::EXACT },
        Self { told: Told::Camera, after: After::Refined, ..Self::EXACT },
        Self::KNOWN,
        Self { after: After::Refined, ..Self::EXACT },
        Self { after: After::Refined, ..Self::KNOWN },
        Self { after: After::Pooled, ..Self::EXACT },
        Self { effort: Effort::Quick, ..Self::EXACT },
    ];
    const EXACT: Self = Self {
        compensation: Compensation::Exact,
        effort: Effort::Full,
        told: Told::Ratio,
        after: After::Rows,
    };
    const KNOWN: Self = Self { compensation: Compensation::Known, told: Told::Camera, ..Self::EXACT };

    /// Whether it makes sense for this cell.
    pub fn concerns(self, cell: &Cell) -> bool {
        self.after != After::Pooled || cell.targets > 1
    }

    /// What the library is told.
    ///
    /// # Errors
    /// A ratio or a camera that the library refuses.
    pub fn settings(self, cell: &Cell, lens: &render::Camera) -> Result<Settings> {
        let spec = match self.told {
            Told::Nothing => TargetSpec::any(),
            Told::Ratio | Told::Camera => TargetSpec::ring(cell.ratio as f32)?,
        };
        let settings = Settings::new(spec).compensation(self.compensation).effort(self.effort);
        Ok(if self.told == Told::Camera { settings.camera(camera(lens)?) } else { settings })
    }

    /// What comes after the targets of a frame were found.
    ///
    /// # Errors
    /// Targets of a board that share no plane.
    pub fn finish(self, targets: &mut [Target], settings: &Settings, image: &Image) -> Result<()> {
        match self.after {
            After::Rows => {}
            // Whether it is refined is among its flags.
            After::Refined => targets.iter_mut().for_each(|target| _ = polish(image, settings, target)),
            After::Pooled => _ = pool(targets, settings.camera.as_ref())?,
        }
        Ok(())
    }
}

/// The camera of a scene as the library takes it.
fn camera(lens: &render::Camera) -> Result<Camera> {
    let [f, cx, cy] = [lens.f, lens.cx, lens.cy].map(|value| value as f32);
    let d = lens.distortion;
    let [k1, k2, p1, p2] = [d.k1, d.k2, d.p1, d.p2].map(|k| k as f32);
    Ok(Camera::new(f, f, cx, cy)?.distortion(Distortion { k1, k2, p1, p2, k3: 0.0 })?)
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

impl Method {
    /// With the bound of the exact form.
    const fn new(name: &'static str, run: usize) -> Self {
        Self { name, run: Run::ALL[run], centre: |target| target.centre, bound: |bounds| bounds.centre }
    }
}

/// The method that the goals are set for, ...
pub const MAIN: &str = "exact";
/// ... and the same after the refinement.
pub const REFINED: &str = "refined";

/// The method with less effort.
pub const QUICK: &str = "quick";

/// Every method, in the order of the tables. Eq. (7) has the covariance of the exact form: they differ by far less.
/// `undistorted` is `refined` with the camera given. `pooled` is only for boards, and is compared with the bound of a target by itself.
pub const METHODS: [Method; 11] = [
    Method { bound: |bounds| bounds.outer, ..Method::new("none", 1) },
    Method { centre: |target| target.eq7, ..Method::new("eq7", 0) },
    Method::new(MAIN, 0),
    Method::new(REFINED, 6),
    Method::new("auto", 2),
    Method::new("exact-any", 3),
    Method::new("undistorted", 4),
    Method { bound: |bounds| bounds.known, ..Method::new("known", 5) },
    Method { bound: |bounds| bounds.known, ..Method::new("known-refined", 7) },
    Method::new("pooled", 8),
    Method::new(QUICK, 9),
];
