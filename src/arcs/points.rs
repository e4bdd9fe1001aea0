//! Crossings as rough points.

use super::gauge::{Gauge, PX};
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
/// What the squared distance to a point on the other side of a stroke counts more, 1/64 px^2: that of 1000 px.
const OPPOSITE: u32 = 64_000_000;
/// Most points for one about a known circle.
pub(super) const MAX_POINTS: usize = 96;

/// A crossing as a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// About the origin, 1/256 px, by linear interpolation.
    pub x: i32,
    pub y: i32,
    /// The axis.
    pub is_on_row: bool,
    /// Light lies on the far side.
    pub is_rising: bool,
}

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
    pub fn new(crossing: &Crossing, origin: (u16, u16)) -> Self {
        let (x, y) = pixel(crossing, origin);
        let [_, n0, n1, n2, n3, _] = crossing.near.map(i32::from);
        let is_rising = n2 + n3 > n0 + n1;
        // Between the two inner samples, at u = -1 and 0.
        let share =
            (PX / 2 * (n0 + n3 - 2 * n1)).checked_div(n2 - n1).map_or(PX / 2, |share| share.clamp(0, PX));
        match crossing.axis() {
            Axis::Row => Self { x: x - PX + share, y, is_on_row: true, is_rising },
            Axis::Column => Self { x, y: y - PX + share, is_on_row: false, is_rising },
        }
    }

    /// Px about the origin.
    pub fn place(&self) -> (f32, f32) {
        const EACH: f32 = 1.0 / PX as f32;
        (self.x as f32 * EACH, self.y as f32 * EACH)
    }

    /// Whether light lies on opposite sides of the two.
    fn opposite(&self, other: &Self) -> bool {
        self.is_on_row == other.is_on_row && self.is_rising != other.is_rising
    }

    /// Measure of the distance to the one that follows.
    fn distance(&self, next: &Self) -> u32 {
        // In 1/8 px, as far as 32 bits hold its square.
        let side = |a: i32, b: i32| (a.abs_diff(b) >> 5).min(1 << 15);
        let (x, y) = (side(self.x, next.x), side(self.y, next.y));
        x * x + y * y + if self.opposite(next) { OPPOSITE } else { 0 }
    }
}

/// About `most` of the crossings of `list` that are `wanted`, about `origin`.
fn chosen(
    list: CrossingList,
    pool: &Pool<'_>,
    (most, origin): (usize, (u16, u16)),
    wanted: impl Fn(&Crossing) -> bool,
) -> impl Iterator<Item = Point> {
    let count = pool.iter(list).filter(|crossing| wanted(crossing)).count();
    let share = (most as u32 * 0x1_0000).checked_div(count as u32).unwrap_or(0);
    // Multiples of the golden section: even along the list, and never only one side of it, of which a row leaves a
    // crossing in turn.
    let even = move |i: usize| u32::from((i as u16).wrapping_mul(0x9e37)) < share;
    let wanted = pool.iter(list).filter(move |crossing| wanted(crossing)).enumerate();
    wanted.filter(move |(i, _)| even(*i)).map(move |(_, crossing)| Point::new(crossing, origin))
}

/// As many of the crossings of `list`, about `origin`, as tell whether an ellipse is whole.
pub(super) fn fewest(list: CrossingList, pool: &Pool<'_>, origin: (u16, u16)) -> impl Iterator<Item = Point> {
    chosen(list, pool, (FEWEST, origin), |_| true)
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
        anchor: &Gauge,
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
        for point in chosen(list, pool, (most, origin), wanted) {
            let _ = points.push(point);
        }
        Self { points }
    }

    /// Puts the points in the order of the outline: each is followed by the nearest that is left, but not by one on the
    /// other side of a thin stroke.
    pub(super) fn sort(&mut self) {
        let mut rest = self.points.as_mut_slice();
        while let Some((last, others)) = rest.split_first_mut() {
            if let Some((next, further)) = others.split_first_mut() {
                let mut least = last.distance(next);
                for point in further {
                    let square = last.distance(point);
                    if square < least {
                        least = square;
                        core::mem::swap(next, point);
                    }
                }
            }
            rest = others;
        }
    }
}
