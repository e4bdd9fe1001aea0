//! The camera from the centres of the board, and the compared method with it.

use anyhow::{Context, Result};
use concentric::{Camera, Covariance, Position, model::Plane};
use nalgebra::{Matrix3, Vector3};

use super::{
    scene::Stage,
    shot::{Found, Shot},
};
use crate::{
    calibrate::{Calibration, Options, Point, View, calibrate},
    measure::px,
};

/// What of a target goes into the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Centre of the inner ellipse, taken for the true centre, as in the paper.
    Inner,
    /// Centre of the outer ellipse, taken for the true centre.
    Outer,
    /// Centre of the inner ellipse, known to be one (Heikkila and Silven 1997).
    InnerCorrected,
    /// Centre of the outer ellipse, known to be one.
    OuterCorrected,
    /// Centre by eq. (7).
    Eq7,
    /// Centre with the correction shared by all targets of a view.
    Pooled,
}

impl Kind {
    /// The place, its covariance, and the radius of the circle whose ellipse it is the centre of, or 0.
    fn measured(self, found: &Found, radii: &[f64]) -> Option<(Position, Covariance, f64)> {
        let Found { target, pooled, .. } = found;
        let (large, small) = (*radii.first()?, *radii.last()?);
        let (outer, inner) = (target.circles.first()?, target.circles.last()?);
        Some(match self {
            Self::Inner => (inner.ellipse.centre, inner.covariance, 0.0),
            Self::Outer => (outer.ellipse.centre, outer.covariance, 0.0),
            Self::InnerCorrected => (inner.ellipse.centre, inner.covariance, small),
            Self::OuterCorrected => (outer.ellipse.centre, outer.covariance, large),
            Self::Eq7 => (target.eq7, target.covariance, 0.0),
            Self::Pooled => (*pooled, target.covariance, 0.0),
        })
    }
}

/// Focal lengths, principal point and two radial terms (Zhang 2000) from the plain targets; nothing is left out.
///
/// # Errors
/// What the calibration refuses.
pub fn camera(stages: &[Stage], shots: &[Shot], kind: Kind) -> Result<Calibration> {
    let views = stages.iter().zip(shots).map(|(stage, shot)| {
        let point = |found: &Found| {
            let target = stage.layout.targets.get(found.index).filter(|target| target.id.is_none())?;
            let (place, covariance, radius) = kind.measured(found, &target.radii)?;
            let covariance = [covariance.xx, covariance.xy, covariance.yy].map(f64::from);
            Some(Point { object: target.position, image: px(place), covariance, radius })
        };
        View {
            name: stage.name.clone(),
            size: stage.size.map(|side| side as u32),
            points: shot.found.iter().filter_map(point).collect(),
        }
    });
    let options = Options { radial: 2, tangential: false, passes: 0, ..Options::default() };
    Ok(calibrate(&views.collect::<Vec<_>>(), &options)?)
}

/// The compared method: eq. (3) with a camera and poses that were calibrated.
#[derive(Clone, Debug)]
pub struct Compared {
    camera: Camera,
    /// Of the views.
    poses: Vec<(Matrix3<f64>, Vector3<f64>)>,
}

impl Compared {
    /// With this camera and these poses.
    ///
    /// # Errors
    /// A camera that the library refuses.
    pub fn new(calibration: &Calibration) -> Result<Self> {
        let poses = calibration.views.iter().map(|view| (view.pose.rotation(), view.pose.tvec));
        Ok(Self { camera: calibration.intrinsics.camera()?, poses: poses.collect() })
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Normal of the board in a view, towards the camera.
    pub fn normal(&self, view: usize) -> Option<[f64; 3]> {
        let (rotation, tvec) = self.poses.get(view)?;
        let normal = rotation.column(2).into_owned();
        let towards = if normal.dot(tvec) > 0.0 { -normal } else { normal };
        Some(towards.into())
    }

    /// The true centre of the circle of `radius` mm at `object` on the board from its measured ellipse centre, px.
    ///
    /// # Errors
    /// A circle that the pose puts behind the camera, or a place where the lens folds the image.
    pub fn correct(&self, view: usize, object: [f64; 3], ellipse: Position, radius: f64) -> Result<[f64; 2]> {
        let corrected = || {
            let (rotation, tvec) = self.poses.get(view)?;
            let centre = rotation * Vector3::from(object) + tvec;
            let normal = rotation.column(2).into_owned();
            let (x, y) = Plane::new(1.0, centre.into(), normal.into())?.eccentricity(radius)?;
            let (fx, fy) = self.camera.focal_lengths();
            let shift = [x * f64::from(fx), y * f64::from(fy)];
            let Position { x, y } = self.camera.undistort(ellipse)?;
            let [dx, dy] = shift.map(|px| (px * f64::from(Position::SCALE)).round() as i32);
            self.camera.distort(Position { x: x - dx, y: y - dy }).map(px)
        };
        corrected().context("a target of the board is behind the calibrated camera")
    }
}
