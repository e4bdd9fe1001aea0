//! What a crossing of an undisturbed target may look like.

use super::samples::Samples;
use crate::fixed::{GREY, fixed};

/// Room in a far stretch, and in the light beside an edge, in standard deviations of the noise: of its mean over a part of a turn.
const FAR_SIGMAS: f32 = 4.0;
const UNEVEN_SIGMAS: f32 = 3.7;

/// Which crossings are used, and which of these are not disturbed. Grey levels.
#[derive(Clone, Copy)]
pub(super) struct Gate {
    /// Few of them only.
    pub few: bool,
    /// Largest residual of a sample.
    misfit: i32,
    /// Largest excess of light beside the edge; and the square of what noise adds to that of a crossing.
    excess: i32,
    noise_square: u32,
    /// Largest residual of a far stretch by the binary logarithm of its number of pixels.
    pub far: [i32; 5],
}

impl Gate {
    #[inline(never)]
    pub fn new(few: bool, misfit: f32, (far, excess): (f32, f32), noise: f32) -> Self {
        let grey_unit = (2 * GREY) as f32;
        let far = [1.0, 0.707, 0.5, 0.354, 0.25].map(|root| grey(far + FAR_SIGMAS * noise * root));
        // Of two samples, the sum of which is the excess.
        let noise = UNEVEN_SIGMAS * noise * grey_unit * core::f32::consts::FRAC_1_SQRT_2;
        Self {
            few,
            misfit: grey(misfit),
            excess: 2 * grey(excess),
            noise_square: (noise * noise) as u32,
            far,
        }
    }

    /// Whether a sample is something else.
    pub fn refuses(&self, samples: &Samples) -> bool {
        samples.residuals.rr > self.misfit * self.misfit && samples.misfit() > self.misfit
    }

    /// Whether `count` crossings with this sum of excesses lie in uneven light.
    pub fn is_uneven(&self, excess: i32, count: i32) -> bool {
        if self.few {
            return false;
        }
        let over = (excess.abs() - self.excess * count).max(0) as u32;
        over > 0 && over.saturating_pow(2) > self.noise_square.saturating_mul(count as u32)
    }
}

/// A residual, which is less than the whole scale.
fn grey(level: f32) -> i32 {
    fixed(level.min(255.0), GREY)
}
