//! Crossings as rough points.

use crate::scan::{Axis, Crossing, CrossingList, Pool};
use heapless::Vec;

/// Most points of a search.
pub(super) const MAX_POINTS: usize = 64;

/// A crossing as a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// About the origin, px, by linear interpolation.
    pub x: f32,
    pub y: f32,
    /// Unit vector of the axis towards light.
    pub light: (f32, f32),
}

impl Point {
    pub fn new(crossing: &Crossing, origin: (u16, u16)) -> Self {
        let x = (i32::from(crossing.x) - i32::from(origin.0)) as f32;
        let y = (i32::from(crossing.y()) - i32::from(origin.1)) as f32;
        let [n0, n1, n2, n3] = crossing.near.map(f32::from);
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

/// Some of an outline's crossings, evenly chosen.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    pub(super) points: Vec<Point, MAX_POINTS>,
}

impl Points {
    /// Of the crossings of `list` about `origin` that are `wanted` by their place, px.
    pub fn new(
        list: CrossingList,
        pool: &Pool<'_>,
        origin: (u16, u16),
        wanted: impl Fn(f32, f32) -> bool,
    ) -> Self {
        let near = |crossing: &&Crossing| {
            let x = i32::from(crossing.x) - i32::from(origin.0);
            let y = i32::from(crossing.y()) - i32::from(origin.1);
            wanted(x as f32, y as f32)
        };
        // Odd, because a row leaves one on the left and one on the right.
        let stride = (pool.iter(list).filter(near).count() / MAX_POINTS + 1) | 1;
        let mut points = Vec::new();
        for crossing in pool.iter(list).filter(near).step_by(stride) {
            let _ = points.push(Point::new(crossing, origin));
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
