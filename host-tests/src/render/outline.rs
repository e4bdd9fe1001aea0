//! Closed outlines made of arcs and straight lines.

use glam::DVec2;
use std::f64::consts::TAU;

/// One piece of an outline, traversed for t from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub enum Piece {
    /// From one point straight to another.
    Line {
        /// Start.
        from: DVec2,
        /// End.
        to: DVec2,
    },
    /// Part of a circle.
    Arc {
        /// Centre of the circle.
        centre: DVec2,
        /// Radius of the circle.
        radius: f64,
        /// Direction of the start from +x towards +y, radians.
        start: f64,
        /// Angle traversed, radians, positive from +x towards +y.
        sweep: f64,
    },
}

impl Piece {
    /// The point at `t` and the derivative by `t`.
    pub fn at(&self, t: f64) -> (DVec2, DVec2) {
        match *self {
            Piece::Line { from, to } => (from + (to - from) * t, to - from),
            Piece::Arc { centre, radius, start, sweep } => {
                let spoke = DVec2::from_angle(start + sweep * t) * radius;
                (centre + spoke, spoke.perp() * sweep)
            }
        }
    }

    /// Angle through which the direction turns, radians.
    pub fn turn(&self) -> f64 {
        match *self {
            Piece::Line { .. } => 0.0,
            Piece::Arc { sweep, .. } => sweep.abs(),
        }
    }

    fn placed(&self, centre: DVec2, angle: f64, scale: f64) -> Self {
        let turn = DVec2::from_angle(angle);
        let place = |p: DVec2| centre + turn.rotate(p) * scale;
        match *self {
            Piece::Line { from, to } => Piece::Line { from: place(from), to: place(to) },
            Piece::Arc { centre, radius, start, sweep } => {
                Piece::Arc { centre: place(centre), radius: radius * scale, start: start + angle, sweep }
            }
        }
    }
}

/// A closed outline without self-intersection: each piece starts where the one before it ends. Either sense
/// of rotation encloses the same area.
#[derive(Clone, Debug)]
pub struct Outline {
    pieces: Vec<Piece>,
}

impl Outline {
    /// The pieces in order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// A circle.
    pub fn circle(centre: DVec2, radius: f64) -> Self {
        Self { pieces: vec![Piece::Arc { centre, radius, start: 0.0, sweep: TAU }] }
    }

    /// The polygon with these corners.
    pub fn polygon(corners: &[DVec2]) -> Self {
        let next = corners.iter().cycle().skip(1);
        Self { pieces: corners.iter().zip(next).map(|(&from, &to)| Piece::Line { from, to }).collect() }
    }

    /// The rectangle with these half sides, parallel to the axes.
    pub fn rectangle(centre: DVec2, half_x: f64, half_y: f64) -> Self {
        let corner = |sx: f64, sy: f64| centre + DVec2::new(sx * half_x, sy * half_y);
        Self::polygon(&[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
    }

    /// A ring about the origin from which the sector from `-gap / 2` to `gap / 2` (radians) is missing.
    pub fn open_ring(outer: f64, inner: f64, gap: f64) -> Self {
        let (start, sweep) = (gap / 2.0, TAU - gap);
        let (first, last) = (DVec2::from_angle(start), DVec2::from_angle(start + sweep));
        let arc = |radius, start, sweep| Piece::Arc { centre: DVec2::ZERO, radius, start, sweep };
        Self {
            pieces: vec![
                arc(outer, start, sweep),
                Piece::Line { from: last * outer, to: last * inner },
                arc(inner, start + sweep, -sweep),
                Piece::Line { from: first * inner, to: first * outer },
            ],
        }
    }

    /// Scaled about the origin, turned by `angle` radians from +x towards +y, moved to `centre`.
    pub fn placed(&self, centre: DVec2, angle: f64, scale: f64) -> Self {
        Self { pieces: self.pieces.iter().map(|piece| piece.placed(centre, angle, scale)).collect() }
    }
}
