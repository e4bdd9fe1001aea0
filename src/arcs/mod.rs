//! Arcs of circles in outlines that are no ellipse: something lies across the target, bites into its rim, or the frame
//! cuts it.
//!
//! 1. [`Points`]: some of an outline's crossings, in the order of the outline.
//! 2. [`free`]: the ellipse of any long arc among them; [`around`]: the one of a circle concentric with a known one.
//! 3. [`take`]: the crossings of that arc, if there are enough of them in the right places.
//! 4. [`shows_paper`]: a letter C is an open ring, but nothing lies over it.
//!
//! The work of a search is bounded: 96 points, 32 trial arcs, and [`limits::MAX_SEARCHES`](crate::settings::limits) a frame. On
//! small processors a floating-point operation is a hundred instructions or more: points, distances, sums and orders are whole
//! numbers, ellipses are not.

mod gap;
mod gauge;
mod pieces;
mod points;
mod search;
mod step;
#[cfg(test)]
mod tests;

pub(crate) use gap::shows_paper;
pub(crate) use points::Points;
pub(crate) use search::{around, common, free};

use crate::fit::Shape;
use crate::list::rolled;
use crate::math;
use crate::scan::{Crossing, CrossingList, Pool};
use crate::settings::limits;
use gauge::{Distance, Gauge, square};
use heapless::Vec;
use points::{MAX_FEWEST, Point};

/// Sectors in which an arc's crossings are looked for.
const SECTORS: u32 = 32;
/// Distance, squared, within which a crossing lies on an arc: linear interpolation is wrong by up to 0.2 px, a short arc's
/// ellipse by more.
const ON: u32 = square(1.0);
/// Distance up to which it is taken for one of the arc.
const TAKEN: u32 = square(1.3);
/// Distance up to which it lies beside it.
const BESIDE: u32 = square(2.5);
/// Distance within which most of them lie, and how many.
const NEAR: f32 = 0.45;
const LEAST_NEAR: f32 = 0.72;
/// Half of the points of an even outline are as near as this, in units of that, ...
const NEAR_SHARE: f32 = 0.4;
/// ... or this often where noise or blur spreads them, ...
const WIDER: [f32; 4] = [1.0, 1.25, 1.6, 2.0];
const WIDEST: f32 = 2.5;
/// ... if no more than one in so many of them is farther away than [`TAKEN`].
const MOST_FAR: usize = 10;
/// One in so many of an ellipse's crossings may lie beside it.
const MOST_OFF: usize = 5;
/// Most crossings beside an arc for each one on it: a circle is left at a corner, a polygon's side or a curve that is no
/// ellipse runs along it.
const MOST_BESIDE: f32 = 0.4;
/// Room for what a better ellipse changes: sectors in which it is seen, and factor on the crossings beside it.
const ROOM_SEEN: u32 = 2;
const ROOM_BESIDE: f32 = 2.5;

/// An ellipse, about an integer origin that its user knows, of which arcs are seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub shape: Shape,
    pub dark_inside: bool,
}

impl Arc {
    /// The same about another origin.
    pub fn moved(&self, from: (u16, u16), to: (u16, u16)) -> Self {
        let shift = |from: u16, to: u16| (i32::from(to) - i32::from(from)) as f32;
        Self { shape: self.shape.about(shift(from.0, to.0), shift(from.1, to.1)), ..*self }
    }
}

/// Where points lie about an arc's ellipse.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    near: u16,
    on: u16,
    beside: u16,
    /// Sectors with points on it, one bit each.
    sectors: u32,
}

impl Seen {
    fn of(gauge: &Gauge, dark_inside: bool, points: impl Iterator<Item = Point>) -> Self {
        let mut seen = Self::default();
        points.for_each(|point| seen.add(gauge, dark_inside, &point));
        seen
    }

    #[inline(never)]
    fn add(&mut self, gauge: &Gauge, dark_inside: bool, point: &Point) {
        let Some(look) = gauge.look(point).filter(|look| look.dark_inside == dark_inside) else { return };
        let Some(distance) = gauge.square_distance(&look) else { return };
        if distance <= ON {
            self.on += 1;
            self.near += u16::from(distance <= square(NEAR));
            self.sectors |= look.sector();
        } else if distance <= BESIDE {
            self.beside += 1;
        }
    }

    /// Whether they make an arc of it.
    fn is_arc(&self) -> bool {
        f32::from(self.beside) <= MOST_BESIDE * f32::from(self.on)
            && f32::from(self.near) >= LEAST_NEAR * f32::from(self.on)
    }

    /// Whether they can when the ellipse is a better one.
    fn is_promising(&self) -> bool {
        self.sectors.count_ones() + ROOM_SEEN >= limits::MIN_SEEN
            && f32::from(self.beside) <= ROOM_BESIDE * MOST_BESIDE * f32::from(self.on)
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
    let gauge = Gauge::new(&arc.shape)?;
    let points = pool.iter(*list).map(|crossing| Point::new(crossing, origin));
    let seen = Seen::of(&gauge, arc.dark_inside, points);
    let sectors = seen.sectors.count_ones();
    let expected = expected_crossings(a, b) * sectors as f32 / SECTORS as f32;
    if sectors < min_seen || !seen.is_arc() || f32::from(seen.on) < 0.5 * expected {
        return None;
    }
    let on = |crossing: &Crossing| {
        let distance = gauge.square_distance_of(&Point::new(crossing, origin), arc.dark_inside);
        distance.is_some_and(|distance| distance <= TAKEN)
    };
    let (taken, rest) = pool.split(*list, on);
    *list = rest;
    Some(taken)
}

/// Where the edge passes a crossing about `origin`, 1/256 px, by linear interpolation.
pub(crate) fn place(crossing: &Crossing, origin: (u16, u16)) -> (i32, i32) {
    let Point { x, y, .. } = Point::new(crossing, origin);
    (x, y)
}

/// Whether more than one in [`MOST_OFF`] of some of the crossings are not near the arc's ellipse. Where half of them are far from
/// it noise or blur spreads them all, and what is near is as much wider.
pub(crate) fn are_off(arc: &Arc, list: CrossingList, pool: &Pool<'_>, origin: (u16, u16)) -> bool {
    let Some(gauge) = Gauge::new(&arc.shape) else { return true };
    let (mut others, mut distances) = (points::count_of_fewest(list), Vec::<_, MAX_FEWEST>::new());
    let most = others / MOST_OFF;
    for point in points::fewest(list, pool, origin) {
        let distance = gauge.distance_of(&point, arc.dark_inside);
        others -= usize::from(!exceeds(&distance, square(NEAR)));
        // As a rule most are near.
        if others <= most {
            return false;
        }
        let _ = distances.push(distance);
    }
    let off = |limit: u32| count_beyond(&distances, limit);
    let many = |limit: u32| MOST_OFF * off(limit) > distances.len();
    // Noise leaves hardly any far away, a dent or a bump does.
    let dented = MOST_FAR * off(TAKEN) > distances.len();
    let fits = |wider: &f32| dented || 2 * off(square(NEAR_SHARE * NEAR * wider)) <= distances.len();
    many(square(NEAR * WIDER.into_iter().find(fits).unwrap_or(WIDEST)))
}

#[inline(never)]
fn count_beyond(distances: &[Option<Distance>], limit: u32) -> usize {
    rolled(distances).filter(|distance| exceeds(distance, limit)).count()
}

fn exceeds(distance: &Option<Distance>, limit: u32) -> bool {
    distance.is_none_or(|distance| distance.exceeds(limit))
}

/// Crossings that a whole ellipse with these semi-axes has, to 10 %, when each axis keeps its own half of them.
pub(crate) fn expected_crossings(a: f32, b: f32) -> f32 {
    4.0 * math::sqrt(a * b)
}
