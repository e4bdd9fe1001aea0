extern crate std;
use super::*;
use crate::camera::Distortion;
use crate::centre::{perspective, weights};
use crate::target::{Circle, Ellipse};
use std::{format, println, vec::Vec};

/// A board of rings of ratio 0.5 before a camera with f 1000 px whose principal point is (640, 512): outer radius and pitch
/// in mm, the middle 800 mm away.
#[derive(Clone, Copy)]
struct Board {
    radius: f64,
    pitch: f64,
    columns: i32,
    rows: i32,
    tilt: f64,
    turn: f64,
}

const BOARD: Board = Board { radius: 20.0, pitch: 62.0, columns: 10, rows: 6, tilt: 40.0, turn: 25.0 };
const F: f64 = 1000.0;
const CENTRE: (f64, f64) = (640.0, 512.0);

struct Seen {
    /// True centre and the same from B1 and B2 alone, px.
    truth: (f64, f64),
    single: (f64, f64),
    target: Target,
}

struct Noise(u64);

impl Noise {
    fn normal(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

impl Board {
    fn axes(&self) -> [[f64; 3]; 2] {
        let ((st, ct), (s, c)) = (self.tilt.to_radians().sin_cos(), self.turn.to_radians().sin_cos());
        [[c, s, 0.0], [-s * ct, c * ct, st]]
    }

    /// True centre, and for each ratio the centre of its ellipse and A^-1 (xx, xy, yy).
    #[allow(clippy::type_complexity)]
    fn project(&self, x: f64, y: f64) -> ((f64, f64), [((f64, f64), [f64; 3]); 2]) {
        let [e1, e2] = self.axes();
        let p: [f64; 3] = core::array::from_fn(|i| [0.0, 0.0, 800.0][i] + x * e1[i] + y * e2[i]);
        let (u, v) = (p[0] / p[2], p[1] / p[2]);
        let ellipses = [1.0, 0.5].map(|ratio| {
            let r = ratio * self.radius;
            let column = |e: [f64; 3]| [(e[0] - u * e[2]), (e[1] - v * e[2])].map(|d| F * r * d / p[2]);
            let (s1, s2, q) = (column(e1), column(e2), [r * e1[2] / p[2], r * e2[2] / p[2]]);
            let scale = 1.0 - q[0] * q[0] - q[1] * q[1];
            let w = [s1[0] * q[0] + s2[0] * q[1], s1[1] * q[0] + s2[1] * q[1]];
            let entry = |i: usize, j: usize| (s1[i] * s1[j] + s2[i] * s2[j] + w[i] * w[j] / scale) / scale;
            ((-w[0] / scale, -w[1] / scale), [entry(0, 0), entry(0, 1), entry(1, 1)])
        });
        ((CENTRE.0 + F * u, CENTRE.1 + F * v), ellipses)
    }

    /// With standard deviation `sigma` px of an outer ellipse centre.
    fn see(&self, sigma: f64, noise: &mut Noise) -> Vec<Seen> {
        let places = (0..self.rows).flat_map(|row| (0..self.columns).map(move |column| (column, row)));
        let offset = |i: i32, count: i32| self.pitch * (f64::from(i) - 0.5 * f64::from(count - 1));
        places
            .map(|(column, row)| {
                let (truth, ellipses) = self.project(offset(column, self.columns), offset(row, self.rows));
                let mut target = Target::default();
                let mut centres = Vec::new();
                for ((centre, w), ratio) in ellipses.into_iter().zip([1.0, 0.5f64]) {
                    let s = sigma / ratio.sqrt();
                    let b =
                        (truth.0 + centre.0 + s * noise.normal(), truth.1 + centre.1 + s * noise.normal());
                    centres.push(b);
                    let variance = (s * s) as f32;
                    let covariance = Covariance { xx: variance, xy: 0.0, yy: variance };
                    let circle = Circle { ellipse: ellipse(b, w), covariance, ..Circle::default() };
                    target.circles.push(circle).unwrap();
                }
                target.centre = target.circles[0].ellipse.centre;
                let ((b1, b2), w) = ((centres[0], centres[1]), ellipses[0].1);
                let (dx, dy) = (b2.0 - b1.0, b2.1 - b1.1);
                let det = w[0] * w[2] - w[1] * w[1];
                let square = (w[2] * dx * dx - 2.0 * w[1] * dx * dy + w[0] * dy * dy) / det;
                let k = weights(&[(1.0, 1.0), (0.5, 1.0)], perspective(square, 0.5)).unwrap();
                let single = (k[0] * b1.0 + k[1] * b2.0 - truth.0, k[0] * b1.1 + k[1] * b2.1 - truth.1);
                Seen { truth, single, target }
            })
            .collect()
    }
}

fn place((x, y): (f64, f64)) -> Position {
    Position { x: (x * 65536.0).round() as i32, y: (y * 65536.0).round() as i32 }
}

fn ellipse(centre: (f64, f64), [xx, xy, yy]: [f64; 3]) -> Ellipse {
    let (mean, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let theta = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (a, b) = ((mean + half).sqrt(), (mean - half).sqrt());
    Ellipse { centre: place(centre), a: a as f32, b: b as f32, theta: theta as f32 }
}

fn targets(seen: &[Seen]) -> Vec<Target> {
    seen.iter().map(|seen| seen.target.clone()).collect()
}

/// Error of a target's centre, px.
fn error(target: &Target, seen: &Seen) -> (f64, f64) {
    let x = |a: i32, b: f64| f64::from(a) / 65536.0 - b;
    (x(target.centre.x, seen.truth.0), x(target.centre.y, seen.truth.1))
}

#[test]
fn exact_without_noise() {
    for (tilt, turn) in [(0.0, 0.0), (3.0, 10.0), (40.0, 25.0), (60.0, 200.0), (70.0, 90.0)] {
        for pitch in [45.0, 62.0] {
            let board = Board { tilt, turn, pitch, ..BOARD };
            let seen = board.see(0.0, &mut Noise(1));
            let mut found = targets(&seen);
            let plane = pool(&mut found, None).unwrap();
            assert_eq!((plane.used, plane.left_out), (60, 0));
            for (target, seen) in found.iter().zip(&seen) {
                let (x, y) = error(target, seen);
                let offset = target.circles[0].ellipse.centre.offset_from(target.centre);
                // The grid of positions has 1.5e-5 px, of which poles take several.
                assert!(x.hypot(y) < 4e-5, "tilt {tilt}: {:e}", x.hypot(y));
                assert!(tilt < 10.0 || offset.0.hypot(offset.1) > 0.03, "teeth: the ellipse's centre is off");
            }
            let camera = Camera::new(F as f32, F as f32, CENTRE.0 as f32, CENTRE.1 as f32).unwrap();
            let [e1, e2] = board.axes();
            let normal = plane.line.normal(&camera).map(f64::from);
            let lean = |e: [f64; 3]| e.iter().zip(normal).map(|(a, b)| a * b).sum::<f64>().abs();
            assert!(lean(e1) < 1e-4 && lean(e2) < 1e-4 && normal[2] < 0.0, "{normal:?}");
        }
    }
}

/// 58 targets: half the noise, and the reported covariance is right.
#[test]
fn half_the_noise_with_an_honest_sigma() {
    let mut noise = Noise(3);
    for board in
        [BOARD, Board { tilt: 20.0, radius: 8.0, ..BOARD }, Board { tilt: 60.0, turn: 130.0, ..BOARD }]
    {
        let (mut pooled, mut single, mut normalised, mut count) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..40 {
            let mut seen = board.see(2e-3, &mut noise);
            seen.truncate(58);
            let mut found = targets(&seen);
            assert_eq!(pool(&mut found, None).unwrap().used, 58);
            for (target, seen) in found.iter().zip(&seen) {
                let (x, y) = error(target, seen);
                let c = target.covariance;
                let [xx, xy, yy] = [c.xx, c.xy, c.yy].map(f64::from);
                pooled += x * x + y * y;
                single += seen.single.0.powi(2) + seen.single.1.powi(2);
                normalised += (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy);
                count += 2.0;
            }
        }
        let (ratio, sigma) = (f64::sqrt(pooled / single), f64::sqrt(normalised / count));
        println!(
            "58 targets, tilt {}: {ratio:.3} of the noise of each by itself, over sigma {sigma:.3}",
            board.tilt
        );
        assert!(ratio < 0.5 && (0.93..1.07).contains(&sigma), "{ratio} {sigma}");
    }
}

#[test]
fn two_targets_share_a_little() {
    let board = Board { columns: 2, rows: 1, ..BOARD };
    let (mut pooled, mut single) = (0.0, 0.0);
    let mut noise = Noise(4);
    for _ in 0..300 {
        let seen = board.see(2e-3, &mut noise);
        let mut found = targets(&seen);
        pool(&mut found, None).unwrap();
        for (target, seen) in found.iter().zip(&seen) {
            let (x, y) = error(target, seen);
            pooled += x * x + y * y;
            single += seen.single.0.powi(2) + seen.single.1.powi(2);
        }
    }
    // (0.82^2 + (1.92^2 - 0.82^2) / 2)^0.5 / 1.92 = 0.77.
    let ratio = f64::sqrt(pooled / single);
    assert!((0.7..0.84).contains(&ratio), "{ratio}");
}

#[test]
fn targets_off_the_plane_are_left_as_they_were() {
    let mut noise = Noise(5);
    let seen = BOARD.see(2e-3, &mut noise);
    let other = Board { tilt: 30.0, turn: 120.0, ..BOARD }.see(2e-3, &mut noise);
    let mut found = targets(&seen);
    let strange = [3, 17, 30, 31, 44, 59];
    for i in strange {
        found[i].circles.clone_from(&other[i].target.circles);
        found[i].centre = found[i].circles[0].ellipse.centre;
    }
    let before = found.clone();
    let plane = pool(&mut found, None).unwrap();
    assert_eq!((plane.used, plane.left_out), (54, 6), "{plane:?}");
    let (mut rms, mut clean) = (0.0, 0.0);
    let mut all = targets(&seen);
    pool(&mut all, None).unwrap();
    for (i, target) in found.iter().enumerate() {
        assert_eq!(plane.holds(target), !strange.contains(&i));
        if strange.contains(&i) {
            assert_eq!(*target, before[i]);
        } else {
            rms += error(target, &seen[i]).0.powi(2);
            clean += error(&all[i], &seen[i]).0.powi(2);
        }
    }
    assert!(f64::sqrt(rms / clean) < 1.1);
}

#[test]
fn distorted_places_are_put_back() {
    let distortion = Distortion { k1: -0.3, k2: 0.1, p1: 1e-3, ..Distortion::default() };
    let plain = Camera::new(F as f32, F as f32, CENTRE.0 as f32, CENTRE.1 as f32).unwrap();
    let camera = plain.distortion(distortion).unwrap();
    let seen = Board { tilt: 50.0, ..BOARD }.see(0.0, &mut Noise(1));
    let mut found = targets(&seen);
    for circle in found.iter_mut().flat_map(|target| &mut target.circles) {
        circle.ellipse.centre = camera.distort(circle.ellipse.centre).unwrap();
    }
    let mut wrong = found.clone();
    pool(&mut found, Some(&camera)).unwrap();
    for (target, seen) in found.iter().zip(&seen) {
        let truth = camera.distort(place(seen.truth)).unwrap();
        let (x, y) = target.centre.offset_from(truth);
        assert!(x.hypot(y) < 6e-5, "{}", x.hypot(y));
    }
    assert!(pool(&mut wrong, Some(&plain)).is_err(), "teeth: without the distortion there is no plane");
}

#[test]
fn what_makes_no_plane_is_an_error() {
    let seen = BOARD.see(2e-3, &mut Noise(6));
    let mut found = targets(&seen);
    let message = |targets: &mut [Target]| format!("{}", pool(targets, None).unwrap_err());
    assert_eq!(message(&mut []), "a plane takes two targets or more: 0 given");
    assert_eq!(message(&mut found[..1]), "a plane takes two targets or more: 1 given");
    let mut twins = [found[0].clone(), found[0].clone()];
    assert_eq!(message(&mut twins), "a plane takes two targets or more that are apart: 2 in one place given");
    let mut noise = Noise(7);
    for (i, target) in found.iter_mut().enumerate() {
        let shift = (0.2 * noise.normal() as f32, 0.2 * noise.normal() as f32);
        target.circles[1].ellipse.centre = target.circles[1].ellipse.centre.moved(shift);
        target.centre = place((10.0 * i as f64, 7.0));
    }
    let before = found.clone();
    assert!(message(&mut found).contains("of 60 targets fit on one plane"));
    assert_eq!(found, before);
    let mut bare = [Target::default(), Target { centre: place((9.0, 9.0)), ..Target::default() }];
    assert_eq!(pool(&mut bare, None), Err(PoolError::NoPlane { fitting: 0, given: 2 }));
}
