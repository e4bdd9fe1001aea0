//! Crossings as rough points.

use super::gauge::{AROUND, Gauge, PX};
use crate::list::rolled;
use crate::scan::{Axis, Crossing, CrossingList, Pool};
use heapless::Vec;

/// Points for a look, and most that come of it.
const FEWEST: usize = 16;
pub(super) const MAX_FEWEST: usize = 24;
/// Most points for a search in which nothing is known.
const FEW: usize = 56;
/// Share of the largest step of an outline that a crossing must have in such a search: what lies over a target is as a rule
/// neither as dark as its ink nor as light as its paper.
const STEP: f32 = 0.6;
/// What a point on the other side of a stroke is farther: more than any squared distance.
const OPPOSITE: i32 = 1 << 28;
/// Most points for one about a known circle.
pub(super) const MAX_POINTS: usize = 96;

/// A crossing as a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// About the origin, 1/256 px, by linear interpolation.
    pub x: i32,
    pub y: i32,
    /// Where light lies: [`RISING`] if on the far side, and [`ON_ROW`] if the axis is that.
    side: u8,
}

const RISING: u8 = 1;
const ON_ROW: u8 = 2;

/// Difference of the levels on both sides of a crossing.
fn step(crossing: &Crossing) -> u16 {
    let [_, a, b, c, d, _] = crossing.near.map(u16::from);
    (a + b).abs_diff(c + d)
}

/// The pixel of a crossing about the origin, 1/256 px.
fn pixel(crossing: &Crossing, origin: (u16, u16)) -> (i32, i32) {
    let from = |p: u16, origin: u16| PX * (i32::from(p) - i32::from(origin));
    (from(crossing.x, origin.0), from(crossing.y(), origin.1))
}

impl Point {
    #[inline(never)]
    pub fn new(crossing: &Crossing, origin: (u16, u16)) -> Self {
        let (x, y) = pixel(crossing, origin);
        let [_, n0, n1, n2, n3, _] = crossing.near.map(i32::from);
        let rising = if crossing.is_rising() { RISING } else { 0 };
        // Between the two inner samples, at u = -1 and 0.
        let share =
            (PX / 2 * (n0 + n3 - 2 * n1)).checked_div(n2 - n1).map_or(PX / 2, |share| share.clamp(0, PX));
        match crossing.axis() {
            Axis::Row => Self { x: x - PX + share, y, side: rising | ON_ROW },
            Axis::Column => Self { x, y: y - PX + share, side: rising },
        }
    }

    /// Px about the origin.
    pub fn place(&self) -> (f32, f32) {
        const EACH: f32 = 1.0 / PX as f32;
        (self.x as f32 * EACH, self.y as f32 * EACH)
    }

    /// Whether a vector leads to the light rather than away from it.
    pub fn leads_to_light(&self, (x, y): (i32, i32)) -> bool {
        let along = if self.side & ON_ROW != 0 { x } else { y };
        if self.side & RISING != 0 { along > 0 } else { along < 0 }
    }

    /// Measure of the distance to the one that follows, in units of 2^(2 `shift`).
    fn distance(&self, next: &Self, shift: u32) -> i32 {
        let (x, y) = ((self.x - next.x) >> shift, (self.y - next.y) >> shift);
        x * x + y * y + if self.side ^ next.side == RISING { OPPOSITE } else { 0 }
    }
}

/// Which of `count` make about `most`: multiples of the golden section, even along a list, and never only one side of an outline,
/// of which a row leaves a crossing in turn.
fn even(most: usize, count: usize) -> impl Fn(usize) -> bool {
    let share = (most as u32 * 0x1_0000).checked_div(count as u32).unwrap_or(0);
    move |i| u32::from((i as u16).wrapping_mul(0x9e37)) < share
}

/// About `most` of the `count` crossings of `list` that are `wanted`, about `origin`.
fn chosen(
    (list, count): (CrossingList, usize),
    pool: &Pool<'_>,
    (most, origin): (usize, (u16, u16)),
    wanted: impl Fn(&Crossing) -> bool,
) -> impl Iterator<Item = Point> {
    let even = even(most, count);
    let wanted = pool.iter(list).filter(move |crossing| wanted(crossing)).enumerate();
    wanted.filter(move |(i, _)| even(*i)).map(move |(_, crossing)| Point::new(crossing, origin))
}

/// As many of the crossings of `list`, about `origin`, as tell whether an ellipse is whole.
pub(super) fn fewest(list: CrossingList, pool: &Pool<'_>, origin: (u16, u16)) -> impl Iterator<Item = Point> {
    chosen((list, list.len().into()), pool, (FEWEST, origin), |_| true)
}

/// How many these are.
pub(super) fn count_of_fewest(list: CrossingList) -> usize {
    let count = list.len().into();
    (0..count).filter(|i| even(FEWEST, count)(*i)).count()
}

/// Some of an outline's crossings, evenly chosen.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    pub(super) points: Vec<Point, MAX_POINTS>,
}

impl Points {
    /// Few of the crossings of `list`, about `origin`: of those with the largest steps.
    pub fn few(list: CrossingList, pool: &Pool<'_>, origin: (u16, u16)) -> Self {
        let largest = pool.iter(list).map(step).max().unwrap_or(0);
        let least = (STEP * f32::from(largest)) as u16;
        Self::new(list, pool, (FEW, origin), |crossing| step(crossing) >= least)
    }

    /// Crossings of `list`, about `origin`, out to `radius` units of the ellipse that `anchor` gauges.
    pub(super) fn around(
        anchor: &Gauge<AROUND>,
        radius: i32,
        list: CrossingList,
        pool: &Pool<'_>,
        origin: (u16, u16),
    ) -> Self {
        let wanted = |crossing: &Crossing| anchor.is_within(pixel(crossing, origin), radius);
        Self::new(list, pool, (MAX_POINTS - 1, origin), wanted)
    }

    fn new(
        list: CrossingList,
        pool: &Pool<'_>,
        (most, origin): (usize, (u16, u16)),
        wanted: impl Fn(&Crossing) -> bool,
    ) -> Self {
        let mut points = Vec::new();
        let count = pool.iter(list).filter(|crossing| wanted(crossing)).count();
        for point in chosen((list, count), pool, (most, origin), wanted) {
            let _ = points.push(point);
        }
        Self { points }
    }

    /// Puts the points in the order of the outline: each is followed by the nearest that is left, but not by one on the
    /// other side of a thin stroke. Coordinates have at most 12 bits above `shift`.
    pub(super) fn sort(&mut self, shift: u32) {
        let mut rest = self.points.as_mut_slice();
        while let Some((last, others)) = rest.split_first_mut() {
            let distance = |point: &Point| last.distance(point, shift);
            if let Some((next, further)) = others.split_first_mut()
                && let Some(nearest) = rolled(further).min_by_key(|point| distance(point))
                && distance(nearest) < distance(next)
            {
                core::mem::swap(next, nearest);
            }
            rest = others;
        }
    }
}
