//! Circles of which only arcs are seen: their ellipses together, as those of concentric circles.
//!
//! An arc by itself leaves its ellipse unsure across the gap, the more the less is seen. What the circles share
//! ([`Concentric`]) takes most of that away.

use super::combine::{combine, measured_perspective};
use super::ellipse::{Fitted, FittedList, NEAR, PASSES, Source, alone, even_sectors, judge, push};
use super::origin::Origin;
use super::sectors::{Sectors, sector_of};
use crate::edge::Edge;
use crate::fit::{Adjusted, Concentric, ConcentricAdjustment, ConcentricStep, Shape, Spread};
use crate::fixed::{ONE, PX, fixed};
use crate::list::{list, rolled};
use crate::math;
use crate::reject::Reject;
use crate::scan::Pool;
use crate::settings::limits;
use crate::target::{Covariance, MAX_CIRCLES};
use heapless::Vec;

/// Room in what the last step leaves for what it found, and the least that it leaves, px.
const LEFT: f32 = 1.5;
const LEAST: f32 = 0.02;
/// Distance of a point that is on an arc from a first guess of it, px.
const ON: f32 = 1.0;

/// Circles that were fitted together.
#[derive(Clone, Debug)]
pub(super) struct Together {
    pub circles: FittedList,
    /// The same, each then fitted by itself.
    pub separate: FittedList,
    /// Of the true centre, px^2.
    pub covariance: Covariance,
}

impl Together {
    /// Whether the inner circles have these ratios as they are measured, so closely that it is no accident.
    pub fn has_ratios(&self, wanted: &[f32]) -> bool {
        let Some((outer, inner)) = self.circles.split_first() else { return false };
        let has = |circle: &Fitted| {
            let measured = math::sqrt(math::sqrt(outer.adjusted.shape.det() / circle.adjusted.shape.det()));
            wanted.iter().any(|ratio| (measured / ratio - 1.0).abs() <= limits::OPEN_RATIO)
        };
        inner.iter().all(has)
    }
}

/// Better ellipses for edges of which only arcs are seen, from crossings that are not placed yet. The search has fitted each by
/// itself, and a short one to what cuts it as well.
#[inline(never)]
pub(super) fn rough(edges: &mut [Edge], pool: &Pool<'_>, origin: &Origin) {
    let source = Source { edges, pool, origin, noise: f32::INFINITY, calm: f32::INFINITY, blur: 0.0 };
    let most = edges.iter().enumerate().max_by_key(|(_, edge)| edge.crossings.len());
    let Some((reference, shape)) = most.map(|(k, edge)| (k, edge.shape)) else { return };
    let Some(family) = Concentric::new(shape, (shape.cx, shape.cy)) else { return };
    let fit = |mostly_on: bool| {
        let limit = if mostly_on { ON } else { f32::INFINITY };
        let mut fit = Fit { source: &source, family, arcs: Vec::new(), limit };
        fit.add(reference, 1.0, (Sectors::ALL, 0.0));
        for (k, _) in edges.iter().enumerate().filter(|(k, edge)| edge.partial && *k != reference) {
            let size =
                if mostly_on { middle_size(&source, k, &shape) } else { mean_size(&source, k, &shape) };
            fit.add(k, size, (Sectors::ALL, 0.0));
        }
        fit.settle(false).map(|_| fit)
    };
    // Each point may be off; where that leads nowhere, most of them are on the arcs.
    let Some(fit) = fit(false).or_else(|| fit(true)) else { return };
    let shapes: Vec<_, MAX_CIRCLES> = list(fit.arcs.iter().map(|arcs| (arcs.edge, fit.shape(arcs))));
    for &(k, shape) in &shapes {
        if let (Some(edge), Some(shape)) = (edges.get_mut(k).filter(|edge| edge.partial), shape) {
            *edge = edge.with_shape(shape);
        }
    }
}

/// The points of an edge in units of an ellipse: their squared distances from its centre.
fn squares(source: &Source<'_, '_>, k: usize, shape: &Shape) -> impl Iterator<Item = f32> {
    source.points(k).map(px).map(|(x, y)| shape.square(x - shape.cx, y - shape.cy))
}

fn mean_size(source: &Source<'_, '_>, k: usize, shape: &Shape) -> f32 {
    let (sum, count) = squares(source, k, shape)
        .fold((0.0, 0.0), |(sum, count), square| (sum + math::sqrt(square), count + 1.0));
    sum / count
}

/// The median, to a thousandth.
fn middle_size(source: &Source<'_, '_>, k: usize, shape: &Shape) -> f32 {
    let (mut low, mut high) = (0.0, 4.0);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        let (below, count) = squares(source, k, shape)
            .fold((0, 0), |(below, count), square| (below + u32::from(square < middle), count + 1));
        if 2 * below < count { low = middle } else { high = middle }
    }
    math::sqrt(0.5 * (low + high))
}

/// Fits the `circles`, which are those of one target, together; `given` tells that their ratios are not measured.
#[inline(never)]
pub(super) fn together(
    circles: &FittedList,
    source: &Source<'_, '_>,
    given: bool,
) -> Result<Together, Reject> {
    let mut fit = Fit::new(circles, source).ok_or(Reject::NotConcentric)?;
    let step = fit.settle(given).ok_or(Reject::NotConcentric)?;
    let factor = fit.excess(step.rms);
    let (mut all, mut separate) = (FittedList::new(), FittedList::new());
    for (circle, arcs) in circles.iter().zip(&fit.arcs) {
        let mut circle = Fitted { ratio: arcs.ratio, ..*circle };
        circle.gap = arcs.seen.closed(arcs.minor).longest_gap();
        let shape = fit.shape(arcs).ok_or(Reject::NotElliptic)?;
        circle.adjusted = Adjusted {
            shape,
            covariance: step.covariance(arcs.ratio).scaled(factor),
            points: arcs.points,
            rms: math::sqrt(arcs.squares / f32::from(arcs.points.max(1))),
            ..circle.adjusted
        };
        // The others were judged by themselves.
        if circle.partial {
            judge(&circle.adjusted, circle.gap, true, source.edge_variance())?;
        }
        let _ = push(&mut all, &circle);
        if let Some(adjusted) = alone(source, arcs.edge, shape, (fit.limit, arcs.used)) {
            circle.adjusted = adjusted.with_variance(factor);
            let _ = push(&mut separate, &circle);
        }
    }
    Ok(Together { circles: all, separate, covariance: step.covariance(0.0).scaled(factor) })
}

/// A point in px.
fn px(((x, y), _): ((i32, i32), i8)) -> (f32, f32) {
    const EACH: f32 = 1.0 / PX as f32;
    (EACH * x as f32, EACH * y as f32)
}

/// The arcs of a circle.
#[derive(Clone, Copy, Debug)]
struct Arcs {
    edge: usize,
    ratio: f32,
    /// w of [`Concentric`].
    size: f32,
    /// Semi-minor axis, px.
    minor: f32,
    /// Sectors in which the light is even, and those of which the points are used.
    even: Sectors,
    used: Sectors,
    /// Variance of the light in the even ones, in units of the contrast.
    light: f32,
    /// Sectors in which there are points within the limit, and such of the edge even if the ellipse was off.
    seen: Sectors,
    near: Sectors,
    /// Number of points within the limit, and as many times the mean squared distance of those that are used, px^2.
    points: u16,
    squares: f32,
}

/// A fit on its way.
struct Fit<'a, 'p> {
    source: &'a Source<'a, 'p>,
    family: Concentric,
    arcs: Vec<Arcs, MAX_CIRCLES>,
    /// Largest distance of a point, px.
    limit: f32,
}

impl<'a, 'p> Fit<'a, 'p> {
    fn new(circles: &FittedList, source: &'a Source<'a, 'p>) -> Option<Self> {
        let outer = circles.first()?.adjusted.shape;
        let start = combine(circles, measured_perspective(circles)?)?;
        // Arcs alone may put it anywhere.
        let family = Concentric::new(outer, (start.x, start.y))
            .or_else(|| Concentric::new(outer, (outer.cx, outer.cy)))?;
        let mut fit = Self { source, family, arcs: Vec::new(), limit: f32::INFINITY };
        for circle in circles {
            let even = even_sectors(source, circle.edge, &circle.adjusted.shape)?;
            fit.add(circle.edge, circle.ratio, even);
        }
        Some(fit)
    }

    fn add(&mut self, edge: usize, ratio: f32, (even, light): (Sectors, f32)) {
        let minor = ratio * self.family.outer.semi_axes().1;
        let none = Sectors::NONE;
        let (used, seen, near) = (even, none, none);
        let arcs =
            Arcs { edge, ratio, size: 0.0, minor, even, light, used, seen, near, points: 0, squares: 0.0 };
        let _ = self.arcs.push(arcs);
    }

    fn shape(&self, arcs: &Arcs) -> Option<Shape> {
        self.family.member(arcs.ratio, arcs.size).shape()
    }

    /// Steps until the points that are used stay the same.
    fn settle(&mut self, given: bool) -> Option<ConcentricStep> {
        let mut last = None;
        for _ in 0..PASSES {
            let (step, farthest, sigma) = self.pass()?;
            let limit = limits::OUTLIER * sigma;
            // Where the circles were off, what the step leaves tells the scatter.
            let left = limits::OUTLIER * (LEFT * step.rms).max(LEAST);
            let mut settled = farthest <= limit.min(left);
            self.family = step.family;
            for (arcs, change) in self.arcs.iter_mut().zip(&step.sizes) {
                arcs.size += change;
                if !given {
                    // The size tells the ratio.
                    arcs.ratio = math::sqrt(arcs.ratio * arcs.ratio + arcs.size);
                    arcs.size = 0.0;
                }
                let used = arcs.near.without_ends(arcs.minor);
                settled &= arcs.used.without(&used) == Sectors::NONE;
                arcs.used = used;
            }
            last = Some(step);
            if settled {
                break;
            }
            self.limit = limit;
        }
        last
    }

    /// A step, the distance of the farthest point that it used, and the robust standard deviation of these, px.
    fn pass(&mut self) -> Option<(ConcentricStep, f32, f32)> {
        let mut adjustment = ConcentricAdjustment::new();
        let mut spread = Spread::default();
        let (mut farthest, limit) = (0.0f32, self.limit);
        for arcs in &mut self.arcs {
            let member = self.family.member(arcs.ratio, arcs.size);
            (arcs.seen, arcs.near, arcs.points, arcs.squares) = (Sectors::NONE, Sectors::NONE, 0, 0.0);
            let mut used = 0u16;
            adjustment.next_circle();
            for (x, y) in self.source.points(arcs.edge).map(px) {
                let view = member.view(x, y);
                let distance = view.distance().abs();
                if distance > limit.max(NEAR) {
                    continue;
                }
                let place = (fixed(view.u, ONE), fixed(view.v, ONE));
                let sector = sector_of(place);
                if !arcs.even.has(sector) {
                    continue;
                }
                arcs.near.mark(sector);
                if distance <= limit {
                    arcs.seen.mark(sector);
                    arcs.points += 1;
                    if arcs.used.has(sector) {
                        adjustment.add(&member, &view);
                        farthest = farthest.max(distance);
                        spread.add(distance * distance);
                        arcs.squares += distance * distance;
                        used += 1;
                    }
                }
            }
            // As many as are seen would have.
            arcs.squares *= f32::from(arcs.points) / f32::from(used.max(1));
        }
        Some((adjustment.finish(&self.family)?, farthest, spread.sigma()))
    }

    /// Largest factor on the covariance because the residuals of a circle are not independent.
    fn excess(&self, rms: f32) -> f32 {
        rolled(&self.arcs)
            .fold(1.0, |factor: f32, arcs| factor.max(self.source.excess(arcs.points, rms, arcs.light)))
    }
}

#[cfg(test)]
mod tests;
