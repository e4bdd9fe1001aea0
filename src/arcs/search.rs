//! The ellipse with the most points on it.

use super::gauge::{Gauge, PX, square};
use super::pieces::{PIECES, Pieces, Unit};
use super::points::{MAX_POINTS, Point, Points};
use super::step::{Free, Normals};
use super::{Arc, Seen};
use crate::fit::Rough;
use crate::list::rolled;
use crate::scan::{CrossingList, Pool};
use heapless::Vec;

/// Lengths of trial arcs in pieces, and the steps between their starts.
const LENGTHS: [(usize, usize); 3] = [(10, 2), (7, 2), (5, 1)];
/// Trials that are refined.
const REFINED: usize = 2;
/// Distance from a trial's ellipse within which a point counts, px.
const TRIAL: f32 = 1.0;
/// Semi-minor axis, px, below which the distances of a search in which nothing is known are less, and their least share: a
/// small ellipse could be bent to anything.
const SMALL: f32 = 12.0;
const LEAST_SHARE: f32 = 0.4;
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
/// Distance within which points are of one concentric circle, 1/256 px: perspective moves its centre.
const CONCENTRIC: i32 = 5 * PX / 2;
/// Largest semi-axis of a trial in units of the points' extent.
const MAX_SIZE: f32 = 3.0;
/// Fewest points on an ellipse.
const MIN_POINTS: usize = 10;
/// Largest radius of a circle around a known one, in units of that.
const MAX_RADIUS: i32 = 11;
/// Least distance of two circles of the same polarity, 1/256 px.
const APART: i32 = 3 * PX;

/// The ellipse of a long arc: that of consecutive points with the most points of the whole outline on it.
#[inline(never)]
pub(crate) fn free(mut points: Points) -> Option<Arc> {
    let unit = Unit::of(&points.points);
    points.sort(unit.shift);
    let points = points.points.as_slice();
    let pieces = Pieces::new(points, &unit);
    let (mut best, mut most) = (None, 0.0);
    for (_, trial) in trials(&pieces, points, &unit).into_iter().flatten() {
        let share = scale(&trial);
        let Some(arc) = approach(&trial, share, points, &unit) else { continue };
        let score = score(&arc, points, TRIAL * scale(&arc));
        if score > most {
            (best, most) = (Some((arc, share)), score);
        }
    }
    let (arc, share) = best?;
    let arc = finish(&arc, share, points)?;
    (score(&arc, points, TRIAL * scale(&arc)) > MIN_POINTS as f32).then_some(arc)
}

/// Share of the distances for the ellipse of an arc.
fn scale(arc: &Arc) -> f32 {
    (arc.shape.semi_axes().1 / SMALL).clamp(LEAST_SHARE, 1.0)
}

/// The ellipses of consecutive pieces that have most points on them, with their scores.
#[inline(never)]
fn trials(pieces: &Pieces, points: &[Point], unit: &Unit) -> [Option<(u32, Arc)>; REFINED] {
    let mut best = [None; REFINED];
    let turns = pieces.turns(unit);
    for (length, step) in LENGTHS {
        for start in (0..PIECES).step_by(step.max(1)) {
            if turns.are_both(start, length) {
                continue;
            }
            let shape = unit.fit(&pieces.sum(start, length));
            let Some(shape) = shape.filter(|shape| shape.semi_axes().0 <= MAX_SIZE * unit.extent) else {
                continue;
            };
            let Some(gauge) = Gauge::new(&shape) else { continue };
            let scores = look(&gauge, points);
            for (dark_inside, score) in [(true, scores[0]), (false, scores[1])] {
                let mut trial = Some((score, Arc { shape, dark_inside }));
                // Sorted by falling score.
                for place in &mut best {
                    if place.is_none_or(|(other, _): (u32, Arc)| other < score) {
                        core::mem::swap(place, &mut trial);
                    }
                }
            }
        }
    }
    best
}

/// Points up to [`TRIAL`] from the ellipse, each the less the farther it is, of every second one, for either polarity, dark
/// inside first.
fn look(gauge: &Gauge, points: &[Point]) -> [u32; 2] {
    let mut scores = [0; 2];
    for look in points.iter().step_by(2).filter_map(|point| gauge.look(point)) {
        let Some(distance) = gauge.square_distance(&look) else { continue };
        let [dark, light] = &mut scores;
        *(if look.dark_inside { dark } else { light }) += square(TRIAL).saturating_sub(distance);
    }
    scores
}

/// The ellipse of a circle that is concentric with the one of `anchor` and not the same, in some of the crossings of `list`,
/// both about `origin`.
pub(crate) fn around(anchor: &Arc, list: CrossingList, pool: &Pool<'_>, origin: (u16, u16)) -> Option<Arc> {
    let gauge = Gauge::around(&anchor.shape)?;
    let points = Points::around(&gauge, MAX_RADIUS, list, pool, origin);
    let mut radii = Vec::<Radius, MAX_POINTS>::new();
    for look in points.points.iter().filter_map(|point| gauge.look(point)) {
        let Some((radius, change)) = gauge.radius(&look) else { continue };
        let over = |width: i32| change * width / (16 * PX);
        let same = look.dark_inside == anchor.dark_inside && (radius - Gauge::UNIT).abs() < over(APART);
        if !same {
            let room = over(CONCENTRIC);
            let _ = radii.push(Radius { radius, room, dark_inside: look.dark_inside });
        }
    }
    let (mut best, mut most) = (None, 0.0);
    for _ in 0..MODES {
        let Some((radius, dark_inside)) = take_mode(&mut radii) else { break };
        let radius = radius as f32 / Gauge::UNIT as f32;
        let trial = Arc { shape: anchor.shape.grown(radius), dark_inside };
        let Some(similar) = adjust(&trial, &points.points, &SIMILAR, Free::Similar) else { continue };
        let free = adjust(&similar, &points.points, &ADJUST, Free::All);
        for (arc, gain) in [(Some(similar), 1.0), (free, FREE_GAIN)] {
            let Some(arc) = arc else { continue };
            let score = score(&arc, &points.points, TRIAL) / gain;
            if score > most {
                (best, most) = (Some(arc), score);
            }
        }
    }
    best
}

/// Radius of the ellipse through a point that is similar to a known one.
#[derive(Clone, Copy, Debug)]
struct Radius {
    /// As [`Gauge::radius`] has it.
    radius: i32,
    /// Largest difference from that of another point of the same circle.
    room: i32,
    dark_inside: bool,
}

impl Radius {
    fn agrees(&self, radius: i32, dark_inside: bool) -> bool {
        self.dark_inside == dark_inside && (self.radius - radius).abs() < self.room
    }
}

/// Takes those radii that most agree out of the list, and gives their mean and polarity.
fn take_mode(radii: &mut Vec<Radius, MAX_POINTS>) -> Option<(i32, bool)> {
    let (mut mode, mut most) = (None, MIN_POINTS as i32 - 1);
    for &Radius { radius: middle, dark_inside, .. } in radii.iter().step_by(2) {
        let agree = rolled(radii.iter()).filter(|radius| radius.agrees(middle, dark_inside));
        let (count, sum) = agree.fold((0, 0), |(count, sum), radius| (count + 1, sum + radius.radius));
        if count > most {
            (mode, most) = (Some((middle, sum / count, dark_inside)), count);
        }
    }
    let (middle, mean, dark_inside) = mode?;
    radii.retain(|radius| !radius.agrees(middle, dark_inside));
    Some((mean, dark_inside))
}

/// The ellipse through all of the points, if at least this share of them lies on it.
pub(crate) fn common(points: &Points, dark_inside: bool, share: f32) -> Option<Arc> {
    let unit = Unit::of(&points.points);
    let mut sum = Rough::default();
    points.points.iter().for_each(|point| unit.add(&mut sum, point));
    let start = Arc { shape: unit.fit(&sum)?, dark_inside };
    let arc = finish(&start, scale(&start), &points.points)?;
    let count = sum_near(&arc, &points.points, TRIAL, Sum::Count);
    (count as f32 >= share * points.points.len() as f32).then_some(arc)
}

/// What points near an arc are summed up to.
enum Sum<'s> {
    Count,
    /// Each the less the farther it is.
    Score(&'s mut u32),
    Algebraic(&'s Unit, &'s mut Rough),
    Geometric(&'s mut Normals),
}

/// Sums up the points up to `distance` px from the arc's ellipse, and counts them.
// Not generic: there is one loop over the points for all uses.
#[inline(never)]
fn sum_near(arc: &Arc, points: &[Point], distance: f32, mut sum: Sum<'_>) -> usize {
    let (limit, dark_inside) = (square(distance), arc.dark_inside);
    let Some(gauge) = Gauge::new(&arc.shape) else { return 0 };
    let mut count = 0;
    for point in points {
        if let Some(look) = gauge.look(point).filter(|look| look.dark_inside == dark_inside)
            && let Some(square) = gauge.square_distance(&look).filter(|square| *square < limit)
        {
            count += 1;
            match &mut sum {
                Sum::Count => (),
                Sum::Score(score) => **score += limit - square,
                Sum::Algebraic(unit, sum) => unit.add(sum, point),
                Sum::Geometric(normals) => normals.add(&look),
            }
        }
    }
    count
}

/// Number of points up to `distance` px from the arc's ellipse, each the less the farther it is.
fn score(arc: &Arc, points: &[Point], distance: f32) -> f32 {
    let mut score = 0;
    sum_near(arc, points, distance, Sum::Score(&mut score));
    score as f32 / square(distance) as f32
}

/// Fits the ellipse to the points that are near it, again and again: algebraically, which gets there from far but shrinks an
/// arc's ellipse. `None` if what it comes to is clearly none that [`take`](super::take) takes.
#[inline(never)]
fn approach(arc: &Arc, share: f32, points: &[Point], unit: &Unit) -> Option<Arc> {
    let mut arc = *arc;
    for distance in REFINE.map(|distance| share * distance) {
        let mut sum = Rough::default();
        if sum_near(&arc, points, distance, Sum::Algebraic(unit, &mut sum)) < MIN_POINTS {
            return None;
        }
        arc.shape = unit.fit(&sum)?;
    }
    let seen = Seen::of(&Gauge::new(&arc.shape)?, arc.dark_inside, points.iter().copied());
    seen.is_promising().then_some(arc)
}

/// Fits it geometrically.
fn finish(arc: &Arc, share: f32, points: &[Point]) -> Option<Arc> {
    adjust(arc, points, &ADJUST.map(|distance| share * distance), Free::All)
}

/// Adjusts the ellipse geometrically, with the points within each of `distances` in turn.
#[inline(never)]
fn adjust(arc: &Arc, points: &[Point], distances: &[f32], free: Free) -> Option<Arc> {
    let mut arc = *arc;
    for &distance in distances {
        let mut normals = Normals::default();
        sum_near(&arc, points, distance, Sum::Geometric(&mut normals));
        if normals.points < MIN_POINTS {
            return None;
        }
        arc.shape = normals.step(&arc.shape, free)?;
    }
    Some(arc)
}
