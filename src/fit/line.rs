//! Where the axis of a crossing passes an ellipse, in integers: for an image without distortion.

use super::shape::{Frame, Shape};
use crate::fixed::{BEND, Inverse, ONE, PX, fixed, scale, wide};
use crate::math;

/// Bits of the frame of an ellipse, and of places in it.
const FRAME: u32 = 30;
pub(crate) const PLACE: u32 = 26;
/// The same for a look that need not be exact.
const COARSE: u32 = 22;
/// Farthest place in the frame that is looked at.
const FARTHEST: u32 = 11 << (PLACE - 2);
/// Bits of the frame of an ellipse for half a pixel, so that places in it may wrap: they are less than 4.
const HALF: u32 = 29;
/// Farthest from the ellipse, 1/8192 px: where the axis passes the middle of the ellipse.
const DEEPEST: i32 = 50_000;
/// Half the reciprocal of the least half chord on an axis, 1/px.
const TIGHTEST: i32 = BEND * 4 / 7;
/// Largest change of the cosine along the axis, 1/px.
const BENT: i32 = BEND * 2 / 5;
/// Half the conic in units of the semi-minor axis beyond which no distance is told, px.
const AWAY: i32 = 15 * PX;
/// Largest distances that are told from each other, px, and farthest that the nearest place on an ellipse lies aside.
const DISTANT: i32 = 11 * PX;
const ASIDE: i32 = 8 * PX;
/// Least |cosine| of an axis of which a pixel can be nearer to the edge than along the other axis.
const LEAST_COSINE: i32 = ONE * 7 / 20;
/// Farthest that an axis is followed to the ellipse, px.
const REACH: i32 = 3 << 13;

/// The place where an axis passes an ellipse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    /// On the axis, from the middle of the crossing, px.
    pub at: i32,
    /// Cosines of the outward normal along and across the axis, and how they change along it, 1/px, before that is normalised.
    pub cosines: (i32, i32),
    pub change: (i32, i32),
    /// Half the curvature of the ellipse, 1/px.
    pub bend: i32,
    /// 1 / length of the conic's gradient, in units of its semi-major axis.
    pub reach: i32,
    /// The place in the frame where the ellipse is the unit circle.
    pub direction: (i32, i32),
}

impl Passage {
    /// For each place on the axis, px from the middle and 1 px apart: whether it is nearer to this edge than to the other side of
    /// the ellipse, and the axis the steeper one there. So each pixel counts once, though rows and columns both pass it.
    #[inline]
    pub fn owns<const N: usize>(&self, first: i32) -> [bool; N] {
        let steps = N as i32 - 1;
        // Far from where the axes are equally steep nothing else needs to be looked at.
        let farthest = (steps * (PX / 2) + self.at.abs()) >> 6;
        let bent = ((self.change.0.abs() + self.change.1.abs()) * farthest) >> 8;
        if self.cosines.0.abs() - self.cosines.1.abs() > bent {
            return [true; N];
        }
        let from = first - self.at;
        let start = |cosine: i32, change: i32| (cosine << 2) + ((change * from) >> 12);
        let mut along = start(self.cosines.0, self.change.0);
        let mut across = start(self.cosines.1, self.change.1);
        let outwards = self.cosines.0 > 0;
        let owned = |along: i32, across: i32| along.abs() >= across.abs() && (along > 0) == outwards;
        // Those that are owned lie side by side.
        if owned(along, across) && owned(along + steps * self.change.0, across + steps * self.change.1) {
            return [true; N];
        }
        let mut owns = [false; N];
        for own in &mut owns {
            *own = owned(along, across);
            along += self.change.0;
            across += self.change.1;
        }
        owns
    }
}

/// An ellipse as rows, or columns, pass it: coordinates along and across these.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Its centre, px, and its frame, 1/px.
    centre: (i32, i32),
    frame: [i32; 3],
    /// The same frame for half a pixel, and the centre in it.
    half_frame: [i32; 3],
    half_centre: (i32, i32),
    /// Half of that half chord of an axis which passes the centre, px.
    half_chord: i32,
    /// The same frame in units of the semi-minor axis.
    by_minor: [i32; 3],
    /// Second derivatives of half the conic, along twice and along and across, in units of the semi-minor axis.
    second: (i32, i32),
    minor: i32,
    /// Semi-minor axis over semi-major axis.
    ratio: i32,
    /// Half the largest curvature, 1/px.
    bend: i32,
    /// From its frame to that of the outline.
    turn: [i32; 4],
}

impl Line {
    /// For rows, whose frame is `row`, and for columns; `minor` is the semi-minor axis, px. `None` if it is no ellipse.
    pub fn both(shape: &Shape, row: &Frame, minor: f32) -> Option<[Self; 2]> {
        let column = Frame::new(&shape.transposed())?;
        let across = 1.0 / (column.l0 * column.l2);
        let turn = [
            row.l1 / column.l0,
            row.l0 / column.l2 - row.l1 * column.l1 * across,
            row.l2 / column.l0,
            -row.l2 * column.l1 * across,
        ];
        Some([
            Self::new(shape, row, minor, [1.0, 0.0, 0.0, 1.0]),
            Self::new(&shape.transposed(), &column, minor, turn),
        ])
    }

    /// For rows, about the ellipse's centre: `None` if it is none.
    pub fn of_rows(shape: &Shape, minor: f32) -> Option<Self> {
        Some(Self::new(shape, &Frame::new(shape)?, minor, [1.0, 0.0, 0.0, 1.0]))
    }

    fn new(shape: &Shape, frame: &Frame, minor: f32, turn: [f32; 4]) -> Self {
        let place = frame.vector(shape.cx, shape.cy);
        let frame = [frame.l0, frame.l1, frame.l2];
        let [l0, l1, _] = frame;
        let ratio = minor * minor * math::sqrt(shape.det());
        Self {
            centre: (fixed(shape.cx, PX), fixed(shape.cy, PX)),
            frame: frame.map(|entry| fixed(entry, 1 << FRAME)),
            half_frame: frame.map(|entry| fixed(entry, 1 << (HALF - 1))),
            half_centre: (fixed(place.0, 1 << HALF), fixed(place.1, 1 << HALF)),
            half_chord: fixed(0.5 / l0, PX),
            by_minor: frame.map(|entry| fixed(minor * entry, 1 << 15)),
            second: (fixed(minor * l0 * l0, BEND), fixed(minor * l0 * l1, BEND)),
            minor: fixed(minor, PX),
            ratio: fixed(ratio, ONE),
            bend: fixed(0.5 / (minor * ratio), BEND),
            turn: turn.map(|entry| fixed(entry, ONE)),
        }
    }
    /// A place from the centre, px, from that about the origin, in 1/2 px.
    pub fn about_centre(&self, (along, across): (i32, i32)) -> (i32, i32) {
        ((along << 11) - self.centre.0, (across << 11) - self.centre.1)
    }

    /// The centre, px.
    pub fn centre(&self) -> (i32, i32) {
        self.centre
    }

    /// The semi-minor axis, px.
    pub fn minor(&self) -> i32 {
        self.minor
    }

    /// Where the axis through a place near the ellipse, px / 2 about the origin, passes it. `None` where it misses it, or nearly.
    #[inline]
    pub fn passage(&self, (along, across): (i32, i32)) -> Option<Passage> {
        let [l0, l1, l2] = self.half_frame;
        let u = l0.wrapping_mul(along).wrapping_add(l1.wrapping_mul(across)).wrapping_sub(self.half_centre.0);
        let v = l2.wrapping_mul(across).wrapping_sub(self.half_centre.1);
        let (u, v) = (u >> (HALF - PLACE), v >> (HALF - PLACE));
        // On the axis only u changes: its square there.
        let passed = (1 << PLACE) - place_square(v);
        let inverse = Inverse::of_root((passed.max(0) as u32) << 2)?;
        let depth = wide(passed - place_square(u), self.half_chord, PLACE - 1);
        if depth.abs() > DEEPEST {
            return None;
        }
        // To be solved: at = first + half * at^2, outwards. Both roundings are down.
        let (first, half) = (inverse.of(depth) + 1, inverse.of(l0 >> (HALF - 16)));
        if first.abs() > REACH || half > TIGHTEST {
            return None;
        }
        let edge = inverse.of(passed >> (PLACE - 14));
        let nearly = (((edge - (u.abs() >> (PLACE - 14))) * self.half_chord) >> 12).min(REACH);
        let at = first + ((half * ((nearly * nearly) >> 13) + (1 << 15)) >> 16);
        let sign = if u < 0 { -1 } else { 1 };
        let (u, v) = (sign * edge, v >> (PLACE - 14));
        let [m0, m1, m2] = self.by_minor;
        let gradient = ((m0 * u) >> 15, (m1 * u + m2 * v) >> 15);
        let inverse = Inverse::of_root(square(gradient))?;
        let cosines = (inverse.cosine(gradient.0), inverse.cosine(gradient.1));
        let change = (inverse.of(self.second.0), inverse.of(self.second.1));
        if cosines.0.abs() < LEAST_COSINE || change.0 > BENT {
            return None;
        }
        let reach = inverse.of(self.ratio);
        Some(Passage {
            at: (sign * at + 1) >> 1,
            cosines,
            change,
            bend: scale(scale(scale(self.bend, reach), reach), reach),
            reach,
            direction: self.turned((u, v)),
        })
    }

    /// A place, px from the centre, as the ellipse has it. `None` far away.
    #[inline]
    pub fn look(&self, (along, across): (i32, i32)) -> Option<Look> {
        let [l0, l1, l2] = self.frame;
        let sum = i64::from(l0) * i64::from(along) + i64::from(l1) * i64::from(across);
        let (u, v) = ((sum >> 16) as i32, wide(l2, across, 16));
        if u.unsigned_abs() > FARTHEST || v.unsigned_abs() > FARTHEST {
            return None;
        }
        let excess = wide(u, u, PLACE) + wide(v, v, PLACE) - (1 << PLACE);
        let (u, v) = (u >> (PLACE - 14), v >> (PLACE - 14));
        let [m0, m1, m2] = self.by_minor;
        Some(Look { place: (u, v), excess, gradient: ((m0 * u) >> 15, (m1 * u + m2 * v) >> 15) })
    }

    /// Distance of a place, px from the centre, from the ellipse, positive outside, and half the curvature of the nearest place on
    /// it: exact near the ellipse and for a circle. `None` far away.
    pub fn distance(&self, (along, across): (i32, i32)) -> Option<(i32, i32)> {
        let Look { excess, gradient, .. } = self.look((along, across))?;
        let depth = wide(excess, self.minor, PLACE + 1);
        if depth.abs() > AWAY {
            return None;
        }
        let radius_square = excess + (1 << PLACE);
        let inverses = Inverse::of_root((radius_square as u32) << 2).zip(Inverse::of_root(square(gradient)));
        // The middle has no direction.
        let Some((by_radius, by_gradient)) = inverses else {
            return Some(((-self.minor).max(-DISTANT), self.bend));
        };
        let (radius, by_radius) = (by_radius.of(radius_square >> (PLACE - 13)) << 1, by_radius.of(ONE));
        let depth = wide(by_gradient.of(depth), (2 << 28) / (ONE + by_radius).max(1), 14);
        let reach = scale(by_gradient.of(self.ratio), radius);
        let bend = scale(scale(scale(self.bend, reach), reach), reach);
        // The place in the same direction from the centre is not the nearest one: the ellipse curves away between them.
        let tangential = wide(along, by_gradient.cosine(gradient.1), 14)
            - wide(across, by_gradient.cosine(gradient.0), 14);
        let aside = wide(tangential, ONE - by_radius, 14).clamp(-ASIDE, ASIDE);
        let distance = depth + wide(bend, (aside * aside) >> 12, 16);
        Some((distance.clamp(-DISTANT, DISTANT), bend))
    }

    fn turned(&self, (u, v): (i32, i32)) -> (i32, i32) {
        let [uu, uv, vu, vv] = self.turn;
        ((u * uu + v * uv) >> 14, (u * vu + v * vv) >> 14)
    }
}

/// A place as an ellipse has it.
pub(crate) struct Look {
    /// In the frame where the ellipse is the unit circle.
    pub place: (i32, i32),
    /// The conic: the square of that, less 1.
    pub excess: i32,
    /// Half its gradient along and across the axis, in units of the semi-minor axis.
    pub gradient: (i32, i32),
}

/// Square of a place in the frame, with as many bits.
#[inline]
fn place_square(x: i32) -> i32 {
    const LOW: u32 = PLACE / 2;
    let (high, low) = (x >> LOW, x & ((1 << LOW) - 1));
    high * high + ((high * low) >> (LOW - 1))
}

/// Square of a vector's length.
fn square((x, y): (i32, i32)) -> u32 {
    x.unsigned_abs().pow(2) + y.unsigned_abs().pow(2)
}

/// An ellipse grown by some width, which tells on which side of it a place is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    centre: (i32, i32),
    frame: [i32; 3],
}

impl Border {
    /// For rows and for columns. `None` if the ellipse is not larger than the width by which it shrinks.
    pub fn both(shape: &Shape, width: f32) -> Option<[Self; 2]> {
        let grown = shape.widened(width)?;
        let border = |shape: &Shape| {
            let Frame { l0, l1, l2 } = Frame::new(shape)?;
            Some(Self {
                centre: (fixed(shape.cx, 4), fixed(shape.cy, 4)),
                frame: [l0, l1, l2].map(|entry| fixed(entry, 1 << COARSE)),
            })
        };
        Some([border(&grown)?, border(&grown.transposed())?])
    }

    /// The place, 1/4 px about the origin, in the frame.
    #[inline]
    fn place(&self, (along, across): (i32, i32)) -> (i32, i32) {
        let [l0, l1, l2] = self.frame;
        let (along, across) = (along - self.centre.0, across - self.centre.1);
        let bounded = |x: i32| (x >> (COARSE + 2 - 14)).clamp(-2 * ONE, 2 * ONE - 1);
        (bounded(l0 * along + l1 * across), bounded(l2 * across))
    }

    /// Whether the place `along`, px / 4, lies inside.
    pub fn contains(&self, along: i32, across: i32) -> bool {
        let (u, v) = self.place((along, across));
        is_inside(u, v)
    }

    /// Whether any place between these two on the axis lies inside.
    pub fn meets(&self, (from, to): (i32, i32), across: i32) -> bool {
        let ((a, v), (b, _)) = (self.place((from, across)), self.place((to, across)));
        // On the axis only u changes.
        let nearest = if (a < 0) != (b < 0) { 0 } else { a.abs().min(b.abs()) };
        is_inside(nearest, v)
    }
}

fn is_inside(u: i32, v: i32) -> bool {
    (u * u) as u32 + (v * v) as u32 <= 1 << 28
}
