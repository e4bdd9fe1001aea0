//! Numbers of the passes over the crossings: integers of 32 bits, for processors that have no others.
//!
//! | what | one is |
//! | --- | --- |
//! | shares, cosines, light, terms, places in units of the target | [`ONE`] |
//! | lengths, px, and standard deviations | [`PX`] |
//! | grey levels | [`GREY`] |
//! | changes for 1 px, curvatures | [`BEND`] |

use crate::math;

pub(super) const ONE: i32 = 1 << 14;
pub(super) const PX: i32 = 1 << 12;
pub(super) const GREY: i32 = 1 << 6;
pub(super) const BEND: i32 = 1 << 16;

/// `x` where one is `one`; saturates.
pub(super) fn fixed(x: f32, one: i32) -> i32 {
    math::round(x * one as f32)
}

/// The product with a share.
#[inline]
pub(super) fn scale(x: i32, share: i32) -> i32 {
    (x * share + ONE / 2) >> 14
}

/// The product of numbers whose product has more than 32 bits, with `shift` bits less.
#[inline]
pub(super) fn wide(a: i32, b: i32, shift: u32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> shift) as i32
}
