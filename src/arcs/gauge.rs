//! How far points lie from an ellipse, in whole numbers: on small processors a floating-point operation is a hundred
//! instructions or more, and a search asks for thousands of distances.

use super::points::Point;
use crate::fit::{Frame, Shape};

/// Points have 1/256 px, and so have distances.
pub(super) const PX: i32 = 256;
/// Largest coordinate and coefficient: the sum of two products of them keeps within 32 bits.
const MOST: i32 = (1 << 15) - 1;
/// Largest coordinate in the frame where the ellipse is the unit circle: the same holds for these and coefficients.
const REACH: i32 = 3 << 13;
/// Bits of the gradient that its length does without.
const COARSE: u32 = 16;
/// Farthest distance that is told.
const FAR: u32 = 4 * PX as u32;

/// An ellipse, as q = L (p - c) on the unit circle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gauge {
    /// 1/256 px.
    centre: (i32, i32),
    /// p - c has 2^-8 times 2^`coarser` px.
    coarser: u32,
    /// L, 2^-`exponent` px^-1.
    l: [i32; 3],
    exponent: i32,
    /// Products have this many bits more than q.
    excess: u32,
    /// q has this many bits after the point.
    bits: u32,
}

/// A point as seen from an ellipse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Where the ellipse is the unit circle, in the unit of the gauge.
    pub u: i32,
    pub v: i32,
    /// The gradient q' L, in a unit of its own.
    gradient: (i32, i32),
    /// Whether the light beside the point is outside.
    pub dark_inside: bool,
}

impl Gauge {
    /// Bits for distances: points up to 3 units of the ellipse are seen.
    const NEAR: u32 = 13;
    /// Bits for what is around: up to 12 units.
    const AROUND: u32 = 11;

    /// For distances. `None` if `shape` is no ellipse or too narrow.
    pub fn new(shape: &Shape) -> Option<Self> {
        Self::with_bits(shape, Self::NEAR)
    }

    /// For what is around the ellipse.
    pub fn around(shape: &Shape) -> Option<Self> {
        Self::with_bits(shape, Self::AROUND)
    }

    fn with_bits(shape: &Shape, bits: u32) -> Option<Self> {
        let Frame { l0, l1, l2 } = Frame::new(shape)?;
        let exponent = 14 - exponent(l0.max(l1.abs()).max(l2));
        let l = [l0, l1, l2].map(|l| (l * power(exponent)) as i32);
        // Largest coordinates within reach.
        let y = 1.0 / l2;
        let x = (1.0 + l1.abs() * y) / l0;
        let reach = (REACH >> bits) as f32 * x.max(y);
        let coarser = (1 + self::exponent(reach) + 8 - 15).max(0);
        let excess = exponent + 8 - coarser - bits as i32;
        let place = |c: f32| (c * PX as f32) as i32;
        // Also refuses what is infinite.
        ((0..=40).contains(&exponent) && coarser < 16 && (0..31).contains(&excess)).then_some(Self {
            centre: (place(shape.cx), place(shape.cy)),
            coarser: coarser as u32,
            l,
            exponent,
            excess: excess as u32,
            bits,
        })
    }

    /// The place `(x, y)`, 1/256 px, where the ellipse is the unit circle. `None` out of reach.
    fn place(&self, x: i32, y: i32) -> Option<(i32, i32)> {
        let half = (1 << self.coarser) >> 1;
        let from =
            |p: i32, c: i32| (p.saturating_sub(c).saturating_add(half) >> self.coarser).clamp(-MOST, MOST);
        let (dx, dy) = (from(x, self.centre.0), from(y, self.centre.1));
        let [l0, l1, l2] = self.l;
        let (u, v) = ((l0 * dx + l1 * dy) >> self.excess, (l2 * dy) >> self.excess);
        (u.abs() < REACH && v.abs() < REACH).then_some((u, v))
    }

    /// Whether `(x, y)`, 1/256 px, lies within `radius` units of the ellipse.
    pub fn is_within(&self, (x, y): (i32, i32), radius: i32) -> bool {
        let radius = radius << self.bits;
        self.place(x, y).is_some_and(|(u, v)| u * u + v * v < radius * radius)
    }

    /// `None` out of reach.
    pub fn look(&self, point: &Point) -> Option<Look> {
        let (u, v) = self.place(point.x, point.y)?;
        let [l0, l1, l2] = self.l;
        let gradient = (l0 * u, l1 * u + l2 * v);
        let outward = if point.is_on_row { gradient.0 } else { gradient.1 };
        let dark_inside = if point.is_rising { outward > 0 } else { outward < 0 };
        Some(Look { u, v, gradient, dark_inside })
    }

    /// Distance from the ellipse to first order, 1/256 px. `None` beyond 4 px.
    pub fn distance(&self, look: &Look) -> Option<u32> {
        let Look { u, v, .. } = *look;
        let (x, y) = look.coarse_gradient();
        let excess = u * u + v * v - (1 << (2 * self.bits));
        let shift = self.exponent - self.bits as i32 - 9;
        let excess = excess.unsigned_abs();
        let excess = if shift < 0 {
            excess >> -shift
        } else if excess.leading_zeros() as i32 > shift {
            excess << shift
        } else {
            return None;
        };
        // Sooner than by a root and a quotient.
        if excess > FAR * (x + y) {
            return None;
        }
        excess.checked_div((x * x + y * y).isqrt()).filter(|&distance| distance <= FAR)
    }

    /// Distance of a point beside which the light is on the side that `dark_inside` tells.
    pub fn distance_of(&self, point: &Point, dark_inside: bool) -> Option<u32> {
        self.distance(&self.look(point).filter(|look| look.dark_inside == dark_inside)?)
    }

    /// Radius of the similar ellipse through a point, with [`UNIT`](Self::UNIT) for the ellipse itself, and by how much it
    /// changes for each px.
    pub fn radius(&self, look: &Look) -> Option<(i32, i32)> {
        let Look { u, v, .. } = *look;
        let (x, y) = look.coarse_gradient();
        let radius = ((u * u + v * v) as u32).isqrt();
        // The gradient over the radius.
        let change = ((x * x + y * y).isqrt() << 14).checked_div(radius)?;
        let shift = u32::try_from(self.exponent - 2 - self.bits as i32).ok()?;
        Some((radius as i32, change.checked_shr(shift)? as i32))
    }

    /// Of [`radius`](Self::radius) where the gauge is for what is around.
    pub const UNIT: i32 = 1 << Self::AROUND;
}

impl Look {
    fn coarse_gradient(&self) -> (u32, u32) {
        (self.gradient.0.unsigned_abs() >> COARSE, self.gradient.1.unsigned_abs() >> COARSE)
    }

    /// The bit of the one of 32 sectors in which it lies.
    pub fn sector(&self) -> u32 {
        // Tangents of a quarter, a half and three quarters of 45 degrees.
        const TANGENTS: [i32; 3] = [204, 424, 684];
        let (u, v) = (self.u.abs(), self.v.abs());
        let (most, least) = (u.max(v), u.min(v));
        let quarters = TANGENTS.iter().filter(|tangent| least << 10 > most * **tangent).count() as u32;
        let octant = u32::from(self.u < 0) << 2 | u32::from(self.v < 0) << 1 | u32::from(u < v);
        1 << (octant << 2 | quarters)
    }
}

/// The power of two at or below a positive number.
fn exponent(x: f32) -> i32 {
    (x.to_bits() >> 23) as i32 - 127
}

/// 2^`exponent`, for -126 to 127.
fn power(exponent: i32) -> f32 {
    f32::from_bits(((exponent.clamp(-126, 127) + 127) as u32) << 23)
}
