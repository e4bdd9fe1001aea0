//! Crossings as rough points.

use crate::fit::Shape;
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
/// Most points for one about a known circle.
pub(super) const MAX_POINTS: usize = 96;

/// A crossing as a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// About the origin, px, by linear interpolation.
    pub x: f32,
    pub y: f32,
    /// Unit vector of the axis towards light.
    pub light: (f32, f32),
}

/// Difference of the levels on both sides of a crossing.
fn step(crossing: &Crossing) -> u16 {
    let [_, a, b, c, d, _] = crossing.near.map(u16::from);
    (a + b).abs_diff(c + d)
}

impl Point {
    pub fn new(crossing: &Crossing, origin: (u16, u16)) -> Self {
        let x = (i32::from(crossing.x) - i32::from(origin.0)) as f32;
        let y = (i32::from(crossing.y()) - i32::from(origin.1)) as f32;
        let [_, n0, n1, n2, n3, _] = crossing.near.map(f32::from);
        let step = n2 - n1;
        // Between the two inner samples, at u = -1 and 0.
        let share = if step == 0.0 { 0.5 } else { ((0.5 * (n0 + n3) - n1) / step).clamp(0.0, 1.0) };
        let sign = if n2 + n3 > n0 + n1 { 1.0 } else { -1.0 };
        match crossing.axis() {
            Axis::Row => Self { x: x - 1.0 + share, y, light: (sign, 0.0) },
            Axis::Column => Self { x, y: y - 1.0 + share, light: (0.0, sign) },
        }
    }

    /// Whether light lies on opposite sides of the two.
    fn opposite(&self, other: &Self) -> bool {
        self.light.0 * other.light.0 + self.light.1 * other.light.1 < 0.0
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

    /// Crossings of `list`, about `origin`, out to `radius` units of the ellipse of `anchor`.
    pub fn around(
        anchor: &Shape,
        radius: f32,
        list: CrossingList,
        pool: &Pool<'_>,
        origin: (u16, u16),
    ) -> Self {
        Self::new(list, pool, (MAX_POINTS - 1, origin), |crossing| {
            let point = Point::new(crossing, origin);
            anchor.square(point.x - anchor.cx, point.y - anchor.cy) < radius * radius
        })
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
            let distance = |point: &Point| {
                let (dx, dy) = (point.x - last.x, point.y - last.y);
                dx * dx + dy * dy + if point.opposite(last) { 1e6 } else { 0.0 }
            };
            if let Some((next, further)) = others.split_first_mut() {
                let mut least = distance(next);
                for point in further {
                    let square = distance(point);
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
