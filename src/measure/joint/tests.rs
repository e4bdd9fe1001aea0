extern crate std;

mod free;
mod tight;

use super::arrow::Arrow;
use super::exact::{Axes, Passage, Place, distance};
use super::part::{PARTS, Part};
use super::samples::Samples;
use super::scene::Scene;
use super::view::View;
use crate::appearance::{Model, OWN, Outline, SHARED, Step};
use crate::edge::normal;
use crate::fit::{Border, Line};
use crate::fit::{Factor, Shape};
use crate::fixed::{BEND, ONE, PX, sector, unit};
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
                let far = [near[0], near[5]].map(|level| Stretch::of(&[level], 0));
                let (x, y) = along(first);
                let place = ((x as i32 + 500) as u16, (y as i32 + 500) as u16);
                all.push((k, Crossing::new(axis, place, near, far)));
            }
        }
    }
    all
}

fn origin() -> Origin {
    Origin::new((500, 500), None).unwrap()
}

fn arrow(model: &Model, crossings: &[(usize, Crossing)]) -> Arrow {
    let scene = Scene::new(model, SIZE, 0.3, false);
    let origin = origin();
    let mut arrow = Arrow::new();
    for k in 0..model.outlines.len() {
        let track = scene.track(k).unwrap();
        let mut parts = [Part::default(); PARTS];
        arrow.next();
        for (_, crossing) in crossings.iter().filter(|(of, _)| *of == k) {
            let mut room = None;
            let Some(view) = View::new(&scene, &track, crossing, &origin, &mut room) else { continue };
            let mut samples = Samples::default();
            view.samples(&mut samples);
            let part = &mut parts[sector(view.direction()) as usize * PARTS / 128];
            part.add(&view, &samples, &scene);
        }
        parts.iter().for_each(|part| arrow.add(part, &scene));
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

/// The right-hand sides are the slopes of half the sum of squares, whatever is unknown; less exactly where edges blur into each
/// other.
#[test]
fn equations_are_the_slope_of_the_squares() {
    for (ratio, room) in [(0.5, 0.06), (0.9, 0.16)] {
        let model = model(ratio);
        let crossings = crossings(&model);
        let scene = Scene::new(&model, SIZE, 0.3, false);
        let (m, right) = arrow(&model, &crossings).whole::<15>(&scene, SIZE);
        for unknown in 0..2 * OWN + SHARED {
            let by = match unknown {
                0..10 => 1e-3,
                10 | 11 => 0.3,
                12 | 13 => 3e-3,
                _ => 1e-2,
            };
            let squares = |by: f32| {
                let mut moved = model.clone();
                moved.take(&change(unknown, by), SIZE).unwrap();
                arrow(&moved, &crossings).squares()
            };
            // Samples that change sides make the squares jump: the median over steps hardly sees that.
            let mut slopes = [0.5, 0.7, 1.0, 1.4, 2.0].map(|size| {
                let by = size * by;
                (squares(by) - squares(-by)) / (-4.0 * by)
            });
            slopes.sort_by(f32::total_cmp);
            let slope = slopes[2];
            // In standard deviations of what noise of one level makes of it.
            let deviation = libm::sqrtf(m[unknown][unknown]);
            let (right, slope) = (right[unknown] / deviation, slope / deviation);
            assert!(
                (right - slope).abs() < room * (1.0 + slope.abs()),
                "{ratio} {unknown}: {right} for {slope}"
            );
        }
    }
}

/// The solution by blocks is that of the whole system.
#[test]
fn blocks_give_the_solution_of_the_whole() {
    let model = model(0.5);
    let scene = Scene::new(&model, SIZE, 0.3, false);
    let mut arrow = arrow(&model, &crossings(&model));
    let (m, right) = arrow.whole::<15>(&scene, SIZE);
    let factor = Factor::new(&m).unwrap();
    let want = factor.solve(right);
    let step = arrow.solve(&scene, SIZE).unwrap();
    assert!((0..2).all(|k| arrow.solution(k).unwrap().points > 40));
    let got = step.own.iter().flatten().chain(&step.shared);
    for (i, (got, want)) in got.zip(want).enumerate() {
        assert!((got - want).abs() < 1e-3 * want.abs() + 1e-6, "{i}: {got} for {want}");
    }
    let (solution, shared) = (arrow.solution(1).unwrap(), arrow.solved.as_ref().unwrap());
    let (own, more) = (solution.covariance(), solution.more(shared));
    let mut unit = [0.0; 15];
    unit[OWN + 3] = -0.5;
    let want = -0.5 * factor.solve(unit)[OWN + 3];
    let got = own[2][2] + more[2][2];
    assert!((got / want - 1.0).abs() < 1e-3, "{got} for {want}");
}

/// The sums by parts are nearly those of the single samples in f64.
#[test]
fn parts_have_the_sums_of_their_samples() {
    let model = model(0.5);
    let scene = Scene::new(&model, SIZE, 0.3, false);
    let crossings = crossings(&model);
    let (m, right) = arrow(&model, &crossings).whole::<15>(&scene, SIZE);
    let samples = samples(&model, &crossings);
    let product = |i: usize, j: usize| samples.iter().map(|(terms, _)| terms[i] * terms[j]).sum::<f64>();
    for i in 0..2 * OWN + SHARED {
        let want = samples.iter().map(|(terms, residual)| terms[i] * residual).sum::<f64>();
        let deviation = product(i, i).sqrt();
        // In the change by the blur the roundings of all samples add up.
        let room = if i == 2 * OWN + SHARED - 1 { 0.15 } else { 0.09 };
        assert!((f64::from(right[i]) - want).abs() < room * deviation, "{i}: {} for {want}", right[i]);
        for j in 0..=i {
            let (want, of_j) = (product(i, j), product(j, j).sqrt());
            let got = f64::from(m[i][j]);
            assert!((got - want).abs() < 0.05 * deviation * of_j, "{i} {j}: {got} for {want}");
        }
    }
}

/// Derivatives and residual of every near sample by differences of the levels that the model gives it, in f64.
fn samples(model: &Model, crossings: &[(usize, Crossing)]) -> Vec<([f64; 15], f64)> {
    let scene = Scene::new(model, SIZE, 0.3, false);
    let mut all = Vec::new();
    for (k, crossing) in crossings {
        let track = scene.track(*k).unwrap();
        let mut room = None;
        let Some(view) = View::new(&scene, &track, crossing, &origin(), &mut room) else { continue };
        let owns: [bool; NEAR] = view.owns();
        for (i, _) in owns.iter().enumerate().filter(|(_, own)| **own) {
            let along = i as f64 - 3.0;
            let at = (f64::from(crossing.x) - 500.0, f64::from(crossing.y()) - 500.0);
            let row = crossing.axis() == Axis::Row;
            let place = if row { (at.0 + along, at.1) } else { (at.0, at.1 + along) };
            let level = |by: Option<(usize, f32)>| {
                let mut moved = model.clone();
                if let Some((unknown, by)) = by {
                    moved.take(&change(unknown, by), SIZE).unwrap();
                }
                level(&moved, *k, place)
            };
            let derivatives = core::array::from_fn(|unknown| {
                let by = if unknown < 10 || unknown == 14 { 1e-3 } else { 0.01 };
                (level(Some((unknown, by))) - level(Some((unknown, -by)))) / (2.0 * f64::from(by))
            });
            all.push((derivatives, f64::from(crossing.near[i]) - level(None)));
        }
    }
    all
}

/// The level that the edge of outline `k` gives a place.
fn level(model: &Model, k: usize, (x, y): (f64, f64)) -> f64 {
    let outline = &model.outlines[k];
    let axes = Axes { along: (1.0, 0.0), across: (0.0, 1.0) };
    let (distance, curvature) = distance(outline, (x as f32, y as f32), &axes);
    let blur = f64::from(model.blur);
    let z = -f64::from(outline.inside) * (f64::from(distance) / blur + 0.5 * f64::from(curvature) * blur);
    let share = 0.5 * libm::erfc(-z / core::f64::consts::SQRT_2);
    let light = 1.0 + f64::from(model.gx) * x + f64::from(model.gy) * y;
    (f64::from(model.dark) + f64::from(model.contrast()) * share) * light
}

/// The passage in integers is that in f32, within a few of its units.
#[test]
fn integers_find_the_passage() {
    let (mut worst, mut count) = ([0.0f32; 9], 0);
    for (a, b, theta) in [(9.0, 8.0, 0.3), (30.0, 15.0, 1.0), (60.0, 45.0, 2.5), (400.0, 190.0, 0.7)] {
        let outline = Outline::new(shape(a, b, theta), -1.0).unwrap();
        let [row, column] = Line::both(&outline.shape, &outline.frame, outline.minor).unwrap();
        for line in -420..=420 {
            for (axis, seen) in [(Axis::Row, &row), (Axis::Column, &column)] {
                let axes = Axes { along: (1.0, 0.0), across: (0.0, 1.0) };
                let axes =
                    if axis == Axis::Row { axes } else { Axes { along: axes.across, across: axes.along } };
                let place = |h: f32| if axis == Axis::Row { (h, line as f32) } else { (line as f32, h) };
                for side in [-1000.0, 1000.0] {
                    let Some(far) = Passage::new(&outline.shape, place(side), &axes) else { continue };
                    let middle = 2 * libm::floorf(side + far.at) as i32 + 1;
                    let exact = Place::new(axis, (middle, 2 * line), &origin()).unwrap();
                    let want = exact.passage(&outline).unwrap();
                    let steep = want.cosines.0.abs() > ONE / 2;
                    let Some(got) = seen.passage((middle, 2 * line)) else {
                        assert!(!steep, "{a} {line} {axis:?}: nothing for {want:?}");
                        continue;
                    };
                    if !steep {
                        continue;
                    }
                    let pairs = [
                        (got.at, want.at, PX),
                        (got.cosines.0, want.cosines.0, ONE),
                        (got.cosines.1, want.cosines.1, ONE),
                        (got.change.0, want.change.0, BEND),
                        (got.change.1, want.change.1, BEND),
                        (got.bend, want.bend, BEND),
                        (got.reach, want.reach, ONE),
                        (got.direction.0, want.direction.0, ONE),
                        (got.direction.1, want.direction.1, ONE),
                    ];
                    for (worst, (got, want, one)) in worst.iter_mut().zip(pairs) {
                        *worst = worst.max((got - want).abs() as f32 / one as f32);
                    }
                    count += 1;
                }
            }
        }
    }
    let room = [1.2e-3, 6e-4, 6e-4, 4e-4, 4e-4, 4e-4, 1e-3, 1e-3, 1e-3];
    assert!(
        count > 2000 && worst.iter().zip(room).all(|(worst, room)| *worst < room),
        "{worst:?} of {count}"
    );
}

/// The distance in integers is that in f32, near the ellipse and as far as anything is told; so is the curvature.
#[test]
fn integers_tell_the_distance() {
    let (mut worst, mut count) = ([0.0f32; 2], 0);
    for (a, b, theta) in
        [(2.2, 2.0, 0.3), (6.0, 3.0, 1.0), (12.0, 10.0, 2.5), (60.0, 30.0, 0.7), (400.0, 190.0, 2.0)]
    {
        let outline = Outline::new(shape(a, b, theta), -1.0).unwrap();
        let [row, column] = Line::both(&outline.shape, &outline.frame, outline.minor).unwrap();
        for i in 0..2000 {
            let (sin, cos) = libm::sincosf(i as f32 * 0.37);
            let far = (b.min(5.0) * (2.0 * (i % 41) as f32 / 41.0 - 0.8)).max(-0.8 * b);
            let (x, y) = (outline.frame.inverse(cos, sin).0, outline.frame.inverse(cos, sin).1);
            let far = 1.0 + far / libm::sqrtf(x * x + y * y);
            let (x, y) = (outline.shape.cx + far * x, outline.shape.cy + far * y);
            let (x, y) = (libm::roundf(2.0 * x), libm::roundf(2.0 * y));
            for (axis, seen, middle) in [(Axis::Row, &row, (x, y)), (Axis::Column, &column, (y, x))] {
                let middle = (middle.0 as i32, middle.1 as i32);
                let (want, want_bend) = Place::new(axis, middle, &origin()).unwrap().distance(&outline, 0);
                let (got, bend) = seen.distance(seen.about_centre(middle)).unwrap();
                // Far from the ellipse neither is exact.
                let room = 1.0 + (want.abs() as f32 / PX as f32);
                worst[0] = worst[0].max((got - want).abs() as f32 / PX as f32 / room);
                worst[1] = worst[1].max((bend - want_bend).abs() as f32 / (want_bend + 200) as f32);
                count += 1;
            }
        }
    }
    assert!(count > 10_000 && worst[0] < 1e-3 && worst[1] < 0.02, "{worst:?} of {count}");
}

/// A border lies as far from its ellipse as it is told, everywhere.
#[test]
fn a_border_is_that_of_the_grown_ellipse() {
    let outline = Outline::new(shape(60.0, 30.0, 0.4), -1.0).unwrap();
    let axes = Axes { along: (1.0, 0.0), across: (0.0, 1.0) };
    for width in [-4.0, 3.0] {
        let [row, column] = Border::both(&outline.shape, width).unwrap();
        for y in -70..=70 {
            for x in -70..=70 {
                let (from, _) = distance(&outline, (x as f32, y as f32), &axes);
                // The distance is not exact far from it, nor is the border.
                if from < -8.0 || (from - width).abs() < 0.8 {
                    continue;
                }
                let inside = from < width;
                assert_eq!(row.contains(4 * x, 4 * y), inside, "{width} {x} {y}");
                assert_eq!(column.contains(4 * y, 4 * x), inside, "{width} {x} {y}");
            }
        }
        assert!(row.meets((-400, 400), 0) && !row.meets((-400, 400), 400) && !row.meets((-800, -400), 0));
    }
    assert!(Border::both(&outline.shape, -31.0).is_none());
}

#[test]
fn sectors_follow_the_turn() {
    for i in 0..4096 {
        let turn = (i as f32 + 0.5) / 4096.0;
        let (sin, cos) = libm::sincosf(turn * core::f32::consts::TAU);
        let direction = ((cos * ONE as f32) as i32, (sin * ONE as f32) as i32);
        let got = sector(direction) as f32 + 0.5 - 128.0 * turn;
        assert!(got.abs() < 0.65, "{i}: {got}");
        let (u, v) = unit((direction.0 * 15 / 16, direction.1 * 15 / 16));
        assert!((u - direction.0).abs() < 24 && (v - direction.1).abs() < 24, "{i}: {u} {v}");
    }
}

/// Each pixel near an outline belongs to one crossing at most, though rows and columns pass it.
#[test]
fn no_pixel_counts_twice() {
    let model = model(0.9);
    let scene = Scene::new(&model, SIZE, 0.3, false);
    let mut pixels = Vec::new();
    for (k, crossing) in &crossings(&model) {
        let track = scene.track(*k).unwrap();
        let mut room = None;
        let Some(view) = View::new(&scene, &track, crossing, &origin(), &mut room) else { continue };
        let mut samples = Samples::default();
        view.samples(&mut samples);
        for (i, _) in samples.own.iter().enumerate().filter(|(_, own)| **own) {
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

/// Noise that neighbouring samples have too moves each edge point by itself, a pattern those of a place together.
#[test]
fn residuals_that_neighbours_do_not_share_are_a_pattern() {
    use super::excess;
    // Twice the noise, of which three quarters of the variance are a pattern, over 80 points in 8 places.
    assert!((excess(16.0, 2.0, 80) - 8.5).abs() < 1e-5);
    // What chance makes of either.
    assert_eq!([excess(4.0, 2.0, 80), excess(6.0, 2.0, 80), excess(4.0, 3.0, 80)], [1.0; 3]);
}
