use super::from_two;
use crate::centre::Real;

/// Lens distortion with the components that the paper names: radial, decentring and affine.
///
/// Coordinates from the principal point over the focal length. The place (x, y), with r^2 = x^2 + y^2, is moved by
///
/// ```text
/// dx = x (k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2) + b1 x + b2 y
/// dy = y (k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
/// ```
///
/// (Fraser 1997, "Digital camera self-calibration", ISPRS J. Photogramm. 52(4); signs and order of names as in
/// [`Camera`](crate::Camera).)
///
/// # Why eq. (7) holds on distorted pictures
///
/// Eq. (8) is eq. (7) with the distorted ellipse centres B' = B + d(B), under the assumption that both are moved alike:
/// d(B1) = d(B2). That assumption does not hold: the ellipse centres are apart by most of the eccentricity, and the slope of
/// the distortion over that distance, times k2 of eq. (7), is what [`neglected`](Self::neglected) gives, hundredths of a
/// pixel for a large target. Nor is a distorted ellipse's centre its centre distorted.
///
/// Eq. (7) works all the same, for another reason. Circle to picture is a smooth map, lens included, and a circle of radius
/// -r is the circle of radius r. So where the centre of the outline appears is an even function of r,
///
/// ```text
/// B'(r) = C' + K' r^2 + O(r^4)
/// ```
///
/// about the distorted true centre C', with a K' that has a part from perspective and one from the distortion's curvature.
/// That is the form of (5) and (6), which is all that eq. (7) needs: it reads the line through both at r = 0. What is left is
/// of the order r^4, as without a lens. Only forms that take more from perspective than this (the exact form, a known camera)
/// want points freed from distortion first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lens<T> {
    /// k1, k2, k3.
    pub radial: [T; 3],
    /// p1, p2.
    pub decentring: [T; 2],
    /// b1, b2.
    pub affine: [T; 2],
}

impl<T: Real> Lens<T> {
    /// (dx, dy) at the place (x, y).
    pub fn shift(&self, (x, y): (T, T)) -> (T, T) {
        let [k1, k2, k3] = self.radial;
        let [p1, p2] = self.decentring;
        let [b1, b2] = self.affine;
        let two = T::from(2.0);
        let square = x * x + y * y;
        let radial = square * (k1 + square * (k2 + square * k3));
        let cross = two * x * y;
        (
            x * radial + p1 * cross + p2 * (square + two * x * x) + b1 * x + b2 * y,
            y * radial + p1 * (square + two * y * y) + p2 * cross,
        )
    }

    /// Where the lens shows the place (x, y).
    pub fn distort(&self, place: (T, T)) -> (T, T) {
        let (dx, dy) = self.shift(place);
        (place.0 + dx, place.1 + dy)
    }

    /// What eq. (8) neglects by d(B1) = d(B2): k1 d(B2) - k2 d(B1) less d(B2), which is k2 (d(B2) - d(B1)).
    ///
    /// `outer` and `inner` are B1 and B2 without distortion; `None` if the ratio is 1.
    pub fn neglected(&self, outer: (T, T), inner: (T, T), ratio: T) -> Option<(T, T)> {
        let (b1, b2) = (self.shift(outer), self.shift(inner));
        let (x, y) = from_two(b1, b2, ratio)?;
        Some((x - b2.0, y - b2.1))
    }
}
