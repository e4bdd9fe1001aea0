use super::Real;

/// The pencil Q2 - x Q1 of the conics of two ellipses, in the frame where the outer one is the unit circle.
///
/// For concentric circles det(Q2 - x Q1) has a double root; the single one belongs to a degenerate conic whose centre is
/// the true centre (Kim, Gurdjos and Kweon 2005, "Geometric and algebraic constraints of projected concentric circles and
/// their applications to camera calibration", IEEE PAMI 27(4)). Only the single root is calculated by itself: the
/// others nearly coincide, so each is lost in noise, but not their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pencil<T> {
    /// Ratio of the radii, inner / outer.
    pub ratio: T,
    /// True centre from the outer ellipse's centre, in the frame where the outer ellipse is the unit circle.
    pub centre: (T, T),
    /// Half the relative difference of the two roots that should coincide: what is left of it is noise, or the ellipses are
    /// not those of concentric circles.
    pub split: T,
}

impl<T: Real> Pencil<T> {
    /// `inner` is the inner ellipse in that frame: its centre (x, y) and its matrix (xx, xy, yy), so that
    /// (q - d)' B (q - d) = 1. `None` if there is no root apart from the others.
    pub fn new((dx, dy): (T, T), (bxx, bxy, byy): (T, T, T)) -> Option<Self> {
        let one = T::from(1.0);
        let half = T::from(0.5);
        let (hx, hy) = (bxx * dx + bxy * dy, bxy * dx + byy * dy);
        let e = dx * hx + dy * hy;
        let h = hx * hx + hy * hy;
        let trace = bxx + byy;
        let det = bxx * byy - bxy * bxy;
        // det(Q2 - x Q1) = x^3 - (T + 1 - e) x^2 + (det + T (1 - e) + h) x - det; without eccentricity the single root is 1.
        let c2 = trace + one - e;
        let c1 = det + trace * (one - e) + h;
        let mut root = one;
        for _ in 0..6 {
            let value = ((root - c2) * root + c1) * root - det;
            let slope = (T::from(3.0) * root - c2 - c2) * root + c1;
            root = root - value / slope;
        }
        let mean = half * (c2 - root);
        let product = det / root;
        if !(root > T::from(0.0) && mean > root) {
            return None;
        }
        let difference = one - product / (mean * mean);
        let split = if difference < T::from(0.0) { -difference } else { difference }.sqrt();
        // The centre of Q2 - root Q1 solves (B - root) q = B d.
        let (mxx, myy) = (bxx - root, byy - root);
        let minor = mxx * myy - bxy * bxy;
        let centre = ((myy * hx - bxy * hy) / minor, (mxx * hy - bxy * hx) / minor);
        Some(Self { ratio: (root / mean).sqrt(), centre, split })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::centre::{perspective, weights};

    /// Exact images of concentric circles: x(s) = c + r S e(s) / (1 + r p.e(s)), as centre and matrix.
    fn image(s: [f64; 3], p: [f64; 2], r: f64) -> ((f64, f64), (f64, f64, f64)) {
        // In the frame q = S^-1 (x - c): |q| = r (1 - p.q), a conic q'(I - r^2 p p')q + 2 r^2 p.q - r^2 = 0.
        let (px, py) = (p[0], p[1]);
        let k = r * r;
        let (mxx, mxy, myy) = (1.0 - k * px * px, -k * px * py, 1.0 - k * py * py);
        let det = mxx * myy - mxy * mxy;
        let (qx, qy) = (-k * (myy * px - mxy * py) / det, -k * (mxx * py - mxy * px) / det);
        let level = k - k * (px * qx + py * qy);
        // Back through S: A = S^-1 M S^-1 / level.
        let ds = s[0] * s[2] - s[1] * s[1];
        let i = [s[2] / ds, -s[1] / ds, s[0] / ds];
        let mul = |m: [f64; 3], x: f64, y: f64| (m[0] * x + m[1] * y, m[1] * x + m[2] * y);
        let m = [mxx, mxy, myy];
        let quad = |a: (f64, f64), b: (f64, f64)| {
            let v = mul(m, b.0, b.1);
            (a.0 * v.0 + a.1 * v.1) / level
        };
        let (c0, c1) = ((i[0], i[1]), (i[1], i[2]));
        (mul(s, qx, qy), (quad(c0, c0), quad(c0, c1), quad(c1, c1)))
    }

    /// The same in the frame of the outer ellipse, with the matrix L that leads there.
    #[allow(clippy::type_complexity)]
    fn in_frame(
        outer: ((f64, f64), (f64, f64, f64)),
        inner: ((f64, f64), (f64, f64, f64)),
    ) -> ((f64, f64), (f64, f64, f64), [f64; 3]) {
        let (axx, axy, ayy) = outer.1;
        let l0 = axx.sqrt();
        let l1 = axy / l0;
        let l2 = (ayy - l1 * l1).sqrt();
        let (dx, dy) = (inner.0.0 - outer.0.0, inner.0.1 - outer.0.1);
        let (bxx, bxy, byy) = inner.1;
        let rxx = bxx / (l0 * l0);
        let rxy = (bxy - l1 * rxx * l0) / (l0 * l2);
        let ryy = (byy - 2.0 * l1 * l2 * rxy - l1 * l1 * rxx) / (l2 * l2);
        ((l0 * dx + l1 * dy, l2 * dy), (rxx, rxy, ryy), [l0, l1, l2])
    }

    #[test]
    fn pencil_and_closed_form_are_exact_and_eq7_is_not() {
        for (k, p) in [(1.0, [0.02, 0.01]), (0.7, [0.1, -0.05]), (1.3, [-0.2, 0.2]), (1.0, [0.0, 0.0])] {
            for ratio in [0.2, 0.5, 0.8] {
                let s = [1.3 * k, 0.3, 0.6];
                let (outer, inner) = (image(s, p, 1.0), image(s, p, ratio));
                let (d, b, [l0, l1, l2]) = in_frame(outer, inner);
                let pencil = Pencil::new(d, b).unwrap();
                assert!((pencil.ratio - ratio).abs() < 1e-12);
                assert!(pencil.split < 1e-6);
                // Back to the image; the true centre is the origin.
                let y = pencil.centre.1 / l2;
                let x = (pencil.centre.0 - l1 * y) / l0;
                let error = (outer.0.0 + x).hypot(outer.0.1 + y);
                assert!(error < 1e-12, "pencil {error}");
                let t = perspective(d.0 * d.0 + d.1 * d.1, ratio);
                assert!((t - (p[0] * p[0] + p[1] * p[1])).abs() < 1e-12);
                let combined = |t| {
                    let w = weights(&[(1.0, 1.0), (ratio, 3.0)], t).unwrap();
                    (w[0] * outer.0.0 + w[1] * inner.0.0).hypot(w[0] * outer.0.1 + w[1] * inner.0.1)
                };
                assert!(combined(t) < 1e-12, "exact {}", combined(t));
                if t > 0.0 {
                    assert!(combined(0.0) > 1e-7, "eq. (7) {}", combined(0.0));
                    assert!(combined(1.02 * t) > 0.015 * combined(0.0), "a wrong t must show");
                }
                let single =
                    Pencil::<f32>::new((d.0 as f32, d.1 as f32), (b.0 as f32, b.1 as f32, b.2 as f32))
                        .unwrap();
                assert!((f64::from(single.centre.0) - pencil.centre.0).abs() < 1e-6);
                assert!((f64::from(single.ratio) - ratio).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_shifted_inner_ellipse_splits_the_roots() {
        let s = [1.0, 0.0, 0.6];
        let (outer, mut inner) = (image(s, [0.02, 0.0], 1.0), image(s, [0.02, 0.0], 0.5));
        inner.1.0 *= 1.1;
        let (d, b, _) = in_frame(outer, inner);
        assert!(Pencil::new(d, b).unwrap().split > 0.04);
    }

    #[test]
    fn three_circles_use_all_and_two_need_no_variance() {
        let two = weights(&[(1.0f64, 1.0), (0.5, 9.0)], 0.0).unwrap();
        assert!((two[0] + 1.0 / 3.0).abs() < 1e-12 && (two[1] - 4.0 / 3.0).abs() < 1e-12);
        let three = weights(&[(1.0f64, 1.0), (0.75, 1.3), (0.5, 2.0)], 0.0).unwrap();
        assert!((three.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(three.iter().all(|w| *w != 0.0));
        assert!(weights(&[(1.0f64, 1.0)], 0.0).is_none());
    }
}
