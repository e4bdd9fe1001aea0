//! An outline in pieces, and trial arcs of them.

use super::gauge::PX;
use super::points::Point;
use crate::fit::{Rough, Shape};
use crate::list::rolled;

/// Pieces of an outline of which trial arcs are made.
pub(super) const PIECES: usize = 16;
/// Distance of a piece's middle from the chord of those beside it that the scatter of the points can make, 1/256 px.
const SCATTER: i32 = PX / 2;

/// The unit of length of [`Rough`] sums.
pub(super) struct Unit {
    /// Coordinates of points have so many bits more.
    pub shift: u32,
    /// Largest coordinate, at least 1 px, in px.
    pub extent: f32,
}

impl Unit {
    pub fn of(points: &[Point]) -> Self {
        let largest =
            |extent: u32, point: &Point| extent.max(point.x.unsigned_abs()).max(point.y.unsigned_abs());
        let extent = rolled(points).fold(PX as u32, largest);
        let shift = (u32::BITS - extent.leading_zeros()).saturating_sub(Rough::BITS);
        Self { shift, extent: extent as f32 / PX as f32 }
    }

    pub fn add(&self, sum: &mut Rough, point: &Point) {
        sum.add(point.x >> self.shift, point.y >> self.shift);
    }

    /// The ellipse of sums, px.
    pub fn fit(&self, sum: &Rough) -> Option<Shape> {
        let unit = (1u32 << (Rough::BITS + self.shift).min(31)) as f32 / PX as f32;
        Some(sum.fit()?.scaled(unit))
    }
}

/// Sums of the first pieces of an outline: none, one, two ...
pub(super) struct Pieces([Rough; PIECES + 1]);

impl Pieces {
    pub fn new(points: &[Point], unit: &Unit) -> Self {
        let mut first = [Rough::default(); PIECES + 1];
        let (mut sum, mut rest) = (Rough::default(), points.iter().enumerate().peekable());
        for (piece, first) in first.iter_mut().enumerate() {
            while let Some((_, point)) = rest.next_if(|(i, _)| i * PIECES < piece * points.len()) {
                unit.add(&mut sum, point);
            }
            *first = sum;
        }
        Self(first)
    }

    /// Sum of `length` pieces from `start` on, around the outline.
    pub fn sum(&self, start: usize, length: usize) -> Rough {
        let none = Rough::default();
        let first = |count: usize| self.0.get(count).unwrap_or(&none);
        let mut sum = *first((start + length).min(PIECES));
        sum.remove(first(start));
        if let Some(wrapped) = (start + length).checked_sub(PIECES) {
            sum.join(first(wrapped));
        }
        sum
    }

    /// Where the outline turns to either side.
    pub fn turns(&self, unit: &Unit) -> Turns {
        let mut turns = Turns { left: 0, right: 0 };
        let scatter = (SCATTER >> unit.shift).max(1);
        let middle = |piece: usize| {
            let piece = piece % PIECES;
            self.0.get(piece + 1)?.mean_without(self.0.get(piece)?)
        };
        for piece in 0..PIECES {
            let [Some(a), Some(b), Some(c)] = [piece + PIECES - 1, piece, piece + 1].map(middle) else {
                continue;
            };
            let ((x, y), (along_x, along_y)) = ((b.0 - a.0, b.1 - a.1), (c.0 - a.0, c.1 - a.1));
            let turn = along_x * y - along_y * x;
            // Not less than the length of the chord.
            let chord = along_x.abs().max(along_y.abs()) + along_x.abs().min(along_y.abs()) / 2;
            if turn.abs() > scatter * chord {
                *(if turn > 0 { &mut turns.left } else { &mut turns.right }) |= 1 << piece;
            }
        }
        turns
    }
}

/// The pieces at which an outline turns to the left and to the right, one bit each: an ellipse does only one of both.
pub(super) struct Turns {
    left: u16,
    right: u16,
}

impl Turns {
    /// Whether it turns to both sides within `length` pieces from `start` on.
    pub fn are_both(&self, start: usize, length: usize) -> bool {
        let within = (u16::MAX >> (PIECES + 2 - length)).rotate_left(start as u32 + 1);
        self.left & within != 0 && self.right & within != 0
    }
}
