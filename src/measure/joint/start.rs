//! First guesses of levels and blur.

use crate::edge::Edges;
use crate::math;
use crate::scan::{Axis, Pool};

/// Density of the normal distribution in its middle.
const PEAK: f32 = 0.3989;
/// Range of the first guess of the blur, px.
const BLUR: (f32, f32) = (0.35, 4.0);

/// Dark, bright and blur in the mean over few crossings of each edge. The levels are those beyond the near samples; the blur is
/// that which makes a slope of the difference of the two samples beside the edge.
pub(super) fn start(edges: &Edges<'_>, pool: &Pool<'_>) -> Option<(f32, f32, f32)> {
    let (mut dark, mut bright, mut slope, mut width, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for edge in edges.edges {
        for crossing in pool.iter(edge.crossings).step_by(edge.stride()) {
            let x = (i32::from(crossing.x) - i32::from(edges.origin.0)) as f32;
            let y = (i32::from(crossing.y()) - i32::from(edges.origin.1)) as f32;
            let ((gx, gy), _) = edge.shape.gradient(x, y);
            let (along, across) = if crossing.axis() == Axis::Row { (gx, gy) } else { (gy, gx) };
            if along.abs() < across.abs() {
                continue;
            }
            let cosine = along.abs() / math::sqrt(along * along + across * across);
            let [first, _, before, after, _, last] = crossing.near.map(f32::from);
            let [far_before, far_after] = crossing.far().map(|stretch| stretch.mean().1);
            let rising = after > before;
            let (low, high) = if rising {
                (first.min(far_before), last.max(far_after))
            } else {
                (last.min(far_after), first.max(far_before))
            };
            dark += low;
            bright += high;
            slope += (after - before).abs() / cosine;
            width += cosine * cosine;
            count += 1.0;
        }
    }
    if count == 0.0 {
        return None;
    }
    let (dark, bright) = (dark / count, bright / count);
    // The edge lies anywhere between the two samples, 1 px apart: on average that is one more blur, a triangle's.
    let ratio = PEAK * count * (bright - dark) / slope;
    let blur = math::sqrt(ratio * ratio - width / (6.0 * count)).clamp(BLUR.0, BLUR.1);
    (bright > dark).then_some((dark, bright, blur))
}
