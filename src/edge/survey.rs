//! Levels and edge points of a target in one pass over its crossings.

use super::levels::Gauge;
use super::place::{Blur, Profile};
use super::{Edge, Edges, Levels, Lines};
use crate::fit::{Frame, View};
use crate::fixed::ONE;
use crate::math;
use crate::scan::Pool;

/// An edge point as its ellipse has it.
pub(crate) struct Point {
    pub view: View,
    /// Lightness beside the edge beyond what the levels give, 1/256 of the contrast, and largest difference of a sample from the
    /// profile.
    pub excess: i32,
    pub misfit: i32,
}

/// A target's crossings with the levels and the blur that few of them tell.
pub(crate) struct Survey<'a> {
    edges: &'a Edges<'a>,
    lines: &'a Lines,
    blur: Blur,
    before: &'a Levels,
    gauge: Gauge<'a>,
    /// Sums of the profiles' densities and of their squares, with the unit of shares.
    densities: (u32, u32),
}

impl<'a> Survey<'a> {
    pub fn new((edges, lines): (&'a Edges<'a>, &'a Lines), before: &'a Levels, blur: &Blur) -> Option<Self> {
        let gauge = Gauge::of_all(before, edges, blur)?;
        Some(Self { edges, lines, blur: *blur, before, gauge, densities: (0, 0) })
    }

    /// Passes over the crossings of edge `k`, the edge points of which go to `take`. Gives the noise of a sample, as a share of the
    /// contrast.
    pub fn pass(&mut self, k: usize, pool: &Pool<'_>, mut take: impl FnMut(&Point)) -> Option<f32> {
        let (edge, views) = (self.edges.edges.get(k)?, self.edges.views(k, self.lines)?);
        let (mut squares, mut count) = (0u32, 0);
        for crossing in pool.iter(edge.crossings) {
            let Some(local) = &views.local_inline(crossing) else { continue };
            let there = self.gauge.light.at(local);
            let profile = Profile::new(local, crossing, (&self.gauge.light, &there), &self.gauge.sharpness);
            self.gauge.add(local, crossing, &profile.edge, &there);
            let Some(placed) = profile.place_from(local.at) else { continue };
            for difference in placed.differences() {
                squares += ((difference * difference) >> 14).unsigned_abs();
            }
            count += 4;
            self.densities.0 += placed.densities.0.unsigned_abs();
            self.densities.1 += placed.densities.1.unsigned_abs() >> ONE.ilog2();
            take(&Point {
                view: views.edge.view(local.axis, &local.conic, local.sign * placed.place),
                excess: placed.excess(),
                misfit: placed.misfit(),
            });
        }
        (count > 0).then(|| math::sqrt(squares as f32 / (ONE as f32 * count as f32)))
    }

    /// The levels that all crossings tell.
    pub fn levels(&self) -> Option<Levels> {
        self.gauge.levels()
    }

    /// How far these put the points of `edge` farther out than the levels before, px: the same for all, and in proportion
    /// to their place in its frame.
    pub fn shift(&self, levels: &Levels, edge: &Edge) -> Option<[f32; 3]> {
        let shape = &edge.shape;
        let Levels { dark, bright, gx, gy, .. } = *self.before;
        let Frame { l0, l1, l2 } = Frame::new(shape)?;
        // Where the middle level is, the profile is steepest; what raises it moves the edge towards light.
        let middle = 0.5 * (dark + bright);
        let raised = 0.5 * (levels.dark + levels.bright) - middle;
        let (x, y) = (middle * (levels.gx - gx), middle * (levels.gy - gy));
        let outwards = if edge.dark_inside { 1.0 } else { -1.0 };
        let by_level = outwards * self.blur.sigma * self.densities.0 as f32
            / (self.densities.1 as f32 * self.before.contrast());
        let field = [raised + x * shape.cx + y * shape.cy, x / l0, (y - x * l1 / l0) / l2];
        Some(field.map(|part| by_level * part))
    }
}
