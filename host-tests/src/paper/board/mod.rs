//! Section 4.2, figures 7 and 8: the board of 58 targets and five coded markers, seen from eight places.
//!
//! 1. [`scene`]: the board, the views.
//! 2. [`shot`]: a picture to targets with their places on the board.
//! 3. [`calibration`]: the camera from the ellipse centres; the compared method, eq. (3).
//! 4. [`level`]: both methods at a noise, against each other and against the truth.
//! 5. [`methods`]: every method named in the paper, what it needs and what it leaves.
//! 6. [`picture`]: figure 7.

pub mod calibration;
pub mod level;
pub mod methods;
pub mod picture;
pub mod scene;
pub mod shot;

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use rayon::prelude::*;

use self::{
    level::Level,
    methods::{Calibrated, Method},
    scene::Stage,
};
use super::printed::DEVIATION;

/// Standard deviations of a pixel, grey levels.
pub const NOISES: [f64; 9] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
/// That for which the methods are compared.
pub const USUAL: f64 = 2.0;

/// What came of the experiment.
#[derive(Clone, Debug)]
pub struct Board {
    /// The views, without noise.
    pub stages: Vec<Stage>,
    /// By noise, rising.
    pub levels: Vec<Level>,
    /// Every method on the same pictures.
    pub methods: Vec<Method>,
    /// The camera from each kind of centre.
    pub calibrated: Vec<Calibrated>,
}

impl Board {
    /// Number of steps that [`Board::new`] counts.
    pub const STEPS: u64 = (super::printed::VIEWS + NOISES.len() + 2) as u64;

    /// Renders the views and measures them.
    ///
    /// # Errors
    /// Views that cannot be identified, or from which no camera can be calibrated.
    pub fn new(progress: &ProgressBar) -> Result<Self> {
        let stages = scene::stages(progress)?;
        let level = |&noise: &f64| {
            let level = Level::new(&stages, noise).with_context(|| format!("board, noise {noise}"));
            progress.inc(1);
            level
        };
        let levels = NOISES.par_iter().map(level).collect::<Result<Vec<_>>>()?;
        let (methods, calibrated) = methods::compare(&stages, progress)?;
        Ok(Self { stages, levels, methods, calibrated })
    }

    /// The noisiest level at which all deviations are as small as the paper says.
    pub fn implied(&self) -> Option<&Level> {
        let small = |level: &&Level| level.deviation.largest < DEVIATION;
        self.levels.iter().take_while(small).last()
    }
}
