//! An ellipse as rows and columns pass it, in integers of 32 bits.

use crate::fit::{Frame, Shape, View};
use crate::fixed::{BEND, Inverse, ONE, PX, fixed, scale};
use crate::math;
use crate::scan::Axis;

/// Bits of places in the frame where the ellipse is the unit circle, and of those that are multiplied there.
const PLACE: u32 = 26;
const COARSE: u32 = PLACE / 2;
/// Farthest place there that is looked at: the sum of two squares has 32 bits.
const FARTHEST: u32 = 56 * (1 << PLACE) / 10;
/// Square of the distance from the centre up to which a place is near, and how near it is, px.
const NEAR: u32 = 3 << PLACE;
const DEEPEST: i32 = 3 * PX;
/// Largest part of the conic that is multiplied, and length, px: 16 bits.
const MOST: i32 = (1 << 16) - 1;

/// An ellipse about the target's origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trace {
    /// The origin in the frame, and the frame for px / 2.
    start: (i32, i32),
    frame: [i32; 3],
    /// The frame in units of the semi-minor axis.
    by_minor: [i32; 3],
    /// Second derivatives of half the conic along rows and along columns, in units of the semi-minor axis.
    second: (i32, i32),
    /// The leading 15 bits of the semi-minor axis, and how many bits of the conic are left out before it is multiplied with that.
    minor: i32,
    less: u32,
    /// Semi-minor axis over semi-major axis.
    ratio: i32,
    /// Half the largest curvature, 1/px.
    bend: i32,
}

/// A place near the ellipse.
pub(super) struct Look {
    /// How far it is outside, px: exact to second order.
    pub distance: i32,
    /// Cosines of the outward normal along and across, and the change of the first along the axis, 1/px.
    pub cosines: (i32, i32),
    pub change: i32,
    /// Half the curvature of the ellipse nearest to it, 1/px.
    pub bend: i32,
    pub conic: Conic,
}

/// The conic at a place and along an axis through it.
pub(super) struct Conic {
    /// The place in the frame.
    place: (i32, i32),
    /// Half the conic, px, and its first and second derivative along the axis.
    depth: i32,
    slope: i32,
    second: i32,
    by_gradient: Inverse,
}

impl Trace {
    /// `minor` is the semi-minor axis, px. `None` if it is no ellipse.
    pub fn new(shape: &Shape, minor: f32) -> Option<Self> {
        let frame = Frame::new(shape)?;
        let Frame { l0, l1, l2 } = frame;
        let (u, v) = frame.vector(-shape.cx, -shape.cy);
        let place = |u: f32| fixed(u, 1 << PLACE);
        let ratio = minor * minor * math::sqrt(shape.det());
        let bits = (u32::BITS - (minor as u32 | 1).leading_zeros()).min(15);
        Some(Self {
            start: (place(u), place(v)),
            frame: [l0, l1, l2].map(|entry| place(0.5 * entry)),
            by_minor: [l0, l1, l2].map(|entry| fixed(minor * entry, ONE)),
            second: (fixed(minor * shape.axx, BEND), fixed(minor * shape.ayy, BEND)),
            minor: fixed(minor, 1 << (15 - bits)),
            less: 16 - bits,
            ratio: fixed(ratio, ONE),
            bend: fixed(0.5 / (minor * ratio), BEND),
        })
    }

    /// A place about the origin, px / 2, in the frame, and the square of its distance from the centre.
    #[inline]
    fn place(&self, (x, y): (i32, i32)) -> Option<((i32, i32), u32)> {
        let [l0, l1, l2] = self.frame;
        let (u, v) = (self.start.0 + l0 * x + l1 * y, self.start.1 + l2 * y);
        if u.unsigned_abs() > FARTHEST || v.unsigned_abs() > FARTHEST {
            return None;
        }
        let coarse = |x: i32| (x + (1 << (COARSE - 1))) >> COARSE;
        let (high, low) = ((coarse(u), coarse(v)), (u - (coarse(u) << COARSE), v - (coarse(v) << COARSE)));
        let square = high.0.unsigned_abs().pow(2) + high.1.unsigned_abs().pow(2);
        let rest = (high.0 * low.0 + high.1 * low.1) >> (COARSE - 1);
        Some((high, square.saturating_add_signed(rest)))
    }

    /// Half the conic, px, for the square of a distance from the centre. `None` where it is large.
    #[inline]
    fn depth(&self, square: u32) -> Option<i32> {
        let excess = (square.wrapping_sub(1 << PLACE) as i32) >> self.less;
        (excess.abs() <= MOST).then(|| (excess * self.minor) >> 14)
    }

    /// Half the conic's gradient at a place in the frame with so many bits, in units of the semi-minor axis.
    #[inline]
    fn gradient(&self, (u, v): (i32, i32), bits: u32) -> ((i32, i32), Option<Inverse>) {
        let [m0, m1, m2] = self.by_minor;
        let (x, y) = ((m0 * u) >> bits, (m1 * u + m2 * v) >> bits);
        ((x, y), Inverse::of_root(x.unsigned_abs().pow(2) + y.unsigned_abs().pow(2)))
    }

    /// The conic at a place about the origin, px / 2, with half its derivative across the axis and the square of the place's distance
    /// from the centre in the frame. `None` where it is not near the ellipse.
    #[inline(always)]
    fn conic(&self, axis: Axis, place: (i32, i32)) -> Option<(Conic, i32, u32)> {
        let (place, square) = self.place(place).filter(|(_, square)| *square < NEAR)?;
        let (gradient, by_gradient) = self.gradient(place, COARSE);
        let (by_gradient, depth) = (by_gradient?, self.depth(square)?);
        if by_gradient.of(depth).abs() > DEEPEST {
            return None;
        }
        let (x, y) = gradient;
        let ((slope, across), second) =
            if axis == Axis::Row { ((x, y), self.second.0) } else { ((y, x), self.second.1) };
        Some((Conic { place, depth, slope, second, by_gradient }, across, square))
    }

    /// The same where the axis is steeper than the other one.
    #[inline]
    pub fn steep_conic(&self, axis: Axis, place: (i32, i32)) -> Option<Conic> {
        let (conic, across, _) = self.conic(axis, place)?;
        (conic.slope.abs() >= across.abs()).then_some(conic)
    }

    /// What a place about the origin, px / 2, has to do with the ellipse. `None` where it is not near that.
    #[inline]
    pub fn look(&self, axis: Axis, place: (i32, i32)) -> Option<Look> {
        let (conic, across, square) = self.conic(axis, place)?;
        let Conic { depth, slope, second, by_gradient, .. } = conic;
        // Distance from the centre less 1, by the series of the root.
        let excess = (square.wrapping_sub(1 << PLACE) as i32) >> (PLACE - ONE.ilog2());
        let beyond = (excess - (scale(excess, excess) >> 2)) >> 1;
        // The gradient on the ellipse is as much less as the place is farther from the centre.
        let reach = scale(by_gradient.of(self.ratio), ONE + beyond);
        Some(Look {
            // The conic is the distance times half of 1 + 1 / radius.
            distance: scale(by_gradient.of(depth), ONE + ((beyond - (scale(beyond, beyond) >> 1)) >> 1)),
            cosines: (by_gradient.cosine(slope), by_gradient.cosine(across)),
            change: by_gradient.of(second),
            bend: scale(scale(scale(self.bend, reach), reach), reach),
            conic,
        })
    }

    /// The place on the axis through that of `conic`, so many px from it, which is near the ellipse.
    #[inline]
    pub fn view(&self, axis: Axis, conic: &Conic, along: i32) -> View {
        let Conic { place: (u, v), depth, slope, second, by_gradient } = *conic;
        let depth = depth + ((slope * along) >> 14) + ((second * ((along * along) >> 12)) >> 17);
        let [l0, l1, l2] = self.frame.map(|entry| entry >> 10);
        let (by_u, by_v) = if axis == Axis::Row { (l0, 0) } else { (l1, l2) };
        View {
            place: ((u << 1) + ((by_u * along) >> 13), (v << 1) + ((by_v * along) >> 13)),
            distance: by_gradient.of(depth.clamp(-DEEPEST, DEEPEST)),
            by_gradient,
        }
    }

    /// How far a place about the origin, px / 2, is outside, px: exact for a circle and near the ellipse. `None` where it is farther
    /// away than 16 px.
    #[inline(never)]
    pub fn distance(&self, place: (i32, i32)) -> Option<i32> {
        let ((u, v), square) = self.place(place)?;
        // The middle has no direction.
        let by_radius = Inverse::of_root(square)?;
        let direction = (by_radius.cosine(u), by_radius.cosine(v));
        let radius = (direction.0 * u + direction.1 * v) >> COARSE;
        // The conic is the distance times half of 1 + radius.
        let depth = ((self.depth(square)? >> 1) * ((1 << 28) / (ONE + radius).max(1))) >> 12;
        let (_, by_gradient) = self.gradient(direction, ONE.ilog2());
        Some(by_gradient?.of(depth.clamp(-MOST, MOST)).clamp(-MOST, MOST))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_ellipse() {
        for (a, b, theta) in
            [(5.0f32, 4.0f32, 0.3f32), (30.0, 21.0, 0.4), (30.0, 10.0, 1.2), (400.0, 300.0, 2.0)]
        {
            let (s, c) = libm::sincosf(theta);
            let (p, q) = (0.25 * a * a, 0.25 * b * b);
            let shape =
                Shape::from_moments(0.3, -0.4, p * c * c + q * s * s, (p - q) * s * c, p * s * s + q * c * c)
                    .unwrap();
            let trace = Trace::new(&shape, b).unwrap();
            let mut seen = 0;
            for i in 0..1000 {
                let (sin, cos) = libm::sincosf(i as f32 * 0.00628);
                let away = 1.0 + (i % 7 - 3) as f32 / (3.0 * b);
                let (u, v) = (a * cos * away, b * sin * away);
                let place =
                    (libm::roundf(2.0 * (u * c - v * s)) as i32, libm::roundf(2.0 * (u * s + v * c)) as i32);
                let (x, y) = (0.5 * place.0 as f32, 0.5 * place.1 as f32);
                let want = shape.distance(x, y).unwrap();
                let ((gx, gy), _) = shape.gradient(x, y);
                let norm = libm::sqrtf(gx * gx + gy * gy);
                let tolerance = 0.01 + 0.03 * want.abs() + a / 20_000.0;
                for (axis, gradient) in [(Axis::Row, gx), (Axis::Column, gy)] {
                    let Some(look) = trace.look(axis, place) else { continue };
                    seen += 1;
                    let distance = look.distance as f32 / PX as f32;
                    assert!(
                        (distance - want).abs() < 0.02 * want * want + tolerance,
                        "{a} {b} {theta} {i}: {distance} for {want}"
                    );
                    let cosine = look.cosines.0 as f32 / ONE as f32;
                    assert!((cosine - gradient / norm).abs() < 2e-3, "{cosine} for {}", gradient / norm);
                    let ((gx, gy), (dx, dy)) = shape.gradient(x, y);
                    let by_radius = libm::sqrtf(gx * dx + gy * dy) / norm;
                    let curvature = shape.det() * by_radius * by_radius * by_radius;
                    let bend = 2.0 * look.bend as f32 / BEND as f32;
                    let far = trace.distance(place).unwrap() as f32 / PX as f32;
                    assert!((far - want).abs() < tolerance, "{a} {b} {theta} {i}: {far} for {want}");
                    if i % 7 == 3 {
                        assert!(
                            (bend / curvature - 1.0).abs() < 0.05 + 2e-4 / curvature,
                            "{bend} for {curvature}"
                        );
                    }
                }
            }
            assert!(seen > 1900, "{seen}");
        }
    }
}
