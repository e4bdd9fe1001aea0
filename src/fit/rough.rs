//! The algebraic fit to points that are good to a fraction of a pixel, from whole numbers.

use super::shape::Shape;
use super::solve::Matrix;
use super::sums::ellipse;

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

    /// With all points of `other`.
    pub fn with(&self, other: &Self) -> Self {
        Self { sums: core::array::from_fn(|i| self.sums[i] + other.sums[i]) }
    }

    /// Without those of `other`, which are among its own.
    pub fn without(&self, other: &Self) -> Self {
        Self { sums: core::array::from_fn(|i| self.sums[i] - other.sums[i]) }
    }

    /// The mean of the points; `None` if there are none.
    pub fn mean(&self) -> Option<(i32, i32)> {
        let [n, x, y, ..] = self.sums.map(|sum| sum as i32);
        Some((x.checked_div(n)?, y.checked_div(n)?))
    }

    /// The fit of [`Sums::fit`](super::Sums::fit), in 4096 units of the coordinates.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_gives_its_ellipse() {
        let mut arc = Rough::default();
        let grid = |x: f32| libm::roundf(x * ONE) as i32;
        for i in 0..40 {
            let (sin, cos) = libm::sincosf(i as f32 * 0.09);
            let mut part = Rough::default();
            part.add(grid(0.1 + 0.8 * cos - 0.1 * sin), grid(-0.2 + 0.1 * cos + 0.5 * sin));
            arc = arc.with(&part);
        }
        assert_eq!(arc.with(&arc).without(&arc).sums, arc.sums);
        let shape = arc.fit().unwrap();
        assert!((shape.cx - 0.1).abs() < 1e-3 && (shape.cy + 0.2).abs() < 1e-3, "{shape:?}");
        arc.add(4096, 4096);
        assert!(arc.fit().is_none_or(|shape| (shape.cx - 0.1).abs() > 0.01));
    }
}
