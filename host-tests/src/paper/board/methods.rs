//! Every method that the paper names, and those of the library, on the same pictures of the board.

use anyhow::{Context, Result};
use concentric::{Camera, Target};
use indicatif::ProgressBar;

use super::{
    USUAL,
    calibration::{Compared, Kind, camera},
    level::{Spread, less, plain, shots},
    scene::{RADII, Stage},
    shot::{Found, Told},
};
use crate::{
    measure::{distance, px},
    paper::one_circle,
};

/// What a method needs beside the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Needs {
    /// The camera: focal length, principal point, distortion.
    pub camera: bool,
    /// Where the target is.
    pub pose: bool,
    /// The circle's radius, mm.
    pub radius: bool,
    /// Two circles, and the ratio of their radii.
    pub ratio: bool,
    /// Several views of the same targets.
    pub views: bool,
    /// Anything else.
    pub other: &'static str,
}

/// A way to the true centre.
#[derive(Clone, Debug)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// What it needs.
    pub needs: Needs,
    /// What it leaves without noise, and at the [`USUAL`] one.
    pub left: [Spread; 2],
}

/// A camera from one kind of centre.
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// What went into it.
    pub name: &'static str,
    /// Its errors without noise, and at the [`USUAL`] one.
    pub errors: [CameraErrors; 2],
}

/// How far a calibrated camera is from the true one, px.
#[derive(Clone, Copy, Debug, Default)]
pub struct CameraErrors {
    /// Mean of the two focal lengths.
    pub focal_length: f64,
    /// Reported standard deviation of one of them.
    pub sigma: f64,
    /// Distance of the principal points.
    pub principal_point: f64,
    /// RMS distance of the measured places from the projected ones.
    pub reprojection: f64,
}

const NOTHING: Needs =
    Needs { camera: false, pose: false, radius: false, ratio: false, views: false, other: "" };
const CAMERA: Needs = Needs { camera: true, ..NOTHING };
const RATIO: Needs = Needs { ratio: true, ..NOTHING };
const GEOMETRY: Needs = Needs { pose: true, radius: true, views: true, ..CAMERA };

const NAMES: [(&str, Needs); 11] = [
    ("centre of the outer ellipse", NOTHING),
    ("centre of the inner ellipse", NOTHING),
    ("eq. (7)", RATIO),
    ("exact form of eq. (7)", RATIO),
    ("pencil of conics, ratio measured", Needs { other: "a second circle", ..NOTHING }),
    ("eq. (3), outer ellipse (Ahn et al. 1999)", GEOMETRY),
    ("eq. (3), inner ellipse: the compared method", GEOMETRY),
    ("eq. (3), inner, camera by Heikkila and Silven 1997", GEOMETRY),
    ("one circle, known camera (Otepka 2004)", Needs { other: "which of two planes", ..CAMERA }),
    ("two circles, known camera", Needs { ratio: true, ..CAMERA }),
    ("correction shared by a plane", Needs { other: "more targets on the plane", ..RATIO }),
];

const KINDS: [(&str, Kind); 6] = [
    ("centre of the inner ellipse", Kind::Inner),
    ("centre of the outer ellipse", Kind::Outer),
    ("the same, corrected inside (Heikkila and Silven 1997), inner", Kind::InnerCorrected),
    ("the same, corrected inside, outer", Kind::OuterCorrected),
    ("eq. (7)", Kind::Eq7),
    ("correction shared by a plane", Kind::Pooled),
];

/// All methods and cameras.
///
/// # Errors
/// What the detector, the matching or the calibration refuses.
pub fn compare(stages: &[Stage], progress: &ProgressBar) -> Result<(Vec<Method>, Vec<Calibrated>)> {
    let at = |noise: f64| {
        let result = Trial::new(stages, noise);
        progress.inc(1);
        result
    };
    let [clean, noisy] = [at(0.0)?, at(USUAL)?];
    let methods = NAMES.into_iter().enumerate().map(|(i, (name, needs))| Method {
        name,
        needs,
        left: [clean.left[i], noisy.left[i]],
    });
    let calibrated = KINDS
        .into_iter()
        .enumerate()
        .map(|(i, (name, _))| Calibrated { name, errors: [clean.cameras[i], noisy.cameras[i]] });
    Ok((methods.collect(), calibrated.collect()))
}

/// All methods at a noise.
struct Trial {
    /// By [`NAMES`].
    left: [Spread; NAMES.len()],
    /// By [`KINDS`].
    cameras: [CameraErrors; KINDS.len()],
}

impl Trial {
    fn new(stages: &[Stage], noise: f64) -> Result<Self> {
        let rows = shots(stages, noise, Told::Ratio)?;
        let any = shots(stages, noise, Told::Nothing)?;
        let calibrations =
            KINDS.iter().map(|(_, kind)| camera(stages, &rows, *kind)).collect::<Result<Vec<_>>>()?;
        let truth = stages.first().context("a view")?.camera;
        let mut cameras = [CameraErrors::default(); KINDS.len()];
        for (errors, calibration) in cameras.iter_mut().zip(&calibrations) {
            let (found, sigma) = (calibration.intrinsics, calibration.sigma);
            *errors = CameraErrors {
                focal_length: (found.fx + found.fy) / 2.0 - truth.f,
                sigma: sigma.fx,
                principal_point: distance([found.cx, found.cy], [truth.cx, truth.cy]),
                reprojection: calibration.rms,
            };
        }
        let [raw, implicit] = [&calibrations[0], &calibrations[2]].map(Compared::new);
        let (raw, implicit) = (raw?, implicit?);
        let known = shots(stages, noise, Told::Camera(implicit.camera()))?;
        let mut left = [(); NAMES.len()].map(|()| Vec::new());
        for (view, stage) in stages.iter().enumerate() {
            let ellipse = |found: &Found, k: usize| found.target.circles.get(k).map(|circle| circle.ellipse);
            for (found, object, truth) in plain(stage, &rows[view]) {
                let (outer, inner) = ellipse(found, 0).zip(ellipse(found, 1)).context("two circles")?;
                let corrected = |by: &Compared, centre, radius| by.correct(view, object, centre, radius);
                let places = [
                    (0, px(outer.centre)),
                    (1, px(inner.centre)),
                    (2, px(found.target.eq7)),
                    (3, px(found.target.exact)),
                    (5, corrected(&raw, outer.centre, RADII[0])?),
                    (6, corrected(&raw, inner.centre, RADII[1])?),
                    (7, corrected(&implicit, inner.centre, RADII[1])?),
                    (10, px(found.pooled)),
                ];
                places.into_iter().for_each(|(method, place)| left[method].push(less(place, truth)));
            }
            for (found, _, truth) in plain(stage, &any[view]) {
                left[4].push(less(px(found.target.exact), truth));
            }
            let normal = implicit.normal(view).context("a pose of each view")?;
            for (found, _, truth) in plain(stage, &known[view]) {
                let place = one_circle(&found.target, &implicit.camera(), normal);
                left[8].push(less(place.context("a circle before the camera")?, truth));
                left[9].push(less(px(found.target.centre), truth));
            }
        }
        Ok(Self { left: left.map(Spread::of), cameras })
    }
}

/// The centre from the outer ellipse alone; of the two planes the one nearer to `normal`.
fn one_circle(target: &Target, camera: &Camera, normal: [f64; 3]) -> Option<[f64; 2]> {
    let along = |candidate: &one_circle::Candidate| -> f64 {
        candidate.normal.iter().zip(normal).map(|(a, b)| a * b).sum()
    };
    let candidates = one_circle::candidates(&target.circles.first()?.ellipse, camera)?;
    candidates.into_iter().max_by(|a, b| along(a).total_cmp(&along(b))).map(|candidate| candidate.centre)
}
