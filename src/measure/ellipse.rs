//! One edge: its edge points to an ellipse.

use super::origin::Origin;
use crate::edge::Edge;
use crate::fit::{Adjusted, Adjustment, Sums};
use crate::math;
use crate::reject::Reject;
use crate::scan::{Axis, Crossing, Pool};
use crate::settings::limits;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Sectors in which edge points are looked for.
pub(super) const SECTORS: u32 = 32;

/// An edge after its fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    pub adjusted: Adjusted,
    pub dark_inside: bool,
    /// Longest run of sectors without an edge point, of 32.
    pub gap: u32,
    /// Radius in units of the outer circle's.
    pub ratio: f32,
    /// The same as it was measured.
    pub measured_ratio: f32,
}

pub(super) type FittedList = Vec<Fitted, MAX_CIRCLES>;

/// Appends to a list that is never longer than the one it is made of.
pub(super) fn list(items: impl Iterator<Item = Fitted>) -> FittedList {
    let mut list = FittedList::new();
    for item in items.take(MAX_CIRCLES) {
        let _ = list.push(item);
    }
    list
}

/// Fits the ellipse of one edge to its edge points.
pub(super) fn fit(edge: &Edge, pool: &Pool<'_>, origin: &Origin) -> Result<Fitted, Reject> {
    let mut sums = Sums::default();
    let crossings = || pool.iter(edge.crossings).filter_map(|crossing| edge_point(crossing, origin.pixel));
    crossings().filter_map(|point| origin.on_grid(point)).for_each(|(x, y)| sums.add(x, y));
    let points = || crossings().filter_map(|point| origin.undistorted(point));
    let start = sums.fit().ok_or(Reject::NotElliptic)?;
    let begin = |shape| Adjustment::new(shape).ok_or(Reject::NotElliptic);
    let mut step = adjust(begin(start)?, points(), f32::INFINITY)?;
    let limit = limits::OUTLIER * step.adjusted.rms.max(1.0 / 256.0);
    if step.farthest > limit {
        step = adjust(begin(step.adjusted.shape)?, points(), limit)?;
    }
    let Step { adjusted, sectors, .. } = step;
    let (_, b) = adjusted.shape.semi_axes();
    let gap = longest_gap(sectors);
    if gap > limits::MAX_GAP {
        return Err(Reject::OpenOutline);
    }
    // Also refuses NaN.
    if !(adjusted.rms <= limits::MAX_RMS + limits::MAX_RMS_PER_AXIS * b) {
        return Err(Reject::NotElliptic);
    }
    Ok(Fitted { adjusted, dark_inside: edge.dark_inside, gap, ratio: 1.0, measured_ratio: 1.0 })
}

/// Edge point of a crossing about the origin, 1/256 px.
fn edge_point(crossing: &Crossing, origin: (u16, u16)) -> Option<(i32, i32)> {
    let offset = i32::from(crossing.offset()?);
    let x = 256 * (i32::from(crossing.x) - i32::from(origin.0));
    let y = 256 * (i32::from(crossing.y()) - i32::from(origin.1));
    Some(match crossing.axis() {
        Axis::Row => (x + offset, y),
        Axis::Column => (x, y + offset),
    })
}

/// An adjustment with what else the points tell.
struct Step {
    adjusted: Adjusted,
    /// Sectors in which there are points, one bit each.
    sectors: u32,
    /// Distance of the farthest point that was used from the ellipse before the step, px.
    farthest: f32,
}

/// One step with the points nearer to the ellipse than `limit` px.
fn adjust(
    mut adjustment: Adjustment,
    points: impl Iterator<Item = (f32, f32)>,
    limit: f32,
) -> Result<Step, Reject> {
    let (mut sectors, mut farthest) = (0u32, 0.0f32);
    for (x, y) in points {
        let point = adjustment.view(x, y);
        let distance = point.square_distance();
        if distance < limit * limit {
            adjustment.add(&point);
            farthest = farthest.max(distance);
            let turn = math::approx::atan2(point.v, point.u) * (0.5 / core::f32::consts::PI) + 1.0;
            sectors |= 1u32.rotate_left((turn * SECTORS as f32) as u32 % SECTORS);
        }
    }
    let adjusted = adjustment.finish().ok_or(Reject::NotElliptic)?;
    Ok(Step { adjusted, sectors, farthest: math::sqrt(farthest) })
}

/// Longest run of sectors without a point, around the circle.
fn longest_gap(sectors: u32) -> u32 {
    let mut empty = !sectors;
    let mut longest = 0;
    while empty != 0 && longest < SECTORS {
        empty &= empty.rotate_left(1);
        longest += 1;
    }
    longest
}
