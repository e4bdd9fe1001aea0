//! One edge: its edge points to an ellipse.

use super::Light;
use super::origin::Origin;
use super::sectors::{PARTS, PLACES, SectorLight, Sectors};
use crate::abilities::ARCS;
use crate::arcs;
use crate::edge::Edge;
use crate::fit::{Adjusted, Adjustment, Shape, Spread, Sums};
use crate::math;
use crate::reject::Reject;
use crate::scan::{Axis, Crossing, CrossingList, Pool};
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
    /// The crossings of edge `k` whose profile is that of an edge.
    pub fn crossings(&self, k: usize) -> impl Iterator<Item = &'a Crossing> + Clone + use<'a, 'p> {
        let tolerance = 256.0 * (limits::MISFIT + limits::MISFIT_SIGMAS * self.noise);
        self.all(k).filter(move |crossing| {
            crossing.edge_point().is_some_and(|point| f32::from(point.misfit) <= tolerance)
        })
    }

    /// Factor on the covariance of an ellipse through so many points because their residuals are not independent. What the noise does
    /// not explain moves the points of a place all together, and so does the light beside the edge, of which `light` is the variance.
    pub fn excess(&self, points: u16, rms: f32, light: f32) -> f32 {
        let square = (rms * rms).max(f32::MIN_POSITIVE);
        let (explained, moved) = (EXPLAINED * self.calm, LIGHT_MOVES * self.blur);
        let unexplained = (1.0 - explained * explained / square).max(0.0);
        1.0 + f32::from(points) / PLACES as f32 * (unexplained + moved * moved * light / square)
    }

    /// Variance of an edge point, px^2, that the noise explains.
    pub fn edge_variance(&self) -> f32 {
        Light::edge_variance(1.0, self.calm, self.blur)
    }

    fn all(&self, k: usize) -> impl Iterator<Item = &'a Crossing> + Clone + use<'a, 'p> {
        self.pool.iter(self.edges.get(k).map_or(CrossingList::EMPTY, |edge| edge.crossings))
    }

    /// Their edge points about the origin, px; by linear interpolation where they are not placed yet.
    pub fn points(&self, k: usize) -> impl Iterator<Item = (f32, f32)> + use<'a, 'p> {
        let origin = self.origin;
        let placed = !ARCS || self.noise.is_finite();
        let rough = self.all(k).filter(move |_| !placed).map(|crossing| arcs::place(crossing, origin.pixel));
        let fine = self
            .crossings(k)
            .filter(move |_| placed)
            .filter_map(|crossing| origin.undistorted(edge_point(crossing, origin.pixel)?));
        rough.chain(fine)
    }
}

/// Fits the ellipse of edge `k`.
pub(super) fn fit(source: &Source<'_, '_>, k: usize) -> Result<Fitted, Reject> {
    let &Source { origin, noise, .. } = source;
    let edge = source.edges.get(k).ok_or(Reject::Alone)?;
    if ARCS && edge.partial {
        return fit_arcs(source, k, edge);
    }
    let places = source.crossings(k).filter_map(|crossing| edge_point(crossing, origin.pixel));
    let points = || source.points(k);
    let start = start(edge, places, origin)?;
    let minor = start.semi_axes().1;
    let (even, light) =
        even_sectors(&start, source.crossings(k), origin, (noise, source.calm)).ok_or(Reject::NotElliptic)?;
    let mut gate = Gate { limit: f32::INFINITY, sectors: even.0, even };
    let mut step = adjust(start, points(), &gate)?;
    for _ in 1..PASSES {
        let next =
            Gate { limit: limits::OUTLIER * step.sigma, sectors: step.near.without_ends(minor).0, even };
        if step.farthest <= next.limit && gate.sectors & !next.sectors == 0 {
            break;
        }
        gate = next;
        step = adjust(step.adjusted.shape, points(), &gate)?;
    }
    let Step { adjusted, seen, .. } = step;
    let gap = seen.closed(minor).longest_gap();
    judge(&adjusted, gap, false, source.edge_variance())?;
    let adjusted = adjusted.with_variance(source.excess(adjusted.points, adjusted.rms, light));
    let Edge { dark_inside, partial, cut, .. } = *edge;
    Ok(Fitted { adjusted, edge: k, dark_inside, partial, cut, gap, ratio: 1.0, measured_ratio: 1.0 })
}

/// Whether what is seen of an ellipse makes it one. The noise explains a variance of `explained` px^2 of its points.
pub(super) fn judge(adjusted: &Adjusted, gap: u32, together: bool, explained: f32) -> Result<(), Reject> {
    if gap > if together { limits::MAX_GAP_TOGETHER } else { limits::MAX_GAP } {
        return Err(Reject::OpenOutline);
    }
    let (a, b) = adjusted.shape.semi_axes();
    // What the gap leaves must be seen, and mostly be of this ellipse.
    let expected = POINTS_PER_AXIS * math::sqrt(a * b) * (PARTS - gap) as f32 / PARTS as f32;
    if f32::from(adjusted.points) < limits::MIN_POINTS_SHARE * expected {
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
    let places = source.crossings(k).filter_map(|crossing| edge_point(crossing, source.origin.pixel));
    let start = start(edge, places, source.origin)?;
    let gate = Gate { limit: f32::INFINITY, sectors: u128::MAX, even: Sectors(u128::MAX) };
    let mut adjusted = adjust(start, source.points(k), &gate)?.adjusted;
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
    let gate = Gate { limit, sectors: used.0, even: used };
    Some(adjust(shape, source.points(k), &gate).ok()?.adjusted)
}

/// Edge point of a crossing about the origin, 1/256 px.
fn edge_point(crossing: &Crossing, origin: (u16, u16)) -> Option<(i32, i32)> {
    let offset = i32::from(crossing.edge_point()?.offset);
    let x = 256 * (i32::from(crossing.x) - i32::from(origin.0));
    let y = 256 * (i32::from(crossing.y()) - i32::from(origin.1));
    Some(match crossing.axis() {
        Axis::Row => (x + offset, y),
        Axis::Column => (x, y + offset),
    })
}

/// The algebraic fit; where arcs are missing that would shrink the ellipse, and the search has given a better one of what is
/// seen.
fn start(edge: &Edge, places: impl Iterator<Item = (i32, i32)>, origin: &Origin) -> Result<Shape, Reject> {
    if ARCS && edge.partial && origin.lens().is_none() {
        return Ok(edge.shape);
    }
    let mut sums = Sums::default();
    places.filter_map(|place| origin.on_grid(place)).for_each(|(x, y)| sums.add(x, y));
    sums.fit().ok_or(Reject::NotElliptic)
}

/// The sectors in which the light beside the edge is the same as around most of the circle, and the variance of the light in them from
/// place to place, in units of the contrast. The noise is that of the samples, and the same without what disturbs them.
pub(super) fn even_sectors<'c>(
    shape: &Shape,
    crossings: impl Iterator<Item = &'c Crossing> + Clone,
    origin: &Origin,
    (noise, calm): (f32, f32),
) -> Option<(Sectors, f32)> {
    // Where nothing disturbs the light there is nothing to sort out.
    let limit = 256.0 * (limits::UNEVEN + 3.0 * noise);
    let uneven = |crossing: &Crossing| {
        crossing.edge_point().is_some_and(|point| f32::from(point.excess).abs() > limit)
    };
    let disturbed = crossings.clone().any(uneven);
    let adjustment = Adjustment::new(*shape)?;
    let mut light = SectorLight::new(shape.semi_axes().1);
    for crossing in crossings {
        let place = edge_point(crossing, origin.pixel).and_then(|place| origin.undistorted(place));
        if let (Some(point), Some((x, y))) = (crossing.edge_point(), place) {
            let view = adjustment.view(x, y);
            light.add(view.u, view.v, point.excess);
        }
    }
    let even = if disturbed { light.even(noise) } else { Sectors(u128::MAX) };
    Some((even, light.variance(even, calm)))
}

/// Which points are used.
struct Gate {
    /// Largest distance from the ellipse, px.
    limit: f32,
    /// Sectors in which they may lie: not those beside gaps, where what hides the edge has a part in its profile.
    sectors: u128,
    /// The same with these.
    even: Sectors,
}

/// An adjustment with what else the points tell.
struct Step {
    adjusted: Adjusted,
    /// Sectors in which there are points within the limit, ...
    seen: Sectors,
    /// ... and in which there are points of the edge, even if the ellipse before the step was off.
    near: Sectors,
    /// Distance of the farthest point that was used from the ellipse before the step, px.
    farthest: f32,
    /// Robust standard deviation of the distances, px.
    sigma: f32,
}

/// One step from `shape` with the points that pass `gate`.
fn adjust(shape: Shape, points: impl Iterator<Item = (f32, f32)>, gate: &Gate) -> Result<Step, Reject> {
    let mut adjustment = Adjustment::new(shape).ok_or(Reject::NotElliptic)?;
    let (mut seen, mut near) = (Sectors(0), Sectors(0));
    let mut spread = Spread::default();
    let mut farthest = 0.0f32;
    let farthest_near = gate.limit.max(NEAR);
    for (x, y) in points {
        let point = adjustment.view(x, y);
        let distance = point.square_distance();
        if distance > farthest_near * farthest_near {
            continue;
        }
        let sector = Sectors::sector(point.u, point.v) & gate.even.0;
        near.0 |= sector;
        if distance <= gate.limit * gate.limit {
            seen.0 |= sector;
            if gate.sectors & sector != 0 {
                adjustment.add(&point);
                farthest = farthest.max(distance);
                spread.add(distance);
            }
        }
    }
    let adjusted = adjustment.finish().ok_or(Reject::NotElliptic)?;
    Ok(Step { adjusted, seen, near, farthest: math::sqrt(farthest), sigma: spread.sigma() })
}
