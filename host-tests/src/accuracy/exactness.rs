//! The closed forms on exact conics: no picture, no noise, only perspective and arithmetic.

use concentric::centre::{Real, perspective, weights};
use glam::DVec2;

use crate::render::{Artwork, Camera, Ellipse, Pose, Scene, Target};

/// A steep circle close to the camera: 60 mm at 200 mm, tilted by 80 degrees.
const RADIUS: f64 = 60.0;
const DISTANCE: f64 = 200.0;
const TILT: f64 = 80.0;
const RATIO: f64 = 0.5;

/// How far the centre from the two exact ellipses is from the true one, px.
#[derive(Clone, Copy, Debug)]
pub struct Exactness {
    /// By eq. (7) of Huo et al. 2013.
    pub eq7: f64,
    /// By the exact form, in f64.
    pub exact: f64,
    /// By the exact form, in f32 about the outer ellipse's centre, as on the device.
    pub device: f64,
}

/// With a camera that shows the outer circle with a semi-major axis of about `size` px.
pub fn exactness(size: f64) -> Exactness {
    let camera = Camera::new(4096, 4096, size * DISTANCE / RADIUS);
    let pose = Pose { x: 2048.3, y: 2047.6, distance: DISTANCE, tilt: TILT, azimuth: 20.0 };
    let artwork = Artwork::annulus(RADIUS, RATIO * RADIUS);
    let mut scene = Scene::empty(camera);
    scene.targets.push(Target { artwork, pose, at: [0.0, 0.0] });
    let truth = scene.truth(0).targets.remove(0);
    let [outer, inner] = [truth.circles[0].ellipse, truth.circles[1].ellipse];
    let between = DVec2::new(inner.x - outer.x, inner.y - outer.y);
    let true_centre = DVec2::new(truth.x - outer.x, truth.y - outer.y);
    let off = |centre: [f64; 2]| (DVec2::from(centre) - true_centre).length();
    Exactness {
        eq7: off(centre(&outer, between, false, |value| value)),
        exact: off(centre(&outer, between, true, |value| value)),
        device: off(centre(&outer, between, true, |value| value as f32)),
    }
}

/// The true centre about that of the outer ellipse, calculated in `T`.
fn centre<T: Real + Into<f64>>(
    outer: &Ellipse,
    between: DVec2,
    exact: bool,
    real: impl Fn(f64) -> T,
) -> [f64; 2] {
    // D' A D, with D along the axes of the outer ellipse in units of these.
    let along = DVec2::from_angle(-outer.theta).rotate(between) / DVec2::new(outer.a, outer.b);
    let (x, y) = (real(along.x), real(along.y));
    let t = if exact { perspective(x * x + y * y, real(RATIO)) } else { real(0.0) };
    let circles = [(real(1.0), real(1.0)), (real(RATIO), real(1.0))];
    // The weights sum to 1, so about the outer centre only that of the inner one counts.
    let inner = weights(&circles, t).and_then(|weights| weights.get(1).copied());
    [between.x, between.y].map(|d| inner.map_or(f64::NAN, |weight| (weight * real(d)).into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_form_is_exact_where_eq7_is_not() {
        // The focal length of the paper shows this circle with 810 px.
        let large = exactness(774.0);
        assert!((large.eq7 - 0.97).abs() < 0.01, "{large:?}");
        assert!(large.exact < 1e-9, "{large:?}");
        let [small, middle] = [exactness(100.0), exactness(512.0)];
        assert!(small.device < 1e-5 && middle.device < 1e-4, "{small:?} {middle:?}");
        assert!(small.device > small.exact, "{small:?}");
    }
}
