//! How far points lie from an ellipse, in whole numbers: on small processors a floating-point operation is a hundred
//! instructions or more, and a search asks for thousands of distances.

use super::points::Point;
use crate::fit::{Frame, Shape};

/// Points have 1/256 px.
pub(super) const PX: i32 = 256;
/// Squared distances have 1/1024 px^2.
const SQUARE: f32 = 1024.0;
/// Largest coordinate and coefficient: the sum of two products of them keeps within 32 bits.
const MOST: i32 = (1 << 15) - 1;
/// Largest coordinate in the frame where the ellipse is the unit circle: the same holds for these and coefficients.
const REACH: i32 = 3 << 13;
/// Farthest centre, 1/256 px.
const FARTHEST: u32 = 1 << 28;
/// Bits of a number whose square has no more than 32.
const HALF: u32 = 16;

/// Bits for distances: points up to 3 units of the ellipse are seen.
pub(super) const NEAR: u32 = 13;
/// Bits for what is around: up to 12 units.
pub(super) const AROUND: u32 = 11;

/// Bits of the gradient that its length does without, where q has `bits`.
const fn coarse(bits: u32) -> u32 {
    bits + 6
}

/// The square of a distance, px, in the unit of the gauge.
pub(super) const fn square(distance: f32) -> u32 {
    (distance * distance * SQUARE) as u32
}

/// An ellipse, as q = L (p - c) on the unit circle; q has `BITS` after the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gauge<const BITS: u32 = NEAR> {
    /// 1/256 px, less what rounds the difference to it.
    centre: (i32, i32),
    /// p - c has 2^-8 times 2^`coarser` px.
    coarser: u32,
    /// L, 2^-`exponent` px^-1.
    l: [i32; 3],
    exponent: i32,
    /// Products have this many bits more than q.
    excess: u32,
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
    /// For distances. `None` if `shape` is no ellipse or too narrow.
    pub fn new(shape: &Shape) -> Option<Self> {
        Self::of(shape)
    }
}

impl Gauge<AROUND> {
    /// Of [`radius`](Self::radius).
    pub const UNIT: i32 = 1 << AROUND;

    /// For what is around the ellipse.
    pub fn around(shape: &Shape) -> Option<Self> {
        Self::of(shape)
    }

    /// Radius of the similar ellipse through a point, with [`UNIT`](Self::UNIT) for the ellipse itself, and by how much it
    /// changes over 16 px.
    pub fn radius(&self, look: &Look) -> Option<(i32, i32)> {
        let Look { u, v, .. } = *look;
        let radius = root((u * u + v * v) as u32);
        // The gradient over the radius.
        let change = (root(look.square_gradient::<AROUND>()) << 17).checked_div(radius)?;
        let shift = u32::try_from(self.exponent + 13 - (coarse(AROUND) + AROUND) as i32).ok()?;
        Some((radius as i32, change.checked_shr(shift)? as i32))
    }
}

impl<const BITS: u32> Gauge<BITS> {
    #[inline(never)]
    fn of(shape: &Shape) -> Option<Self> {
        let Frame { l0, l1, l2 } = Frame::new(shape)?;
        let exponent = 14 - exponent(l0.max(l1.abs()).max(l2));
        let l = [l0, l1, l2].map(|l| (l * power(exponent)) as i32);
        // Largest coordinates within reach.
        let y = 1.0 / l2;
        let x = (1.0 + l1.abs() * y) / l0;
        let reach = (REACH >> BITS) as f32 * x.max(y);
        let coarser = (1 + self::exponent(reach) + 8 - 15).max(0);
        let excess = exponent + 8 - coarser - BITS as i32;
        let [cx, cy] = [shape.cx, shape.cy].map(|c| (c * PX as f32) as i32);
        let is_far = cx.unsigned_abs().max(cy.unsigned_abs()) > FARTHEST;
        // Also refuses what is infinite.
        if is_far || !(0..=40).contains(&exponent) || coarser >= 16 || !(0..31).contains(&excess) {
            return None;
        }
        let half = (1 << coarser) >> 1;
        let centre = (cx - half, cy - half);
        Some(Self { centre, coarser: coarser as u32, l, exponent, excess: excess as u32 })
    }

    /// The place `(x, y)`, 1/256 px, where the ellipse is the unit circle. `None` out of reach.
    fn place(&self, x: i32, y: i32) -> Option<(i32, i32)> {
        let from = |p: i32, c: i32| ((p - c) >> self.coarser).clamp(-MOST, MOST);
        let (dx, dy) = (from(x, self.centre.0), from(y, self.centre.1));
        let [l0, l1, l2] = self.l;
        let (u, v) = ((l0 * dx + l1 * dy) >> self.excess, (l2 * dy) >> self.excess);
        (u.abs() < REACH && v.abs() < REACH).then_some((u, v))
    }

    /// Whether `(x, y)`, 1/256 px, lies within `radius` units of the ellipse.
    pub fn is_within(&self, (x, y): (i32, i32), radius: i32) -> bool {
        let radius = radius << BITS;
        self.place(x, y).is_some_and(|(u, v)| u * u + v * v < radius * radius)
    }

    /// `None` out of reach.
    pub fn look(&self, point: &Point) -> Option<Look> {
        let (u, v) = self.place(point.x, point.y)?;
        let [l0, l1, l2] = self.l;
        let gradient = (l0 * u, l1 * u + l2 * v);
        let dark_inside = point.leads_to_light(gradient);
        Some(Look { u, v, gradient, dark_inside })
    }

    /// Squared distance from the ellipse to first order, 1/1024 px^2; the distance is good to 0.05 px, 3 % of itself and 1/4000
    /// of the major semi-axis together. `None` far away: beyond 2.5 px.
    pub fn square_distance(&self, look: &Look) -> Option<u32> {
        let Distance { excess, square } = self.distance(look)?;
        (excess * excess).checked_div(square)
    }

    /// The same before the division, which small processors do not have.
    fn distance(&self, look: &Look) -> Option<Distance> {
        let Look { u, v, .. } = *look;
        let excess = (u * u + v * v - (1 << (2 * BITS))).unsigned_abs();
        // 32 px times the gradient.
        let shift = u32::try_from((coarse(BITS) + BITS) as i32 - 4 - self.exponent).ok()?;
        let excess = excess.checked_shr(shift)?;
        let square = look.square_gradient::<BITS>();
        // What is not near need not be as precise.
        let (excess, square) =
            if excess >> HALF == 0 { (excess, square) } else { (excess >> 2, square >> 4) };
        (excess >> HALF == 0).then_some(Distance { excess, square })
    }

    /// That of a point beside which the light is on the side that `dark_inside` tells.
    #[inline(never)]
    pub fn square_distance_of(&self, point: &Point, dark_inside: bool) -> Option<u32> {
        self.square_distance(&self.look(point).filter(|look| look.dark_inside == dark_inside)?)
    }

    /// The same as a distance that only compares.
    pub fn distance_of(&self, point: &Point, dark_inside: bool) -> Option<Distance> {
        self.distance(&self.look(point).filter(|look| look.dark_inside == dark_inside)?)
    }
}

/// How far a point lies from an ellipse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Distance {
    /// Has [`HALF`] bits.
    excess: u32,
    /// Squared distances are its square over this.
    square: u32,
}

impl Distance {
    /// Whether its square is more than `limit`, below 2^16.
    pub fn exceeds(&self, limit: u32) -> bool {
        // Where the product would have more than 32 bits, no excess has a square as large.
        let most = self.square.min(u32::MAX / (limit + 1));
        self.square == 0 || self.excess * self.excess >= (limit + 1) * most
    }
}

impl Look {
    /// Square of the length of the gradient, in a unit of its own, where q has `BITS`.
    pub fn square_gradient<const BITS: u32>(&self) -> u32 {
        let side = |side: i32| (side.unsigned_abs() + (1 << (coarse(BITS) - 1))) >> coarse(BITS);
        let (x, y) = (side(self.gradient.0), side(self.gradient.1));
        x * x + y * y
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

/// Square root of a number of up to 31 bits, rounded down. That of `core` divides, which small processors cannot.
pub(super) fn root(square: u32) -> u32 {
    let (mut rest, mut root) = (square, 0);
    let mut bit = 1 << 30;
    while bit > rest {
        bit >>= 2;
    }
    while bit != 0 {
        let trial = root + bit;
        root >>= 1;
        if rest >= trial {
            rest -= trial;
            root += bit;
        }
        bit >>= 2;
    }
    root
}

/// The power of two at or below a positive number.
fn exponent(x: f32) -> i32 {
    (x.to_bits() >> 23) as i32 - 127
}

/// 2^`exponent`, for -126 to 127.
fn power(exponent: i32) -> f32 {
    f32::from_bits(((exponent.clamp(-126, 127) + 127) as u32) << 23)
}
