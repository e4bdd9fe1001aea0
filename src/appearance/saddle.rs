//! An ellipse that bends about as tightly as the blur is wide.
//!
//! What a place has of the inside of a blurred ellipse is the probability that a normal vector about it lies inside: that a
//! quadratic form of normal variables is below one. Near a straight edge that is known from the distance, for a bent one with a
//! term of its curvature. Where the sides of a tip blur into each other, the saddlepoint approximation still holds (Lugannani and
//! Rice 1980, "Saddle point approximation for the distribution of the sum of independent random variables", Adv. Appl. Prob. 12;
//! for quadratic forms Kuonen 1999, "Saddlepoint approximations for distributions of quadratic forms in normal variables",
//! Biometrika 86), in the form of Barndorff-Nielsen 1986, "Inference on full or partial parameters based on the standardized
//! signed log likelihood ratio", Biometrika 73.

use super::Outline;
use crate::math;

/// Radius of curvature at the ends of the major axis, px, and standard deviations of the blur, from which on distance and curvature
/// tell all, ...
const TIGHT: (f32, f32) = (3.0, 4.0);
/// ... and standard deviations from which on what they leave is less than the noise of most pictures.
const TIGHTEST: f32 = 2.5;
/// Steps to the saddlepoint.
const STEPS: usize = 3;
/// Share of the way to the pole that a step leaves at least.
const LEFT: f32 = 0.25;
/// Saddlepoint, in units of the squared semi-minor axis, nearer to the edge than which the digits end.
const LEAST: f32 = 2e-3;

/// A blurred ellipse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Saddle {
    /// Unit vector along the minor axis.
    minor: (f32, f32),
    /// Inverse squares of the semi-axes, minor first, 1/px^2, and the ratio of these.
    squares: [f32; 2],
    ratio: f32,
}

impl Saddle {
    /// Whether distance and curvature do not tell enough.
    pub fn is_tight(&Outline { major, minor, .. }: &Outline, blur: f32) -> bool {
        minor * minor < major * TIGHT.0.max(TIGHT.1 * blur)
    }

    /// The same for those that cannot afford it where little is gained.
    pub fn is_tightest(&Outline { major, minor, .. }: &Outline, blur: f32) -> bool {
        minor * minor < major * TIGHTEST * blur
    }

    /// `None` where distance and curvature tell enough.
    pub fn new(outline: &Outline, blur: f32) -> Option<Self> {
        if !Self::is_tight(outline, blur) {
            return None;
        }
        let &Outline { shape, major: a, minor: b, .. } = outline;
        let (major, minor) = (1.0 / (a * a), 1.0 / (b * b));
        // Of the two forms of the eigenvector the one that keeps its digits.
        let (x, y) = if shape.axx >= shape.ayy {
            (shape.axx - major, shape.axy)
        } else {
            (shape.axy, shape.ayy - major)
        };
        let norm = math::sqrt(x * x + y * y);
        // A circle has no direction.
        let minor_axis = if norm > 0.0 { (x / norm, y / norm) } else { (1.0, 0.0) };
        Some(Self { minor: minor_axis, squares: [minor, major], ratio: major / minor })
    }

    /// How far the place `(x, y)` px from the centre is beyond the edge outwards where the blur has the variance `square` px^2, and
    /// what is to be added to tell its share of the outside by the normal distribution, standard deviations: the one goes with the
    /// inverse of the blur, the other with the blur.
    pub fn beyond(&self, (x, y): (f32, f32), square: f32) -> (f32, f32) {
        let Self { minor: (mx, my), squares, ratio } = *self;
        let (v, u) = (mx * x + my * y, mx * y - my * x);
        let places = [squares[0] * v * v, squares[1] * u * u];
        let noise = squares.map(|inverse| inverse * square);
        let found = saddlepoint(places, noise, ratio);
        let at = if found.abs() < LEAST { LEAST.copysign(found) } else { found };
        let [(e, place), (f, other)] = [0, 1].map(|i| {
            let scaled = at * if i == 0 { 1.0 } else { ratio };
            (-scaled / (1.0 + scaled), places[i] / noise[i])
        });
        let moved = (e * e * place, f * f * other);
        // What is left of both logarithms beyond the first order.
        let left = e + f - math::ln_1p(e + f + e * f);
        let deviance = left + moved.0 + moved.1;
        let cubes = 0.5 * (e * e + f * f) - left + e * moved.0 + f * moved.1;
        let w = math::sqrt(deviance).copysign(at);
        let lead = -0.5 * math::ln_1p(cubes / deviance) / w;
        (w * (found / at) - 2.0 * lead, lead)
    }
}

/// Where the cumulant generating function has the slope one, as the way to the ellipse: 0 on it, positive outside, in units of the
/// squared semi-minor axis. By Newton's method for the inverse root of the slope, which is nearly a straight line.
fn saddlepoint(places: [f32; 2], noise: [f32; 2], ratio: f32) -> f32 {
    let mut at = 0.0;
    for _ in 0..STEPS {
        let (mut slope, mut change) = (0.0, 0.0);
        for ((place, noise), scale) in places.into_iter().zip(noise).zip([1.0, ratio]) {
            let inverse = 1.0 / (1.0 + at * scale);
            let square = place * inverse;
            slope += (noise + square) * inverse;
            change += scale * (noise + 2.0 * square) * inverse * inverse;
        }
        let step = 2.0 * slope * (math::sqrt(slope) - 1.0) / change;
        let (next, least) = (at + step, LEFT * (1.0 + at) - 1.0);
        at = if next > least { next } else { least };
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge::normal;
    use crate::fit::Shape;

    /// What a place along and across the major axis has of the inside of a blurred ellipse: chords, summed up.
    fn share(a: f64, b: f64, blur: f64, (x, y): (f64, f64)) -> f64 {
        let below = |z: f64| 0.5 * libm::erfc(-z / (core::f64::consts::SQRT_2 * blur));
        let steps = 2000;
        let step = core::f64::consts::PI / f64::from(steps);
        (0..steps).fold(0.0, |sum, i| {
            let (s, c) = libm::sincos((f64::from(i) + 0.5) * step);
            let z = (y + b * c) / blur;
            let density = libm::exp(-0.5 * z * z) / (2.5066 * blur);
            sum + density * b * s * step * (below(a * s - x) - below(-a * s - x))
        })
    }

    #[test]
    fn tips_are_blurred_as_they_are() {
        let (mut worst, mut plain) = (0.0f64, 0.0f64);
        for (a, b) in [(8.0f32, 4.0f32), (10.0, 5.0), (5.0, 5.0), (7.0, 3.5), (6.0, 3.0)] {
            for (theta, blur) in [(0.0f32, 1.5f32), (0.7, 1.53), (1.5, 1.4), (2.5, 1.3), (-0.9, 1.0)] {
                let (s, c) = libm::sincosf(theta);
                let (p, q) = (0.25 * a * a, 0.25 * b * b);
                let shape = Shape::from_moments(
                    0.0,
                    0.0,
                    p * c * c + q * s * s,
                    (p - q) * s * c,
                    p * s * s + q * c * c,
                )
                .unwrap();
                let Some(saddle) = Saddle::new(&Outline::new(shape, 1.0).unwrap(), blur) else { continue };
                for i in 0..400 {
                    let (x, y) = ((i % 20) as f32 * 0.05 * (a + 4.0), (i / 20) as f32 * 0.05 * (b + 4.0));
                    let want = share(f64::from(a), f64::from(b), f64::from(blur), (x.into(), y.into()));
                    let (z, more) = saddle.beyond((c * x - s * y, s * x + c * y), blur * blur);
                    let off = (f64::from(1.0 - normal(z + more).0) - want).abs();
                    assert!(off.is_finite(), "{a} {b} {blur}: {x} {y}");
                    worst = worst.max(off);
                    plain = plain.max((f64::from(1.0 - normal(z).0) - want).abs());
                }
            }
        }
        assert!(worst < 0.012 && plain > 0.1, "{worst} {plain}");
    }
}
