//! A target in two short passes over its crossings: one for the levels, one for the edge points and the ellipses.

use super::ellipse::{Fitted, FittedList, judge};
use super::origin::Origin;
use super::sectors::Sectors;
use super::{Light, check_contrast};
use crate::edge::{Edge, Edges, Levels, Probit};
use crate::fit::Adjustment;
use crate::fixed::{PX, sector};
use crate::math;
use crate::scan::Pool;

/// Largest noise of a sample, as a share of the contrast: more is not only noise.
const MOST_NOISE: f32 = 0.06;
/// Least distance of two edges, px: nearer ones have a part in each other's samples.
const LEAST_GAP: f32 = 3.0;
/// Least radius of curvature of an edge, px: a blurred one lies inside of where it bends more.
const LEAST_RADIUS: f32 = 2.4;
/// Largest blur, px, with which the samples beside an edge are those of the levels.
const MOST_BLUR: f32 = 1.3;
/// Variance of the edge points in units of what the noise explains, and beyond that, px^2: more is disturbed.
const EXPLAINED: f32 = 3.0;
const UNEXPLAINED: f32 = 0.03 * 0.03;
/// Farthest of the points, standard deviations, beside what the outline leaves of the ellipse, px.
const FARTHEST: f32 = 4.5;
/// Largest distance of the outline from its edge that the one step of the fit is good for, px.
const NEAR: f32 = 0.5;

/// The fitted ellipses of all edges into `fitted`, and the light. `None` where anything disturbs the target.
#[inline(never)]
pub(super) fn quick(
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    origin: &Origin,
    fitted: &mut FittedList,
) -> Option<Light> {
    let list = edges.edges;
    let inside = list.iter().skip(1);
    let tight = list.iter().zip(inside).any(|(outer, inner)| outer.axes.1 - inner.axes.1 < LEAST_GAP);
    let bent = |edge: &Edge| edge.axes.1 * edge.axes.1 < LEAST_RADIUS * edge.axes.0;
    let unfit = |edge: &Edge| edge.partial || edge.cut || bent(edge);
    if tight || origin.lens().is_some() || list.iter().any(unfit) {
        return None;
    }
    let levels = Levels::of_flat(edges, pool)?;
    check_contrast(levels.contrast()).ok()?;
    if levels.noise > MOST_NOISE * levels.contrast() {
        return None;
    }
    let mut probit = Probit::new(&levels, edges.origin);
    for (k, edge) in list.iter().enumerate() {
        fitted.push(fit((edge, k), pool, &mut probit)?).ok()?;
    }
    let blur = probit.blur();
    let light = Light::new(&levels, blur, fitted.first());
    let most = EXPLAINED * light.edge_variance + UNEXPLAINED;
    let calm = |circle: &Fitted| {
        circle.adjusted.rms * circle.adjusted.rms <= most
            && judge(&circle.adjusted, 0, false, light.edge_variance).is_ok()
    };
    (blur <= MOST_BLUR && fitted.iter().all(calm)).then_some(light)
}

/// The ellipse of the edge points of edge `k`, by one step from its outline's.
#[inline(never)]
fn fit((edge, k): (&Edge, usize), pool: &Pool<'_>, probit: &mut Probit) -> Option<Fitted> {
    let mut adjustment = Adjustment::new(edge.shape)?;
    let mut seen = Sectors::NONE;
    let (mut sum, mut ends) = (0, (0, 0));
    probit.pass(edge, pool, |point| {
        seen.mark(sector(point.place));
        sum += point.distance;
        ends = (point.distance.min(ends.0), point.distance.max(ends.1));
        adjustment.add(point);
    })?;
    let (adjusted, step, []) = adjustment.finish_with(&[])?;
    let mean = sum as f32 / f32::from(adjusted.points);
    let farthest = (ends.1 as f32 - mean).max(mean - ends.0 as f32) / PX as f32;
    // The outline leaves the ellipse by this.
    let (major, minor) = edge.axes;
    let [p, q, size, x, y] = step;
    let off = 0.5 * major * (math::sqrt(p * p + q * q) + math::sqrt(x * x + y * y))
        + 0.5 * (major - minor) * size.abs();
    let undisturbed = seen.without_ends(minor) == Sectors::ALL
        && mean.abs() < NEAR * PX as f32
        && farthest <= FARTHEST * adjusted.rms + off;
    let Edge { dark_inside, partial, cut, .. } = *edge;
    let fitted =
        Fitted { adjusted, edge: k, dark_inside, partial, cut, gap: 0, ratio: 1.0, measured_ratio: 1.0 };
    undisturbed.then_some(fitted)
}
