extern crate std;
use super::*;
use crate::camera::Camera;
use crate::fit::Adjustment;
use crate::measure::combine::{combine, measured_perspective};
use crate::target::Position;
use std::vec::Vec;

/// A ring of ratio 0.5: focal length, place of its centre from the principal point, px, semi-major axis of the outer ellipse,
/// px, tilt to the line of sight and its direction, degrees.
#[derive(Clone, Copy, Debug)]
struct Scene {
    f: f64,
    at: (f64, f64),
    radius: f64,
    tilt: f64,
    turn: f64,
}

type Vector = [f64; 3];

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: Vector) -> Vector {
    let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / size)
}

impl Scene {
    fn basis(&self) -> (Vector, Vector, Vector) {
        let sight = unit([self.at.0, self.at.1, self.f]);
        let side = unit(cross(sight, [0.0, 1.0, 0.0]));
        let up = cross(sight, side);
        let ((s, c), (sin, cos)) = (self.tilt.to_radians().sin_cos(), self.turn.to_radians().sin_cos());
        let e1: Vector = core::array::from_fn(|i| cos * side[i] + sin * up[i]);
        let flat: Vector = core::array::from_fn(|i| cos * up[i] - sin * side[i]);
        let e2: Vector = core::array::from_fn(|i| c * flat[i] + s * sight[i]);
        (e1, e2, unit(cross(e2, e1)))
    }

    /// The circle of `ratio` about its true centre, with noise along the normal, about a point a px each, px.
    fn points(&self, ratio: f64, sigma: f64, noise: &mut Noise) -> Vec<(f32, f32)> {
        let (e1, e2, _) = self.basis();
        let size = (self.at.0.powi(2) + self.at.1.powi(2) + self.f.powi(2)).sqrt();
        let r = ratio * self.radius * size / self.f;
        let centre = [self.at.0, self.at.1, self.f];
        let project = |t: f64| {
            let p: Vector = core::array::from_fn(|i| centre[i] + r * (t.cos() * e1[i] + t.sin() * e2[i]));
            (self.f * p[0] / p[2] - self.at.0, self.f * p[1] / p[2] - self.at.1)
        };
        let (mut t, mut points) = (0.1, Vec::new());
        while t < 0.1 + core::f64::consts::TAU {
            let ((x, y), (x1, y1)) = (project(t), project(t + 1e-5));
            let (dx, dy) = ((x1 - x) / 1e-5, (y1 - y) / 1e-5);
            let speed = dx.hypot(dy);
            let off = sigma * noise.normal();
            points.push(((x + off * dy / speed) as f32, (y - off * dx / speed) as f32));
            t += 1.0 / speed;
        }
        points
    }

    fn fit(&self, ratio: f64, sigma: f64, noise: &mut Noise) -> Fitted {
        let points = self.points(ratio, sigma, noise);
        let mut sums = crate::fit::Sums::default();
        for (x, y) in &points {
            sums.add((256.0 * x).round() as i32, (256.0 * y).round() as i32);
        }
        let mut shape = sums.fit().unwrap();
        // Twice, so that without noise nothing but rounding is left.
        for _ in 0..2 {
            let mut adjustment = Adjustment::new(shape).unwrap();
            points.iter().for_each(|&(x, y)| adjustment.add(&adjustment.view(x, y)));
            let adjusted = adjustment.finish().unwrap();
            shape = adjusted.shape;
        }
        let mut adjustment = Adjustment::new(shape).unwrap();
        points.iter().for_each(|&(x, y)| adjustment.add(&adjustment.view(x, y)));
        Fitted {
            adjusted: adjustment.finish().unwrap(),
            dark_inside: ratio == 1.0,
            gap: 0,
            ratio: ratio as f32,
        }
    }

    fn lens(&self, camera: &Camera) -> Local {
        let (cx, cy) = camera.principal_point();
        let place = |c: f32, d: f64| ((f64::from(c) + d) * 65536.0).round() as i32;
        Local::new(camera, Position { x: place(cx, self.at.0), y: place(cy, self.at.1) }).unwrap()
    }
}

struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

#[derive(Debug, Default)]
struct Statistics {
    known: f64,
    exact: f64,
    normalised: f64,
    angle: f64,
    wrong: u32,
    none: u32,
}

/// RMS errors, px and degrees, of many trials.
fn trials(scene: &Scene, sigma: f64, count: u32, f_used: f64) -> Statistics {
    let camera = Camera::new(f_used as f32, f_used as f32, 600.0, 500.0).unwrap();
    let lens = scene.lens(&camera);
    let (_, _, truth) = scene.basis();
    let mut noise = Noise(7 + scene.radius as u64);
    let mut s = Statistics::default();
    for _ in 0..count {
        let circles = super::super::ellipse::list(
            [1.0, 0.5].into_iter().map(|ratio| scene.fit(ratio, sigma, &mut noise)),
        );
        let exact = combine(&circles, measured_perspective(&circles).unwrap()).unwrap();
        s.exact += f64::from(exact.x * exact.x + exact.y * exact.y);
        let Some(Known { centre: Centre { x, y, covariance: c, .. }, normal }) = known(&circles, &lens)
        else {
            s.none += 1;
            continue;
        };
        s.known += f64::from(x * x + y * y);
        s.normalised +=
            f64::from((c.yy * x * x - 2.0 * c.xy * x * y + c.xx * y * y) / (c.xx * c.yy - c.xy * c.xy));
        let off = cross(normal.map(f64::from), truth);
        let angle = off.iter().map(|x| x * x).sum::<f64>().sqrt().asin().to_degrees();
        s.angle += angle * angle;
        s.wrong += u32::from(angle > 0.5 * scene.tilt);
    }
    let mean = |sum: f64| (sum / f64::from(count - s.none)).sqrt();
    Statistics {
        known: mean(s.known / 2.0),
        exact: mean(s.exact / 2.0),
        normalised: mean(s.normalised / 2.0),
        angle: mean(s.angle),
        ..s
    }
}

#[test]
fn table() {
    for (f, at, radius) in [
        (2580.0, (0.0, 0.0), 30.0),
        (1000.0, (0.0, 0.0), 12.0),
        (1000.0, (300.0, -200.0), 30.0),
        (1000.0, (0.0, 0.0), 60.0),
        (600.0, (200.0, 200.0), 100.0),
        (2580.0, (500.0, 0.0), 10.0),
        (2580.0, (0.0, 0.0), 8.0),
    ] {
        for tilt in [0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 45.0, 60.0, 70.0] {
            let scene = Scene { f, at, radius, tilt, turn: 25.0 };
            let s = trials(&scene, 0.016, 400, f);
            let z = trials(&scene, 0.0, 1, f);
            std::println!(
                "f {f} R {radius} tilt {tilt}: known {:.2} exact {:.2} mpx ratio {:.2} sigma {:.2} normal {:.2} deg wrong {} none {} noise-free {:.1e}, {:.1e} px",
                1e3 * s.known,
                1e3 * s.exact,
                s.known / s.exact,
                s.normalised,
                s.angle,
                s.wrong,
                s.none,
                z.known,
                z.exact
            );
        }
    }
}
