//! The closed forms against the projection of conics.

extern crate std;

use super::*;
use crate::centre::Real;

type Vector = [f64; 3];

/// Goal, px.
const EXACT: f64 = 1e-9;
const SCENES: usize = 1000;

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance((x, y): (f64, f64), (u, v): (f64, f64)) -> f64 {
    (x - u).hypot(y - v)
}

/// Even numbers, without a pattern.
struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// True centre and ellipse centre of the circle about `centre` in the plane of the unit vectors `e1`, `e2`, all in camera
/// axes: the dual conic H diag(r^2, r^2, -1) H' of the homography H = (e1 e2 centre), whose last column is the centre.
fn projected(c: f64, centre: Vector, [e1, e2]: [Vector; 2], radius: f64) -> [(f64, f64); 2] {
    let dual = |i: usize| radius * radius * (e1[i] * e1[2] + e2[i] * e2[2]) - centre[i] * centre[2];
    let place = |x: f64, y: f64, z: f64| (c * x / z, c * y / z);
    [place(centre[0], centre[1], centre[2]), place(dual(0), dual(1), dual(2))]
}

/// A random [`Scene`], its parameters, and what the projection makes of a random circle.
struct Case {
    scene: Scene<f64>,
    parameters: [f64; 5],
    radius: f64,
    projected: [(f64, f64); 2],
}

fn cases() -> impl Iterator<Item = Case> {
    let mut random = Random(1);
    std::iter::repeat_with(move || {
        let c = random.within(500.0, 4000.0);
        let d = random.within(150.0, 2000.0);
        let (omega, alpha) = (random.within(-1.4, 1.4), random.within(-1.3, 1.3));
        let x = random.within(-0.4, 0.4) * d;
        let radius = random.within(0.001, 0.3) * d;
        let l = d * (omega - alpha).cos();
        // Anything a camera can see: at most 45 degrees off the axis, 80 from the normal, the circle wholly before it.
        let seen = (omega - alpha).abs() < 0.75 && radius * omega.sin().abs() < 0.8 * l;
        let scene = Scene::new(c, x, d, omega, alpha).filter(|_| seen)?;
        let (s, co) = omega.sin_cos();
        // Camera axes in those of the plane.
        let camera = [0.0, -d * alpha.sin(), d * alpha.cos()];
        let axes = [[1.0, 0.0, 0.0], [0.0, co, s], [0.0, s, -co]];
        let turned = |v: Vector| axes.map(|axis| dot(axis, v));
        let centre = turned([x - camera[0], -camera[1], -camera[2]]);
        let plane = [turned([1.0, 0.0, 0.0]), turned([0.0, 1.0, 0.0])];
        let projected = projected(c, centre, plane, radius);
        Some(Case { scene, parameters: [c, x, d, omega, alpha], radius, projected })
    })
    .flatten()
    .take(SCENES)
}

#[test]
fn equations_1_to_3_are_the_projection() {
    let mut worst = [0.0f64; 3];
    let (mut misprinted, mut mirrored) = (0, 0);
    for Case { scene, parameters: [_, _, _, omega, alpha], radius, projected: [centre, ellipse] } in cases() {
        let shift = scene.eccentricity(radius).unwrap();
        let truth = (ellipse.0 - centre.0, ellipse.1 - centre.1);
        let off = [
            distance(scene.centre(), centre),
            distance(scene.ellipse_centre(radius).unwrap(), ellipse),
            distance(shift, truth),
        ];
        for (worst, off) in worst.iter_mut().zip(off) {
            *worst = worst.max(off);
        }
        // What the paper prints in (4), and the sign that others quote.
        let printed = (shift.0, shift.1 * omega.cos() / alpha.cos());
        misprinted += usize::from(distance(printed, truth) > EXACT);
        mirrored += usize::from(distance((shift.0, -shift.1), truth) > EXACT);
    }
    std::println!("equations (1), (2), (3) against the projection, {SCENES} scenes: {worst:?} px");
    assert!(worst.iter().all(|off| *off < EXACT), "{worst:?}");
    assert_eq!((misprinted, mirrored), (SCENES, SCENES));
}

#[test]
fn planes_in_any_direction_are_scenes() {
    let mut random = Random(2);
    let mut worst = 0.0f64;
    let mut done = 0;
    while done < SCENES {
        let c = random.within(500.0, 4000.0);
        let z = random.within(150.0, 2000.0);
        let centre = [random.within(-0.6, 0.6) * z, random.within(-0.6, 0.6) * z, z];
        let [a, b, g] = [(); 3].map(|()| random.within(-1.0, 1.0));
        let length = dot([a, b, g], [a, b, g]).sqrt();
        let normal = [a / length, b / length, g / length];
        let radius = random.within(0.001, 0.2) * z;
        if dot(normal, centre).abs() < 0.1 * z || length < 0.1 {
            continue;
        }
        done += 1;
        // Any two directions in the plane.
        let e1 = [normal[1], -normal[0], 0.0];
        let size = dot(e1, e1).sqrt();
        let e1 = e1.map(|v| v / size);
        let e2 = [
            normal[1] * e1[2] - normal[2] * e1[1],
            normal[2] * e1[0] - normal[0] * e1[2],
            normal[0] * e1[1] - normal[1] * e1[0],
        ];
        let [truth, ellipse] = projected(c, centre, [e1, e2], radius);
        // The normal may point either way and have any length.
        let plane = Plane::new(c, centre, normal.map(|v| -3.0 * v)).unwrap();
        let corrected = plane.correct(ellipse, radius).unwrap();
        worst = worst.max(distance(corrected, truth)).max(distance(plane.centre(), truth));
        if radius > 0.02 * z && normal[2].abs() < 0.99 {
            let wrong = plane.correct(ellipse, 1.001 * radius).unwrap();
            assert!(distance(wrong, truth) > EXACT, "a wrong radius must show");
        }
    }
    std::println!("eq. (3) on planes in any direction, {SCENES} scenes: {worst:e} px");
    assert!(worst < EXACT);
}

#[test]
fn seen_from_the_front_nothing_is_to_correct() {
    let plane = Plane::new(1000.0, [10.0, -20.0, 500.0], [0.0, 0.0, 1.0]).unwrap();
    assert_eq!(plane.correct((20.0, -40.0), 50.0), Some((20.0, -40.0)));
}

/// (4) to (6) are (3) without kappa r^2; eq. (7) leaves what the law says, to its last digits.
#[test]
fn approximation_and_residual_are_what_theory_says() {
    for Case { scene, parameters: [_, _, d, omega, alpha], radius, .. } in cases() {
        let exact = scene.eccentricity(radius).unwrap();
        let kappa = (omega.sin() / (d * (omega - alpha).cos())).powi(2);
        let near = scene.approximation(radius);
        let share = 1.0 - kappa * radius * radius;
        assert!(distance((exact.0 * share, exact.1 * share), near) < 1e-9 * (1.0 + exact.0.hypot(exact.1)));

        let (outer, inner) = (radius, 0.4 * radius);
        let centres = [outer, inner].map(|r| scene.ellipse_centre(r).unwrap());
        let seven = from_two(centres[0], centres[1], 0.4).unwrap();
        let (x, y) = scene.residual(outer, inner);
        let truth = scene.centre();
        // Cancellation leaves some 1e-13 of the places in px.
        assert!(distance(seven, (truth.0 + x, truth.1 + y)) < 1e-9 * x.hypot(y) + 1e-11);
        if x.hypot(y) > 1e-6 {
            let wrong = distance(seven, (truth.0 + 1.01 * x, truth.1 + 1.01 * y));
            assert!(wrong > 1e-9 * x.hypot(y) + 1e-11, "a wrong law must show");
        }
    }
    assert_eq!(from_two((0.0, 0.0), (1.0, 1.0), 1.0), None);
}

/// The device's arithmetic: 1e-5 of the distance from the principal point.
#[test]
fn single_precision_is_good_to_its_digits() {
    for Case { parameters, radius, projected: [centre, ellipse], .. } in cases() {
        let [c, x, d, omega, alpha] = parameters.map(|value| value as f32);
        let scene = Scene::new(c, x, d, omega, alpha).unwrap();
        let wide = |(u, v): (f32, f32)| (f64::from(u), f64::from(v));
        let shift = (ellipse.0 - centre.0, ellipse.1 - centre.1);
        let off = [
            (scene.centre(), centre, centre),
            (scene.ellipse_centre(radius as f32).unwrap(), ellipse, ellipse),
            (scene.eccentricity(radius as f32).unwrap(), shift, shift),
        ]
        .map(|(found, truth, size)| distance(wide(found), truth) / (1e-3 + size.0.hypot(size.1)));
        assert!(off.iter().all(|off| *off < 1e-4), "{off:?} {parameters:?} {radius}");
    }
}

#[test]
fn what_no_camera_sees_is_none() {
    // From below, from behind, from within the plane's steepest line.
    assert_eq!(Scene::new(1000.0, 0.0, 100.0, 0.1, 2.0), None);
    assert_eq!(Scene::new(1000.0, 0.0, 100.0, 3.0, 0.0), None);
    assert_eq!(Scene::new(1000.0, f64::NAN, -100.0, 0.0, 0.0), None);
    assert_eq!(Plane::new(1000.0, [0.0, 0.0, -5.0], [0.0, 0.0, 1.0]), None);
    assert_eq!(Plane::new(1000.0, [0.0, 0.0, 5.0], [1.0, 0.0, 0.0]), None);
    let near = Scene::<f64>::new(1000.0, 0.0, 100.0, 1.0, 1.0).unwrap();
    assert_eq!(near.eccentricity(200.0), None);
    assert_eq!(near.ellipse_centre(200.0), None);
    assert_eq!(near.eccentricity(0.0).map(|(u, v)| (u.abs(), v.abs())), Some((0.0, 0.0)));
}

/// The neglected term of (8) is what the distortion's slope makes of the distance between the ellipse centres.
#[test]
fn eq_8_neglects_what_the_slope_of_the_distortion_makes() {
    let lens: Lens<f64> = Lens { radial: [-0.3, 0.1, 0.02], decentring: [1e-3, -5e-4], affine: [2e-3, 1e-3] };
    let (outer, inner) = ((0.301, 0.199), (0.3005, 0.1994));
    let step = 1e-6;
    let slope = |(dx, dy): (f64, f64)| {
        let [a, b] = [1.0, -1.0].map(|sign| lens.shift((0.3 + sign * step * dx, 0.2 + sign * step * dy)));
        ((a.0 - b.0) / (2.0 * step), (a.1 - b.1) / (2.0 * step))
    };
    let (x, y) = slope((inner.0 - outer.0, inner.1 - outer.1));
    let neglected = lens.neglected(outer, inner, 0.5).unwrap();
    assert!(distance(neglected, (x / 3.0, y / 3.0)) < 0.01 * x.hypot(y), "{neglected:?} {x} {y}");
    assert!(neglected.0.hypot(neglected.1) > 1e-6);
    assert_eq!(lens.distort((0.0, 0.0)), (0.0, 0.0));
}

/// Radial and decentring terms are the camera's.
#[test]
fn lens_is_that_of_the_camera() {
    use crate::{Camera, Distortion, Position};
    let distortion = Distortion { k1: -0.2, k2: 0.05, p1: 3e-3, p2: -2e-3, k3: 0.01 };
    let camera = Camera::new(1000.0, 1000.0, 0.0, 0.0).unwrap().distortion(distortion).unwrap();
    let lens = Lens { radial: [-0.2, 0.05, 0.01], decentring: [3e-3, -2e-3], affine: [0.0; 2] };
    for (x, y) in [(300, -200), (-150, 420), (10, 350)] {
        let scale = Position::SCALE;
        let seen = camera.distort(Position { x: x * scale, y: y * scale }).unwrap();
        let (u, v) = lens.distort((f64::from(x) / 1000.0, f64::from(y) / 1000.0));
        let off = distance((1000.0 * u, 1000.0 * v), {
            let scale = f64::from(scale);
            (f64::from(seen.x) / scale, f64::from(seen.y) / scale)
        });
        assert!(off < 1e-4, "{off}");
    }
}

#[test]
fn sine_and_cosine_are_those_of_libm() {
    let (s, c) = Real::sin_cos(0.7f64);
    assert!((s - 0.7f64.sin()).abs() < 1e-15 && (c - 0.7f64.cos()).abs() < 1e-15);
    let (s, c) = Real::sin_cos(0.7f32);
    assert!((s - 0.7f32.sin()).abs() < 1e-6 && (c - 0.7f32.cos()).abs() < 1e-6);
}
