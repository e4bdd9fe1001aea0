extern crate std;

use super::arrow::Arrow;
use super::passage::{Axes, Passage, distance};
use super::scene::Scene;
use super::view::View;
use crate::appearance::{Model, OWN, Outline, SHARED, Step};
use crate::edge::normal;
use crate::fit::{Factor, Matrix, Shape};
use crate::measure::Origin;
use crate::scan::{Axis, Crossing, NEAR, Stretch};
use std::vec::Vec;

const SIZE: f32 = 60.0;

fn shape(a: f32, b: f32, theta: f32) -> Shape {
    let (s, c) = (libm::sinf(theta), libm::cosf(theta));
    let (p, q) = (0.25 * a * a, 0.25 * b * b);
    Shape::from_moments(0.2, -0.3, p * c * c + q * s * s, (p - q) * s * c, p * s * s + q * c * c).unwrap()
}

/// Two outlines, the inner one `ratio` times as large.
fn model(ratio: f32) -> Model {
    let outer = Outline::new(shape(SIZE, 45.0, 0.4), -1.0).unwrap();
    let inner = Outline::new(shape(SIZE * ratio, 45.0 * ratio, 0.4), 1.0).unwrap();
    let outlines = [outer, inner].into_iter().collect();
    Model { outlines, dark: 40.0, bright: 190.0, gx: 0.002, gy: -0.001, blur: 0.9 }
}

/// Crossings on every third row and column, with levels that `model` would nearly give.
fn crossings(model: &Model) -> Vec<(usize, Crossing)> {
    let mut all = Vec::new();
    for (k, outline) in model.outlines.iter().enumerate() {
        let shape = &outline.shape;
        for line in (-42..=42).step_by(3) {
            for (axis, sign) in
                [(Axis::Row, 1.0), (Axis::Row, -1.0), (Axis::Column, 1.0), (Axis::Column, -1.0)]
            {
                let along = |h: f32| if axis == Axis::Row { (h, line as f32) } else { (line as f32, h) };
                let axes =
                    if axis == Axis::Row { [(1.0, 0.0), (0.0, 1.0)] } else { [(0.0, 1.0), (1.0, 0.0)] };
                let axes = Axes { along: axes[0], across: axes[1] };
                let Some(passage) = Passage::new(shape, along(sign * 200.0), &axes) else { continue };
                let first = libm::ceilf(sign * 200.0 + passage.at);
                let mut step = 0.0;
                let near: [u8; NEAR] = core::array::from_fn(|i| {
                    let (x, y) = along(first - 3.0 + i as f32);
                    let lightness: f32 = model.outlines.iter().fold(1.0, |sum, outline| {
                        let (d, _) = distance(outline, (x, y), &axes);
                        sum + outline.inside * (1.0 - normal(d / model.blur).0)
                    });
                    step += 0.7;
                    let light = 1.0 + model.gx * x + model.gy * y;
                    libm::roundf(
                        (model.dark + model.contrast() * lightness) * light
                            + 3.0 * libm::sinf(step + line as f32),
                    ) as u8
                });
                let far = [near[0], near[5]].map(|level| Stretch::new(&[level]));
                let (x, y) = along(first);
                let place = ((x as i32 + 500) as u16, (y as i32 + 500) as u16);
                all.push((k, Crossing::new(axis, place, near, far)));
            }
        }
    }
    all
}

fn arrow(model: &Model, crossings: &[(usize, Crossing)]) -> Arrow {
    let scene = Scene::new(model, SIZE, 0.3, false);
    let origin = Origin::new((500, 500), None).unwrap();
    let mut arrow = Arrow::new(model);
    for (k, crossing) in crossings {
        let Some(view) = View::new(&scene, *k, crossing, &origin) else { continue };
        let Some(samples) = view.samples() else { continue };
        arrow.add(*k, &view.told(&samples), model);
    }
    arrow
}

/// The step that changes one unknown by `by`.
fn change(unknown: usize, by: f32) -> Step {
    let mut step = Step { own: [[0.0; OWN]; 2].into_iter().collect(), shared: [0.0; SHARED] };
    match unknown.checked_sub(2 * OWN) {
        Some(shared) => step.shared[shared] = by,
        None => step.own[unknown / OWN][unknown % OWN] = by,
    }
    step
}

/// The right-hand sides are the slopes of half the sum of squares, whatever is unknown.
#[test]
fn equations_are_the_slope_of_the_squares() {
    for ratio in [0.5, 0.9] {
        let model = model(ratio);
        let crossings = crossings(&model);
        let whole = arrow(&model, &crossings);
        assert!(whole.blocks.iter().all(|block| block.points > 40));
        for unknown in 0..2 * OWN + SHARED {
            let by = match unknown {
                0..10 => 1e-4,
                10 | 11 => 0.1,
                12 | 13 => 1e-3,
                _ => 2e-3,
            };
            let squares = |by: f32| {
                let mut moved = model.clone();
                moved.take(&change(unknown, by), SIZE).unwrap();
                arrow(&moved, &crossings).squares
            };
            let slope = (squares(by) - squares(-by)) / (-4.0 * by);
            let (right, weight) = match unknown.checked_sub(2 * OWN) {
                Some(i) => (whole.right[i], whole.shared[i][i]),
                None => {
                    let block = &whole.blocks[unknown / OWN];
                    (block.right[unknown % OWN], block.m[unknown % OWN][unknown % OWN])
                }
            };
            // In standard deviations of what noise of one level makes of it.
            let (right, slope) = (right / libm::sqrtf(weight), slope / libm::sqrtf(weight));
            assert!(
                (right - slope).abs() < 0.08 * (1.0 + slope.abs()),
                "{ratio} {unknown}: {right} for {slope}"
            );
        }
    }
}

/// The solution by blocks is that of the whole system.
#[test]
fn blocks_give_the_solution_of_the_whole() {
    let model = model(0.5);
    let arrow = arrow(&model, &crossings(&model));
    let mut m: Matrix<15> = [[0.0; 15]; 15];
    let mut right = [0.0; 15];
    for (k, block) in arrow.blocks.iter().enumerate() {
        for i in 0..OWN {
            right[OWN * k + i] = block.right[i];
            for j in 0..OWN {
                m[OWN * k + i][OWN * k + j] = block.m[i][j];
                m[2 * OWN + j][OWN * k + i] = block.cross[i][j];
            }
        }
    }
    for i in 0..SHARED {
        right[2 * OWN + i] = arrow.right[i];
        m[2 * OWN + i][2 * OWN..].copy_from_slice(&arrow.shared[i]);
    }
    let factor = Factor::new(&m).unwrap();
    let want = factor.solve(right);
    let solved = arrow.solve().unwrap();
    let step = solved.step();
    let got = step.own.iter().flatten().chain(&step.shared);
    for (i, (got, want)) in got.zip(want).enumerate() {
        assert!((got - want).abs() < 1e-3 * want.abs() + 1e-6, "{i}: {got} for {want}");
    }
    let spread = solved.spread(1).unwrap();
    let mut unit = [0.0; 15];
    unit[OWN + 3] = -0.5;
    let want = -0.5 * factor.solve(unit)[OWN + 3];
    let got = spread.own[2][2] + spread.shared[2][2];
    assert!((got / want - 1.0).abs() < 1e-3, "{got} for {want}");
}

/// Each pixel near an outline belongs to one crossing at most, though rows and columns pass it.
#[test]
fn no_pixel_counts_twice() {
    let model = model(0.9);
    let scene = Scene::new(&model, SIZE, 0.3, false);
    let origin = Origin::new((500, 500), None).unwrap();
    let mut pixels = Vec::new();
    for (k, crossing) in &crossings(&model) {
        let Some(view) = View::new(&scene, *k, crossing, &origin) else { continue };
        let Some(samples) = view.samples() else { continue };
        for (i, _) in samples.own.iter().enumerate().filter(|(_, own)| **own > 0.0) {
            let at = crossing.x + i as u16 - 3;
            let down = crossing.y() + i as u16 - 3;
            pixels.push(if crossing.axis() == Axis::Row { (at, crossing.y()) } else { (crossing.x, down) });
        }
    }
    let count = pixels.len();
    pixels.sort_unstable();
    pixels.dedup();
    assert!(count > 400 && pixels.len() == count, "{} of {count}", pixels.len());
}
