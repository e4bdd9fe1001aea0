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
    pub fn step(&self, shape: &Shape, free: Free) -> Option<Shape> {
        const UNIT: f32 = 1.0 / (1 << (VALUE - TERM)) as f32;
        let first = free as usize;
        // The others are held by an equation each of their own.
        let m: Matrix<TERMS> = core::array::from_fn(|i| {
            core::array::from_fn(|j| match j < first {
                true => f32::from(u8::from(i == j)),
                false => self.m[i][j] as f32,
            })
        });
        let right = core::array::from_fn(|i| if i < first { 0.0 } else { self.right[i] as f32 * UNIT });
        Frame::new(shape)?.moved(shape, &Factor::new(&m)?.solve(right))
    }
}

/// What a step changes: the terms from this one on.
#[derive(Clone, Copy, Debug)]
pub(super) enum Free {
    All = 0,
    /// To a similar ellipse: only centre and size, as between concentric circles.
    Similar = 2,
}
