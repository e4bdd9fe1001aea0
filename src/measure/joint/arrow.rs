//! Normal equations of all ellipses and of what they share: an arrow of 5 x 5 blocks, summed up in integers.
//!
//! In the units of the sums, a unit of an outline's terms moves its edge by half its semi-major axis, the light's slopes are those
//! over [`Scene::unit`] with 256 grey levels, and the logarithm of the blur changes levels by the contrast.

use super::part::{Here, Part, RIGHT_BITS, Residuals, SLOPE_BITS, SQUARE_BITS, Stretches, Sums, mean_of};
use super::scene::Scene;
use super::solve::{Shared, Solved};
use crate::appearance::{OWN, SHARED};
use crate::fit::Matrix;
use crate::fixed::{GREY, scale};
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// An outline's part.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Block {
    pub m: Matrix<OWN, i32>,
    pub right: [i64; OWN],
    /// Rows: the conic's terms; columns: what is shared.
    pub cross: [[i32; SHARED]; OWN],
    /// Of the crossings: squared products of the residuals with the change by the place of the edge, and squares of that.
    pub residuals: i64,
    pub squares: i32,
    /// Inverse variances of the edge points, and their number.
    pub information: i32,
    pub points: u16,
}

impl Block {
    fn add(&mut self, part: &Part, sums: &Sums, here: &Here) {
        for (sum, right) in self.right.iter_mut().zip(part.right) {
            *sum += i64::from(right);
        }
        self.residuals += i64::from(part.scatter);
        self.points = self.points.saturating_add(part.crossings as u16);
        let Sums { p, lp, bp, pp, .. } = *sums;
        self.squares += pp * part.crossings;
        let Here { light, unit, terms, .. } = *here;
        let square = scale(scale(unit, unit), pp);
        let [dark, bright, x, y] = here.with_levels(scale(p, unit), scale(lp, unit));
        let shared = [dark, bright, x, y, scale(scale(bp, unit), light)];
        for ((row, cross), term) in self.m.iter_mut().zip(&mut self.cross).zip(terms) {
            let own = scale(square, term);
            // Above the diagonal too: loops of one length take fewer instructions.
            for (sum, other) in row.iter_mut().zip(terms) {
                *sum += here.all(own, other);
            }
            for (sum, shared) in cross.iter_mut().zip(shared) {
                *sum += here.all(term, shared);
            }
        }
        self.information += here.all(scale(light, light), pp);
    }
}

/// What the far stretches of one side tell: the sums over their pixels of the products of 1, the place, and the residual.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    n: i32,
    x: i32,
    y: i32,
    xx: i32,
    xy: i32,
    yy: i32,
    r: i64,
    rx: i64,
    ry: i64,
}

/// Bits of places in these.
const PLACE_BITS: u32 = 9;

impl Side {
    fn add(&mut self, all: &Stretches, scene: &Scene<'_>) {
        let mean = mean_of(all.n);
        let place = |sum: i32| scene.place(mean(sum)) >> (14 - PLACE_BITS);
        let (x, y) = (place(all.x), place(all.y));
        let (nx, ny) = (all.n * x, all.n * y);
        self.n += all.n;
        self.x += nx;
        self.y += ny;
        self.xx += (nx * x) >> PLACE_BITS;
        self.xy += (nx * y) >> PLACE_BITS;
        self.yy += (ny * y) >> PLACE_BITS;
        self.r += i64::from(all.r);
        self.rx += i64::from(all.r) * i64::from(x);
        self.ry += i64::from(all.r) * i64::from(y);
    }

    /// Equations of the level and of the light's slopes, which change the side's level by `level`, where the light has the slopes
    /// `(gx, gy)`.
    pub fn equations(&self, level: f32, (gx, gy): (f32, f32)) -> ([[f32; 3]; 3], [f32; 3]) {
        let one = (1 << PLACE_BITS) as f32;
        let [x, y, xx, xy, yy] = [self.x, self.y, self.xx, self.xy, self.yy].map(|sum| sum as f32 / one);
        let [rx, ry] = [self.rx, self.ry].map(|sum| sum as f32 / one);
        let (n, r) = (self.n as f32, self.r as f32);
        let (lx, ly) = (x + gx * xx + gy * xy, y + gx * xy + gy * yy);
        let square = n + gx * (x + lx) + gy * (y + ly);
        let level_square = level * level;
        let grey = 1.0 / GREY as f32;
        (
            [
                [square, 0.0, 0.0],
                [level * lx, level_square * xx, 0.0],
                [level * ly, level_square * xy, level_square * yy],
            ],
            [grey * (r + gx * rx + gy * ry), grey * level * rx, grey * level * ry],
        )
    }
}

/// Bits by which the sums for what is shared are fewer.
pub(super) const SHARED_BITS: u32 = 2;

/// All of them.
#[derive(Clone, Debug)]
pub(super) struct Arrow {
    /// Of the outlines so far.
    pub outlines: Vec<Slot, MAX_CIRCLES>,
    /// With [`SHARED_BITS`] fewer bits, for the room of all crossings.
    pub shared: Matrix<SHARED, i32>,
    pub right: [i64; SHARED],
    /// Far stretches of the dark and of the light side.
    pub sides: [Side; 2],
    /// Squared residuals of the samples, and their number.
    pub squares: i64,
    pub samples: i32,
    /// The solution for what is shared, once it is solved.
    pub solved: Option<Shared>,
}

/// An outline's equations, or what is left of them once they are solved: in one place, because both are large.
#[derive(Clone, Debug)]
pub(super) enum Slot {
    Sums(Block),
    Solved(Solved),
}

impl Arrow {
    pub fn new() -> Self {
        Self {
            outlines: Vec::new(),
            shared: [[0; SHARED]; SHARED],
            right: [0; SHARED],
            sides: [Side::default(); 2],
            squares: 0,
            samples: 0,
            solved: None,
        }
    }

    pub fn clear(&mut self) {
        self.outlines.clear();
        self.shared = [[0; SHARED]; SHARED];
        self.right = [0; SHARED];
        self.sides = [Side::default(); 2];
        (self.squares, self.samples, self.solved) = (0, 0, None);
    }

    /// The next outline's crossings follow.
    pub fn next(&mut self) {
        let _ = self.outlines.push(Slot::Sums(Block::default()));
    }

    /// Adds a part of the outline.
    pub fn add(&mut self, part: &Part, scene: &Scene<'_>) {
        if part.crossings == 0 {
            return;
        }
        let mean = mean_of(part.crossings);
        let (here, sums) = (part.here(scene, &mean), part.sums.map(&mean));
        if let Some(Slot::Sums(block)) = self.outlines.last_mut() {
            block.add(part, &sums, &here);
        }
        for (side, stretches) in self.sides.iter_mut().zip(&part.sides) {
            if stretches.count > 0 {
                side.add(stretches, scene);
                self.samples += stretches.count;
            }
        }
        self.squares += i64::from(part.residuals.rr) << SQUARE_BITS;
        self.samples += part.residuals.n;
        self.add_right(part, &here, scene);
        self.add_shared(&sums, &here);
    }

    fn add_right(&mut self, part: &Part, here: &Here, scene: &Scene<'_>) {
        let Residuals { r, lr, br, .. } = part.residuals;
        let [dark, bright, x, y, blur] = &mut self.right;
        for (right, sum) in [(dark, r - lr), (bright, lr), (blur, br)] {
            *right += i64::from(sum) * i64::from(here.light);
        }
        for (right, sum) in [(x, part.slopes.0), (y, part.slopes.1)] {
            *right += scene.place_sum(sum) << (RIGHT_BITS - SLOPE_BITS);
        }
    }

    fn add_shared(&mut self, sums: &Sums, here: &Here) {
        let Sums { n, l, ll, b, lb, bb, .. } = *sums;
        let (light, (x, y)) = (here.light, here.place);
        let [dark_dark, dark_bright, dark_x, dark_y] = here.with_levels(n - l, l - ll);
        let [_, bright_bright, bright_x, bright_y] = here.with_levels(l, ll);
        let (mixed_x, mixed_y) = (here.mixed(dark_x, bright_x), here.mixed(dark_y, bright_y));
        let [blur_dark, blur_bright, blur_x, blur_y] = here.with_levels(scale(b, light), scale(lb, light));
        let all =
            |a: i32, b: i32| ((a * b + (1 << (13 + SHARED_BITS))) >> (14 + SHARED_BITS)) * here.crossings;
        let [dark, bright, along_x, along_y, blur] = &mut self.shared;
        dark[0] += all(light, dark_dark);
        bright[0] += all(light, dark_bright);
        bright[1] += all(light, bright_bright);
        for (row, place, levels) in [(along_x, x, [dark_x, bright_x]), (along_y, y, [dark_y, bright_y])] {
            row[0] += all(light, levels[0]);
            row[1] += all(light, levels[1]);
            row[2] += all(place, mixed_x);
            row[3] += all(place, mixed_y);
        }
        let rows = [blur_dark, blur_bright, blur_x, blur_y, scale(scale(bb, light), light)];
        for (sum, product) in blur.iter_mut().zip(rows) {
            *sum += (product * here.crossings) >> SHARED_BITS;
        }
    }
}
