//! The only door to `libm`, `micromath` and the square root of the processor.
//!
//! Functions are called by their `libm` names, never as `f32` methods, because those pick another
//! implementation when `std` is linked, and reports must be bit-identical on every processor.

// Both round correctly, so that the bits are the same.
#[cfg(all(target_arch = "arm", target_abi = "eabihf", target_os = "none"))]
use crate::arm::sqrt as root;
#[cfg(not(all(target_arch = "arm", target_abi = "eabihf", target_os = "none")))]
use libm::sqrtf as root;

/// Square root, correctly rounded. Negative arguments (rounding noise) give 0.
// Where it is no instruction, the comparison need not be at every call.
#[cfg_attr(not(all(target_arch = "arm", target_abi = "eabihf", target_os = "none")), inline(never))]
pub(crate) fn sqrt(x: f32) -> f32 {
    if x > 0.0 { root(x) } else { 0.0 }
}

/// Angle of `(x, y)` from +x towards +y, radians.
pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// e^x.
pub(crate) fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// ln(1 + x).
pub(crate) fn ln_1p(x: f32) -> f32 {
    libm::log1pf(x)
}

/// (sin, cos) of radians.
pub(crate) fn sincos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// Nearest integer, halves away from zero; saturates.
pub(crate) fn round(x: f32) -> i32 {
    // The largest value below one half: with it, and not with one half, what is just below a half stays below the next integer.
    const HALF: f32 = 0.5 - 0.25 * f32::EPSILON;
    (x + HALF.copysign(x)) as i32
}

/// Functions good to about 1 %: for where to look, never for a measured value.
pub(crate) mod approx {
    /// (sin, cos) of radians, wrong by at most 0.002.
    pub(crate) fn sincos(x: f32) -> (f32, f32) {
        (micromath::F32(x).sin().0, micromath::F32(x).cos().0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn approximations_are_as_good_as_told() {
        let worst = (0..10_000).fold(0.0f32, |worst, i| {
            let x = i as f32 * 1e-3;
            let ((s, c), (sin, cos)) = (approx::sincos(x), sincos(x));
            worst.max((s - sin).abs()).max((c - cos).abs())
        });
        assert!(worst < 0.002, "{worst}");
    }

    #[test]
    fn rounds_as_libm() {
        let same = |x: f32| assert_eq!(round(x), libm::roundf(x) as i32, "{x:e}");
        // Every exponent and sign with many mantissas, NaN and the infinities among them.
        (0..=u32::MAX).step_by(4093).for_each(|bits| same(f32::from_bits(bits)));
        for k in 0..100_000i32 {
            let half = k as f32 + 0.5;
            for x in [half, half.next_up(), half.next_down()] {
                same(x);
                same(-x);
            }
        }
    }
}
