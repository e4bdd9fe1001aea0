//! Section 4.2, figure 6: one picture of a single target, radii 120 and 60 mm, about 1 m away, at about 45 degrees.

use anyhow::{Context, Result};
use concentric::{Settings, Target, TargetSpec, model::Scene as Model};

use super::simulation::RATIO;
use crate::{
    detect::{self, Outcome},
    measure::{distance, px},
    overlay::{Canvas, Overlay},
    picture::Picture,
    render::{Mark, Scene},
};

/// Outer radius, mm.
pub const RADIUS: f64 = 120.0;
/// From the camera, mm.
pub const DISTANCE: f64 = 1000.0;
/// Degrees.
pub const TILT: f64 = 45.0;
const AZIMUTH: f64 = 205.0;
const SEED: u64 = 6;

/// The picture and what was found.
#[derive(Clone, Debug)]
pub struct Single {
    picture: Picture,
    outcome: Outcome,
    /// Where the centre really is.
    pub truth: [f64; 2],
    /// Name, place, distance from the true centre, px.
    pub centres: [(&'static str, [f64; 2], f64); 4],
    /// Semi-axes of the outer ellipse, px.
    pub axes: [f64; 2],
    /// Standard deviation of one coordinate of the centre as the library reports it, px.
    pub sigma: f64,
    /// What eq. (7) leaves by the model with known geometry, px.
    pub residual: f64,
}

/// Renders and measures the picture.
///
/// # Errors
/// A target that is not found.
pub fn run() -> Result<Single> {
    let mut scene = Scene::single(RADIUS, TILT, AZIMUTH, [8.3, -5.6]);
    let target = scene.targets.first_mut().context("a target")?;
    target.pose.distance = DISTANCE;
    target.artwork.mark = Some(Mark::Plus);
    let frame = scene.render(SEED);
    let truth = frame.truth.targets.first().map(|target| [target.x, target.y]).context("a target")?;
    let picture = Picture::new("figure 6", frame.width, frame.height, frame.pixels)?;
    let outcome = detect::run(&picture, Settings::new(TargetSpec::ring(RATIO as f32)?))?;
    let found = outcome.targets.first().context("the single target is not found")?;
    let (centres, axes) = centres(found, truth).context("the single target has two circles")?;
    let tilt = TILT.to_radians();
    let model = Model::new(scene.camera.f, 0.0, DISTANCE, tilt, tilt).context("a plane before the camera")?;
    let (u, v) = model.residual(RADIUS, RATIO * RADIUS);
    let sigma = f64::from((found.covariance.xx + found.covariance.yy) / 2.0).sqrt();
    Ok(Single { truth, centres, axes, sigma, residual: u.hypot(v), picture, outcome })
}

type Centres = [(&'static str, [f64; 2], f64); 4];

fn centres(target: &Target, truth: [f64; 2]) -> Option<(Centres, [f64; 2])> {
    let (outer, inner) = (target.circles.first()?.ellipse, target.circles.last()?.ellipse);
    let places = [
        ("B1, centre of the outer ellipse", outer.centre),
        ("B2, centre of the inner ellipse", inner.centre),
        ("C by eq. (7)", target.eq7),
        ("C by the exact form", target.exact),
    ];
    let centres = places.map(|(name, place)| (name, px(place), distance(px(place), truth)));
    Some((centres, [outer.a, outer.b].map(f64::from)))
}

impl Single {
    /// The picture with the centres on it, and its middle enlarged.
    ///
    /// # Errors
    /// No memory for it.
    pub fn overlay(&self) -> Result<Canvas> {
        Overlay { picture: &self.picture, outcome: &self.outcome, truth: &[self.truth] }.draw()
    }
}
