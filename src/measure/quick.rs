//! A target in two short passes over its crossings: one for the levels, one for the edge points and the ellipses.

use super::distances::Distances;
use super::ellipse::{Fitted, FittedList, judge};
use super::origin::Origin;
use super::sectors::Sectors;
use super::{Light, check_contrast};
use crate::edge::{Edge, Edges, Levels, Probit};
use crate::fit::Adjustment;
use crate::fixed::sector;
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
    let mut distances = Distances::default();
    probit.pass(edge, pool, |point| {
        seen.mark(sector(point.place));
        distances.add(point.distance);
        adjustment.add(point);
    })?;
    let (adjusted, step, []) = adjustment.finish_with(&[])?;
    let undisturbed =
        seen.without_ends(edge.axes.1) == Sectors::ALL && distances.are_near(&adjusted, &step, edge.axes);
    let Edge { dark_inside, partial, cut, .. } = *edge;
    let fitted =
        Fitted { adjusted, edge: k, dark_inside, partial, cut, gap: 0, ratio: 1.0, measured_ratio: 1.0 };
    undisturbed.then_some(fitted)
}
