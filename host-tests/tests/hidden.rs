//! Targets of which a part cannot be seen.
//!
//! `cargo test --release -p concentric-host --test hidden -- --nocapture` prints the figures; `CONCENTRIC_TRIALS=1000` takes
//! that many frames of each kind of damage instead of a few.

mod common;

use common::detect;
use concentric::{Flags, Position, Target, TargetSpec};
use concentric_host::render::{Artwork, Camera, Cover, Occluder, Pose, Scene};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Size of the frames, px.
const SIZE: u32 = 260;
/// Focal length, px.
const F: f64 = 2580.0;

fn trials(few: u32) -> u32 {
    std::env::var("CONCENTRIC_TRIALS").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

/// Random numbers of one trial.
struct Random(Pcg64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u32() as f64 / f64::from(u32::MAX))
    }
}

/// One annulus of ratio 0.5 about the middle of the frame: semi-major axis 15 to 60 px, tilt 0 to 60 degrees.
fn annulus(random: &mut Random) -> (Scene, f64) {
    let mut scene = Scene::empty(Camera::new(SIZE, SIZE, F));
    let semi_axis = 15.0 * 4f64.powf(random.within(0.0, 1.0));
    let middle = f64::from(SIZE) / 2.0;
    let pose = Pose {
        x: middle + random.within(-0.5, 0.5),
        y: middle + random.within(-0.5, 0.5),
        distance: F * 10.0 / semi_axis,
        tilt: random.within(0.0, 60.0),
        azimuth: random.within(0.0, 360.0),
    };
    scene.targets.push(concentric_host::render::Target {
        artwork: Artwork::annulus(10.0, 5.0),
        pose,
        at: [0.0, 0.0],
    });
    (scene, semi_axis)
}

#[derive(Default)]
struct Outcome {
    frames: usize,
    /// Error px, in reported standard deviations, and what was found.
    found: Vec<(f64, f64, Target, u64)>,
    false_targets: usize,
    rejects: std::collections::BTreeMap<&'static str, u32>,
}

impl Outcome {
    fn add(&mut self, scene: &Scene, seed: u64, spec: TargetSpec) {
        let frame = scene.render(seed);
        let (targets, summary) = detect(&frame, spec);
        let truth = &frame.truth.targets[0];
        self.frames += 1;
        let mut hit = false;
        for target in targets {
            let scale = f64::from(Position::SCALE);
            let dx = f64::from(target.centre.x) / scale - truth.x;
            let dy = f64::from(target.centre.y) / scale - truth.y;
            if dx.hypot(dy) < 5.0 {
                let c = target.covariance;
                let (xx, xy, yy) = (f64::from(c.xx), f64::from(c.xy), f64::from(c.yy));
                let square = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy);
                if dx.hypot(dy) > 0.1 && square.sqrt() > 5.0 && std::env::var_os("CONCENTRIC_SHOW").is_some()
                {
                    println!(
                        "silent: seed {seed}, {:.3} px, {:.1} sigma {:?}",
                        dx.hypot(dy),
                        square.sqrt(),
                        scene.targets[0].pose
                    );
                }
                self.found.push((dx.hypot(dy), square.sqrt(), target, seed));
                hit = true;
            } else {
                self.false_targets += 1;
            }
        }
        if !hit {
            for (cause, n) in summary.rejected.iter().filter(|(_, n)| *n > 0) {
                *self.rejects.entry(cause.name()).or_default() += n;
            }
            if std::env::var_os("CONCENTRIC_SHOW").is_some() {
                println!("missed: seed {seed}, {:?}", scene.targets[0].pose);
            }
        }
    }

    fn print(&self, what: &str) {
        let mut errors: Vec<f64> = self.found.iter().map(|f| f.0).collect();
        let mut sigmas: Vec<f64> = self.found.iter().map(|f| f.1).collect();
        errors.sort_by(f64::total_cmp);
        sigmas.sort_by(f64::total_cmp);
        let at = |list: &[f64], share: f64| {
            list.get(((list.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN)
        };
        let silent = self.found.iter().filter(|f| f.0 > 0.1 && f.1 > 5.0).count();
        let flagged = self.found.iter().filter(|f| f.2.flags.contains(Flags::OCCLUDED)).count();
        println!(
            "{what:28} found {:5.1} %  error px: median {:.4} 99 % {:.4} max {:.3}; sigmas: median {:.2} 99 % {:.1} max \
             {:.1}; silent {silent}, flagged {flagged} of {}, false {} {:?}",
            100.0 * self.found.len() as f64 / self.frames as f64,
            at(&errors, 0.5),
            at(&errors, 0.99),
            at(&errors, 1.0),
            at(&sigmas, 0.5),
            at(&sigmas, 0.99),
            at(&sigmas, 1.0),
            self.found.len(),
            self.false_targets,
            self.rejects
        );
    }
}

fn damage(what: &str, few: u32, change: impl Fn(&mut Scene, &mut Random, f64)) -> Outcome {
    let mut all = Outcome::default();
    if std::env::var("ONLY").is_ok_and(|only| !what.starts_with(&only)) {
        return all;
    }
    for trial in 0..trials(few) {
        if std::env::var("SEED").is_ok_and(|seed| seed != trial.to_string()) {
            continue;
        }
        let mut random = Random::new(u64::from(trial) + 1000);
        let (mut scene, semi_axis) = annulus(&mut random);
        change(&mut scene, &mut random, semi_axis);
        let spec = if trial % 2 == 0 { TargetSpec::any() } else { TargetSpec::ring(0.5).expect("a ratio") };
        all.add(&scene, u64::from(trial), spec);
    }
    all.print(what);
    all
}

#[test]
fn figures() {
    damage("nothing", 60, |_, _, _| ());
    for tone in [0.0, 0.25, 0.5, 0.75, 0.9] {
        damage(&format!("wedge 0.4, tone {tone}"), 60, |scene, random, _| {
            scene.hide(0, 0.4, random.within(0.0, 360.0), tone);
        });
    }
    let around = |scene: &Scene, random: &mut Random, distance: f64| {
        let (pose, angle) = (scene.targets[0].pose, random.within(0.0, std::f64::consts::TAU));
        (pose.x + distance * angle.cos(), pose.y + distance * angle.sin())
    };
    for tone in [0.0, 0.3, 0.6, 0.9, 1.0] {
        damage(&format!("strip, tone {tone}"), 60, |scene, random, size| {
            let far = random.within(0.0, 0.8) * size;
            let (x, y) = around(scene, random, far);
            let width = random.within(0.1, 0.35) * size;
            let direction = random.within(0.0, 180.0);
            scene
                .occluders
                .push(Occluder { cover: Cover::Strip { x, y, width, length: 900.0, direction }, tone });
        });
        damage(&format!("scratch, tone {tone}"), 60, |scene, random, size| {
            let far = random.within(0.0, 0.8) * size;
            let (x, y) = around(scene, random, far);
            let width = random.within(0.5, 2.5);
            let direction = random.within(0.0, 180.0);
            scene
                .occluders
                .push(Occluder { cover: Cover::Strip { x, y, width, length: 900.0, direction }, tone });
        });
        damage(&format!("bite, tone {tone}"), 60, |scene, random, size| {
            let far = random.within(0.8, 1.1) * size;
            let (x, y) = around(scene, random, far);
            let radius = random.within(0.1, 0.5) * size;
            scene.occluders.push(Occluder { cover: Cover::Disc { x, y, radius }, tone });
        });
    }
    damage("glare", 60, |scene, random, size| {
        let far = random.within(0.0, 1.1) * size;
        let (x, y) = around(scene, random, far);
        let (radius, strength) = (random.within(0.1, 0.3) * size, random.within(0.5, 3.0));
        scene.occluders.push(Occluder { cover: Cover::Glare { x, y, radius, strength }, tone: 1.0 });
    });
    damage("cut", 60, |scene, random, size| {
        let far = random.within(0.0, 0.8) * size;
        let edge = f64::from(SIZE) - 1.0;
        let pose = &mut scene.targets[0].pose;
        match (random.within(0.0, 4.0)) as u32 {
            0 => pose.x = far,
            1 => pose.x = edge - far,
            2 => pose.y = far,
            _ => pose.y = edge - far,
        }
    });
}
