//! Exact sums of the edge points and the linear fit to them.

use super::shape::Shape;
use super::solve::{Factor, Matrix};

/// The fit's unit of length, 1/256 px: a power of two, so that no digit is lost, which keeps fourth powers in f32.
const UNIT: f32 = 32768.0;
/// Edge points have 1/256 px.
const GRID: f32 = 256.0;

/// Sums of monomials of edge points about the target's integer origin. Exact, so the order of the points is of no
/// matter and every processor has the same: at most 2^16 points within 2048 px (19 bits) make 73 bits in the third order
/// and 92 in the fourth.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    n: i64,
    x: i64,
    y: i64,
    xx: i64,
    xy: i64,
    yy: i64,
    xxx: i128,
    xxy: i128,
    xyy: i128,
    yyy: i128,
    xxxx: i128,
    xxxy: i128,
    xxyy: i128,
    xyyy: i128,
    yyyy: i128,
}

impl Sums {
    /// Adds a point, 1/256 px from the origin.
    pub fn add(&mut self, x: i32, y: i32) {
        let (x, y) = (i64::from(x), i64::from(y));
        let (xx, xy, yy) = (x * x, x * y, y * y);
        self.n += 1;
        self.x += x;
        self.y += y;
        self.xx += xx;
        self.xy += xy;
        self.yy += yy;
        self.xxx += i128::from(xx * x);
        self.xxy += i128::from(xx * y);
        self.xyy += i128::from(x * yy);
        self.yyy += i128::from(yy * y);
        let product = |a: i64, b: i64| i128::from(a) * i128::from(b);
        self.xxxx += product(xx, xx);
        self.xxxy += product(xx, xy);
        self.xxyy += product(xx, yy);
        self.xyyy += product(xy, yy);
        self.yyyy += product(yy, yy);
    }

    /// Least squares of a (x^2 - y^2) + b x y + d x + e y + f = -(x^2 + y^2): the algebraic fit with constant trace,
    /// invariant to rotation, shift and scale. `None` if the points do not determine an ellipse.
    pub fn fit(&self) -> Option<Shape> {
        let unit = 1.0 / UNIT;
        let each = 1.0 / self.n.max(1) as f32;
        let s1 = |v: i64| v as f32 * unit * each;
        let s2 = |v: i64| v as f32 * (unit * unit) * each;
        let s3 = |v: i128| v as f32 * (unit * unit * unit) * each;
        let s4 = |v: i128| v as f32 * (unit * unit * unit * unit) * each;
        let m: Matrix<5> = [
            [s4(self.xxxx - 2 * self.xxyy + self.yyyy), 0.0, 0.0, 0.0, 0.0],
            [s4(self.xxxy - self.xyyy), s4(self.xxyy), 0.0, 0.0, 0.0],
            [s3(self.xxx - self.xyy), s3(self.xxy), s2(self.xx), 0.0, 0.0],
            [s3(self.xxy - self.yyy), s3(self.xyy), s2(self.xy), s2(self.yy), 0.0],
            [s2(self.xx - self.yy), s2(self.xy), s1(self.x), s1(self.y), 1.0],
        ];
        let right = [
            -s4(self.xxxx - self.yyyy),
            -s4(self.xxxy + self.xyyy),
            -s3(self.xxx + self.xyy),
            -s3(self.xxy + self.yyy),
            -s2(self.xx + self.yy),
        ];
        ellipse(&m, right).map(|shape| shape.scaled(UNIT / GRID))
    }
}

/// The ellipse that solves the normal equations, in their unit of length.
pub(super) fn ellipse(m: &Matrix<5>, right: [f32; 5]) -> Option<Shape> {
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

    /// Points of an ellipse, 1/256 px, from f64.
    fn points(a: f64, b: f64, theta: f64, cx: f64, cy: f64, n: usize) -> Vec<(i32, i32)> {
        (0..n)
            .map(|i| {
                let (s, c) = (i as f64 / n as f64 * core::f64::consts::TAU).sin_cos();
                let (u, v) = (a * c, b * s);
                let (x, y) = (cx + u * theta.cos() - v * theta.sin(), cy + u * theta.sin() + v * theta.cos());
                ((x * 256.0).round() as i32, (y * 256.0).round() as i32)
            })
            .collect()
    }

    fn fit(points: &[(i32, i32)]) -> Option<Shape> {
        let mut sums = Sums::default();
        points.iter().for_each(|&(x, y)| sums.add(x, y));
        sums.fit()
    }

    #[test]
    fn recovers_an_ellipse_at_every_size() {
        for (a, b, n, tolerance) in [
            (5.0, 4.0, 40, 2e-3),
            (30.0, 21.0, 250, 4e-4),
            (120.0, 31.0, 1000, 4e-4),
            (500.0, 130.0, 4000, 1e-3),
            (1000.0, 900.0, 8000, 2e-3),
            (2040.0, 600.0, 16000, 4e-3),
        ] {
            for theta in [0.0, 0.4, 1.5, 2.5] {
                let shape = fit(&points(a, b, theta, 0.3, -0.4, n)).unwrap();
                let (fa, fb) = shape.semi_axes();
                for (got, want) in [(shape.cx, 0.3), (shape.cy, -0.4), (fa, a as f32), (fb, b as f32)] {
                    assert!((got - want).abs() < tolerance, "{a} {b} {theta}: {got} for {want}");
                }
            }
        }
    }

    #[test]
    fn one_displaced_point_moves_the_fit() {
        let mut points = points(30.0, 21.0, 0.4, 0.3, -0.4, 250);
        points[17].0 += 512;
        let shape = fit(&points).unwrap();
        assert!((shape.cx - 0.3).abs() > 2e-3);
    }

    #[test]
    fn refuses_points_that_are_no_ellipse() {
        assert!(fit(&[]).is_none());
        assert!(fit(&[(0, 0); 20]).is_none());
        let line: Vec<_> = (0..50).map(|i| (i * 64, i * 32)).collect();
        assert!(fit(&line).is_none());
    }
}
