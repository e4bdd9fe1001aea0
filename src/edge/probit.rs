//! Edge points from two samples each: quick, and with more error than [`place`](super::place()) has.

use super::place::inverse_normal;
use super::trace::Trace;
use super::{Edge, Levels};
use crate::fit::View;
use crate::fixed::{GREY, ONE, PX, fixed};
use crate::math;
use crate::scan::{Crossing, Pool};

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

    /// Passes over the crossings of `edge`, the edge points of which go to `take`, as its ellipse has them.
    #[inline]
    pub fn pass(&mut self, edge: &Edge, pool: &Pool<'_>, mut take: impl FnMut(&View)) -> Option<()> {
        let trace = Trace::new(&edge.shape, edge.axes.1)?;
        for crossing in pool.iter(edge.crossings) {
            let (axis, middle) = (crossing.axis(), crossing.middle(self.origin));
            // Where the other axis is steeper there is a crossing on that.
            if let Some(conic) = trace.steep_conic(axis, middle)
                && let Some(at) = self.place(crossing, middle)
            {
                take(&trace.view(axis, &conic, at));
            }
        }
        Some(())
    }

    /// Where the edge passes the axis of a crossing, px from its middle, which is `(x, y)`. `None` where there is no edge between its
    /// samples.
    #[inline(always)]
    fn place(&mut self, crossing: &Crossing, (x, y): (i32, i32)) -> Option<i32> {
        const HALF: i32 = ONE / 2;
        let rising = crossing.is_rising();
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
        Some(if rising { at } else { -at })
    }

    /// The blur that the rises tell, px: axes are up to 45 degrees off the normals of the edges.
    pub fn blur(&self) -> f32 {
        /// Root of the mean square of the cosine.
        const COSINE: f32 = 0.9046;
        let square = self.rises as f32 / (256.0 * self.points.max(1) as f32);
        COSINE / math::sqrt(square.max(1e-4))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::{Axis, Stretch};

    const ORIGIN: (u16, u16) = (100, 100);

    /// A crossing in column 120 and row 100, where an edge with this blur passes `at` px from its middle, towards growing levels where
    /// it is `rising`, in light that changes by `slope` for each px along the row.
    fn crossing(at: f32, blur: f32, rising: bool, slope: f32) -> Crossing {
        let level = |i: usize| {
            let along = i as f32 - 2.5;
            let z = (along - at) / blur;
            let share = 0.5 * libm::erfcf(if rising { -z } else { z } * core::f32::consts::FRAC_1_SQRT_2);
            let light = 1.0 + slope * (19.5 + along);
            libm::roundf(light * (40.0 + 160.0 * share)) as u8
        };
        Crossing::new(Axis::Row, (120, 100), core::array::from_fn(level), [Stretch::of_one(0); 2])
    }

    fn probit(slope: f32) -> Probit {
        let slopes = (0.0, 0.0, 0.0);
        let levels = Levels {
            dark: 40.0,
            bright: 200.0,
            gx: slope,
            gy: 0.0,
            slopes,
            noise: 1.0,
            spread: 1.0,
            pixels: 1.0,
            clipped: false,
        };
        Probit::new(&levels, ORIGIN)
    }

    /// Largest and RMS error over places, px, and the blur that is told.
    fn errors(blur: f32, rising: bool, slope: f32, told: f32) -> (f32, f32, f32) {
        let mut probit = probit(told);
        let (mut worst, mut square, mut count) = (0.0f32, 0.0, 0.0);
        for i in -24..=24 {
            let at = i as f32 / 24.0;
            let crossing = crossing(at, blur, rising, slope);
            let place = probit.place(&crossing, crossing.middle(ORIGIN)).unwrap() as f32 / PX as f32;
            worst = worst.max((place - at).abs());
            square += (place - at) * (place - at);
            count += 1.0;
        }
        (worst, libm::sqrtf(square / count), probit.blur() / 0.9046)
    }

    #[test]
    fn edges_are_where_they_pass() {
        for blur in [0.5, 0.7, 1.0, 1.3] {
            for rising in [false, true] {
                let (worst, rms, told) = errors(blur, rising, 0.0, 0.0);
                assert!(worst < 0.03 && rms < 0.012, "{blur}: {worst} {rms}");
                assert!((told / blur - 1.0).abs() < 0.1, "{told} for {blur}");
            }
        }
    }

    #[test]
    fn the_slope_of_the_light_moves_no_edge_only_if_it_is_known() {
        let (_, known, _) = errors(0.8, true, 0.004, 0.004);
        let (_, unknown, _) = errors(0.8, true, 0.004, 0.0);
        assert!(known < 0.015 && unknown > 4.0 * known, "{known} {unknown}");
    }

    #[test]
    fn samples_without_an_edge_have_no_place() {
        let (dark, light) = ([40; 6], [200; 6]);
        for near in [dark, light, [40, 40, 40, 41, 41, 41]] {
            let crossing = Crossing::new(Axis::Column, (100, 120), near, [Stretch::of_one(0); 2]);
            assert_eq!(probit(0.0).place(&crossing, crossing.middle(ORIGIN)), None);
        }
    }
}
