//! Measured values as fixed-point numbers. Everything saturates; what is not a number counts as too large, so
//! that no spread is ever understated.

use crate::Covariance;
use crate::math::{round, sqrt};

/// `value` in units of `1 / scale`, rounded.
#[inline(never)]
pub(super) fn unsigned16(value: f32, scale: f32) -> u16 {
    let scaled = value * scale;
    if scaled < f32::from(u16::MAX) { round(scaled).max(0) as u16 } else { u16::MAX }
}

/// `value` in units of `1 / scale`, rounded; at most `i32::MAX` units.
#[inline(never)]
pub(super) fn unsigned32(value: f32, scale: f32) -> u32 {
    round(value * scale).max(0) as u32
}

/// Angle in units of pi / 32768.
pub(super) fn angle(radians: f32) -> i16 {
    const UNITS: f32 = 32768.0 / core::f32::consts::PI;
    round(radians * UNITS).clamp(i16::MIN.into(), i16::MAX.into()) as i16
}

/// Standard deviation in 1/65536 px; the largest value when `variance` is negative.
pub(super) fn sigma(variance: f32) -> u16 {
    if variance >= 0.0 { unsigned16(sqrt(variance), 65536.0) } else { u16::MAX }
}

/// Correlation of x and y in 1/127; 0 when one of them has no variance.
pub(super) fn correlation(covariance: &Covariance) -> i8 {
    let scale = sqrt(covariance.xx) * sqrt(covariance.yy);
    if scale > 0.0 { round(127.0 * covariance.xy / scale).clamp(-127, 127) as i8 } else { 0 }
}
