use super::Real;
use crate::list::rolled;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Weights of the ellipse centres in the true centre, outermost first; their sum is 1.
pub type Weights<T> = Vec<T, MAX_CIRCLES>;

/// t = (radius x sin(tilt) / distance)^2 of the outer circle, from its ellipse (x - B1)' A (x - B1) = 1, the vector
/// D = B2 - B1 between the ellipse centres and the `ratio` of the radii.
///
/// `square` is D' A D. With u = 1 - ratio^2, D' A D = u^2 t / (1 - ratio^2 t)^2 for any perspective; this is the root
/// below 1.
pub fn perspective<T: Real>(square: T, ratio: T) -> T {
    let one = T::from(1.0);
    let four = T::from(4.0);
    let u = one - ratio * ratio;
    let root = u + (u * u + four * square * ratio * ratio).sqrt();
    four * square / (root * root)
}

/// Weights of the mean with the least noise: by the inverse of these variances of the ellipse centres.
///
/// `None` if there are none, or too many.
pub fn mean<T: Real>(variances: impl Iterator<Item = T> + Clone) -> Option<Weights<T>> {
    let one = T::from(1.0);
    let mut sum = T::from(0.0);
    for variance in rolled(variances.clone()) {
        sum = sum + one / variance;
    }
    let mut weights = Weights::new();
    for variance in rolled(variances) {
        weights.push(one / (variance * sum)).ok()?;
    }
    Some(weights)
}

/// Weights with which the ellipse centres give the true centre.
///
/// `circles` holds for each circle, outermost first, its radius in units of the outer one and the variance of its
/// ellipse centre (in any unit; only their proportion counts, and with two circles not even that). `t` is
/// [`perspective`], or 0 for eq. (7) of Huo et al. 2013:
/// with two circles and t = 0 the weights are r2^2 / (r2^2 - r1^2) and r1^2 / (r1^2 - r2^2).
///
/// `None` if all radii are the same or there are less than two.
#[inline(never)]
pub fn weights<T: Real>(circles: &[(T, T)], t: T) -> Option<Weights<T>> {
    let one = T::from(1.0);
    let zero = T::from(0.0);
    let g = |ratio: T| ratio * ratio / (one - t * ratio * ratio);
    // Weighted line through (g, B), read at g = 0.
    let (mut s0, mut s1) = (zero, zero);
    for &(ratio, variance) in rolled(circles) {
        s0 = s0 + one / variance;
        s1 = s1 + g(ratio) / variance;
    }
    let mean = s1 / s0;
    let mut spread = zero;
    for &(ratio, variance) in rolled(circles) {
        let d = g(ratio) - mean;
        spread = spread + d * d / variance;
    }
    // Also refuses NaN.
    if !(spread > zero) {
        return None;
    }
    let mut weights = Weights::new();
    for &(ratio, variance) in rolled(circles) {
        let weight = (one / s0 - mean * (g(ratio) - mean) / spread) / variance;
        weights.push(weight).ok()?;
    }
    Some(weights)
}
