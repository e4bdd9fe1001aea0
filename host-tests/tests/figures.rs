//! The figures that the README states: finding rate and accuracy on rendered frames.
//!
//! `cargo test --release --test figures -- --nocapture` prints them.

mod common;

use common::{detect, errors};
use concentric::{Target, TargetSpec};
use concentric_host::render::{Artwork, Mark, Scene, Style};

/// Root of the mean square distance, px.
fn rms(errors: &[(f64, f64)]) -> f64 {
    (errors.iter().map(|(x, y)| x * x + y * y).sum::<f64>() / errors.len() as f64).sqrt()
}

struct Cell {
    errors: Vec<(f64, f64)>,
    normalised: Vec<f64>,
    missed: usize,
    false_targets: usize,
}

/// Frames of one target in the middle of 1280 x 1024: f 2580 px, 800 mm away.
fn single(radius: f64, tilt: f64, trials: u32, change: impl Fn(&mut Scene), spec: TargetSpec) -> Cell {
    let mut cell = Cell { errors: vec![], normalised: vec![], missed: 0, false_targets: 0 };
    for trial in 0..trials {
        // Azimuth and sub-pixel place walk over their ranges without a pattern.
        let turn = |step: f64| (f64::from(trial) * step + radius * 0.37 + tilt * 0.11).fract();
        let mut scene = Scene::single(radius, tilt, 360.0 * turn(0.381_966), [turn(0.618_034) - 0.5, turn(0.754_878) - 0.5]);
        change(&mut scene);
        let frame = scene.render(u64::from(trial) + (radius * 1000.0 + tilt) as u64);
        let (targets, _) = detect(&frame, spec);
        let (found, false_targets) = errors(&targets, &frame.truth);
        cell.missed += 1 - found.len();
        cell.false_targets += false_targets;
        for (dx, dy, target) in found {
            cell.errors.push((dx, dy));
            cell.normalised.push(mahalanobis(dx, dy, target));
        }
    }
    cell
}

/// Squared error in units of the reported covariance: 2 on average if that is right.
fn mahalanobis(dx: f64, dy: f64, target: &Target) -> f64 {
    let c = target.covariance;
    let (xx, xy, yy) = (f64::from(c.xx), f64::from(c.xy), f64::from(c.yy));
    (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy)
}

#[test]
fn pooled_accuracy() {
    let trials = std::env::var("CONCENTRIC_TRIALS").ok().and_then(|n| n.parse().ok()).unwrap_or(3);
    for noise in [0.0, 2.0] {
    for spec in [TargetSpec::any(), TargetSpec::ring(0.5).unwrap()] {
        let (mut all, mut missed, mut false_targets, mut normalised) = (vec![], 0, 0, vec![]);
        for radius in [10.0, 20.0, 30.0, 40.0, 50.0, 60.0] {
            let mut line = format!("{radius:4}");
            for tilt in [12.0, 24.0, 36.0, 48.0, 60.0, 72.0] {
                let cell = single(radius, tilt, trials, |scene| scene.photometry.noise = noise, spec);
                line += &format!(" {:.4}", rms(&cell.errors));
                line += &format!("({:.2})", (cell.normalised.iter().sum::<f64>()/cell.normalised.len() as f64/2.0).sqrt());
                missed += cell.missed;
                false_targets += cell.false_targets;
                all.extend(cell.errors);
                normalised.extend(cell.normalised);
            }
            println!("{line}");
        }
        println!("noise {noise} pooled {:.4} px, missed {missed}, false {false_targets}, of {}", rms(&all), all.len() + missed);
    }
    }
}

/// Frames with many targets: how many were there, found, false.
fn crowd(width: u32, height: u32, seeds: std::ops::Range<u64>, change: impl Fn(&mut Scene)) -> [usize; 3] {
    let mut counts = [0; 3];
    for seed in seeds {
        for spec in [TargetSpec::any(), TargetSpec::ring(0.5).unwrap()] {
            let mut scene = Scene::many(60, width, height, true, seed).expect("sixty targets fit");
            change(&mut scene);
            let frame = scene.render(seed);
            let (targets, summary) = detect(&frame, spec);
            let (found, false_targets) = errors(&targets, &frame.truth);
            for (dx, dy, t) in &found { if dx.hypot(*dy) > 0.1 { println!("off {:?} {:.3} {:?} {}", t.centre.to_px(), dx.hypot(*dy), t.flags.names().collect::<Vec<_>>(), t.circles[1].ellipse.b); } }
            if found.len() < 60 || false_targets > 0 { 
                for t in &frame.truth.targets { if !found.iter().any(|(dx,dy,f)| { let (x,y)=f.centre.to_px(); (t.x-x as f64).hypot(t.y-y as f64)<3.0 }) { println!("missed {:.1} {:.1} {:?}", t.x,t.y,t.circles.iter().map(|c| c.ellipse).collect::<Vec<_>>()); } }
                println!("{width} seed {seed} {spec:?}: {} found, {false_targets} false {summary:?}", found.len()); }
            counts[0] += frame.truth.targets.len();
            counts[1] += found.len();
            counts[2] += false_targets;
        }
    }
    counts
}

#[test]
fn sixty_targets_in_clutter() {
    for (width, height) in [(640, 480), (1280, 1024)] {
        println!("{width}: {:?}", crowd(width, height, 0..10, |_| ()));
    }
}

#[test]
fn exposures() {
    for (black, white) in [(20.0, 60.0), (190.0, 240.0)] {
        println!("{black}: {:?}", crowd(640, 480, 0..5, |scene| (scene.photometry.black, scene.photometry.white) = (black, white)));
    }
}

#[test]
fn marks_and_lines() {
    let marks = [None, Some(Mark::Plus), Some(Mark::Dot), Some(Mark::Digits("58".into()))];
    for radius in [10.0, 20.0, 40.0] {
        for style in [Style::Bands, Style::Lines(1.0), Style::Lines(1.5)] {
            for mark in &marks {
                for spec in [TargetSpec::any(), TargetSpec::ring(0.5).unwrap()] {
                    let mut all = vec![];
                    let mut missed = 0;
                    for tilt in [0.0, 20.0, 40.0, 60.0] {
                        let cell = single(radius, tilt, 3, |scene| {
                            scene.targets[0].artwork = Artwork { style, mark: mark.clone(), ..Artwork::annulus(radius, radius / 2.0) };
                        }, spec);
                        missed += cell.missed + cell.false_targets;
                        all.extend(cell.errors);
                    }
                    println!("{radius} {style:?} {mark:?} {} rms {:.4} missed {missed}", spec.ratios().len(), rms(&all));
                }
            }
        }
    }
}
