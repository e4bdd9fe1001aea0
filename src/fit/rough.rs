//! The algebraic fit in f32, for points that are good to a fraction of a pixel.

use super::shape::Shape;
use super::solve::Matrix;
use super::sums::ellipse;

/// Number of monomials up to the fourth order.
const MONOMIALS: usize = 15;

/// Sums of monomials of points, which should lie within about 1 of the origin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rough {
    /// 1, x, y, x2, xy, y2, x3, x2 y, x y2, y3, x4, x3 y, x2 y2, x y3, y4.
    sums: [f32; MONOMIALS],
}

impl Rough {
    /// Adds a point.
    pub fn add(&mut self, x: f32, y: f32) {
        let (xx, xy, yy) = (x * x, x * y, y * y);
        let monomials = [
            1.0,
            x,
            y,
            xx,
            xy,
            yy,
            xx * x,
            xx * y,
            x * yy,
            yy * y,
            xx * xx,
            xx * xy,
            xx * yy,
            xy * yy,
            yy * yy,
        ];
        for (sum, monomial) in self.sums.iter_mut().zip(monomials) {
            *sum += monomial;
        }
    }

    /// Adds all points of `other`.
    pub fn join(&mut self, other: &Self) {
        for (sum, other) in self.sums.iter_mut().zip(other.sums) {
            *sum += other;
        }
    }

    /// The fit of [`Sums::fit`](super::Sums::fit).
    pub fn fit(&self) -> Option<Shape> {
        let [n, x, y, xx, xy, yy, xxx, xxy, xyy, yyy, xxxx, xxxy, xxyy, xyyy, yyyy] = self.sums;
        let m: Matrix<5> = [
            [xxxx - 2.0 * xxyy + yyyy, 0.0, 0.0, 0.0, 0.0],
            [xxxy - xyyy, xxyy, 0.0, 0.0, 0.0],
            [xxx - xyy, xxy, xx, 0.0, 0.0],
            [xxy - yyy, xyy, xy, yy, 0.0],
            [xx - yy, xy, x, y, n],
        ];
        ellipse(&m, [yyyy - xxxx, -(xxxy + xyyy), -(xxx + xyy), -(xxy + yyy), -(xx + yy)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_gives_its_ellipse() {
        let mut arc = Rough::default();
        for i in 0..40 {
            let (sin, cos) = libm::sincosf(i as f32 * 0.09);
            let mut part = Rough::default();
            part.add(0.1 + 0.8 * cos - 0.1 * sin, -0.2 + 0.1 * cos + 0.5 * sin);
            arc.join(&part);
        }
        let shape = arc.fit().unwrap();
        assert!((shape.cx - 0.1).abs() < 1e-3 && (shape.cy + 0.2).abs() < 1e-3, "{shape:?}");
        arc.add(2.0, 2.0);
        assert!(arc.fit().is_none_or(|shape| (shape.cx - 0.1).abs() > 0.01));
    }
}
