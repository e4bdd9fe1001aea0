//! One reweighted Gauss-Newton step on a fitted ellipse.
//!
//! In the frame where the ellipse is the unit circle, q = L (p - c) with A = L' L, the conic is |q|^2 - 1 plus five
//! small terms. Each point counts with the inverse square of the conic's gradient *in the image*, so that the sum is
//! that of squared distances in px (Sampson 1982, "Fitting conic sections to 'very scattered' data", Comput. Graph.
//! Image Process. 18); the normal matrix is then the inverse covariance of the five terms for a unit variance of the
//! edge.

use super::line::{Line, PLACE};
use super::shape::{Frame, Shape};
use super::solve::{Factor, Matrix, dot};
use crate::fixed::{Inverse, PX, wide};
use crate::math;
use crate::target::Covariance;

/// Terms of the conic: (u^2 - v^2, 2 u v, u^2 + v^2, u, v).
pub(crate) const TERMS: usize = 5;
/// Largest square of a point's distance from the centre, in the frame, less 1.
const MOST: i32 = 3 << PLACE;
/// Farthest from the ellipse, 1/16384 px, before the gradient's length is known.
const DEEPEST: i32 = 60_000;
/// Bits of the products of places in the frame.
const PRODUCT: u32 = 13;
/// Bits of terms over the length of the gradient for the longest, and room of these: sums of the products of as many points have 32
/// bits.
const TERM: u32 = 8;
const ROOM: i32 = 362;
const MOST_POINTS: u16 = 1 << 14;
/// Largest distance of a point, px / 4096.
const FARTHEST: i32 = (1 << 15) - 1;

/// One in a field over the points.
pub(crate) const FIELD: i32 = 1 << 7;

/// Least variance of a point, px^2: that of rounding to 1/256 px.
const ROUNDING: f32 = 1.0 / (12.0 * 256.0 * 256.0);

/// Normal equations of the step, point by point: integers, so that the order of the points is of no matter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Adjustment {
    shape: Shape,
    frame: Frame,
    line: Line,
    /// Lower triangle.
    m: Matrix<TERMS, i32>,
    right: [i64; TERMS],
    /// Bits that the terms have less than the products of places.
    less: u32,
    /// Sum of squared distances.
    squares: u64,
    points: u16,
}

/// What an [`Adjustment`] gives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Adjusted {
    pub shape: Shape,
    /// Covariance of its centre, px^2.
    pub covariance: Covariance,
    /// Covariance of stretch and centre in the frame where it is the unit circle: of the terms (u^2 - v^2, 2 u v) of its
    /// conic and of (u, v) of its centre.
    pub frame_covariance: Matrix<4>,
    /// RMS distance of the points, px.
    pub rms: f32,
    pub points: u16,
}

impl Adjusted {
    /// The same with `factor` times the variance.
    #[inline(never)]
    pub fn with_variance(&self, factor: f32) -> Self {
        let frame_covariance = self.frame_covariance.map(|row| row.map(|entry| factor * entry));
        Self { covariance: self.covariance.scaled(factor), frame_covariance, ..*self }
    }
}

/// A point near an ellipse.
pub(crate) struct View {
    /// In the frame where the ellipse is the unit circle.
    pub place: (i32, i32),
    /// Distance from the ellipse, px, to first order: positive outside, and bounded.
    pub distance: i32,
    /// 1 / length of half the conic's gradient in units of the semi-minor axis.
    pub by_gradient: Inverse,
}

impl Adjustment {
    /// `None` if `shape` is no ellipse.
    pub fn new(shape: Shape) -> Option<Self> {
        let (major, minor) = shape.semi_axes();
        let (frame, line) = (Frame::new(&shape)?, Line::of_rows(&shape, minor)?);
        // On the major axis they are longer by the ratio of the axes.
        let less = PRODUCT - TERM + u32::BITS - ((0.75 * major / minor) as u32).leading_zeros();
        Some(Self {
            shape,
            frame,
            line,
            m: [[0; TERMS]; TERMS],
            right: [0; TERMS],
            less: less.min(PRODUCT),
            squares: 0,
            points: 0,
        })
    }

    /// The point `(x, y)`, [`PX`], as this ellipse sees it. `None` far from it.
    #[inline]
    pub fn view(&self, (x, y): (i32, i32)) -> Option<View> {
        let (cx, cy) = self.line.centre();
        let look = self.line.look((x - cx, y - cy)).filter(|look| look.excess < MOST)?;
        let (gx, gy) = look.gradient;
        let by_gradient = Inverse::of_root(gx.unsigned_abs().pow(2) + gy.unsigned_abs().pow(2))?;
        let depth = wide(look.excess, self.line.minor(), PLACE - 1).clamp(-DEEPEST, DEEPEST);
        let distance = ((by_gradient.of(depth) + 2) >> 2).clamp(-FARTHEST, FARTHEST);
        Some(View { place: look.place, distance, by_gradient })
    }

    /// Adds a point. Gives its terms over the length of the gradient.
    #[inline]
    pub fn add(&mut self, point: &View) -> [i32; TERMS] {
        let (u, v) = point.place;
        let (uu, vv) = (u * u, v * v);
        let terms = [(uu - vv) >> 15, (u * v) >> 14, (uu + vv) >> 15, u >> 1, v >> 1];
        let (less, half) = (self.less, (1 << self.less) >> 1);
        let terms = terms.map(|term| ((point.by_gradient.of(term) + half) >> less).clamp(-ROOM, ROOM));
        if self.points >= MOST_POINTS {
            return terms;
        }
        for i in 0..TERMS {
            for j in 0..=i {
                self.m[i][j] += terms[i] * terms[j];
            }
            self.right[i] -= i64::from(terms[i] * point.distance);
        }
        self.squares += u64::from(point.distance.unsigned_abs().pow(2));
        self.points += 1;
        terms
    }

    /// Takes the step. `None` if the points do not determine it.
    pub fn finish(&self) -> Option<Adjusted> {
        Some(self.finish_with(&[])?.0)
    }

    /// The same with the step, and how much further that goes where the points lie 1 px times a field farther out; each of `fields` has
    /// the sums of the points' terms times that field, [`FIELD`].
    #[inline(never)]
    pub fn finish_with<const N: usize>(
        &self,
        fields: &[[i32; TERMS]; N],
    ) -> Option<(Adjusted, [f32; TERMS], [[f32; TERMS]; N])> {
        const SQUARE: f32 = 1.0 / (PX as f32 * PX as f32);
        // A term counts half the semi-minor axis over the length of the gradient, px.
        let term = 0.5 * self.line.minor() as f32 / (PX as f32 * (1u32 << (PRODUCT - self.less)) as f32);
        let m = self.m.map(|row| row.map(|sum| term * term * sum as f32));
        let right = self.right.map(|sum| term / PX as f32 * sum as f32);
        let factor = Factor::new(&m)?;
        let step = factor.solve(right);
        let gain = dot(&step, &right);
        let squares = (SQUARE * self.squares as f32 - gain).max(ROUNDING * f32::from(self.points));
        let free = self.points.checked_sub(5).filter(|&free| free > 0)?;
        let variance = squares / f32::from(free);
        let frame_covariance = frame_covariance(&factor, variance);
        let further = fields.map(|field| factor.solve(field.map(|sum| -term / FIELD as f32 * sum as f32)));
        let adjusted = Adjusted {
            shape: self.frame.moved(&self.shape, &step)?,
            covariance: self.frame.covariance(&frame_covariance),
            frame_covariance,
            rms: math::sqrt(squares / f32::from(self.points)),
            points: self.points,
        };
        Some((adjusted, step, further))
    }
}

/// Stretch and centre from the terms of the conic, as (index, factor): the centre moves by minus half the last two.
pub(crate) const CENTRE_TERMS: [(usize, f32); 4] = [(0, 1.0), (1, 1.0), (3, -0.5), (4, -0.5)];

/// [`Adjusted::frame_covariance`].
fn frame_covariance(factor: &Factor<5>, variance: f32) -> Matrix<4> {
    CENTRE_TERMS.map(|(term, scale)| {
        let mut unit = [0.0; 5];
        unit[term] = scale * variance;
        let solved = factor.solve(unit);
        CENTRE_TERMS.map(|(term, scale)| scale * solved[term])
    })
}

#[cfg(test)]
impl Adjustment {
    /// Adds the point `(x, y)` px.
    pub fn add_point(&mut self, (x, y): (f32, f32)) {
        let fixed = |x: f32| libm::roundf(x * PX as f32) as i32;
        let view = self.view((fixed(x), fixed(y))).unwrap();
        self.add(&view);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn shape(a: f32, b: f32, theta: f32) -> Shape {
        let (s, c) = (libm::sinf(theta), libm::cosf(theta));
        let (p, q) = (0.25 * a * a, 0.25 * b * b);
        Shape::from_moments(0.3, -0.4, p * c * c + q * s * s, (p - q) * s * c, p * s * s + q * c * c).unwrap()
    }

    /// Points of the ellipse of `shape(a, b, theta)`, displaced along the normal by `noise(i)` px.
    fn points(a: f32, b: f32, theta: f32, n: usize, noise: impl Fn(usize) -> f32) -> Vec<(f32, f32)> {
        let (s, c) = (libm::sinf(theta), libm::cosf(theta));
        (0..n)
            .map(|i| {
                let (sin, cos) = libm::sincosf(i as f32 / n as f32 * core::f32::consts::TAU);
                let (nx, ny) = (cos / a, sin / b);
                let k = noise(i) / libm::sqrtf(nx * nx + ny * ny);
                let (u, v) = (a * cos + k * nx, b * sin + k * ny);
                (0.3 + u * c - v * s, -0.4 + u * s + v * c)
            })
            .collect()
    }

    fn adjust(start: Shape, points: &[(f32, f32)]) -> Adjusted {
        let mut adjustment = Adjustment::new(start).unwrap();
        for &point in points {
            adjustment.add_point(point);
        }
        adjustment.finish().unwrap()
    }

    #[test]
    fn corrects_a_displaced_start() {
        let start = Shape { cx: 0.35, cy: -0.43, ..shape(30.05, 17.95, 0.701) };
        let adjusted = adjust(start, &points(30.0, 18.0, 0.7, 250, |_| 0.0));
        let (a, b) = adjusted.shape.semi_axes();
        for (got, want) in [(adjusted.shape.cx, 0.3), (adjusted.shape.cy, -0.4), (a, 30.0), (b, 18.0)] {
            assert!((got - want).abs() < 4e-4, "{got} for {want}");
        }
        assert!(adjusted.rms < 2e-3, "{}", adjusted.rms);
    }

    /// Many noisy trials: the reported covariance is that of the centres.
    #[test]
    fn covariance_is_that_of_the_centres() {
        let mut state = 1u32;
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1u32 << 24) as f32 - 0.5
        };
        let (mut sum, mut reported) = ([0.0f64; 3], [0.0f64; 3]);
        let trials = 2000;
        for _ in 0..trials {
            // Sum of twelve uniforms: variance 1.
            let noise: Vec<f32> = (0..120).map(|_| 0.02 * (0..12).map(|_| uniform()).sum::<f32>()).collect();
            let adjusted = adjust(shape(30.0, 12.0, 0.5), &points(30.0, 12.0, 0.5, 120, |i| noise[i]));
            let (dx, dy) = (f64::from(adjusted.shape.cx) - 0.3, f64::from(adjusted.shape.cy) + 0.4);
            let c = adjusted.covariance;
            for ((s, r), (d, c)) in
                sum.iter_mut().zip(&mut reported).zip([(dx * dx, c.xx), (dx * dy, c.xy), (dy * dy, c.yy)])
            {
                *s += d / f64::from(trials);
                *r += f64::from(c) / f64::from(trials);
            }
        }
        for (actual, reported) in sum.iter().zip(reported) {
            assert!((actual / reported - 1.0).abs() < 0.1, "{sum:?} {reported:?}");
        }
    }
}
