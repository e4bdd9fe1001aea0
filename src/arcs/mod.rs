//! Arcs of circles in outlines that are no ellipse: something lies across the target, bites into its rim, or the frame
//! cuts it.
//!
//! 1. [`Points`]: some of an outline's crossings, in the order of the outline.
//! 2. [`free`]: the ellipse of any long arc among them; [`around`]: the one of a circle concentric with a known one.
//! 3. [`take`]: the crossings of that arc, if there are enough of them in the right places.
//! 4. [`shows_paper`]: a letter C is an open ring, but nothing lies over it.
//!
//! The work of a search is bounded: 96 points, 32 trial windows, and [`limits::MAX_SEARCHES`](crate::settings::limits) a frame.

mod gap;
mod points;
mod search;

pub(crate) use gap::shows_paper;
pub(crate) use points::Points;
pub(crate) use search::{around, common, free};

use crate::fit::{Frame, Shape};
use crate::math;
use crate::scan::{Crossing, CrossingList, Pool};
use crate::settings::limits;
use heapless::Vec;
use points::{MAX_FEWEST, Point};

/// Sectors in which an arc's crossings are looked for.
const SECTORS: u32 = 32;
/// Distance within which a crossing lies on an arc, px: linear interpolation is wrong by up to 0.2 px, a short arc's ellipse
/// by more.
const ON: f32 = 1.0;
/// Distance up to which it is taken for one of the arc, px.
const TAKEN: f32 = 1.3;
/// Distance up to which it lies beside it, px.
const BESIDE: f32 = 2.5;
/// Distance within which most of them lie, px, and how many.
const NEAR: f32 = 0.45;
const LEAST_NEAR: f32 = 0.72;
/// Half of the points of an even outline are as near as this, in units of that, ...
const NEAR_SHARE: f32 = 0.4;
/// ... or this often where noise or blur spreads them, ...
const WIDER: [f32; 4] = [1.0, 1.25, 1.6, 2.0];
const WIDEST: f32 = 2.5;
/// ... if no larger share of them is farther away than [`TAKEN`].
const MOST_FAR: f32 = 0.1;
/// Most crossings beside an arc for each one on it: a circle is left at a corner, a polygon's side or a curve that is no
/// ellipse runs along it.
const MOST_BESIDE: f32 = 0.4;

/// An ellipse, about an integer origin that its user knows, of which arcs are seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub shape: Shape,
    pub dark_inside: bool,
}

impl Arc {
    /// Squared distance of a point to first order, px^2; infinite where the light is on the wrong side.
    fn square_distance(&self, point: &Point) -> f32 {
        let ((gx, gy), (dx, dy)) = self.shape.gradient(point.x, point.y);
        let (lx, ly) = point.light;
        if (gx * lx + gy * ly > 0.0) != self.dark_inside {
            return f32::INFINITY;
        }
        let excess = dx * gx + dy * gy - 1.0;
        0.25 * excess * excess / (gx * gx + gy * gy)
    }

    /// The same about another origin.
    pub fn moved(&self, from: (u16, u16), to: (u16, u16)) -> Self {
        let shift = |from: u16, to: u16| (i32::from(to) - i32::from(from)) as f32;
        Self { shape: self.shape.about(shift(from.0, to.0), shift(from.1, to.1)), ..*self }
    }
}

/// Takes the crossings of `arc` about `origin` out of `list`. `None`, and nothing is taken, if there are too few for the length
/// of the arc, or it is seen in less than `min_seen` sectors.
pub(crate) fn take(
    arc: &Arc,
    list: &mut CrossingList,
    (pool, origin): (&mut Pool<'_>, (u16, u16)),
    min_seen: u32,
) -> Option<CrossingList> {
    let (a, b) = arc.shape.semi_axes();
    // Also refuses NaN.
    if !(b >= limits::MIN_INNER_SEMI_AXIS && a <= limits::MAX_ASPECT * b) {
        return None;
    }
    let frame = Frame::new(&arc.shape)?;
    let (mut near, mut on, mut beside, mut sectors) = (0u16, 0u16, 0u16, 0u32);
    for crossing in pool.iter(*list) {
        let point = Point::new(crossing, origin);
        let square = arc.square_distance(&point);
        if square <= ON * ON {
            on += 1;
            near += u16::from(square <= NEAR * NEAR);
            let (u, v) = frame.vector(point.x - arc.shape.cx, point.y - arc.shape.cy);
            sectors |= sector(u, v);
        } else if square <= BESIDE * BESIDE {
            beside += 1;
        }
    }
    let seen = sectors.count_ones();
    let expected = expected_crossings(a, b) * seen as f32 / SECTORS as f32;
    let enough = seen >= min_seen
        && f32::from(on) >= 0.5 * expected
        && f32::from(beside) <= MOST_BESIDE * f32::from(on)
        && f32::from(near) >= LEAST_NEAR * f32::from(on);
    if !enough {
        return None;
    }
    let on = |crossing: &Crossing| arc.square_distance(&Point::new(crossing, origin)) <= TAKEN * TAKEN;
    let (taken, rest) = pool.split(*list, on);
    *list = rest;
    Some(taken)
}

/// Where the edge passes a crossing about `origin`, px, by linear interpolation.
pub(crate) fn place(crossing: &Crossing, origin: (u16, u16)) -> (f32, f32) {
    let Point { x, y, .. } = Point::new(crossing, origin);
    (x, y)
}

/// Share of some of the crossings that are not near the arc's ellipse. Where half of them are far from it noise or blur spreads
/// them all, and what is near is as much wider.
pub(crate) fn share_off(arc: &Arc, list: CrossingList, pool: &Pool<'_>, origin: (u16, u16)) -> f32 {
    let mut squares = Vec::<f32, MAX_FEWEST>::new();
    for point in points::fewest(list, pool, origin) {
        let _ = squares.push(arc.square_distance(&point));
    }
    let share = |limit: f32| {
        let off = squares.iter().filter(|square| **square > limit * limit).count();
        off as f32 / squares.len().max(1) as f32
    };
    // Noise leaves hardly any far away, a dent or a bump does.
    let dented = share(TAKEN) > MOST_FAR;
    let fits = |wider: &f32| dented || share(NEAR_SHARE * NEAR * wider) <= 0.5;
    share(NEAR * WIDER.into_iter().find(fits).unwrap_or(WIDEST))
}

/// Crossings that a whole ellipse with these semi-axes has, to 10 %, when each axis keeps its own half of them.
pub(crate) fn expected_crossings(a: f32, b: f32) -> f32 {
    4.0 * math::sqrt(a * b)
}

/// The bit of the sector in which `(u, v)` lies.
pub(crate) fn sector(u: f32, v: f32) -> u32 {
    let turn = math::approx::atan2(v, u) * (0.5 / core::f32::consts::PI) + 1.0;
    1u32.rotate_left((turn * SECTORS as f32) as u32 % SECTORS)
}
