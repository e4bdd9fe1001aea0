//! The ellipse with the most points on it.

use super::Arc;
use super::points::{MAX_POINTS, Point, Points};
use crate::fit::{Adjustment, Rough, Shape};
use crate::math;
use heapless::Vec;

/// Pieces of an outline of which trial arcs are made.
const PIECES: usize = 16;
/// Lengths of trial arcs in pieces, and the steps between their starts.
const LENGTHS: [(usize, usize); 2] = [(7, 2), (5, 1)];
/// Trials that are refined.
const REFINED: usize = 2;
/// Distance from a trial's ellipse within which a point counts, px.
const TRIAL: f32 = 1.0;
/// Distances within which points are taken for the fits that follow, px.
const REFINE: [f32; 2] = [2.0, 1.0];
/// The same for the steps after these, and from a circle that is known to be concentric.
const ADJUST: [f32; 2] = [1.0, 0.6];
/// The same while its ellipse is kept similar to that of the known circle.
const SIMILAR: [f32; 2] = [2.5, 1.2];
/// Least ratio of the scores with which the ellipse is then better left free.
const FREE_GAIN: f32 = 1.15;
/// Most radii that are tried for it.
const MODES: usize = 2;
/// Distance within which points are of one concentric circle, px: perspective moves its centre.
const CONCENTRIC: f32 = 2.5;
/// Largest semi-axis of a trial in units of the points' extent.
const MAX_SIZE: f32 = 3.0;
/// Fewest points on an ellipse.
const MIN_POINTS: usize = 10;
/// Least distance of two circles of the same polarity, px.
const APART: f32 = 3.0;

/// The ellipse of a long arc: that of consecutive points with the most points of the whole outline on it.
pub(crate) fn free(mut points: Points) -> Option<Arc> {
    points.sort();
    let points = points.points.as_slice();
    let unit = extent(points);
    let mut pieces = [Rough::default(); PIECES];
    for (i, point) in points.iter().enumerate() {
        if let Some(piece) = pieces.get_mut(i * PIECES / points.len().max(1)) {
            piece.add(point.x / unit, point.y / unit);
        }
    }
    let mut best = None;
    let mut most = MIN_POINTS as f32;
    for trial in trials(&pieces, points, unit).into_iter().flatten() {
        let Some(arc) = refine(&trial.1, points, unit, &REFINE) else { continue };
        let score = score(&arc, points);
        if score > most {
            (best, most) = (Some(arc), score);
        }
    }
    best
}

/// The ellipses of consecutive pieces that have most points on them, with their scores.
fn trials(pieces: &[Rough; PIECES], points: &[Point], unit: f32) -> [Option<(f32, Arc)>; REFINED] {
    let mut best = [None; REFINED];
    for (length, step) in LENGTHS {
        for start in (0..PIECES).step_by(step.max(1)) {
            let mut sum = Rough::default();
            pieces.iter().cycle().skip(start).take(length).for_each(|piece| sum.join(piece));
            let Some(shape) = sum.fit().filter(|shape| shape.semi_axes().0 <= MAX_SIZE) else { continue };
            let shape = shape.scaled(unit);
            let scores = look(&shape, points);
            for (dark_inside, score) in [(true, scores[0]), (false, scores[1])] {
                let mut trial = Some((score, Arc { shape, dark_inside }));
                // Sorted by falling score.
                for place in &mut best {
                    if place.is_none_or(|(other, _): (f32, Arc)| other < score) {
                        core::mem::swap(place, &mut trial);
                    }
                }
            }
        }
    }
    best
}

/// The [`score`] of every second point on the ellipse for either polarity, dark inside first.
fn look(shape: &Shape, points: &[Point]) -> [f32; 2] {
    let mut scores = [0.0; 2];
    for point in points.iter().step_by(2) {
        let ((gx, gy), (dx, dy)) = shape.gradient(point.x, point.y);
        let excess = dx * gx + dy * gy - 1.0;
        let near = (1.0 - 0.25 * excess * excess / (gx * gx + gy * gy)).max(0.0);
        let [dark, light] = &mut scores;
        *(if gx * point.light.0 + gy * point.light.1 > 0.0 { dark } else { light }) += near;
    }
    scores
}

/// The ellipse of a circle that is concentric with the one of `anchor` and not the same.
pub(crate) fn around(points: &Points, anchor: &Arc) -> Option<Arc> {
    let mut radii = Vec::<(f32, f32, bool), MAX_POINTS>::new();
    for point in &points.points {
        let ((gx, gy), (dx, dy)) = anchor.shape.gradient(point.x, point.y);
        let radius = math::sqrt(dx * gx + dy * gy);
        let dark_inside = gx * point.light.0 + gy * point.light.1 > 0.0;
        // Px along the normal for each unit of the radius.
        let scale = radius / math::sqrt(gx * gx + gy * gy);
        let same = dark_inside == anchor.dark_inside && ((radius - 1.0) * scale).abs() < APART;
        if !same {
            let _ = radii.push((radius, scale, dark_inside));
        }
    }
    let (mut best, mut most) = (None, 0.0);
    for _ in 0..MODES {
        let Some((radius, dark_inside)) = take_mode(&mut radii) else { break };
        let trial = Arc { shape: anchor.shape.grown(radius), dark_inside };
        let Some(similar) = adjust(&trial, &points.points, &SIMILAR, Adjustment::similar) else { continue };
        let free = adjust(&similar, &points.points, &ADJUST, step);
        for (arc, gain) in [(Some(similar), 1.0), (free, FREE_GAIN)] {
            let Some(arc) = arc else { continue };
            let score = score(&arc, &points.points) / gain;
            if score > most {
                (best, most) = (Some(arc), score);
            }
        }
    }
    best
}

/// Takes those radii (with px for each unit and polarity) that most agree out of the list, and gives their mean.
fn take_mode(radii: &mut Vec<(f32, f32, bool), MAX_POINTS>) -> Option<(f32, bool)> {
    let near = |(radius, scale, dark): &(f32, f32, bool), middle: f32, dark_inside: bool| {
        *dark == dark_inside && ((radius - middle) * scale).abs() < CONCENTRIC
    };
    let (mut mode, mut most) = (None, MIN_POINTS - 1);
    for &(middle, _, dark_inside) in radii.iter().step_by(2) {
        let agree = radii.iter().filter(|radius| near(radius, middle, dark_inside));
        let (count, sum) = agree.fold((0, 0.0), |(count, sum), (radius, ..)| (count + 1, sum + radius));
        if count > most {
            (mode, most) = (Some((middle, sum / count as f32, dark_inside)), count);
        }
    }
    let (middle, mean, dark_inside) = mode?;
    radii.retain(|radius| !near(radius, middle, dark_inside));
    Some((mean, dark_inside))
}

/// The ellipse through all of the points, if at least this share of them lies on it.
pub(crate) fn common(points: &Points, dark_inside: bool, share: f32) -> Option<Arc> {
    let unit = extent(&points.points);
    let mut sum = Rough::default();
    points.points.iter().for_each(|point| sum.add(point.x / unit, point.y / unit));
    let start = Arc { shape: sum.fit()?.scaled(unit), dark_inside };
    let arc = refine(&start, &points.points, unit, &[])?;
    (count(&arc, &points.points) as f32 >= share * points.points.len() as f32).then_some(arc)
}

/// Number of points on the arc's ellipse, each the less the farther it is.
fn score(arc: &Arc, points: &[Point]) -> f32 {
    const SCALE: f32 = 1.0 / (TRIAL * TRIAL);
    points.iter().fold(0.0, |sum, point| sum + (1.0 - SCALE * arc.square_distance(point)).max(0.0))
}

/// Points on the arc's ellipse.
fn count(arc: &Arc, points: &[Point]) -> usize {
    points.iter().filter(|point| arc.square_distance(point) < TRIAL * TRIAL).count()
}

/// Fits the ellipse to the points that are near it, again and again: first algebraically within each of `distances`, which
/// gets there from far but shrinks an arc's ellipse, then geometrically.
fn refine(arc: &Arc, points: &[Point], unit: f32, distances: &[f32]) -> Option<Arc> {
    let mut arc = *arc;
    for &distance in distances {
        let (mut sum, mut count) = (Rough::default(), 0);
        for point in points.iter().filter(|point| arc.square_distance(point) < distance * distance) {
            sum.add(point.x / unit, point.y / unit);
            count += 1;
        }
        if count < MIN_POINTS {
            return None;
        }
        arc.shape = sum.fit()?.scaled(unit);
    }
    adjust(&arc, points, &ADJUST, step)
}

/// Adjusts the ellipse geometrically, with the points within each of `distances` in turn.
fn adjust(
    arc: &Arc,
    points: &[Point],
    distances: &[f32],
    step: impl Fn(&Adjustment) -> Option<Shape>,
) -> Option<Arc> {
    let mut arc = *arc;
    for &distance in distances {
        let mut adjustment = Adjustment::new(arc.shape)?;
        let mut count = 0;
        for point in points.iter().filter(|point| arc.square_distance(point) < distance * distance) {
            let view = adjustment.view(point.x, point.y);
            adjustment.add(&view);
            count += 1;
        }
        arc.shape = step(&adjustment).filter(|_| count >= MIN_POINTS)?;
    }
    Some(arc)
}

/// The step in which the whole ellipse is free.
fn step(adjustment: &Adjustment) -> Option<Shape> {
    adjustment.finish().map(|adjusted| adjusted.shape)
}

/// Largest coordinate, at least 1 px.
fn extent(points: &[Point]) -> f32 {
    points.iter().fold(1.0, |extent, point| extent.max(point.x.abs()).max(point.y.abs()))
}
