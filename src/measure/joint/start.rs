//! First guesses of levels and blur.

use crate::edge::{Edge, Edges};
use crate::fixed::{Inverse, ONE, fixed, scale};
use crate::math;
use crate::scan::{Axis, Crossing, Pool};

/// Density of the normal distribution in its middle.
const PEAK: f32 = 0.3989;
/// Range of the first guess of the blur, px.
const BLUR: (f32, f32) = (0.35, 4.0);
/// What is one in the matrix of an ellipse, in places, and in levels.
const MATRIX: i32 = 1 << 20;
const PLACE: i32 = 1 << 4;
const LEVEL: i32 = 1 << 4;

/// The direction of an edge's outward normal.
struct Normal {
    centre: (i32, i32),
    /// The ellipse's matrix times its semi-minor axis, so that the gradient is at most one.
    xx: i32,
    xy: i32,
    yy: i32,
}

impl Normal {
    fn new(edge: &Edge) -> Self {
        let Edge { shape, axes: (_, minor), .. } = edge;
        let [xx, xy, yy] = [shape.axx, shape.axy, shape.ayy].map(|entry| fixed(minor * entry, MATRIX));
        Self { centre: (fixed(shape.cx, PLACE), fixed(shape.cy, PLACE)), xx, xy, yy }
    }

    /// |cosine| of its angle with the axis of a crossing at a place about the origin, px; `None` where the other axis is steeper.
    fn cosine(&self, axis: Axis, (x, y): (i32, i32)) -> Option<i32> {
        let (x, y) = (x * PLACE - self.centre.0, y * PLACE - self.centre.1);
        let x_part = self.xx.wrapping_mul(x).wrapping_add(self.xy.wrapping_mul(y)).unsigned_abs() >> 10;
        let y_part = self.xy.wrapping_mul(x).wrapping_add(self.yy.wrapping_mul(y)).unsigned_abs() >> 10;
        let (along, across) = if axis == Axis::Row { (x_part, y_part) } else { (y_part, x_part) };
        // An outline may be far from its ellipse.
        if along < across || along > 2 * ONE as u32 {
            return None;
        }
        Some(Inverse::of_root(along * along + across * across)?.cosine(along as i32))
    }
}

/// Sums over crossings.
#[derive(Default)]
struct Sums {
    count: i32,
    dark: i32,
    bright: i32,
    /// Differences of the two samples beside the edge.
    step: i32,
    cosine: i32,
    square: i32,
}

impl Sums {
    fn add(&mut self, crossing: &Crossing, cosine: i32) {
        let [first, _, before, after, _, last] = crossing.near.map(|level| i32::from(level) * LEVEL);
        let [far_before, far_after] = crossing.far().map(|stretch| {
            let (log, sum) = stretch.sum();
            (i32::from(sum) * LEVEL) >> log
        });
        let (low, high) = if after > before {
            (first.min(far_before), last.max(far_after))
        } else {
            (last.min(far_after), first.max(far_before))
        };
        self.count += 1;
        self.dark += low;
        self.bright += high;
        self.step += (after - before).abs();
        self.cosine += cosine;
        self.square += scale(cosine, cosine);
    }
}

/// Dark, bright and blur in the mean over few crossings of each edge. The levels are those beyond the near samples; the blur is
/// that which makes a slope of the difference of the two samples beside the edge.
pub(super) fn start(edges: &Edges<'_>, pool: &Pool<'_>) -> Option<(f32, f32, f32)> {
    let mut sums = Sums::default();
    for edge in edges.edges {
        let normal = Normal::new(edge);
        for crossing in pool.iter(edge.crossings).step_by(edge.stride()) {
            let x = i32::from(crossing.x) - i32::from(edges.origin.0);
            let y = i32::from(crossing.y()) - i32::from(edges.origin.1);
            if let Some(cosine) = normal.cosine(crossing.axis(), (x, y)) {
                sums.add(crossing, cosine);
            }
        }
    }
    if sums.count == 0 || sums.bright <= sums.dark {
        return None;
    }
    let mean = |sum: i32, one: i32| sum as f32 / (one * sums.count) as f32;
    let (dark, bright) = (mean(sums.dark, LEVEL), mean(sums.bright, LEVEL));
    // The edge lies anywhere between the two samples, 1 px apart: on average that is one more blur, a triangle's.
    let ratio = PEAK * (bright - dark) * mean(sums.cosine, ONE) / mean(sums.step, LEVEL);
    let blur = math::sqrt(ratio * ratio - mean(sums.square, ONE) / 6.0).clamp(BLUR.0, BLUR.1);
    Some((dark, bright, blur))
}
