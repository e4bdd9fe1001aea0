//! Ids of targets that move, appear and disappear.

mod common;

use common::detect;
use concentric::TargetSpec;
use concentric::track::{MAX_MISSED, Tracker};
use concentric_host::render::Scene;
use std::collections::BTreeMap;

/// The ids of a frame's targets by the number of the target in the scene, with their ages.
fn ids(tracker: &mut Tracker<16>, scene: &Scene, seed: u64) -> BTreeMap<usize, (u16, u32)> {
    let frame = scene.render(seed);
    let (targets, _) = detect(&frame, TargetSpec::any());
    tracker.begin();
    let mut ids = BTreeMap::new();
    for target in &targets {
        let (x, y) = target.centre.to_px();
        let near = |truth: f64, found: f32| (truth - f64::from(found)).abs() < 1.0;
        let truth = frame.truth.targets.iter().position(|truth| near(truth.x, x) && near(truth.y, y));
        let track = tracker.follow(target).expect("room for all");
        assert!(ids.insert(truth.expect("a true target"), (track.id, track.age)).is_none());
    }
    ids
}

fn moved(scene: &Scene, frame: usize) -> Scene {
    let mut scene = scene.clone();
    for (i, target) in scene.targets.iter_mut().enumerate() {
        let (dx, dy) = [(3.0, 1.0), (-2.0, 2.5), (0.0, -3.0)][i % 3];
        target.pose.x += dx * frame as f64;
        target.pose.y += dy * frame as f64;
    }
    scene
}

#[test]
fn ids_stay_with_targets_that_move() {
    let scene = Scene::many(6, 640, 480, false, 2).expect("six fit");
    let mut tracker = Tracker::new();
    let first = ids(&mut tracker, &scene, 0);
    assert_eq!(first.len(), 6);
    for frame in 1..6 {
        let now = ids(&mut tracker, &moved(&scene, frame), frame as u64);
        assert_eq!(now.len(), 6, "frame {frame}");
        for (target, (id, age)) in now {
            assert_eq!((id, age), (first[&target].0, frame as u32), "frame {frame}, target {target}");
        }
    }
}

#[test]
fn a_target_that_comes_back_soon_is_the_same_and_later_a_new_one() {
    let whole = Scene::many(4, 640, 480, false, 5).expect("four fit");
    let mut without = whole.clone();
    without.targets.pop();
    for (missing, same) in [(1, true), (usize::from(MAX_MISSED), true), (usize::from(MAX_MISSED) + 1, false)]
    {
        let mut tracker = Tracker::new();
        let first = ids(&mut tracker, &whole, 0);
        for frame in 0..missing {
            let now = ids(&mut tracker, &without, frame as u64 + 1);
            assert_eq!(now.len(), 3);
            assert!(now.iter().all(|(target, (id, _))| *id == first[target].0));
        }
        let now = ids(&mut tracker, &whole, 99);
        assert_eq!(now[&3].0 == first[&3].0, same, "missing in {missing} frames");
        assert_eq!(now[&3].1, if same { missing as u32 + 1 } else { 0 });
        assert_eq!(now[&0], (first[&0].0, missing as u32 + 1));
    }
}

/// More targets than tracks: those that are followed keep their ids.
#[test]
fn a_full_tracker_follows_on() {
    let scene = Scene::many(6, 640, 480, false, 2).expect("six fit");
    let (targets, _) = detect(&scene.render(0), TargetSpec::any());
    let mut tracker = Tracker::<4>::new();
    for frame in 0..3 {
        tracker.begin();
        let tracks: Vec<_> =
            targets.iter().map(|target| tracker.follow(target).map(|track| track.id)).collect();
        assert_eq!(tracks, [Some(1), Some(2), Some(3), Some(4), None, None], "frame {frame}");
    }
    assert_eq!(tracker.tracks().len(), 4);
}
