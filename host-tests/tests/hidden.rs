//! Targets of which a part cannot be seen.
//!
//! `cargo test --release -p concentric-host --test hidden -- --nocapture` prints the figures; `CONCENTRIC_TRIALS=1000` takes
//! that many frames of each kind of damage instead of a few.

mod common;

use common::detect;
use concentric::{Flags, Position, Target, TargetSpec};
use concentric_host::accuracy::cell::Cell;
use concentric_host::render::{Artwork, Camera, Cover, Frame, Occluder, Pose, Scene};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Size of the frames, px.
const SIZE: u32 = 260;
/// Focal length, px.
const F: f64 = 2580.0;
/// An error above this, px, and above this many reported standard deviations is silently wrong.
const SILENT: (f64, f64) = (0.1, 5.0);
/// Semi-major axes, px.
const SIZES: [f64; 4] = [15.0, 20.0, 30.0, 60.0];

fn trials(few: u32) -> u32 {
    std::env::var("CONCENTRIC_TRIALS").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

/// Random numbers of one trial.
struct Random(Pcg64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// A place up to `most` px from the target's.
    fn around(&mut self, scene: &Scene, (least, most): (f64, f64)) -> (f64, f64) {
        let (pose, angle) = (scene.targets[0].pose, self.within(0.0, std::f64::consts::TAU));
        let distance = self.within(least, most);
        (pose.x + distance * angle.cos(), pose.y + distance * angle.sin())
    }
}

/// One annulus of ratio 0.5 and this semi-major axis, px, about the middle of the frame: tilt 0 to 60 degrees.
fn annulus(random: &mut Random, semi_axis: f64) -> Scene {
    let mut scene = Scene::empty(Camera::new(SIZE, SIZE, F));
    let middle = f64::from(SIZE) / 2.0;
    let pose = Pose {
        x: middle + random.within(-0.5, 0.5),
        y: middle + random.within(-0.5, 0.5),
        distance: F * 10.0 / semi_axis,
        tilt: random.within(0.0, 60.0),
        azimuth: random.within(0.0, 360.0),
    };
    let artwork = Artwork::annulus(10.0, 5.0);
    scene.targets.push(concentric_host::render::Target { artwork, pose, at: [0.0, 0.0] });
    scene
}

/// A target that was found.
struct Found {
    trial: u32,
    /// Error, px, and in reported standard deviations.
    error: f64,
    sigmas: f64,
    target: Target,
    /// Largest share of a circle that is hidden.
    hidden: f64,
}

#[derive(Default)]
struct Outcome {
    frames: usize,
    found: Vec<Found>,
    false_targets: usize,
}

impl Outcome {
    fn add(&mut self, frame: &Frame, trial: u32, spec: TargetSpec) {
        let truth = &frame.truth.targets[0];
        self.frames += 1;
        for target in detect(frame, spec).0 {
            let scale = f64::from(Position::SCALE);
            let dx = f64::from(target.centre.x) / scale - truth.x;
            let dy = f64::from(target.centre.y) / scale - truth.y;
            if dx.hypot(dy) > 5.0 {
                self.false_targets += 1;
                continue;
            }
            let c = target.covariance;
            let (xx, xy, yy) = (f64::from(c.xx), f64::from(c.xy), f64::from(c.yy));
            let square = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy);
            let hidden = truth.circles.iter().map(|circle| circle.hidden).fold(0.0, f64::max);
            self.found.push(Found { trial, error: dx.hypot(dy), sigmas: square.sqrt(), target, hidden });
        }
    }

    fn share_found(&self) -> f64 {
        self.found.len() as f64 / self.frames as f64
    }

    /// Number of targets that are wrong without saying so.
    fn silent(&self) -> Vec<&Found> {
        let (error, sigmas) = SILENT;
        self.found.iter().filter(|found| found.error > error && found.sigmas > sigmas).collect()
    }

    fn quantile(&self, share: f64, value: impl Fn(&Found) -> f64) -> f64 {
        let mut values: Vec<f64> = self.found.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values.get(((values.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN)
    }

    fn flagged(&self, flag: Flags) -> usize {
        self.found.iter().filter(|found| found.target.flags.contains(flag)).count()
    }

    fn print(&self, what: &str) {
        let (error, sigmas) = (|found: &Found| found.error, |found: &Found| found.sigmas);
        println!(
            "{what:24} found {:5.1} %; error px: median {:.4}, 99 % {:.3}; in sigmas: median {:.2}, 99 % {:.1}; silent {}, \
             occluded {}, cut {}, false {}",
            100.0 * self.share_found(),
            self.quantile(0.5, error),
            self.quantile(0.99, error),
            self.quantile(0.5, sigmas),
            self.quantile(0.99, sigmas),
            self.silent().len(),
            self.flagged(Flags::OCCLUDED),
            self.flagged(Flags::CUT),
            self.false_targets
        );
        for found in self.silent() {
            let Found { trial, error, sigmas, target, .. } = found;
            println!("    trial {trial}: {error:.3} px, {sigmas:.1} sigmas, {:?}", target.flags);
        }
    }
}

/// Frames of one target each, damaged at random places; the ratio is given in every second.
fn damage(what: &str, change: impl Fn(&mut Scene, &mut Random, f64)) -> Outcome {
    damage_seen(what, change, |_, _, _| ())
}

/// The same with something done to the frame.
fn damage_seen(
    what: &str,
    change: impl Fn(&mut Scene, &mut Random, f64),
    seen: impl Fn(&mut Frame, &mut Random, f64),
) -> Outcome {
    let mut all = Outcome::default();
    for trial in 0..trials(200) {
        let mut random = Random(Pcg64::seed_from_u64(u64::from(trial) + 1000));
        let size = SIZES[trial as usize / 2 % SIZES.len()];
        let mut scene = annulus(&mut random, size);
        change(&mut scene, &mut random, size);
        let mut frame = scene.render(u64::from(trial));
        seen(&mut frame, &mut random, size);
        let spec = if trial % 2 == 0 { TargetSpec::any() } else { TargetSpec::ring(0.5).expect("a ratio") };
        all.add(&frame, trial, spec);
    }
    all.print(what);
    assert_eq!(all.false_targets, 0, "{what}");
    all
}

fn strip(scene: &mut Scene, random: &mut Random, place: (f64, f64), width: f64, tone: f64) {
    let ((x, y), direction) = (place, random.within(0.0, 180.0));
    scene.occluders.push(Occluder { cover: Cover::Strip { x, y, width, length: 900.0, direction }, tone });
}

#[test]
fn nothing_hidden_is_nothing_flagged() {
    let all = damage("nothing", |_, _, _| ());
    assert_eq!((all.share_found(), all.silent().len()), (1.0, 0));
    assert_eq!((all.flagged(Flags::OCCLUDED), all.flagged(Flags::CUT)), (0, 0));
    // Teeth: the damage of the other tests is more than the errors here would hide.
    assert!(all.quantile(1.0, |found| found.error) < 0.03);
}

/// An object over 40 % of the perimeter.
#[test]
fn two_fifths_hidden() {
    for (tone, least) in [(0.0, 0.9), (0.25, 0.85), (0.5, 0.6), (0.75, 0.9), (0.9, 0.9)] {
        let all = damage(&format!("wedge 0.4, tone {tone}"), |scene, random, _| {
            scene.hide(0, 0.4, random.within(0.0, 360.0), tone);
        });
        assert!(all.share_found() >= least, "tone {tone}: {}", all.share_found());
        assert_eq!(all.flagged(Flags::OCCLUDED), all.found.len(), "tone {tone}");
        assert_eq!(all.silent().len(), 0, "tone {tone}");
        // The gap is known.
        assert!(all.found.iter().all(|found| found.target.gap() > 100.0), "tone {tone}");
        // Teeth: as if nothing were hidden, the standard deviation would be several times too small.
        assert!(all.quantile(0.5, |found| found.error) > 0.01, "tone {tone}");
    }
}

/// Small targets whose hole is cut by what is nearly as dark as the ring: an ellipse through a piece of it and the border of what
/// lies there is not taken for the circle, because the outer one tells where that is.
#[test]
fn a_cut_hole_is_found_by_the_circle_around_it() {
    let cell = Cell { radius: 15.0, hidden: 0.4, draws: 1, ..Cell::default() };
    let mut all = Outcome::default();
    let frames = [43, 253, 354, 450];
    for index in frames {
        let frame = cell.scene(index).render(cell.noise_seed(index, 0));
        all.add(&frame, index, TargetSpec::ring(cell.ratio as f32).expect("a ratio"));
    }
    assert_eq!((all.found.len(), all.false_targets), (frames.len(), 0));
    assert_eq!(all.flagged(Flags::OCCLUDED), frames.len());
    assert!(all.quantile(1.0, |found| found.error) < 0.1 && all.quantile(1.0, |found| found.sigmas) < 4.0);
}

/// A cable, and a scratch as thin as the blur.
#[test]
fn strips_and_scratches() {
    for (tone, cable, scratch) in
        [(0.0, 0.4, 0.8), (0.3, 0.5, 0.9), (0.6, 0.8, 0.95), (0.9, 0.7, 0.9), (1.0, 0.5, 0.9)]
    {
        let wide = damage(&format!("strip, tone {tone}"), |scene, random, size| {
            let place = random.around(scene, (0.0, 0.8 * size));
            let width = random.within(0.1, 0.35) * size;
            strip(scene, random, place, width, tone);
        });
        let thin = damage(&format!("scratch, tone {tone}"), |scene, random, size| {
            let place = random.around(scene, (0.0, 0.8 * size));
            let width = random.within(0.5, 2.5);
            strip(scene, random, place, width, tone);
        });
        for (all, least) in [(wide, cable), (thin, scratch)] {
            assert!(all.share_found() >= least, "tone {tone}: {}", all.share_found());
            // The ones left are small targets with an object of almost the paper's tone along a rim.
            assert!(all.silent().len() * 200 <= all.frames, "tone {tone}: {}", all.silent().len());
        }
    }
}

/// A bite out of the rim. One that has the paper's tone and reaches the hole makes a letter C, which is no target.
#[test]
fn bites() {
    for tone in [0.0, 0.3, 0.6, 0.9, 1.0] {
        let all = damage(&format!("bite, tone {tone}"), |scene, random, size| {
            let (x, y) = random.around(scene, (0.8 * size, 1.1 * size));
            let radius = random.within(0.1, 0.5) * size;
            scene.occluders.push(Occluder { cover: Cover::Disc { x, y, radius }, tone });
        });
        assert!(all.share_found() >= if tone == 1.0 { 0.75 } else { 0.95 }, "tone {tone}");
        assert_eq!(all.silent().len(), 0, "tone {tone}");
        let large = all.found.iter().filter(|found| found.hidden > 0.16);
        assert!(large.clone().all(|found| found.target.flags.contains(Flags::OCCLUDED)), "tone {tone}");
        assert!(large.count() > 0);
    }
}

/// Reflections up to three times as light as the paper, anywhere on the target.
#[test]
fn glare() {
    let all = damage("glare", |scene, random, size| {
        let (x, y) = random.around(scene, (0.0, 1.1 * size));
        let (radius, strength) = (random.within(0.1, 0.3) * size, random.within(0.5, 3.0));
        scene.occluders.push(Occluder { cover: Cover::Glare { x, y, radius, strength }, tone: 1.0 });
    });
    assert!(all.share_found() >= 0.6, "{}", all.share_found());
    assert_eq!(all.silent().len(), 0);
}

/// Shadows with a straight border, sharp or soft, that leave 30 to 80 % of the light, anywhere on the target.
#[test]
fn shadows() {
    let all = damage_seen(
        "shadow",
        |_, _, _| (),
        |frame, random, size| {
            let middle = f64::from(SIZE) / 2.0;
            let (sin, cos) = random.within(0.0, std::f64::consts::TAU).sin_cos();
            let (at, soft) = (random.within(-1.1, 1.1) * size, 0.5 * 20f64.powf(random.within(0.0, 1.0)));
            let rest = random.within(0.3, 0.8);
            for (i, pixel) in frame.pixels.iter_mut().enumerate() {
                let (x, y) = ((i % frame.width) as f64 - middle, (i / frame.width) as f64 - middle);
                let lit = 1.0 / (1.0 + (-(cos * x + sin * y - at) / soft).exp());
                *pixel = (f64::from(*pixel) * (rest + (1.0 - rest) * lit)).round() as u8;
            }
        },
    );
    assert!(all.share_found() >= 0.5, "{}", all.share_found());
    assert_eq!(all.silent().len(), 0);
}

/// Targets whose true centre is in the frame, up to half of them outside.
#[test]
fn cut_by_the_frame() {
    let all = damage("cut", |scene, random, size| {
        let far = random.within(0.0, 0.8) * size;
        let edge = f64::from(SIZE) - 1.0;
        let pose = &mut scene.targets[0].pose;
        match random.within(0.0, 4.0) as u32 {
            0 => pose.x = far,
            1 => pose.x = edge - far,
            2 => pose.y = far,
            _ => pose.y = edge - far,
        }
    });
    assert!(all.share_found() >= 0.9, "{}", all.share_found());
    assert_eq!(all.silent().len(), 0);
    let cut = all.found.iter().filter(|found| found.hidden > 0.05);
    assert!(cut.clone().all(|found| found.target.flags.contains(Flags::CUT)) && cut.count() > 10);
}
