//! Numbers of the passes over crossings and edge points: integers of 32 bits, for processors that have no others.
//!
//! | what | one is |
//! | --- | --- |
//! | shares, cosines, light, terms, places in units of the target | [`ONE`] |
//! | lengths, px, and standard deviations | [`PX`] |
//! | grey levels | [`GREY`] |
//! | changes for 1 px, curvatures | [`BEND`] |

use crate::math;

pub(crate) const ONE: i32 = 1 << 14;
pub(crate) const PX: i32 = 1 << 12;
pub(crate) const GREY: i32 = 1 << 6;
pub(crate) const BEND: i32 = 1 << 16;

/// Light that is calculated with, for the room of its products.
pub(crate) const LEAST_LIGHT: i32 = ONE / 4;
pub(crate) const MOST_LIGHT: i32 = ONE * 3 / 2;

/// `x` where one is `one`; saturates.
#[inline(never)]
pub(crate) fn fixed(x: f32, one: i32) -> i32 {
    math::round(x * one as f32)
}

/// The product with a share.
#[inline]
pub(crate) fn scale(x: i32, share: i32) -> i32 {
    (x * share + ONE / 2) >> 14
}

/// The product of numbers whose product has more than 32 bits, with `shift` bits less.
#[inline]
pub(crate) fn wide(a: i32, b: i32, shift: u32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> shift) as i32
}

/// The reciprocal of the length of a vector of length nearly one.
pub(crate) fn reciprocal((x, y): (i32, i32)) -> i32 {
    let square = (x * x + y * y) >> 14;
    let excess = square - ONE;
    // Its series, and a step of Newton.
    let near = ONE - scale(excess, ONE / 2 - scale(excess, ONE * 3 / 8));
    scale(near, 3 * ONE - scale(square, scale(near, near))) >> 1
}

/// The reciprocal of a square root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inverse {
    /// Of the root after so many doublings.
    inverse: i32,
    doublings: u32,
}

impl Inverse {
    /// The least square of which there is one.
    const LEAST: u32 = 1 << 20;

    /// Of a square of which one is 1 << 28. `None` below 1/256.
    #[inline]
    pub fn of_root(square: u32) -> Option<Self> {
        /// The parabola that differs least from 1 / root of 1 to 4.
        const PARABOLA: [u32; 3] = [87_493, 26_885, 3349];
        const MOST: u32 = (1 << 16) - 1;
        if square < Self::LEAST {
            return None;
        }
        let doublings = square.leading_zeros() / 2;
        let square = (square << (2 * doublings)) >> 15;
        let [a, b, c] = PARABOLA;
        let mut root = a - ((square * (b - ((c * square) >> 15))) >> 15);
        // Two steps of Newton.
        for _ in 0..2 {
            root = root.min(MOST);
            let excess = (1u32 << 31).wrapping_sub(square * ((root * root) >> 16)) as i32;
            root = root.wrapping_add_signed((root as i32 * (excess >> 16)) >> 16);
        }
        Some(Self { inverse: ((root + 1) >> 1) as i32, doublings })
    }

    /// `x` times it.
    #[inline]
    pub fn of(&self, x: i32) -> i32 {
        (x * self.inverse) >> (16 - self.doublings)
    }

    /// A component of the vector whose length it is the reciprocal of, times it.
    #[inline]
    pub fn cosine(&self, component: i32) -> i32 {
        ((component << self.doublings) * self.inverse) >> 16
    }
}

/// A vector of length nearly one with that length.
pub(crate) fn unit(vector: (i32, i32)) -> (i32, i32) {
    let reciprocal = reciprocal(vector);
    (scale(vector.0, reciprocal), scale(vector.1, reciprocal))
}

/// Which of 128 sectors of a turn, from +x towards +y, holds a direction of length one.
pub(crate) fn sector((u, v): (i32, i32)) -> u32 {
    /// The series of the arc sine, and sectors of a radian.
    const SERIES: (i32, i32) = (2731, 1794);
    const SECTORS: i32 = 5215;
    let sine = u.abs().min(v.abs());
    let square = scale(sine, sine);
    let angle = sine + scale(sine, scale(square, SERIES.0 + scale(square, SERIES.1)));
    let octant = ((angle * SECTORS) >> 22).clamp(0, 15);
    let quadrant = if v.abs() <= u.abs() { octant } else { 31 - octant };
    let half = if u < 0 { 63 - quadrant } else { quadrant };
    (if v < 0 { 127 - half } else { half }) as u32
}
