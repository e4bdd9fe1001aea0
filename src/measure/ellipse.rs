//! One edge: its edge points to an ellipse.

use super::Light;
use super::origin::Origin;
use super::sectors::{PARTS, PLACES, SectorLight, Sectors, sector_of};
use crate::abilities::ARCS;
use crate::arcs;
use crate::edge::Edge;
use crate::fit::{Adjusted, Adjustment, Shape, Spread, rough};
use crate::fixed::{PX, fixed};
use crate::math;
use crate::reject::Reject;
use crate::scan::{Axis, Crossing, CrossingList, EdgePoint, Pool};
use crate::settings::limits;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Most steps of a fit; an undamaged ellipse needs one or two.
pub(super) const PASSES: usize = 6;

/// How far light beside an edge moves that, in units of the blur for light of the whole contrast: 1 / density(0).
const LIGHT_MOVES: f32 = 2.507;
/// Residual, px, that noise of the whole contrast explains: that of four samples under a blur of 1 px, with room.
pub(super) const EXPLAINED: f32 = 2.2;
/// Edge points of a whole circle for each px of its radius: one for each row or column that it passes less steeply than the other.
const POINTS_PER_AXIS: f32 = 5.66;
/// Distance from an ellipse, px, within which a point is one of its edge, though perhaps displaced.
pub(super) const NEAR: f32 = 0.25;

/// An edge after its fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitted {
    pub adjusted: Adjusted,
    /// Which of the candidate's edges.
    pub edge: usize,
    pub dark_inside: bool,
    /// Only arcs of it are seen.
    pub partial: bool,
    /// The frame's border cuts it.
    pub cut: bool,
    /// Longest gap between edge points, in parts of a turn.
    pub gap: u32,
    /// Radius in units of the outer circle's.
    pub ratio: f32,
    /// The same as it was measured.
    pub measured_ratio: f32,
}

impl Fitted {
    /// Whether a part of it is not seen, so that it is fitted together with the others.
    pub fn is_occluded(&self) -> bool {
        ARCS && (self.partial || self.has_gap())
    }

    /// Whether edge points are missing on an arc.
    pub fn has_gap(&self) -> bool {
        self.gap > limits::FLAG_GAP
    }
}

pub(crate) type FittedList = Vec<Fitted, MAX_CIRCLES>;

/// Adds a circle. `None` if there are too many.
// Not inlined: a circle is a hundred and fifty bytes that are copied one by one.
#[inline(never)]
pub(super) fn push(circles: &mut FittedList, circle: &Fitted) -> Option<()> {
    circles.push(*circle).ok()
}

/// Where the edge points come from.
#[derive(Clone, Copy)]
pub(super) struct Source<'a, 'p> {
    pub edges: &'a [Edge],
    pub pool: &'a Pool<'p>,
    pub origin: &'a Origin,
    /// Noise of their samples in units of the contrast; infinite where they are not placed yet.
    pub noise: f32,
    /// The same without what disturbs the samples, as far as that is known.
    pub calm: f32,
    /// Blur of the edges, px.
    pub blur: f32,
}

impl<'a, 'p> Source<'a, 'p> {
    /// The crossings of edge `k` whose profile is that of an edge; all where they are not placed yet.
    fn crossings(&self, k: usize) -> impl Iterator<Item = &'a Crossing> + use<'a, 'p> {
        let tolerance = (256.0 * (limits::MISFIT + limits::MISFIT_SIGMAS * self.noise)) as u8;
        let list = self.edges.get(k).map_or(CrossingList::EMPTY, |edge| edge.crossings);
        self.pool.iter(list).filter(move |crossing| {
            tolerance == u8::MAX || crossing.edge_point().is_some_and(|point| point.misfit <= tolerance)
        })
    }

    /// Factor on the covariance of an ellipse through so many points because their residuals are not independent. What the noise does
    /// not explain moves the points of a place all together, and so does the light beside the edge, of which `light` is the variance.
    #[inline(never)]
    pub fn excess(&self, points: u16, rms: f32, light: f32) -> f32 {
        let square = (rms * rms).max(f32::MIN_POSITIVE);
        let (explained, moved) = (EXPLAINED * self.calm, LIGHT_MOVES * self.blur);
        let unexplained = (1.0 - explained * explained / square).max(0.0);
        1.0 + f32::from(points) / PLACES as f32 * (unexplained + moved * moved * light / square)
    }

    /// Variance of an edge point, px^2, that the noise explains: nothing where there is more than any target has, because that is a
    /// pattern.
    pub fn edge_variance(&self) -> f32 {
        if self.calm > limits::MOST_NOISE { 0.0 } else { Light::edge_variance(1.0, self.calm, self.blur) }
    }

    /// Their edge points about the origin, [`PX`], with the excess of the light there; by linear interpolation where they are not
    /// placed yet.
    pub fn points(&self, k: usize) -> impl Iterator<Item = ((i32, i32), i8)> + use<'a, 'p> {
        let origin = self.origin;
        let placed = !ARCS || self.noise.is_finite();
        self.crossings(k).filter_map(move |crossing| {
            let (place, excess) = if placed {
                edge_point(crossing, origin.pixel)?
            } else {
                (arcs::place(crossing, origin.pixel), 0)
            };
            Some((origin.undistorted(place)?, excess))
        })
    }
}

/// Fits the ellipse of edge `k`.
pub(super) fn fit(source: &Source<'_, '_>, k: usize) -> Result<Fitted, Reject> {
    let noise = source.noise;
    let edge = source.edges.get(k).ok_or(Reject::Alone)?;
    if ARCS && edge.partial {
        return fit_arcs(source, k, edge);
    }
    let points = || source.points(k);
    let start = start(source, k, edge)?;
    let minor = start.semi_axes().1;
    let mut light = SectorLight::new(minor);
    let mut gate = Gate::OPEN;
    let mut step = adjust(start, points(), &gate, Some(&mut light))?;
    let (even, light) = light.judged((noise, source.calm));
    if even != Sectors::ALL {
        gate = Gate { sectors: even, even, ..gate };
        step = adjust(start, points(), &gate, None)?;
    }
    for _ in 1..PASSES {
        let limit = fixed(limits::OUTLIER * step.sigma, PX);
        let next = Gate { limit, sectors: step.near.without_ends(minor), even };
        if step.farthest <= next.limit && gate.sectors.without(&next.sectors) == Sectors::NONE {
            break;
        }
        gate = next;
        step = adjust(step.adjusted.shape, points(), &gate, None)?;
    }
    let Step { adjusted, seen, .. } = step;
    let gap = seen.closed(minor).longest_gap();
    judge(&adjusted, gap, false, source.edge_variance())?;
    let adjusted = adjusted.with_variance(source.excess(adjusted.points, adjusted.rms, light));
    let Edge { dark_inside, partial, cut, .. } = *edge;
    Ok(Fitted { adjusted, edge: k, dark_inside, partial, cut, gap, ratio: 1.0, measured_ratio: 1.0 })
}

/// Whether what is seen of an ellipse makes it one. The noise explains a variance of `explained` px^2 of its points.
#[inline(never)]
pub(super) fn judge(adjusted: &Adjusted, gap: u32, together: bool, explained: f32) -> Result<(), Reject> {
    if gap > if together { limits::MAX_GAP_TOGETHER } else { limits::MAX_GAP } {
        return Err(Reject::OpenOutline);
    }
    let (a, b) = adjusted.shape.semi_axes();
    // What the gap leaves must be seen, and mostly be of this ellipse.
    let expected = POINTS_PER_AXIS * math::sqrt(a * b) * (PARTS - gap) as f32 / PARTS as f32;
    let whole = gap <= limits::FLAG_GAP && b >= limits::FLAG_SMALL;
    let share = if whole { limits::MIN_POINTS_SHARE_WHOLE } else { limits::MIN_POINTS_SHARE };
    if f32::from(adjusted.points) < share * expected {
        return Err(Reject::NotElliptic);
    }
    let share = if together { limits::PARTIAL_RMS } else { 1.0 };
    // Also refuses NaN.
    let most = share * (limits::MAX_RMS + limits::MAX_RMS_PER_AXIS * b);
    if adjusted.rms * adjusted.rms <= most * most + explained { Ok(()) } else { Err(Reject::NotElliptic) }
}

/// A first ellipse of an edge of which only arcs are seen: that of [`rough`](super::together::rough), unless a lens bends it. What is
/// seen of it is judged when it is fitted together with others.
fn fit_arcs(source: &Source<'_, '_>, k: usize, edge: &Edge) -> Result<Fitted, Reject> {
    let start = start(source, k, edge)?;
    let mut adjusted = adjust(start, source.points(k), &Gate::OPEN, None)?.adjusted;
    adjusted.shape = start;
    let Edge { dark_inside, partial, cut, .. } = *edge;
    Ok(Fitted { adjusted, edge: k, dark_inside, partial, cut, gap: 0, ratio: 1.0, measured_ratio: 1.0 })
}

/// The ellipse of edge `k` by itself with the points up to `limit` px from `shape` in some sectors, which is near it.
pub(super) fn alone(
    source: &Source<'_, '_>,
    k: usize,
    shape: Shape,
    (limit, used): (f32, Sectors),
) -> Option<Adjusted> {
    let gate = Gate { limit: fixed(limit, PX), sectors: used, even: used };
    Some(adjust(shape, source.points(k), &gate, None).ok()?.adjusted)
}

/// Edge point of a crossing about the origin, 1/256 px, and the excess of the light there.
#[inline]
fn edge_point(crossing: &Crossing, origin: (u16, u16)) -> Option<((i32, i32), i8)> {
    let EdgePoint { offset, excess, .. } = crossing.edge_point()?;
    let offset = i32::from(offset);
    let x = 256 * (i32::from(crossing.x) - i32::from(origin.0));
    let y = 256 * (i32::from(crossing.y()) - i32::from(origin.1));
    let row = crossing.axis() == Axis::Row;
    Some((if row { (x + offset, y) } else { (x, y + offset) }, excess))
}

/// The algebraic fit; where arcs are missing that would shrink the ellipse, and the search has given a better one of what is
/// seen.
#[inline(never)]
fn start(source: &Source<'_, '_>, k: usize, edge: &Edge) -> Result<Shape, Reject> {
    /// Room for points that are off, and for what a lens moves them.
    const ROOM: (f32, f32) = (1.2, 4.0);
    let shape = &edge.shape;
    if ARCS && edge.partial && source.origin.lens().is_none() {
        return Ok(*shape);
    }
    let extent = shape.cx.abs().max(shape.cy.abs()) + shape.semi_axes().0;
    rough(source.points(k).map(|(place, _)| place), ROOM.0 * extent + ROOM.1).ok_or(Reject::NotElliptic)
}

/// What [`SectorLight`] tells around an ellipse.
#[inline(never)]
pub(super) fn even_sectors(source: &Source<'_, '_>, k: usize, shape: &Shape) -> Option<(Sectors, f32)> {
    let adjustment = Adjustment::new(*shape)?;
    let mut light = SectorLight::new(shape.semi_axes().1);
    for (place, excess) in source.points(k) {
        if let Some(view) = adjustment.view(place) {
            light.add(sector_of(view.place), excess);
        }
    }
    Some(light.judged((source.noise, source.calm)))
}

/// Which points are used.
struct Gate {
    /// Largest distance from the ellipse, [`PX`].
    limit: i32,
    /// Sectors in which they may lie: not those beside gaps, where what hides the edge has a part in its profile.
    sectors: Sectors,
    /// The same with these.
    even: Sectors,
}

impl Gate {
    /// All of them.
    const OPEN: Self = Self { limit: i32::MAX, sectors: Sectors::ALL, even: Sectors::ALL };
}

/// An adjustment with what else the points tell.
struct Step {
    adjusted: Adjusted,
    /// Sectors in which there are points within the limit, ...
    seen: Sectors,
    /// ... and in which there are points of the edge, even if the ellipse before the step was off.
    near: Sectors,
    /// Distance of the farthest point that was used from the ellipse before the step, [`PX`].
    farthest: i32,
    /// Robust standard deviation of the distances, px.
    sigma: f32,
}

/// One step from `shape` with the points that pass `gate`.
#[inline(never)]
fn adjust(
    shape: Shape,
    points: impl Iterator<Item = ((i32, i32), i8)>,
    gate: &Gate,
    mut light: Option<&mut SectorLight>,
) -> Result<Step, Reject> {
    let mut adjustment = Adjustment::new(shape).ok_or(Reject::NotElliptic)?;
    let (mut seen, mut near) = (Sectors::NONE, Sectors::NONE);
    let mut spread = Spread::default();
    let mut farthest = 0;
    let farthest_near = gate.limit.max(fixed(NEAR, PX));
    for (place, excess) in points {
        let Some(point) = adjustment.view(place) else { continue };
        let distance = point.distance.abs();
        if distance > farthest_near {
            continue;
        }
        let sector = sector_of(point.place);
        if let Some(light) = &mut light {
            light.add(sector, excess);
        }
        if !gate.even.has(sector) {
            continue;
        }
        near.mark(sector);
        if distance <= gate.limit {
            seen.mark(sector);
            if gate.sectors.has(sector) {
                adjustment.add(&point);
                farthest = farthest.max(distance);
                spread.add_fixed(distance, PX.ilog2());
            }
        }
    }
    let adjusted = adjustment.finish().ok_or(Reject::NotElliptic)?;
    Ok(Step { adjusted, seen, near, farthest, sigma: spread.sigma() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a third of the points is missing there is a gap, or what is left is no circle either.
    #[test]
    fn missing_points_leave_a_gap() {
        let judged = |share: f32, gap: u32| {
            let shape = Shape::from_moments(0.0, 0.0, 56.0, 0.0, 20.0).unwrap();
            let (a, b) = shape.semi_axes();
            let seen = (PARTS - gap) as f32 / PARTS as f32;
            let points = (share * POINTS_PER_AXIS * math::sqrt(a * b) * seen) as u16;
            let frame_covariance = Default::default();
            let adjusted =
                Adjusted { shape, covariance: Default::default(), frame_covariance, rms: 0.02, points };
            judge(&adjusted, gap, false, 0.0)
        };
        assert_eq!([judged(0.8, 0), judged(0.65, 0)], [Ok(()), Err(Reject::NotElliptic)]);
        assert_eq!([judged(0.65, 8), judged(0.45, 8)], [Ok(()), Err(Reject::NotElliptic)]);
    }
}
