//! Eq. (8): eq. (7) on outlines that a lens distorts. Exact outlines, no pictures.

use anyhow::{Context, Result};
use concentric::model::{Lens, Plane, from_two};
use glam::{DMat2, DVec2, DVec3};
use nalgebra::{SMatrix, SVector};

use super::simulation::RATIO;
use crate::render::{Camera, Pose, View};

/// Focal length, px.
pub const FOCAL_LENGTH: f64 = 1000.0;
/// Where the true centre is without distortion, from the principal point, px.
pub const PLACE: DVec2 = DVec2::new(300.0, -200.0);
/// Of the target, degrees.
pub const TILT: f64 = 45.0;
/// Direction of the axis of tilt, degrees.
const AZIMUTH: f64 = 20.0;
/// Points of an outline.
const POINTS: u32 = 2000;

/// A lens and a target. All errors in px.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The lens.
    pub lens: Lens<f64>,
    /// Outer semi-major axis, px, near enough.
    pub radius: f64,
    /// How far the centre of the distorted outer outline is from the distorted true centre.
    pub outer: f64,
    /// |d(B1) - d(B2)|, which the paper assumes to be 0.
    pub apart: f64,
    /// What of that eq. (8) neglects.
    pub neglected: f64,
    /// How far eq. (7) on the centres of the distorted outlines is from the distorted true centre.
    pub eq7: f64,
    /// The same without a lens: what eq. (7) leaves of perspective.
    pub perspective: f64,
}

/// Lenses with radial distortion, and one with all components; targets of three sizes.
///
/// # Errors
/// None that a caller can cause.
pub fn rows() -> Result<Vec<Row>> {
    let radial = |k1: f64| Lens { radial: [k1, 0.0, 0.0], decentring: [0.0; 2], affine: [0.0; 2] };
    let all = Lens { radial: [-0.2, 0.05, -0.01], decentring: [1e-3, -5e-4], affine: [2e-3, 1e-3] };
    let lenses = [radial(-0.1), radial(-0.2), radial(-0.3), all];
    let rows = [30.0, 60.0, 100.0].into_iter().flat_map(|radius| lenses.map(|lens| row(lens, radius)));
    rows.collect()
}

fn row(lens: Lens<f64>, radius: f64) -> Result<Row> {
    let view = view(radius);
    let circles = [radius, RATIO * radius];
    let truth = view.undistorted(DVec2::ZERO);
    let plane = plane(&view)?;
    let mut centres = [(0.0, 0.0); 2];
    for (centre, radius) in centres.iter_mut().zip(circles) {
        let (x, y) = plane.eccentricity(radius).context("a circle before the camera")?;
        *centre = (truth.x / FOCAL_LENGTH + x, truth.y / FOCAL_LENGTH + y);
    }
    let [d1, d2] = centres.map(|centre| vector(lens.shift(centre)) * FOCAL_LENGTH);
    let neglected = lens.neglected(centres[0], centres[1], RATIO).context("two circles")?;
    let distorted = distort(&lens, truth);
    let none = Lens { radial: [0.0; 3], decentring: [0.0; 2], affine: [0.0; 2] };
    let left = |lens: &Lens<f64>| -> Result<(DVec2, DVec2)> {
        let outlines = circles.map(|radius| outline(lens, &view, radius));
        let [outer, inner] = outlines.map(|outline| centre(&outline, distort(lens, truth)));
        let (outer, inner) = (outer.context("an ellipse")?, inner.context("an ellipse")?);
        let seven = from_two((outer.x, outer.y), (inner.x, inner.y), RATIO).context("two circles")?;
        Ok((outer, vector(seven)))
    };
    let (outer, eq7) = left(&lens)?;
    Ok(Row {
        lens,
        radius,
        outer: (outer - distorted).length(),
        apart: (d1 - d2).length(),
        neglected: vector(neglected).length() * FOCAL_LENGTH,
        eq7: (eq7 - distorted).length(),
        perspective: (left(&none)?.1 - truth).length(),
    })
}

fn vector((x, y): (f64, f64)) -> DVec2 {
    DVec2::new(x, y)
}

/// The target's plane, 1 mm on which is about 1 px; the principal point is the origin.
fn view(radius: f64) -> View {
    let camera = Camera { cx: 0.0, cy: 0.0, ..Camera::new(1, 1, FOCAL_LENGTH) };
    // The tip of the major axis is this much farther than the centre.
    let distance = camera.ray(PLACE.x, PLACE.y).length() * FOCAL_LENGTH;
    let pose = Pose { x: PLACE.x, y: PLACE.y, distance, tilt: TILT, azimuth: AZIMUTH };
    debug_assert!(radius < 0.5 * distance);
    pose.view(&camera)
}

fn plane(view: &View) -> Result<Plane<f64>> {
    let origin = view.point(DVec2::ZERO);
    let normal: DVec3 = (view.point(DVec2::X) - origin).cross(view.point(DVec2::Y) - origin);
    Plane::new(1.0, origin.into(), normal.into()).context("a plane before the camera")
}

fn distort(lens: &Lens<f64>, place: DVec2) -> DVec2 {
    let (x, y) = lens.distort((place.x / FOCAL_LENGTH, place.y / FOCAL_LENGTH));
    DVec2::new(x, y) * FOCAL_LENGTH
}

fn outline(lens: &Lens<f64>, view: &View, radius: f64) -> Vec<DVec2> {
    let spoke = |i: u32| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / f64::from(POINTS));
    (0..POINTS).map(|i| distort(lens, view.undistorted(spoke(i) * radius))).collect()
}

/// Centre of the ellipse that fits the closed outline best, every piece of it with its length; `about` is near it. The cost
/// is that of the library: a (x^2 - y^2) + b x y + d x + e y + f + (x^2 + y^2).
fn centre(outline: &[DVec2], about: DVec2) -> Option<DVec2> {
    let scale = outline.iter().map(|place| place.distance(about)).fold(0.0, f64::max);
    let (mut normal, mut right) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
    let neighbours = outline.iter().zip(outline.iter().cycle().skip(1));
    for (&from, &to) in neighbours {
        let DVec2 { x, y } = ((from + to) / 2.0 - about) / scale;
        // The middle of a chord lies inside by the same small share everywhere on an ellipse.
        let weight = from.distance(to);
        let row = SVector::<f64, 5>::from([x * x - y * y, x * y, x, y, 1.0]);
        normal += weight * row * row.transpose();
        right -= weight * (x * x + y * y) * row;
    }
    let [a, b, d, e, _] = normal.lu().solve(&right)?.into();
    let matrix = DMat2::from_cols_array(&[2.0 * (1.0 + a), b, b, 2.0 * (1.0 - a)]);
    Some(about - matrix.inverse() * DVec2::new(d, e) * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fit_finds_the_centre_of_an_ellipse() {
        let view = view(60.0);
        let none = Lens { radial: [0.0; 3], decentring: [0.0; 2], affine: [0.0; 2] };
        let truth = view.ellipse(DVec2::ZERO, 60.0);
        let found = centre(&outline(&none, &view, 60.0), PLACE).unwrap();
        assert!(found.distance(DVec2::new(truth.x, truth.y)) < 1e-5, "{found} {truth:?}");
    }

    /// The assumption of eq. (8) is wrong by far more than what eq. (7) leaves; that falls with the fourth power of the
    /// size, as an even function of the radius does beyond its square.
    #[test]
    fn eq_7_holds_though_the_assumption_of_eq_8_does_not() {
        for row in rows().unwrap() {
            assert!(row.apart > 0.008 && row.neglected > 0.002, "{row:?}");
            assert!(row.eq7 < 0.2 * row.neglected, "{row:?}");
            assert!(row.outer > 10.0 * row.eq7, "{row:?}");
        }
        let lens = rows().unwrap()[2].lens;
        let [large, small] = [100.0, 50.0].map(|radius| row(lens, radius).unwrap());
        let order = |of: fn(&Row) -> f64| (of(&large) / of(&small)).log2();
        assert!((order(|row| row.outer) - 2.0).abs() < 0.1, "{}", order(|row| row.outer));
        assert!((order(|row| row.eq7) - 4.0).abs() < 0.2, "{}", order(|row| row.eq7));
    }
}
