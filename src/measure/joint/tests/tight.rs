//! Targets so small that their edges bend as tightly as the blur is wide.

extern crate std;

use super::super::samples::{self, Samples};
use super::super::scene::Scene;
use super::super::view::View;
use super::{origin, shape};
use crate::appearance::{Model, Outline};
use crate::fit::Shape;
use crate::fixed::GREY;
use crate::scan::{Axis, Crossing, NEAR, Stretch};
use std::vec::Vec;

/// Where edges bend as tightly as the blur is wide, and blur into each other, the samples of a picture without noise are as the model
/// has them, and far stretches tell no level that another edge reaches.
#[test]
fn tight_edges_are_blurred_as_they_are() {
    let outlines = [(16.0, 8.0, -1.0), (8.0, 4.0, 1.0)]
        .into_iter()
        .map(|(a, b, inside)| Outline::new(shape(a, b, 0.9), inside).unwrap())
        .collect();
    let model = Model { outlines, dark: 40.0, bright: 190.0, gx: 0.0, gy: 0.0, blur: 1.5 };
    let scene = Scene::new(&model, 16.0, 0.3, false);
    let mut count = [0; 2];
    for (k, axis, along, across) in
        (0..2).flat_map(|k| [Axis::Row, Axis::Column].into_iter().flat_map(move |axis| edges(k, axis)))
    {
        let near: [u8; NEAR] = core::array::from_fn(|i| picture(axis, along + i as i32 - 3, across));
        let stretch = |first: i32, step: i32| {
            let levels: [u8; 4] = core::array::from_fn(|i| picture(axis, first + step * i as i32, across));
            Stretch::of(&levels[..2], 1)
        };
        let far = [stretch(along - 4, -1), stretch(along + 3, 1)];
        let (x, y) = if axis == Axis::Row { (along, across) } else { (across, along) };
        let crossing = Crossing::new(axis, ((x + 500) as u16, (y + 500) as u16), near, far);
        let track = scene.track(k).unwrap();
        let mut room = None;
        let Some(view) = View::new(&scene, &track, &crossing, &origin(), &mut room) else { continue };
        let mut samples = Samples::default();
        view.samples(&mut samples);
        let misfit = samples.misfit();
        count[k] += 1;
        assert!(misfit < 3 * GREY, "{k} {axis:?} {along} {across}: {misfit}");
        for side in [-1, 1] {
            if let samples::Stretch::Clear(far) = view.far(side) {
                assert!(far.residual.abs() < 3 * GREY, "{k} {axis:?} {along} {across}: {far:?}");
            }
        }
    }
    assert!(count[0] > 60 && count[1] > 25, "{count:?}");
}

/// Where rows or columns pass outline `k` of that picture: the pixel after the edge along the axis, and that across it.
fn edges(k: usize, axis: Axis) -> Vec<(usize, Axis, i32, i32)> {
    let outline = shape([16.0, 8.0][k], [8.0, 4.0][k], 0.9);
    let inside = |along: i32, across: i32| {
        let (x, y) = if axis == Axis::Row { (along, across) } else { (across, along) };
        outline.square(x as f32 - outline.cx, y as f32 - outline.cy) < 1.0
    };
    let mut all = Vec::new();
    for across in -20..=20 {
        for along in -20..=20 {
            if inside(along, across) != inside(along - 1, across) {
                all.push((k, axis, along, across));
            }
        }
    }
    all
}

/// A level of that picture: the blur summed up.
fn picture(axis: Axis, along: i32, across: i32) -> u8 {
    let (x, y) = if axis == Axis::Row { (along, across) } else { (across, along) };
    let outlines = [shape(16.0, 8.0, 0.9), shape(8.0, 4.0, 0.9)];
    let (mut sum, mut all) = (0.0, 0.0);
    for i in -60..=60 {
        for j in -60..=60 {
            let (dx, dy) = (0.1 * i as f32, 0.1 * j as f32);
            let weight = libm::expf(-0.5 * (dx * dx + dy * dy) / (1.5 * 1.5));
            let is_inside = |o: &Shape| o.square(x as f32 + dx - o.cx, y as f32 + dy - o.cy) < 1.0;
            all += weight;
            sum += if is_inside(&outlines[0]) && !is_inside(&outlines[1]) { 0.0 } else { weight };
        }
    }
    libm::roundf(40.0 + 150.0 * sum / all) as u8
}
