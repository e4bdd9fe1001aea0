//! The Cramer-Rao bound: the least variance that an unbiased centre can have.
//!
//! An edge of contrast dI, blurred to s = sqrt(sigma_psf^2 + 1/12) px, in noise of variance v, tells about its normal offset
//! `q = integral of (dI/dn)^2 / v = dI^2 / (2 sqrt(pi) s v)` per px of contour. What that says about the parameters of a
//! family of contours is the Fisher information (Kay 1993, "Fundamentals of Statistical Signal Processing: Estimation
//! Theory", section 3.7), the integral of `q (n . dx/dp_i) (n . dx/dp_j)` along the contours. Rounding to 8 bits
//! adds 1/12 to the variance. Levels and blur are taken as known.

use std::f64::consts::{PI, TAU};

use concentric::centre::weights;
use glam::{DMat2, DVec2};

use crate::render::{Camera, Distortion, Photometry, Pose, TargetTruth, View};

/// Points along a contour.
const STEPS: u32 = 360;
/// Step of the numeric derivatives, relative to parameters of order 1.
const STEP: f64 = 1e-5;
/// Variance of rounding to whole grey levels.
pub const ROUNDING: f64 = 1.0 / 12.0;
/// Points across an edge, and how far they reach, in units of the blur.
const ACROSS: u32 = 64;
const REACH: f64 = 5.0;

/// Least covariances of the forms of the centre, px^2.
#[derive(Clone, Debug)]
pub struct Bounds {
    /// Of the outer ellipse's centre.
    pub outer: DMat2,
    /// Of the exact form and of eq. (7): each circle is an ellipse of its own.
    pub centre: DMat2,
    /// The weights of the ellipse centres in the exact form.
    pub combination: Vec<f64>,
    /// Of the image of the centre when both circles are taken as concentric from the start.
    pub joint: DMat2,
    /// The same where the camera is known: focal length, principal point, lens distortion.
    pub known: DMat2,
}

impl Bounds {
    /// For a target of a frame; `visible` tells which places of the image show it.
    ///
    /// `None` when too little of it is visible to tell the parameters.
    pub fn new(
        truth: &TargetTruth,
        camera: &Camera,
        photometry: &Photometry,
        visible: &dyn Fn(DVec2) -> bool,
    ) -> Option<Self> {
        let edge = Edge { photometry, visible };
        let radii: Vec<_> = truth.circles.iter().map(|circle| circle.radius_mm).collect();
        let pinhole = Camera { distortion: Distortion::default(), ..*camera };
        let place = [truth.undistorted.x, truth.undistorted.y];
        let view = pose(truth, place, [0.0; 3]).view(&pinhole);
        let plane = Plane::new(&view);

        let centre_of = |radius: f64| edge.single(&plane, radius);
        let separate = radii.iter().map(|&radius| centre_of(radius)).collect::<Option<Vec<_>>>()?;
        let known = edge.covariance(&radii, |p: &[f64; 5], point| {
            let pose = pose(truth, place, [p[2], p[3], p[4]]);
            let moved = Pose { x: pose.x + p[0], y: pose.y + p[1], ..pose };
            moved.view(&pinhole).at(point).0
        })?;
        let joint = edge.covariance(&radii, |p: &[f64; 7], point| {
            let shape = DMat2::from_cols_array(&[1.0 + p[2], p[3], p[3], 1.0 + p[4]]) * plane.matrix;
            let slope = plane.slope + DVec2::new(p[5], p[6]) / radii[0];
            plane.centre + DVec2::new(p[0], p[1]) + shape * point / (1.0 + slope.dot(point))
        })?;
        let outer = *separate.first()?;
        let combination = combination(&radii, &plane, &separate)?;
        let terms = separate.iter().zip(&combination);
        let centre = terms.fold(DMat2::ZERO, |sum, (c, weight)| sum + *c * (weight * weight));
        Some(Self { outer, centre, combination, joint, known })
    }
}

/// Root of the mean variance of both coordinates, px.
pub fn per_coordinate(covariance: DMat2) -> f64 {
    ((covariance.x_axis.x + covariance.y_axis.y) / 2.0).sqrt()
}

/// The target's plane with the circles' centre at its origin. `[x, y, s]`: turned about the image axes by x and y radians,
/// farther by the factor 1 + s.
fn pose(truth: &TargetTruth, [x, y]: [f64; 2], [tilt_x, tilt_y, scale]: [f64; 3]) -> Pose {
    let turn = DVec2::from_angle(truth.azimuth.to_radians()) * truth.tilt.to_radians();
    let turn = turn + DVec2::new(tilt_x, tilt_y);
    Pose {
        x,
        y,
        distance: truth.distance * (1.0 + scale),
        tilt: turn.length().to_degrees(),
        azimuth: turn.to_angle().to_degrees(),
    }
}

/// Weights of the ellipse centres in the exact form.
fn combination(radii: &[f64], plane: &Plane, separate: &[DMat2]) -> Option<Vec<f64>> {
    let outer = *radii.first()?;
    let perspective = plane.slope.length_squared() * outer * outer;
    let circles: Vec<_> =
        radii.iter().zip(separate).map(|(r, c)| (r / outer, per_coordinate(*c).powi(2))).collect();
    Some(weights(&circles, perspective)?.to_vec())
}

/// A plane in the image: `x(p) = centre + matrix p / (1 + slope . p)`, p in mm.
struct Plane {
    centre: DVec2,
    matrix: DMat2,
    slope: DVec2,
}

impl Plane {
    fn new(view: &View) -> Self {
        let (centre, matrix) = view.at(DVec2::ZERO);
        let depth = |p: DVec2| view.point(p).z / view.point(DVec2::ZERO).z - 1.0;
        Self { centre, matrix, slope: DVec2::new(depth(DVec2::X), depth(DVec2::Y)) }
    }

    /// Centre of the ellipse that the circle of `radius` mm gives, and the matrix S of its points `centre + S e(t)`.
    fn ellipse(&self, radius: f64) -> (DVec2, DMat2) {
        let slope = self.slope * radius;
        let scale = 1.0 - slope.length_squared();
        let centre = self.centre - self.matrix * slope * (radius / scale);
        // With q = M^-1 (x - c) / r the ellipse is |q|^2 = (1 - slope . q)^2: longer along the slope.
        let along = slope.try_normalize().unwrap_or(DVec2::X);
        let across = along.perp();
        let stretch = DMat2::from_cols(along / scale, across / scale.sqrt());
        (centre, self.matrix * stretch * radius)
    }
}

/// What an edge tells.
struct Edge<'a> {
    photometry: &'a Photometry,
    visible: &'a dyn Fn(DVec2) -> bool,
}

impl Edge<'_> {
    /// Information on the normal offset at `place`, 1/px^2 per px of contour.
    fn information(&self, place: DVec2) -> f64 {
        let Photometry { blur, noise, black, white, gamma, .. } = *self.photometry;
        if !(self.visible)(place) {
            return 0.0;
        }
        let light = self.photometry.shading.map_or(1.0, |shading| shading.at(place.x, place.y));
        let width = (blur * blur + ROUNDING).sqrt();
        let variance = noise * noise + ROUNDING;
        let [low, high] = [0.0, 1.0].map(|reflectance| self.photometry.level(reflectance, light));
        if gamma == 1.0 && (0.0..=255.0).contains(&low) && (0.0..=255.0).contains(&high) {
            return (high - low).powi(2) / (2.0 * PI.sqrt() * width * variance);
        }
        debug_assert!(black < white);
        let step = 2.0 * REACH / f64::from(ACROSS);
        let level = |z: f64| {
            let reflectance = 0.5 * (1.0 + libm::erf(z / 2f64.sqrt()));
            self.photometry.level(reflectance, light).clamp(0.0, 255.0)
        };
        let slope = |i: u32| {
            let z = -REACH + f64::from(i) * step;
            (level(z + step) - level(z)) / step
        };
        (0..ACROSS).map(|i| slope(i).powi(2)).sum::<f64>() * step / (width * variance)
    }

    /// Covariance of the first two of the `N` parameters, which move the centre; `image` maps a point of the plane
    /// for parameters that are all 0 at the truth.
    fn covariance<const N: usize>(
        &self,
        radii: &[f64],
        image: impl Fn(&[f64; N], DVec2) -> DVec2,
    ) -> Option<DMat2> {
        let mut information = [[0.0; N]; N];
        let none = [0.0; N];
        let turn = DVec2::from_angle(STEP);
        for (&radius, step) in radii.iter().flat_map(|radius| (0..STEPS).map(move |step| (radius, step))) {
            let point = DVec2::from_angle(f64::from(step) * TAU / f64::from(STEPS)) * radius;
            let [ahead, behind] =
                [turn, DVec2::new(turn.x, -turn.y)].map(|turn| image(&none, turn.rotate(point)));
            let tangent = (ahead - behind) / (2.0 * STEP);
            let normal = tangent.perp().normalize();
            let slopes: [f64; N] = std::array::from_fn(|i| {
                let moved = |by: f64| {
                    let mut parameters = none;
                    parameters[i] = by;
                    image(&parameters, point)
                };
                normal.dot(moved(STEP) - moved(-STEP)) / (2.0 * STEP)
            });
            let known = self.information(image(&none, point)) * tangent.length() * TAU / f64::from(STEPS);
            for (row, a) in information.iter_mut().zip(slopes) {
                row.iter_mut().zip(slopes).for_each(|(entry, b)| *entry += known * a * b);
            }
        }
        first_two(information)
    }

    /// Covariance of the centre of the ellipse of one circle.
    fn single(&self, plane: &Plane, radius: f64) -> Option<DMat2> {
        let (centre, matrix) = plane.ellipse(radius);
        self.covariance(&[1.0], |p: &[f64; 5], point| {
            let shape = DMat2::from_cols_array(&[1.0 + p[2], p[3], p[3], 1.0 + p[4]]);
            centre + DVec2::new(p[0], p[1]) + shape * matrix * point
        })
    }
}

/// Covariance of the first two parameters: the others are taken out of the information one by one (Schur complement).
/// `None` where it does not tell them all.
fn first_two<const N: usize>(mut information: [[f64; N]; N]) -> Option<DMat2> {
    let scale = information;
    for k in (2..N).rev() {
        let pivot = information[k];
        if !(pivot[k] > 1e-9 * scale[k][k]) {
            return None;
        }
        for row in &mut information[..k] {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(entry, known)| *entry -= factor * known);
        }
    }
    let column = |j: usize| DVec2::new(information[0][j], information[1][j]);
    let rest = DMat2::from_cols(column(0), column(1));
    (rest.determinant() > 1e-9 * scale[0][0] * scale[1][1]).then(|| rest.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Artwork, Scene, Target};

    const EVERYWHERE: &dyn Fn(DVec2) -> bool = &|_| true;
    /// Focal length of most cases, px.
    const F: f64 = 2580.0;

    /// A target of semi-major axis `size` px, and levels with a contrast of 150 in noise of variance 4 after rounding.
    fn target(size: f64, ratio: f64, tilt: f64, f: f64) -> (TargetTruth, Scene) {
        let camera = Camera::new(640, 480, f);
        let pose = Pose { x: 320.0, y: 240.0, distance: 800.0, tilt, azimuth: 25.0 };
        let radius = size * 800.0 / f;
        let mut scene = Scene::empty(camera);
        scene.targets.push(Target {
            artwork: Artwork::annulus(radius, radius * ratio),
            pose,
            at: [0.0, 0.0],
        });
        let noise = (4.0f64 - 1.0 / 12.0).sqrt();
        scene.photometry =
            Photometry { blur: 0.7, black: 40.0, white: 190.0, noise, ..Photometry::default() };
        (scene.truth(0).targets.remove(0), scene)
    }

    fn bounds(size: f64, ratio: f64, tilt: f64, f: f64) -> Bounds {
        let (truth, scene) = target(size, ratio, tilt, f);
        Bounds::new(&truth, &scene.camera, &scene.photometry, EVERYWHERE).expect("all is visible")
    }

    fn assert_close(found: f64, expected: f64, relative: f64) {
        assert!((found / expected - 1.0).abs() < relative, "{found} is not {expected}");
    }

    #[test]
    fn the_ellipse_goes_through_the_images_of_the_circle() {
        let (truth, scene) = target(60.0, 0.5, 60.0, 300.0);
        let view = pose(&truth, [truth.x, truth.y], [0.0; 3]).view(&scene.camera);
        let radius = truth.circles[0].radius_mm;
        let (centre, matrix) = Plane::new(&view).ellipse(radius);
        for i in 0..12 {
            let seen = view.at(DVec2::from_angle(f64::from(i)) * radius).0;
            assert_close((matrix.inverse() * (seen - centre)).length(), 1.0, 1e-12);
        }
    }

    /// sigma_B = 1.062 sqrt(s / R) sigma_n / dI for one circle, times A(ratio) for the corrected centre.
    #[test]
    fn frontal_bounds_follow_the_closed_form() {
        let s = (0.49f64 + 1.0 / 12.0).sqrt();
        for size in [10.0, 30.0, 100.0] {
            let one = 1.062 * (s / size).sqrt() * 2.0 / 150.0;
            for ratio in [0.3, 0.433, 0.5, 0.8] {
                let found = bounds(size, ratio, 0.0, F);
                let factor = (1.0 / ratio + ratio.powi(4)).sqrt() / (1.0 - ratio * ratio);
                assert_close(per_coordinate(found.outer), one, 2e-3);
                assert_close(per_coordinate(found.centre), one * factor, 2e-3);
            }
        }
        assert_close(per_coordinate(bounds(30.0, 0.5, 0.0, F).centre), 4.31e-3, 2e-3);
    }

    #[test]
    fn tilt_raises_the_bound() {
        let flat = per_coordinate(bounds(30.0, 0.5, 0.0, F).centre);
        for (tilt, factor) in [(30.0, 1.04), (45.0, 1.12), (60.0, 1.30), (75.0, 1.91), (80.0, 2.53)] {
            assert_close(per_coordinate(bounds(30.0, 0.5, tilt, F).centre), flat * factor, 6e-3);
        }
    }

    /// Eq. (7) and the exact form lose next to nothing against the joint fit of both circles.
    #[test]
    fn separate_ellipses_are_efficient() {
        let ratio = |size, tilt, f| {
            let bounds = bounds(size, 0.5, tilt, f);
            per_coordinate(bounds.joint) / per_coordinate(bounds.centre)
        };
        assert_close(ratio(30.0, 45.0, F), 0.9999, 1e-3);
        assert_close(ratio(100.0, 60.0, 1000.0), 0.995, 5e-3);
        assert_close(ratio(200.0, 60.0, 600.0), 0.975, 5e-3);
    }

    #[test]
    fn a_known_camera_takes_the_price_of_the_correction_away() {
        let share = |size, tilt| {
            let bounds = bounds(size, 0.5, tilt, 1000.0);
            per_coordinate(bounds.known) / per_coordinate(bounds.centre)
        };
        for size in [15.0, 30.0, 60.0] {
            assert_close(share(size, 30.0), 0.435, 0.02);
        }
        for (size, tilt, expected) in
            [(15.0, 5.0, 0.44), (30.0, 5.0, 0.49), (60.0, 5.0, 0.61), (30.0, 1.0, 0.85)]
        {
            assert_close(share(size, tilt), expected, 0.03);
        }
    }

    /// The integral across the edge agrees with the closed form, and light, response, clipping and cover change it as they must.
    #[test]
    fn levels_and_cover_change_the_information() {
        let (truth, scene) = target(30.0, 0.5, 45.0, F);
        let of = |photometry: Photometry, visible: &dyn Fn(DVec2) -> bool| {
            let bounds = Bounds::new(&truth, &scene.camera, &photometry, visible).expect("enough is visible");
            per_coordinate(bounds.centre)
        };
        let plain = of(scene.photometry, EVERYWHERE);
        assert_close(of(Photometry { gamma: 1.0 + 1e-9, ..scene.photometry }, EVERYWHERE), plain, 2e-3);
        assert_close(
            of(Photometry { noise: 4.0f64.mul_add(4.0, -1.0 / 12.0).sqrt(), ..scene.photometry }, EVERYWHERE),
            2.0 * plain,
            1e-9,
        );
        // The contrast falls to 129, but the edge becomes steeper on its bright side.
        let curved = of(Photometry { gamma: 2.2, ..scene.photometry }, EVERYWHERE);
        assert!(curved > 1.05 * plain && curved < 150.0 / 129.0 * plain, "{curved} {plain}");
        let clipped = of(Photometry { gain: 1.5, ..scene.photometry }, EVERYWHERE);
        assert!(clipped > plain / 1.5 && clipped < plain, "{clipped} {plain}");
        let half = of(scene.photometry, &|place| place.x < 320.0);
        assert!(half > 2.0 * plain, "{half} {plain}");
        let little = Bounds::new(&truth, &scene.camera, &scene.photometry, &|_| false);
        assert!(little.is_none());
    }
}
