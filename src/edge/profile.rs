//! The profile of a blurred edge: the normal distribution and its density.

/// Beyond this many standard deviations the edge is over: 2.3e-4 of the contrast is left.
const REACH: f32 = 3.5;

/// (share - 1/2) / z as a polynomial in z^2, lowest power first: least maximum error on 0..3.5.
const SHARE: [f32; 8] = [
    3.989198873e-01,
    -6.639556376e-02,
    9.855545969e-03,
    -1.120220118e-03,
    9.452947597e-05,
    -5.523200879e-06,
    1.958275636e-07,
    -3.123530649e-09,
];

/// The density as a polynomial in z^2, likewise.
const DENSITY: [f32; 8] = [
    3.989050775e-01,
    -1.990446054e-01,
    4.906119518e-02,
    -7.720292352e-03,
    8.189382862e-04,
    -5.651953392e-05,
    2.269036418e-06,
    -3.980953785e-08,
];

/// Share of the step that lies before `z` standard deviations, and its density there: within 5e-6 and 4e-5 up to 3.5
/// standard deviations, then constant. Polynomials, so that four samples are done at once where the processor can.
#[inline]
pub(crate) fn normal(z: f32) -> (f32, f32) {
    let z = z.clamp(-REACH, REACH);
    let square = z * z;
    (0.5 + z * polynomial(&SHARE, square), polynomial(&DENSITY, square))
}

/// Mean share of the step over `n` pixels, the first of which is at `z` standard deviations, below 0, and which lead away from
/// the edge by `k` each.
#[inline]
pub(crate) fn mean_tail(z: f32, k: f32, n: f32) -> f32 {
    // Of more than one pixel, the integral of the tail from the border of the first.
    let z = if n > 1.0 { z + 0.5 * k } else { z };
    let (share, density) = normal(z);
    if n > 1.0 { (density + z * share) / (k * n) } else { share }
}

/// A blurred edge along an axis that crosses it. Lengths in standard deviations of the blur, but on the axis in px.
///
/// The edge is taken as a parabola. Blur moves the level of one half towards its hollow side, by half the curvature times
/// the variance (the diffusion equation in polar coordinates).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blurred {
    /// Change along the normal and along the tangent, 1/px.
    pub k: f32,
    pub across: f32,
    /// Curvature, positive where the edge bends away from light.
    pub curvature: f32,
}

impl Blurred {
    /// Standard deviations `h` px beyond the edge on the axis.
    #[inline]
    pub fn deviation(&self, h: f32) -> f32 {
        let t = self.across * h;
        self.k * h + 0.5 * self.curvature * (1.0 + t * t)
    }

    /// Change of that with `h`, 1/px.
    #[inline]
    pub fn slope(&self, h: f32) -> f32 {
        self.k + self.curvature * self.across * self.across * h
    }
}

#[inline]
fn polynomial(coefficients: &[f32; 8], x: f32) -> f32 {
    let [a, b, c, d, e, f, g, h] = *coefficients;
    // In pairs, because a chain of eight steps would keep the processor waiting.
    let (x2, x4) = (x * x, (x * x) * (x * x));
    ((a + x * b) + x2 * (c + x * d)) + x4 * ((e + x * f) + x2 * (g + x * h))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_error_function() {
        for i in -4500..=4500 {
            let z = f64::from(i) / 1000.0;
            let (share, density) = normal(z as f32);
            let want = 0.5 * libm::erfc(-z / core::f64::consts::SQRT_2);
            let want_density = libm::exp(-0.5 * z * z) * 0.398_942_280_401_432_7;
            let (near, near_density) = if z.abs() <= 3.5 { (6e-6, 5e-5) } else { (2.5e-4, 9e-4) };
            assert!((f64::from(share) - want).abs() < near, "{z}: {share} for {want}");
            assert!(
                (f64::from(density) - want_density).abs() < near_density,
                "{z}: {density} for {want_density}"
            );
        }
    }
}
