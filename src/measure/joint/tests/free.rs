//! Far stretches that need no look at other edges.

extern crate std;

use super::super::exact::{Axes, Passage};
use super::super::scene::Scene;
use super::{SIZE, model};
use crate::fixed::PX;
use crate::scan::Axis;

/// What is free of other edges by its length is so by their ellipses too; a little farther it is not.
#[test]
fn free_lengths_are_clear_of_other_edges() {
    let (mut free, mut beyond) = (0, 0);
    for ratio in [0.6, 0.65, 0.7, 0.75] {
        let model = model(ratio);
        let scene = Scene::new(&model, SIZE, 0.3, false);
        for (k, outline) in model.outlines.iter().enumerate() {
            let track = scene.track(k).unwrap();
            for (x, sign) in (-44..=44).flat_map(|x| [(x, 1.0f32), (x, -1.0)]) {
                let axes = Axes { along: (0.0, 1.0), across: (1.0, 0.0) };
                let Some(passage) = Passage::new(&outline.shape, (x as f32, sign * 200.0), &axes) else {
                    continue;
                };
                if passage.gradient.0.abs() < passage.gradient.1.abs() {
                    continue;
                }
                let edge = sign * 200.0 + passage.at;
                let pixel = libm::ceilf(edge);
                for (side, more) in [-1, 1].into_iter().flat_map(|side| (0..16).map(move |more| (side, more)))
                {
                    let inwards = side as f32 * sign < 0.0;
                    let first = 4 * pixel as i32 - 2 + 14 * side;
                    let last = first + side * 4 * more;
                    let clear = track.is_clear(Axis::Column, inwards, (first, last), 4 * x);
                    let reach = (last - first).abs() as f32 / 4.0 + 3.5 + (pixel - 0.5 - edge).abs();
                    let left = track.free(inwards) - (reach * PX as f32) as i32;
                    free += i32::from(left >= 0);
                    beyond += i32::from(left < 0 && left > -3 * PX && !clear);
                    assert!(left < 0 || clear, "{ratio} {k} {x} {sign}: {side} {more}");
                }
            }
        }
    }
    assert!(free > 500 && beyond > 20, "{free} {beyond}");
}
