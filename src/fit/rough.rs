//! The algebraic fit to points that are good to a fraction of a pixel, from whole numbers.

use core::hint::black_box;

use super::shape::Shape;
use super::solve::{Factor, Matrix};
use crate::fixed::{PX, fixed};
use crate::list::rolled;

/// Number of monomials up to the fourth order.
const MONOMIALS: usize = 15;
/// Largest coordinate: the unit of the fit.
const ONE: f32 = 4096.0;

/// Exact sums of monomials of points, up to 2^12 from the origin. Those of the fourth order have 48 bits each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rough {
    /// 1, x, y, x2, xy, y2, x3, x2 y, x y2, y3, x4, x3 y, x2 y2, x y3, y4.
    sums: [i64; MONOMIALS],
}

impl Rough {
    /// Bits of a coordinate.
    pub const BITS: u32 = 12;

    /// Adds a point.
    #[inline(never)]
    pub fn add(&mut self, x: i32, y: i32) {
        let (xx, xy, yy) = (x * x, x * y, y * y);
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        let monomials = [
            1,
            i64::from(x),
            i64::from(y),
            i64::from(xx),
            i64::from(xy),
            i64::from(yy),
            product(xx, x),
            product(xx, y),
            product(x, yy),
            product(yy, y),
            product(xx, xx),
            product(xx, xy),
            product(xx, yy),
            product(xy, yy),
            product(yy, yy),
        ];
        for (sum, monomial) in self.sums.iter_mut().zip(monomials) {
            *sum += monomial;
        }
    }

    /// Adds all points of `other`, ...
    pub fn join(&mut self, other: &Self) {
        self.add_each(other, 1);
    }

    /// ... or takes them away, which are among its own.
    pub fn remove(&mut self, other: &Self) {
        self.add_each(other, -1);
    }

    #[inline(never)]
    fn add_each(&mut self, other: &Self, sign: i64) {
        // What the compiler cannot count it does not unroll.
        for (sum, other) in rolled(black_box(&mut self.sums[..]).iter_mut().zip(&other.sums)) {
            *sum += if sign < 0 { -other } else { *other };
        }
    }

    /// The mean of the points without those of `other`; `None` if there are none.
    pub fn mean_without(&self, other: &Self) -> Option<(i32, i32)> {
        let [n, x, y] = [0, 1, 2].map(|i| (self.sums[i] - other.sums[i]) as i32);
        Some((x.checked_div(n)?, y.checked_div(n)?))
    }

    /// The fit of [`rough`], in 4096 units of the coordinates.
    #[inline(never)]
    pub fn fit(&self) -> Option<Shape> {
        const UNIT: f32 = 1.0 / ONE;
        let [n, x, y, xx, xy, yy, xxx, xxy, xyy, yyy, xxxx, xxxy, xxyy, xyyy, yyyy] = self.sums;
        let s1 = |v: i64| v as f32 * UNIT;
        let s2 = |v: i64| v as f32 * (UNIT * UNIT);
        let s3 = |v: i64| v as f32 * (UNIT * UNIT * UNIT);
        let s4 = |v: i64| v as f32 * (UNIT * UNIT * UNIT * UNIT);
        let cross = s2(xy);
        let m: Matrix<5> = [
            [s4(xxxx - 2 * xxyy + yyyy), 0.0, 0.0, 0.0, 0.0],
            [s4(xxxy - xyyy), s4(xxyy), 0.0, 0.0, 0.0],
            [s3(xxx - xyy), s3(xxy), s2(xx), 0.0, 0.0],
            [s3(xxy - yyy), s3(xyy), cross, s2(yy), 0.0],
            [s2(xx - yy), cross, s1(x), s1(y), n as f32],
        ];
        let right = [s4(yyyy - xxxx), -s4(xxxy + xyyy), -s3(xxx + xyy), -s3(xxy + yyy), -s2(xx + yy)];
        ellipse(&m, right)
    }
}

/// The algebraic fit to points, [`PX`], most of them within `extent` px of the origin: least squares of a (x^2 - y^2) + b x y + d x +
/// e y + f = -(x^2 + y^2), which has constant trace and is invariant to rotation, shift and scale. `None` if the points do not
/// determine an ellipse.
#[inline(never)]
pub(crate) fn rough(points: impl Iterator<Item = (i32, i32)>, extent: f32) -> Option<Shape> {
    const MOST: i32 = 1 << Rough::BITS;
    let extent = fixed(extent, PX).unsigned_abs();
    let shift = (u32::BITS - extent.leading_zeros()).saturating_sub(Rough::BITS);
    let half = (1 << shift) >> 1;
    let coarse = |x: i32| ((x + half) >> shift).clamp(-MOST, MOST);
    let mut sums = Rough::default();
    points.for_each(|(x, y)| sums.add(coarse(x), coarse(y)));
    Some(sums.fit()?.scaled((1u32 << shift) as f32))
}

/// The ellipse that solves the normal equations, in their unit of length.
fn ellipse(m: &Matrix<5>, right: [f32; 5]) -> Option<Shape> {
    let [a, b, d, e, f] = Factor::new(m)?.solve(right);
    let (axx, axy, ayy) = (1.0 + a, 0.5 * b, 1.0 - a);
    let det = axx * ayy - axy * axy;
    if !(det > 0.0) {
        return None;
    }
    let cx = 0.5 * (axy * e - ayy * d) / det;
    let cy = 0.5 * (axy * d - axx * e) / det;
    let level = -(f + 0.5 * (d * cx + e * cy));
    // A real ellipse has its centre inside.
    (level > 0.0).then(|| Shape { cx, cy, axx: axx / level, axy: axy / level, ayy: ayy / level })
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn an_arc_gives_its_ellipse() {
        let mut arc = Rough::default();
        let grid = |x: f32| libm::roundf(x * ONE) as i32;
        for i in 0..40 {
            let (sin, cos) = libm::sincosf(i as f32 * 0.09);
            let mut part = Rough::default();
            part.add(grid(0.1 + 0.8 * cos - 0.1 * sin), grid(-0.2 + 0.1 * cos + 0.5 * sin));
            arc.join(&part);
        }
        let mut same = arc;
        same.join(&arc);
        assert_ne!(same.sums, arc.sums);
        same.remove(&arc);
        assert_eq!(same.sums, arc.sums);
        let shape = arc.fit().unwrap();
        assert!((shape.cx - 0.1).abs() < 1e-3 && (shape.cy + 0.2).abs() < 1e-3, "{shape:?}");
        arc.add(4096, 4096);
        assert!(arc.fit().is_none_or(|shape| (shape.cx - 0.1).abs() > 0.01));
    }

    /// Points of an ellipse, 1/4096 px, from f64.
    fn points((a, b): (f64, f64), theta: f64, (cx, cy): (f64, f64), n: usize) -> Vec<(i32, i32)> {
        (0..n)
            .map(|i| {
                let (s, c) = (i as f64 / n as f64 * core::f64::consts::TAU).sin_cos();
                let (u, v) = (a * c, b * s);
                let (x, y) = (cx + u * theta.cos() - v * theta.sin(), cy + u * theta.sin() + v * theta.cos());
                ((x * 4096.0).round() as i32, (y * 4096.0).round() as i32)
            })
            .collect()
    }

    fn fit(points: &[(i32, i32)], extent: f32) -> Option<Shape> {
        rough(points.iter().copied(), extent)
    }

    /// To a part of the 12 bits that a coordinate has: [`Adjustment`](super::super::Adjustment) begins here.
    #[test]
    fn recovers_an_ellipse_at_every_size() {
        for (a, b, n, tolerance) in [
            (5.0, 4.0, 40, 2e-3),
            (30.0, 21.0, 250, 7e-4),
            (120.0, 31.0, 1000, 2e-3),
            (500.0, 130.0, 4000, 3.2e-3),
            (1000.0, 900.0, 8000, 3e-3),
            (2040.0, 600.0, 16000, 9e-3),
        ] {
            for theta in [0.0, 0.4, 1.5, 2.5] {
                let shape = fit(&points((a, b), theta, (0.3, -0.4), n), a as f32 + 1.0).unwrap();
                let (fa, fb) = shape.semi_axes();
                for (got, want) in [(shape.cx, 0.3), (shape.cy, -0.4), (fa, a as f32), (fb, b as f32)] {
                    assert!((got - want).abs() < tolerance, "{a} {b} {theta}: {got} for {want}");
                }
            }
        }
    }

    #[test]
    fn one_displaced_point_moves_the_fit() {
        let mut points = points((30.0, 21.0), 0.4, (0.3, -0.4), 250);
        points[17].0 += 8192;
        let shape = fit(&points, 33.0).unwrap();
        assert!((shape.cx - 0.3).abs() > 2e-3);
    }

    #[test]
    fn refuses_points_that_are_no_ellipse() {
        assert!(fit(&[], 1.0).is_none());
        assert!(fit(&[(0, 0); 20], 1.0).is_none());
        let line: Vec<_> = (0..50).map(|i| (i * 1024, i * 512)).collect();
        assert!(fit(&line, 10.0).is_none());
    }
}
