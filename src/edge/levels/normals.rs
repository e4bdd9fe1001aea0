//! Sums over the samples, and the levels that they tell.

use super::{BEYOND, CLIPPED_SLOPE, Levels, SLOPE, Sample};
use crate::fit::{Factor, Spread};
use crate::fixed::{GREY, ONE};
use crate::math;

/// Bits of the number of pixels as a weight, and of places in units of the target.
const WEIGHT: u32 = 3;
pub const TERM: u32 = 5;
/// Bits that the sums of lightness and of squares have less, for the room of a target of 16,000 crossings.
const LESS: u32 = 7;

/// Weighted sums over the samples on one side of the edges.
#[derive(Clone, Copy, Default)]
pub struct Side {
    weight: i32,
    lightness: i32,
    /// Of places, and of their products.
    x: i32,
    y: i32,
    xx: i32,
    xy: i32,
    yy: i32,
    /// Of what the levels before leave, by itself and with the places; and of its squares.
    residual: i32,
    residual_x: i32,
    residual_y: i32,
    squares: i32,
    /// Sum of the weights for one pixel.
    weights: i32,
}

impl Side {
    #[inline]
    pub fn add(&mut self, sample: &Sample, (x, y): (i32, i32), residual: i32) {
        let weight = (sample.flatness << sample.log) >> (ONE.ilog2() - WEIGHT);
        self.weight += weight;
        self.lightness += (weight * sample.lightness) >> LESS;
        let (wx, wy) = (weight * x, weight * y);
        self.x += wx;
        self.y += wy;
        self.xx += wx * x;
        self.xy += wx * y;
        self.yy += wy * y;
        let weighted = weight * residual;
        self.residual += weighted;
        let weighted = (weighted + (1 << (WEIGHT - 1))) >> WEIGHT;
        self.residual_x += weighted * x;
        self.residual_y += weighted * y;
        self.squares += (weighted * residual) >> LESS;
        self.weights += sample.flatness >> (ONE.ilog2() - WEIGHT);
    }
}

/// What the samples tell of the changes of dark, bright and the two slopes.
#[derive(Default)]
pub struct Normals {
    /// Dark and bright.
    pub sides: [Side; 2],
    pub spread: Spread,
    pub samples: u32,
    pub clipped: u32,
}

impl Normals {
    /// The levels after `before`; places are in units of `unit` px. All samples of a side have its mean lightness here: their own
    /// hardly differs, and what they leave is that from their own.
    #[inline(never)]
    pub fn solve(&self, before: &Levels, unit: f32) -> Option<Levels> {
        const PIXEL: f32 = 1.0 / (1 << WEIGHT) as f32;
        const PLACE: f32 = 1.0 / (1 << TERM) as f32;
        const LEVEL: f32 = 1.0 / GREY as f32;
        const MORE: f32 = (1 << LESS) as f32;
        let (mut m, mut right) = ([[0.0; 4]; 4], [0.0; 4]);
        let (mut squares, mut weights) = (0.0, 0.0);
        for side in &self.sides {
            let lightness = MORE * side.lightness as f32 / (ONE as f32 * side.weight.max(1) as f32);
            let level = (before.dark + before.contrast() * lightness) / SLOPE;
            let place = level * PIXEL * PLACE;
            let product = level * level * PIXEL * PLACE * PLACE;
            let [weight, x, y] = [PIXEL * side.weight as f32, place * side.x as f32, place * side.y as f32];
            let own = [1.0 - lightness, lightness];
            for i in 0..2 {
                for j in 0..=i {
                    m[i][j] += weight * own[i] * own[j];
                }
                m[2][i] += own[i] * x;
                m[3][i] += own[i] * y;
                right[i] += own[i] * PIXEL * LEVEL * side.residual as f32;
            }
            m[2][2] += product * side.xx as f32;
            m[3][2] += product * side.xy as f32;
            m[3][3] += product * side.yy as f32;
            right[2] += level * PLACE * LEVEL * side.residual_x as f32;
            right[3] += level * PLACE * LEVEL * side.residual_y as f32;
            squares += LEVEL * LEVEL * MORE * side.squares as f32;
            weights += PIXEL * side.weights as f32;
        }
        let factor = Factor::new(&m)?;
        let [dark, bright, gx, gy] = factor.solve(right);
        let scale = 1.0 / (SLOPE * unit);
        let variance = squares / weights;
        let of_slopes = variance * scale * scale;
        let [_, _, xx, xy] = factor.solve([0.0, 0.0, of_slopes, 0.0]);
        let [_, _, _, yy] = factor.solve([0.0, 0.0, 0.0, of_slopes]);
        let clipped = self.clipped > self.samples / 10;
        // Where the scale ends the light may change unseen.
        let most = CLIPPED_SLOPE / (unit - BEYOND);
        let unseen = if clipped { most * most } else { 0.0 };
        let (xx, yy) = (xx + unseen, yy + unseen);
        Some(Levels {
            dark: before.dark + dark,
            bright: before.bright + bright,
            gx: before.gx + gx * scale,
            gy: before.gy + gy * scale,
            slopes: (xx, xy, yy),
            noise: math::sqrt(variance),
            spread: self.spread.sigma(),
            pixels: PIXEL * self.sides.iter().fold(0, |sum, side| sum + side.weight) as f32,
            clipped,
        })
    }
}
