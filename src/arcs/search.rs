//! The ellipse with the most points on it.

use super::Arc;
use super::points::{MAX_POINTS, Point, Points};
use crate::fit::{Rough, Shape};
use crate::math;
use heapless::Vec;

/// Pieces of an outline of which trial arcs are made.
const PIECES: usize = 16;
/// Lengths of trial arcs in pieces, longest first, because a long one is the surer.
const LENGTHS: [usize; 4] = [11, 8, 6, 5];
/// Distance from a trial's ellipse within which a point counts, px.
const TRIAL: f32 = 1.5;
/// Distances within which points are taken for the fits that follow, px.
const REFINE: [f32; 2] = [1.5, 1.0];
/// The same from an ellipse that is only known to be concentric.
const REFINE_CONCENTRIC: [f32; 4] = [3.0, 2.0, 1.5, 1.0];
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
    let (mut best, mut most) = (None, MIN_POINTS - 1);
    for length in LENGTHS {
        for start in 0..PIECES {
            let mut sum = Rough::default();
            pieces.iter().cycle().skip(start).take(length).for_each(|piece| sum.join(piece));
            let Some(shape) = sum.fit().filter(|shape| shape.semi_axes().0 <= MAX_SIZE) else { continue };
            let shape = shape.scaled(unit);
            for dark_inside in [true, false] {
                let arc = Arc { shape, dark_inside };
                let count = count(&arc, points);
                if count > most {
                    (best, most) = (Some(arc), count);
                }
            }
        }
        if 2 * most > points.len() {
            break;
        }
    }
    refine(&best?, points, unit, &REFINE)
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
    let (mut best, mut most) = (None, MIN_POINTS - 1);
    for &(middle, _, dark_inside) in radii.iter().step_by(2) {
        let [first, ..] = REFINE_CONCENTRIC;
        let near = radii.iter().filter(|(radius, scale, dark)| {
            *dark == dark_inside && ((radius - middle) * scale).abs() < first
        });
        let (count, sum) = near.fold((0usize, 0.0), |(count, sum), (radius, ..)| (count + 1, sum + radius));
        if count > most {
            let shape = anchor.shape.grown(sum / count as f32);
            (best, most) = (Some(Arc { shape, dark_inside }), count);
        }
    }
    let unit = extent(&points.points);
    refine(&best?, &points.points, unit, &REFINE_CONCENTRIC)
}

/// The ellipse through all of the points, if at least this share of them lies on it.
pub(crate) fn common(points: &Points, dark_inside: bool, share: f32) -> Option<Arc> {
    let unit = extent(&points.points);
    let mut sum = Rough::default();
    points.points.iter().for_each(|point| sum.add(point.x / unit, point.y / unit));
    let arc = Arc { shape: sum.fit()?.scaled(unit), dark_inside };
    (count(&arc, &points.points) as f32 >= share * points.points.len() as f32).then_some(arc)
}

/// Points on the arc's ellipse.
fn count(arc: &Arc, points: &[Point]) -> usize {
    points.iter().filter(|point| arc.square_distance(point) < TRIAL * TRIAL).count()
}

/// Fits the ellipse to the points that are near it, as often as there are `distances`.
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
        let shape: Shape = sum.fit()?.scaled(unit);
        arc.shape = shape;
    }
    Some(arc)
}

/// Largest coordinate, at least 1 px.
fn extent(points: &[Point]) -> f32 {
    points.iter().fold(1.0, |extent, point| extent.max(point.x.abs()).max(point.y.abs()))
}
