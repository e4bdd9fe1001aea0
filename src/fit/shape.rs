//! An ellipse as the library calculates with it.

use super::solve::Matrix;
use crate::math;
use crate::target::{Covariance, Ellipse};

/// The ellipse (p - c)' A (p - c) = 1, about an integer origin that its user knows. Lengths in px.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shape {
    pub cx: f32,
    pub cy: f32,
    pub axx: f32,
    pub axy: f32,
    pub ayy: f32,
}

impl Shape {
    /// The ellipse whose filled area has this centroid and these central second moments for each unit of area.
    pub fn from_moments(cx: f32, cy: f32, mxx: f32, mxy: f32, myy: f32) -> Option<Self> {
        let det = mxx * myy - mxy * mxy;
        if !(det > 0.0) {
            return None;
        }
        let scale = 0.25 / det;
        Some(Self { cx, cy, axx: myy * scale, axy: -mxy * scale, ayy: mxx * scale })
    }

    /// det A = 1 / (a b)^2.
    pub fn det(&self) -> f32 {
        self.axx * self.ayy - self.axy * self.axy
    }

    /// d' A d.
    pub fn square(&self, dx: f32, dy: f32) -> f32 {
        dx * (self.axx * dx + self.axy * dy) + dy * (self.axy * dx + self.ayy * dy)
    }

    /// A d.
    pub fn product(&self, (dx, dy): (f32, f32)) -> (f32, f32) {
        (self.axx * dx + self.axy * dy, self.axy * dx + self.ayy * dy)
    }

    /// A (p - c) at `(x, y)`: the direction of the outward normal, and the vector p - c.
    pub fn gradient(&self, x: f32, y: f32) -> ((f32, f32), (f32, f32)) {
        let from = (x - self.cx, y - self.cy);
        (self.product(from), from)
    }

    /// Signed distance of `(x, y)`, px, positive outside: exact for a circle and near the ellipse. `None` at the centre.
    pub fn distance(&self, x: f32, y: f32) -> Option<f32> {
        let ((gx, gy), (dx, dy)) = self.gradient(x, y);
        let radius = math::sqrt(dx * gx + dy * gy);
        let norm = math::sqrt(gx * gx + gy * gy);
        (norm > 0.0).then(|| (radius - 1.0) * radius / norm)
    }

    /// The same with x and y exchanged.
    pub fn transposed(&self) -> Self {
        Self { cx: self.cy, cy: self.cx, axx: self.ayy, axy: self.axy, ayy: self.axx }
    }

    /// An ellipse of the report, with its centre at `(cx, cy)`. `None` if it has no area.
    pub fn from_ellipse(ellipse: &Ellipse, (cx, cy): (f32, f32)) -> Option<Self> {
        let (s, c) = math::sincos(ellipse.theta);
        let (p, q) = (0.25 * ellipse.a * ellipse.a, 0.25 * ellipse.b * ellipse.b);
        Self::from_moments(cx, cy, p * c * c + q * s * s, (p - q) * s * c, p * s * s + q * c * c)
    }

    /// Semi-axes, px, major first.
    #[inline(never)]
    pub fn semi_axes(&self) -> (f32, f32) {
        let mean = 0.5 * (self.axx + self.ayy);
        let half = 0.5 * (self.axx - self.ayy);
        let large = mean + math::sqrt(half * half + self.axy * self.axy);
        // det / large keeps its digits where the difference would lose them.
        let small = self.det() / large;
        (1.0 / math::sqrt(small), 1.0 / math::sqrt(large))
    }

    /// The same in a unit of length of which the present one is `unit`.
    pub fn scaled(&self, unit: f32) -> Self {
        let inverse = 1.0 / (unit * unit);
        let Self { cx, cy, axx, axy, ayy } = *self;
        Self { cx: cx * unit, cy: cy * unit, axx: axx * inverse, axy: axy * inverse, ayy: ayy * inverse }
    }

    /// The same about its own centre, `factor` times as large.
    pub fn grown(&self, factor: f32) -> Self {
        Self { cx: self.cx, cy: self.cy, ..self.scaled(factor) }
    }

    /// The same with both semi-axes longer by `width` px. `None` if one of them vanishes.
    pub fn widened(&self, width: f32) -> Option<Self> {
        // The inverse of A has the squares of the semi-axes; its root is known from their sum and product.
        let product = 1.0 / math::sqrt(self.det());
        let square = product * product;
        let sum = math::sqrt((self.axx + self.ayy) * square + 2.0 * product);
        let by_root = 2.0 * width / sum;
        let (stretch, more) = (square * (1.0 + by_root), by_root * product + width * width);
        let (xx, xy, yy) = (stretch * self.ayy + more, -stretch * self.axy, stretch * self.axx + more);
        let smaller = 0.5 * (sum - math::sqrt((sum * sum - 4.0 * product).max(0.0)));
        let det = xx * yy - xy * xy;
        (smaller + width > 0.0).then(|| Self { axx: yy / det, axy: -xy / det, ayy: xx / det, ..*self })
    }

    /// Half the sides of its bounding box.
    pub fn extent(&self) -> (f32, f32) {
        let det = self.det();
        (math::sqrt(self.ayy / det), math::sqrt(self.axx / det))
    }

    /// The same about `(x, y)` px as origin instead.
    pub fn about(&self, x: f32, y: f32) -> Self {
        Self { cx: self.cx - x, cy: self.cy - y, ..*self }
    }

    /// For the report, without the centre's place in the image.
    pub fn to_ellipse(self) -> Ellipse {
        let (a, b) = self.semi_axes();
        let theta = 0.5 * math::atan2(-2.0 * self.axy, self.ayy - self.axx);
        Ellipse { a, b, theta, ..Ellipse::default() }
    }
}

/// The frame in which an ellipse is the unit circle: q = L (p - c) with A = L' L, L upper triangular.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub l0: f32,
    pub l1: f32,
    pub l2: f32,
}

impl Frame {
    /// `None` if `shape` is no ellipse.
    #[inline(never)]
    pub fn new(shape: &Shape) -> Option<Self> {
        let l0 = math::sqrt(shape.axx);
        let l1 = shape.axy / l0;
        let l2 = math::sqrt(shape.ayy - l1 * l1);
        (l0 > 0.0 && l2 > 0.0).then_some(Self { l0, l1, l2 })
    }

    /// A difference of places.
    pub fn vector(&self, dx: f32, dy: f32) -> (f32, f32) {
        (self.l0 * dx + self.l1 * dy, self.l2 * dy)
    }

    /// The matrix (xx, xy, yy) of an ellipse: L'^-1 A L^-1.
    pub fn matrix(&self, shape: &Shape) -> (f32, f32, f32) {
        let Self { l0, l1, l2 } = *self;
        let xx = shape.axx / (l0 * l0);
        let xy = (shape.axy - l1 * l0 * xx) / (l0 * l2);
        let yy = (shape.ayy - 2.0 * l1 * l2 * xy - l1 * l1 * xx) / (l2 * l2);
        (xx, xy, yy)
    }

    /// The ellipse `shape`, whose frame this is, after adding the terms (u^2 - v^2, 2 u v, u^2 + v^2, u, v) times `step` to its
    /// conic.
    #[inline(never)]
    pub fn moved(&self, shape: &Shape, &[a, b, c, d, e]: &[f32; 5]) -> Option<Shape> {
        let (kxx, kxy, kyy) = (1.0 + c + a, b, 1.0 + c - a);
        let det = kxx * kyy - kxy * kxy;
        if !(det > 0.0) {
            return None;
        }
        let u = 0.5 * (kxy * e - kyy * d) / det;
        let v = 0.5 * (kxy * d - kxx * e) / det;
        let level = 1.0 - 0.5 * (d * u + e * v);
        let (dx, dy) = self.inverse(u, v);
        let Self { l0, l1, l2 } = *self;
        (level > 0.0).then(|| Shape {
            cx: shape.cx + dx,
            cy: shape.cy + dy,
            axx: l0 * l0 * kxx / level,
            axy: l0 * (l1 * kxx + l2 * kxy) / level,
            ayy: (l1 * l1 * kxx + 2.0 * l1 * l2 * kxy + l2 * l2 * kyy) / level,
        })
    }

    /// The inverse of [`vector`](Self::vector).
    pub fn inverse(&self, u: f32, v: f32) -> (f32, f32) {
        let dy = v / self.l2;
        ((u - self.l1 * dy) / self.l0, dy)
    }

    /// The covariance in the image of a centre, from that of stretch and centre in the frame.
    pub fn covariance(&self, frame: &Matrix<4>) -> Covariance {
        self.point_covariance(frame[2][2], frame[3][2], frame[3][3])
    }

    /// The covariance in the image of a place, from that in the frame.
    #[inline(never)]
    pub fn point_covariance(&self, uu: f32, uv: f32, vv: f32) -> Covariance {
        let Self { l0, l1, l2 } = *self;
        let k = l1 / (l0 * l2);
        Covariance {
            xx: uu / (l0 * l0) - 2.0 * k * uv / l0 + k * k * vv,
            xy: (uv / l0 - k * vv) / l2,
            yy: vv / (l2 * l2),
        }
    }
}
