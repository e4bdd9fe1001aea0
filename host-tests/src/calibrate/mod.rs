//! Calibration: from points of known place on an object and where views show them, to the camera.
//!
//! 1. [`View`], [`Point`]: what was measured, with covariances.
//! 2. [`calibrate`]: closed form (Zhang 2000), bundle adjustment weighted by the covariances, points that contradict the others
//!    left out in a bounded number of passes.
//! 3. [`Calibration`]: the [`Intrinsics`] with standard deviations, a [`Pose`] and the residuals of each view.
//!
//! Lengths in the image are px, pixel centres at integer coordinates; on the object mm. The camera's model is the library's
//! ([`concentric::Camera`]), which is OpenCV's.

mod adjust;
pub mod command;
mod error;
pub mod file;
pub mod input;
mod listing;
mod model;
pub mod plots;
mod solve;
mod start;

pub use error::CalibrationError;
pub use model::{COUNT, Intrinsics, Placed, Pose, Projection};
pub use solve::calibrate;

use nalgebra::DMatrix;

/// Fewest views.
pub const MIN_VIEWS: usize = 4;
/// Fewest points of a view: a homography takes four.
pub const MIN_POINTS: usize = 4;

/// A point of the object and where a view shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// On the object, mm.
    pub object: [f64; 3],
    /// In the image, px.
    pub image: [f64; 2],
    /// Covariance `(xx, xy, yy)` of the image, px^2.
    pub covariance: [f64; 3],
    /// 0 if `image` is where the point itself appears. Else it is the centre of the ellipse as which a circle of this radius
    /// (mm) about the point appears; the eccentricity is then taken into account with the pose and the camera of the
    /// moment (Heikkila and Silven 1997, "A four-step camera calibration procedure with implicit image correction",
    /// section 3.2, here by the exact conic and with the lens distortion within the ellipse).
    pub radius: f64,
}

/// A view of the object.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Name for messages.
    pub name: String,
    /// Width and height of the frame, px.
    pub size: [u32; 2],
    /// Its points.
    pub points: Vec<Point>,
}

/// What is estimated, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// `fx = fy`.
    pub same_focal: bool,
    /// Number of radial terms, 0 to 3; the rest is 0.
    pub radial: u8,
    /// Whether the lens has tangential terms; else they are 0.
    pub tangential: bool,
    /// Whether points count by their covariances; else all are alike.
    pub weighted: bool,
    /// Most times that contradicting points are left out and the rest adjusted anew. 0: none is left out.
    pub passes: u32,
}

impl Default for Options {
    /// OpenCV's model of five coefficients, weighted.
    fn default() -> Self {
        Self { same_focal: false, radial: 3, tangential: true, weighted: true, passes: 5 }
    }
}

impl Options {
    /// Parameters that are estimated, by [`Intrinsics::NAMES`]; those in one entry are the same.
    fn free(&self) -> Vec<Vec<usize>> {
        let focal = if self.same_focal { vec![vec![0, 1]] } else { vec![vec![0], vec![1]] };
        let radial = [4, 5, 8].into_iter().take(self.radial.into());
        let tangential = [6, 7].into_iter().filter(|_| self.tangential);
        let rest = [2, 3].into_iter().chain(radial).chain(tangential).map(|parameter| vec![parameter]);
        focal.into_iter().chain(rest).collect()
    }
}

/// What a point leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Where it was measured, px.
    pub image: [f64; 2],
    /// That minus its projection, px.
    pub shift: [f64; 2],
    /// Length of the shift in standard deviations of the point (px where points are not weighted).
    pub normalised: f64,
    /// Whether the point took part in the end.
    pub kept: bool,
}

/// A view after the adjustment.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Its name.
    pub name: String,
    /// Where the object stands.
    pub pose: Pose,
    /// Standard deviations of `rvec` (radians) and `tvec` (mm).
    pub sigma: [f64; 6],
    /// Its points, in their order.
    pub residuals: Vec<Residual>,
    /// RMS length of the shifts of kept points, px.
    pub rms: f64,
}

/// A calibrated camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Width and height of the frames, px.
    pub size: [u32; 2],
    /// The camera.
    pub intrinsics: Intrinsics,
    /// Standard deviations of its parameters, 0 for one that is fixed.
    pub sigma: Intrinsics,
    /// Covariance of its parameters, by [`Intrinsics::NAMES`].
    pub covariance: DMatrix<f64>,
    /// The views, in their order.
    pub views: Vec<Fitted>,
    /// RMS length of the shifts of all kept points, px.
    pub rms: f64,
    /// Sum of squared normalised residuals over their expected number: 1 if points are as exact as their covariances say.
    /// Above 1 the standard deviations are enlarged by its root.
    pub variance_factor: f64,
    /// Times that points were left out.
    pub passes: u32,
    /// Largest angle between the object's normals in two views, degrees.
    pub angle: f64,
}

impl Calibration {
    /// Number of points that were left out.
    pub fn rejected(&self) -> usize {
        self.views.iter().map(Fitted::rejected).sum()
    }

    /// Number of points that took part.
    pub fn kept(&self) -> usize {
        self.views.iter().map(|view| view.residuals.len()).sum::<usize>() - self.rejected()
    }
}

impl Fitted {
    /// Number of points that were left out.
    pub fn rejected(&self) -> usize {
        self.residuals.iter().filter(|residual| !residual.kept).count()
    }
}
