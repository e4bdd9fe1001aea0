//! How far edge points lie from the ellipse of their outline.

use crate::fit::{Adjusted, TERMS};
use crate::fixed::PX;
use crate::math;

/// Farthest of the points, standard deviations, beside what the outline leaves of the ellipse.
const FARTHEST: f32 = 4.5;
/// Largest distance of the outline from its edge that the one step of a fit is good for, px.
const NEAR: f32 = 0.5;

/// Sum of the distances, and the least and the largest, [`PX`].
#[derive(Default)]
pub(super) struct Distances {
    sum: i32,
    ends: (i32, i32),
}

impl Distances {
    #[inline(always)]
    pub fn add(&mut self, distance: i32) {
        self.sum += distance;
        self.ends = (self.ends.0.min(distance), self.ends.1.max(distance));
    }

    /// Whether one step from the outline, whose semi-axes are `axes`, px, is enough, and no point farther off than the noise puts it.
    #[inline(never)]
    pub fn are_near(&self, adjusted: &Adjusted, step: &[f32; TERMS], (major, minor): (f32, f32)) -> bool {
        let mean = self.sum as f32 / f32::from(adjusted.points);
        let farthest = (self.ends.1 as f32 - mean).max(mean - self.ends.0 as f32) / PX as f32;
        // The outline leaves the ellipse by this.
        let [p, q, size, x, y] = *step;
        let off = 0.5 * major * (math::sqrt(p * p + q * q) + math::sqrt(x * x + y * y))
            + 0.5 * (major - minor) * size.abs();
        mean.abs() < NEAR * PX as f32 && farthest <= FARTHEST * adjusted.rms + off
    }
}
