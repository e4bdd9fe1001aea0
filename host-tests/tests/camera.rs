//! Known camera, lens distortion and coplanar targets, on rendered frames.
//!
//! `cargo test --release -p concentric-host --test camera -- --nocapture` prints the figures; `CONCENTRIC_TRIALS=50` takes more
//! frames a cell.

mod common;

use common::{detect_with, errors};
use concentric::{Camera, Compensation, Distortion, Settings, Target, TargetSpec, coplanar::pool};
use concentric_host::render::{self, Artwork, Frame, Pose, Scene};

fn trials(few: u32) -> u32 {
    std::env::var("CONCENTRIC_TRIALS").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

/// The camera of a scene as the library takes it.
fn camera(of: &render::Camera) -> Camera {
    let d = of.distortion;
    let [k1, k2, p1, p2] = [d.k1, d.k2, d.p1, d.p2].map(|k| k as f32);
    let camera = Camera::new(of.f as f32, of.f as f32, of.cx as f32, of.cy as f32).unwrap();
    camera.distortion(Distortion { k1, k2, p1, p2, k3: 0.0 }).unwrap()
}

fn exact() -> Settings {
    Settings::new(TargetSpec::ring(0.5).unwrap())
}

fn known(camera: Camera) -> Settings {
    exact().compensation(Compensation::Known).camera(camera)
}

/// Errors of some targets.
#[derive(Default)]
struct Errors {
    /// True minus found centre, px.
    all: Vec<(f64, f64)>,
    /// Squared error in units of the reported covariance.
    normalised: f64,
}

impl Errors {
    fn add(&mut self, targets: &[Target], frame: &Frame) {
        let (found, false_targets) = errors(targets, &frame.truth);
        assert_eq!((found.len(), false_targets), (frame.truth.targets.len(), 0), "missed or false");
        for (dx, dy, target) in found {
            let c = target.covariance;
            let (xx, xy, yy) = (f64::from(c.xx), f64::from(c.xy), f64::from(c.yy));
            self.all.push((dx, dy));
            self.normalised += (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy);
        }
    }

    /// RMS of a coordinate, px.
    fn rms(&self) -> f64 {
        (self.all.iter().map(|(x, y)| x * x + y * y).sum::<f64>() / self.all.len() as f64 / 2.0).sqrt()
    }

    /// Length of the mean error, px: what no averaging over noise removes.
    fn bias(&self) -> f64 {
        let (x, y) = self.all.iter().fold((0.0, 0.0), |(x, y), e| (x + e.0, y + e.1));
        x.hypot(y) / self.all.len() as f64
    }

    fn over_sigma(&self) -> f64 {
        (self.normalised / self.all.len() as f64 / 2.0).sqrt()
    }
}

/// Standard deviation of a coordinate of the outer ellipse's centre for a circle of semi-major axis `radius` px seen from the
/// front, times what eq. (7) makes of it at ratio 0.5, times the tilt's factor: the Cramer-Rao bound of eq. (7).
fn eq7_bound(scene: &Scene, radius: f64, tilt: f64) -> f64 {
    let photometry = &scene.photometry;
    let blur = (photometry.blur.powi(2) + 1.0 / 12.0).sqrt();
    let contrast = photometry.white - photometry.black;
    let noise = (photometry.noise.powi(2) + 1.0 / 12.0).sqrt();
    let tilts = [(0.0, 1.0), (30.0, 1.04), (45.0, 1.12), (60.0, 1.30)];
    let pair = tilts.windows(2).find(|pair| tilt <= pair[1].0).expect("tilts up to 60 degrees");
    let share = (tilt - pair[0].0) / (pair[1].0 - pair[0].0);
    let factor = pair[0].1 + share * (pair[1].1 - pair[0].1);
    1.062 * (blur / radius).sqrt() * noise / contrast * 1.92 * factor
}

/// A target of semi-major axis `radius` px whose centre appears at `(x, y)`.
fn scene(camera: render::Camera, radius: f64, tilt: f64, azimuth: f64, (x, y): (f64, f64)) -> Scene {
    let mut scene = Scene::empty(camera);
    let pose = Pose { x, y, distance: 800.0, tilt, azimuth };
    let mm = radius * 800.0 / camera.f;
    let artwork = Artwork::annulus(mm, mm / 2.0);
    scene.targets.push(render::Target { artwork, pose, at: [0.0, 0.0] });
    scene
}

/// Place and azimuth number `i` of a walk over their ranges without a pattern.
fn turn(i: u32, step: f64) -> f64 {
    (f64::from(i) * step + 0.37).fract()
}

#[test]
fn known_camera_takes_off_more_than_half_of_the_noise() {
    let (mut ratios, mut bounds, mut cells) = (0.0, 0.0, 0.0);
    for f in [1000.0, 2580.0] {
        let lens = render::Camera::new(640, 512, f);
        for radius in [20.0, 30.0, 50.0] {
            for tilt in [20.0, 40.0, 60.0] {
                let (mut with, mut without) = (Errors::default(), Errors::default());
                let mut bound = 0.0;
                for i in 0..trials(40) {
                    let at = (320.0 + 40.0 * turn(i, 0.618_034), 256.0 + 40.0 * turn(i, 0.754_878));
                    let scene = scene(lens, radius, tilt, 360.0 * turn(i, 0.381_966), at);
                    bound = eq7_bound(&scene, radius, tilt);
                    let frame = scene.render(u64::from(i) + (1e4 * tilt + f) as u64);
                    with.add(&detect_with(&frame, known(camera(&lens))).0, &frame);
                    without.add(&detect_with(&frame, exact()).0, &frame);
                }
                let ratio = with.rms() / without.rms();
                println!(
                    "f {f} R {radius} tilt {tilt}: {:.2} mpx (over sigma {:.2}), exact {:.2} ({:.2}), ratio {ratio:.3}; \
                     {:.3} of the bound of eq. (7), {:.2} mpx",
                    1e3 * with.rms(),
                    with.over_sigma(),
                    1e3 * without.rms(),
                    without.over_sigma(),
                    with.rms() / bound,
                    1e3 * bound
                );
                ratios += ratio * ratio;
                bounds += (with.rms() / bound).powi(2);
                cells += 1.0;
            }
        }
    }
    println!(
        "pooled: {:.3} of exact, {:.3} of eq. (7)'s bound",
        f64::sqrt(ratios / cells),
        f64::sqrt(bounds / cells)
    );
}
#[test]
fn debug_noise_free() {
    for (f, radius, tilt) in [
        (1000.0, 20.0, 20.0),
        (1000.0, 30.0, 20.0),
        (1000.0, 30.0, 40.0),
        (1000.0, 30.0, 60.0),
        (2580.0, 50.0, 20.0),
        (1000.0, 50.0, 60.0),
    ] {
        let lens = render::Camera::new(640, 512, f);
        for noise in [0.0, 1.0, 2.0] {
            let (mut with, mut without, mut outer) = (Errors::default(), Errors::default(), (0.0, 0.0));
            for i in 0..trials(40) {
                let at = (320.0 + 40.0 * turn(i, 0.618_034), 256.0 + 40.0 * turn(i, 0.754_878));
                let mut scene = scene(lens, radius, tilt, 360.0 * turn(i, 0.381_966), at);
                scene.photometry.noise = noise;
                let frame = scene.render(u64::from(i) + (1e4 * tilt + f) as u64);
                let k = detect_with(&frame, known(camera(&lens))).0;
                with.add(&k, &frame);
                let e = detect_with(&frame, exact()).0;
                without.add(&e, &frame);
                for j in 0..2 {
                    let el = &frame.truth.targets[0].circles[j].ellipse;
                    let b = concentric_host::measure::px(e[0].circles[j].ellipse.centre);
                    let s = ((el.x - b[0]).powi(2) + (el.y - b[1]).powi(2)) / 2.0 / f64::from(trials(40));
                    if j == 0 { outer.0 += s } else { outer.1 += s }
                }
            }
            println!(
                "f {f} R {radius} tilt {tilt} noise {noise}: known {:.2} ({:.2}) exact {:.2} ({:.2}) outer {:.2} inner {:.2} mpx",
                1e3 * with.rms(),
                with.over_sigma(),
                1e3 * without.rms(),
                without.over_sigma(),
                1e3 * f64::sqrt(outer.0),
                1e3 * f64::sqrt(outer.1)
            );
        }
    }
}
