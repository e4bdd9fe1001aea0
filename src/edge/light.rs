//! The levels of a target in integers.

use super::Levels;
use super::local::Local;
use crate::fixed::{GREY, LEAST_LIGHT, MOST_LIGHT, ONE, fixed, scale};
use crate::scan::Axis;

/// [`Levels`] in integers.
pub(super) struct Light {
    pub dark: i32,
    pub contrast: i32,
    /// Slopes along x and y, 1/px, with 64 times the unit of light.
    slopes: (i32, i32),
}

impl Light {
    #[inline(never)]
    pub fn new(levels: &Levels) -> Self {
        let grey = |level: f32| fixed(level.clamp(0.0, 500.0), GREY);
        let slope = |slope: f32| fixed(slope.clamp(-0.06, 0.06), ONE << 6);
        let (dark, bright) = (grey(levels.dark), grey(levels.bright));
        Self { dark, contrast: bright - dark, slopes: (slope(levels.gx), slope(levels.gy)) }
    }

    /// Level without the plane of light at this lightness.
    #[inline]
    pub fn mixed(&self, lightness: i32) -> i32 {
        self.dark + scale(self.contrast, lightness)
    }

    /// Along the axis of a crossing.
    #[inline]
    pub fn at(&self, local: &Local) -> LightThere {
        let (x, y) = self.slopes;
        let (along, across) = if local.axis == Axis::Row { (x, y) } else { (y, x) };
        let (m, n) = local.middle;
        let middle = ONE + ((along * m + across * n + (1 << 6)) >> 7);
        LightThere { middle: middle.clamp(LEAST_LIGHT, MOST_LIGHT), slope: local.sign * along }
    }
}

/// The light at the middle of a crossing, and its change towards light, 1/px, with 64 times its unit.
pub(super) struct LightThere {
    pub middle: i32,
    pub slope: i32,
}

impl LightThere {
    /// Light at a place on the axis, px / 2.
    #[inline]
    pub fn beside(&self, place: i32) -> i32 {
        (self.middle + ((self.slope * place + (1 << 6)) >> 7)).clamp(LEAST_LIGHT, MOST_LIGHT)
    }
}
