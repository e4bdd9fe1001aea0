//! A step of an ellipse towards points near it, in whole numbers: that of [`Adjustment`](crate::fit::Adjustment), without what
//! it tells of the uncertainty.

use super::gauge::{Look, NEAR};
use crate::fit::{Factor, Frame, Matrix, Shape};

/// Terms of the conic: (u^2 - v^2, 2 u v, u^2 + v^2, u, v).
const TERMS: usize = 5;
/// Bits after the point of u and v, of the terms, and of the conic's value.
const PLACE: u32 = NEAR;
const TERM: u32 = 10;
const VALUE: u32 = 13;
/// Points farther than two units from the centre are left out: terms have up to 12 bits, ...
const FARTHEST: i32 = 4 << (2 * PLACE);
/// ... and with the largest weight products keep within 32. They are exact, because what is rounded in one of two factors
/// would be the noise of a matrix that short arcs make nearly singular.
const MOST: u32 = 127;
/// Weight times squared gradient: where the gradient is largest, points have weights of 8 to 32.
const WEIGHT: u32 = 1 << 21;

/// Normal equations of the step, point by point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Normals {
    /// Lower triangle.
    m: Matrix<TERMS, i64>,
    right: [i64; TERMS],
    pub points: usize,
}

impl Normals {
    /// Adds a point near the ellipse.
    pub fn add(&mut self, look: &Look) {
        let Look { u, v, .. } = *look;
        let (uu, vv) = (u * u, v * v);
        if uu + vv >= FARTHEST {
            return;
        }
        let term = |square: i32| square >> (2 * PLACE - TERM);
        let terms = [term(uu - vv), term(2 * u * v), term(uu + vv), u >> (PLACE - TERM), v >> (PLACE - TERM)];
        let value = (uu + vv - (1 << (2 * PLACE))) >> (2 * PLACE - VALUE);
        let square = look.square_gradient::<PLACE>();
        let weight = (WEIGHT + square / 2).checked_div(square).map_or(MOST, |weight| weight.min(MOST)) as i32;
        for (i, row) in self.m.iter_mut().enumerate() {
            let weighted = weight * terms[i];
            for (entry, term) in row.iter_mut().zip(terms).take(i + 1) {
                *entry += i64::from(weighted * term);
            }
            self.right[i] -= i64::from(weighted) * i64::from(value);
        }
        self.points += 1;
    }

    /// Takes the step from the ellipse `shape` of the looks.
    pub fn step(&self, shape: &Shape) -> Option<Shape> {
        self.take::<0, TERMS>(shape)
    }

    /// Takes the step to a similar ellipse instead: only centre and size are free, as between concentric circles.
    pub fn similar(&self, shape: &Shape) -> Option<Shape> {
        self.take::<2, 3>(shape)
    }

    /// Takes the step in the `N` terms from `FIRST` on.
    fn take<const FIRST: usize, const N: usize>(&self, shape: &Shape) -> Option<Shape> {
        const UNIT: f32 = 1.0 / (1 << (VALUE - TERM)) as f32;
        let m: Matrix<N> =
            core::array::from_fn(|i| core::array::from_fn(|j| self.m[FIRST + i][FIRST + j] as f32));
        let right = core::array::from_fn(|i| self.right[FIRST + i] as f32 * UNIT);
        let solved = Factor::new(&m)?.solve(right);
        let mut step = [0.0; TERMS];
        step[FIRST..].copy_from_slice(&solved);
        Frame::new(shape)?.moved(shape, &step)
    }
}
