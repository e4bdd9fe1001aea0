//! Edge points from two samples each: quick, and with more error than [`place`](super::place()) has.

use super::Levels;
use super::place::inverse_normal;
use crate::fixed::{GREY, ONE, PX, fixed};
use crate::math;
use crate::scan::{Axis, Crossing};

/// Least rise from sample to sample of an edge, standard deviations of its blur.
const LEAST_RISE: i32 = PX / 32;
/// Light that is calculated with, as reciprocal.
const LIGHT: (i32, i32) = (ONE * 2 / 3, ONE * 2);

/// Places edge points between the two samples next to them: lightness gives standard deviations of the blur, and these rise evenly
/// along the axis.
pub(crate) struct Probit {
    origin: (u16, u16),
    dark: i32,
    /// The reciprocal of the contrast.
    by_contrast: i32,
    /// Slopes of the light along x and y, 1/px, with 64 times the unit of light.
    slopes: (i32, i32),
    /// Sum of the squares of the rises from sample to sample, and how many.
    rises: u32,
    points: u32,
}

impl Probit {
    pub fn new(levels: &Levels, origin: (u16, u16)) -> Self {
        let slope = |slope: f32| fixed(slope.clamp(-0.06, 0.06), ONE << 6);
        Self {
            origin,
            dark: fixed(levels.dark, GREY),
            by_contrast: (1 << 26) / fixed(levels.contrast(), GREY).max(GREY),
            slopes: (slope(levels.gx), slope(levels.gy)),
            rises: 0,
            points: 0,
        }
    }

    /// The edge point of a crossing about the origin, px. `None` where there is no edge between its samples.
    #[inline(always)]
    pub fn place(&mut self, crossing: &Crossing) -> Option<(i32, i32)> {
        const HALF: i32 = ONE / 2;
        let rising = crossing.is_rising();
        let (x, y) = crossing.middle(self.origin);
        let excess = (self.slopes.0 * x + self.slopes.1 * y) >> 7;
        // The reciprocal of the light, by its series.
        let by_light = (ONE - excess + ((excess * excess) >> 14)).clamp(LIGHT.0, LIGHT.1);
        let lightness =
            |level: u8| ((((i32::from(level) * by_light) >> 8) - self.dark) * self.by_contrast) >> 12;
        let [_, a, b, c, d, _] = crossing.near;
        let [a, b, c, d] = if rising { [a, b, c, d] } else { [d, c, b, a] };
        let (b, c) = (lightness(b), lightness(c));
        let (from, low, high) = if b >= HALF {
            (-3 * PX / 2, lightness(a), b)
        } else if c < HALF {
            (PX / 2, c, lightness(d))
        } else {
            (-PX / 2, b, c)
        };
        if low >= HALF || high < HALF {
            return None;
        }
        let low = inverse_normal(low);
        let rise = inverse_normal(high) - low;
        if rise < LEAST_RISE {
            return None;
        }
        self.rises += ((rise >> 4) * (rise >> 4)) as u32 >> 8;
        self.points += 1;
        let at = from + (-low << 12) / rise;
        let at = if rising { at } else { -at };
        let (x, y) = ((PX / 2) * x, (PX / 2) * y);
        Some(if crossing.axis() == Axis::Row { (x + at, y) } else { (x, y + at) })
    }

    /// The blur that the rises tell, px: axes are up to 45 degrees off the normals of the edges.
    pub fn blur(&self) -> f32 {
        /// Root of the mean square of the cosine.
        const COSINE: f32 = 0.9046;
        let square = self.rises as f32 / (256.0 * self.points.max(1) as f32);
        COSINE / math::sqrt(square.max(1e-4))
    }
}
