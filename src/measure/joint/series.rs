//! How far places on an axis are beyond an edge that bends.

use crate::fixed::{BEND, ONE, scale};
use crate::scan::NEAR;

/// Standard deviations of the blur beyond an edge, as a power series of the distance on an axis, px.
pub(super) struct Series {
    pub first: i32,
    second: i32,
    third: i32,
    /// In 1/16 of the unit of the others, because it is small.
    fourth: i32,
}

impl Series {
    /// For an axis with this cosine and an edge that bends by so much; one that is `tight` bends too much for the last term.
    #[inline]
    pub fn new(sharpness: i32, (cosine, bend): (i32, i32), tight: bool) -> Self {
        let square = scale(cosine, cosine);
        let second = (scale(bend, ONE - square) * sharpness) >> 13;
        let third = -((scale(bend, cosine) * second) >> 15);
        let cube = || (((second * bend) >> 12) * bend + BEND / 2) >> 16;
        let fourth = if tight { 0 } else { scale(cube(), 5 * square - ONE) };
        Self { first: scale(cosine, sharpness), second, third, fourth }
    }

    /// For the places 1 px apart about the middle, which is `h` from the edge towards light, along the axis if `sign` is 1: their
    /// distances and `more`.
    #[inline]
    pub fn beyond(&self, h: i32, sign: i32, more: i32) -> [i32; NEAR + 2] {
        let Self { first, second, third, fourth } = *self;
        let bends = second + ((h * (third + ((h * fourth) >> 16))) >> 12);
        let here = first + ((h * bends) >> 15);
        let here = ((h * here) >> 6) + (more << 7) + (1 << 6);
        // The series about the middle.
        let bent = 3 * ((third * h) >> 12);
        let odd = sign * (first + ((h * (2 * second + bent)) >> 15));
        let (even, cubic) = (second + bent, sign * (third + ((fourth * h) >> 14)));
        let pair = |m: i32, quartic: i32| {
            let (even, odd) = (here + 2 * m * m * even + quartic, 32 * m * odd + m * m * m * cubic);
            [(even - odd) >> 7, (even + odd) >> 7]
        };
        let [d, e] = pair(1, 0);
        let [c, f] = pair(3, (5 * fourth) >> 1);
        let [b, g] = pair(5, (39 * fourth) >> 1);
        let [a, h] = pair(7, 75 * fourth);
        [a, b, c, d, e, f, g, h]
    }
}
