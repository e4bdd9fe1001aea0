//! Every method that the paper names, and those of the library, on the same pictures of the board.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use concentric::{Camera, Target};
use indicatif::ProgressBar;

use super::{
    USUAL,
    calibration::{Compared, Kind, camera},
    level::{Spread, less, plain, shots},
    scene::Stage,
    shot::{Shot, Told},
};
use crate::{measure::px, paper::one_circle};

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
    /// The camera without noise, and at the [`USUAL`] one.
    pub cameras: [Figures; 2],
}

/// A calibrated camera, px.
#[derive(Clone, Copy, Debug, Default)]
pub struct Figures {
    /// Mean of the two focal lengths.
    pub focal_length: f64,
    /// Reported standard deviation of one of them.
    pub sigma: f64,
    /// Principal point.
    pub principal_point: [f64; 2],
    /// RMS distance of the measured places from the projected ones.
    pub reprojection: f64,
}

const NOTHING: Needs =
    Needs { camera: false, pose: false, radius: false, ratio: false, views: false, other: "" };
const CAMERA: Needs = Needs { camera: true, ..NOTHING };
const RATIO: Needs = Needs { ratio: true, ..NOTHING };
const GEOMETRY: Needs = Needs { pose: true, radius: true, views: true, ..CAMERA };

/// The methods.
pub const NAMES: [(&str, Needs); 11] = [
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

/// What cameras are calibrated from.
pub const KINDS: [(&str, Kind); 6] = [
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
        .map(|(i, (name, _))| Calibrated { name, cameras: [clean.cameras[i], noisy.cameras[i]] });
    Ok((methods.collect(), calibrated.collect()))
}

/// All methods on the same pictures.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What is left of the true centres by [`NAMES`]; of those by eq. (7) where the truth is not known.
    pub left: [Spread; NAMES.len()],
    /// By [`KINDS`].
    pub cameras: [Figures; KINDS.len()],
    /// Plain targets found and identified.
    pub targets: usize,
}

/// What a trial goes through.
struct Shots {
    /// The library is told the ratio.
    ratio: Vec<Shot>,
    /// It is told nothing.
    nothing: Vec<Shot>,
    /// It is told the camera.
    camera: Vec<Shot>,
    /// Eq. (3) with a camera from the inner ellipses' centres.
    raw: Compared,
    /// The same with one that allows for these being no true centres.
    implicit: Compared,
}

impl Trial {
    /// Of pictures of a board, rendered ones with this noise.
    ///
    /// # Errors
    /// What the detector, the matching or the calibration refuses.
    pub fn new(stages: &[Stage], noise: f64) -> Result<Self> {
        let ratio = shots(stages, noise, Told::Ratio)?;
        let calibrations =
            KINDS.iter().map(|(_, kind)| camera(stages, &ratio, *kind)).collect::<Result<Vec<_>>>()?;
        let mut cameras = [Figures::default(); KINDS.len()];
        for (figures, calibration) in cameras.iter_mut().zip(&calibrations) {
            let (found, sigma) = (calibration.intrinsics, calibration.sigma);
            *figures = Figures {
                focal_length: (found.fx + found.fy) / 2.0,
                sigma: sigma.fx,
                principal_point: [found.cx, found.cy],
                reprojection: calibration.rms,
            };
        }
        let of = |wanted: Kind| {
            let index = KINDS.iter().position(|(_, kind)| *kind == wanted).context("a kind of centre")?;
            Compared::new(&calibrations[index])
        };
        let implicit = of(Kind::InnerCorrected)?;
        let all = Shots {
            nothing: shots(stages, noise, Told::Nothing)?,
            camera: shots(stages, noise, Told::Camera(implicit.camera()))?,
            ratio,
            raw: of(Kind::Inner)?,
            implicit,
        };
        let mut left = [(); NAMES.len()].map(|()| Vec::new());
        for (view, stage) in stages.iter().enumerate() {
            for (method, shift) in all.view(view, stage)? {
                left[method].push(shift);
            }
        }
        Ok(Self { targets: left[0].len(), left: left.map(Spread::of), cameras })
    }
}

impl Shots {
    /// The method, by [`NAMES`], and what it leaves, for every target of a view.
    fn view(&self, view: usize, stage: &Stage) -> Result<Vec<(usize, [f64; 2])>> {
        let mut left = Vec::new();
        let mut reference = BTreeMap::new();
        for (found, printed) in plain(stage, &self.ratio[view]) {
            let eq7 = px(found.target.eq7);
            let truth = stage.centre(found.index).unwrap_or(eq7);
            reference.insert(found.index, truth);
            let (outer, inner) = ends(&found.target.circles).context("a target has circles")?;
            let (large, small) = ends(&printed.radii).context("a target has radii")?;
            let (outer, inner) = (outer.ellipse.centre, inner.ellipse.centre);
            let eq3 = |by: &Compared, ellipse, radius| by.correct(view, printed.position, ellipse, radius);
            let places = [
                (0, px(outer)),
                (1, px(inner)),
                (2, eq7),
                (3, px(found.target.exact)),
                (5, eq3(&self.raw, outer, *large)?),
                (6, eq3(&self.raw, inner, *small)?),
                (7, eq3(&self.implicit, inner, *small)?),
                (10, px(found.pooled)),
            ];
            left.extend(places.map(|(method, place)| (method, less(place, truth))));
        }
        for (found, _) in plain(stage, &self.nothing[view]) {
            let Some(&truth) = reference.get(&found.index) else { continue };
            left.push((4, less(px(found.target.exact), truth)));
        }
        let normal = self.implicit.normal(view).context("a pose of each view")?;
        for (found, _) in plain(stage, &self.camera[view]) {
            let Some(&truth) = reference.get(&found.index) else { continue };
            let place = one_circle(&found.target, &self.implicit.camera(), normal);
            left.push((8, less(place.context("a circle before the camera")?, truth)));
            left.push((9, less(px(found.target.centre), truth)));
        }
        Ok(left)
    }
}

/// The first and the last.
fn ends<T>(all: &[T]) -> Option<(&T, &T)> {
    Some((all.first()?, all.last()?))
}

/// The centre from the outer ellipse alone; of the two planes the one nearer to `normal`.
fn one_circle(target: &Target, camera: &Camera, normal: [f64; 3]) -> Option<[f64; 2]> {
    let along = |candidate: &one_circle::Candidate| -> f64 {
        candidate.normal.iter().zip(normal).map(|(a, b)| a * b).sum()
    };
    let candidates = one_circle::candidates(&target.circles.first()?.ellipse, camera)?;
    candidates.into_iter().max_by(|a, b| along(a).total_cmp(&along(b))).map(|candidate| candidate.centre)
}
