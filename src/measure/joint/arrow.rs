//! Normal equations of all ellipses and of what they share: an arrow of 5 x 5 blocks.

use super::view::Far;
use crate::appearance::{Model, OWN, SHARED, Spread, Step};
use crate::fit::{CENTRE_TERMS, Factor, Matrix};
use crate::list::list;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Sums over the samples of a crossing, of products of: 1 (n), lightness (l), its changes with the logarithm of the blur (b) and
/// with the place of the edge (p), and the residual (r).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub n: f32,
    pub l: f32,
    pub ll: f32,
    pub b: f32,
    pub lb: f32,
    pub bb: f32,
    pub p: f32,
    pub lp: f32,
    pub bp: f32,
    pub pp: f32,
    pub r: f32,
    pub lr: f32,
    pub br: f32,
    pub pr: f32,
    pub rr: f32,
}

/// What a crossing tells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told {
    /// Terms of the conic where it passes the edge.
    pub terms: [f32; OWN],
    /// How far a unit of them moves the edge outwards, px.
    pub reach: f32,
    /// Change of the level for 1 px outwards, in units of `p`.
    pub by_place: f32,
    /// Light there, relative to that at the origin.
    pub light: f32,
    /// Place in units of the target's size.
    pub place: (f32, f32),
    pub sums: Sums,
}

impl Told {
    /// Products of a quantity with the derivatives by dark, bright, and the light's slopes, from its sums with 1 and lightness.
    fn with_levels(&self, model: &Model, sum: f32, with_lightness: f32) -> [f32; 4] {
        let (dark, bright) = (sum - with_lightness, with_lightness);
        let mixed = model.dark * dark + model.bright * bright;
        [self.light * dark, self.light * bright, self.place.0 * mixed, self.place.1 * mixed]
    }
}

/// An outline's part.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Block {
    pub m: Matrix<OWN>,
    pub right: [f32; OWN],
    /// Rows: the conic's terms; columns: what is shared.
    pub cross: [[f32; SHARED]; OWN],
    /// What moving each edge point by itself would take from the squares.
    scatter: f32,
    /// Inverse variances of the edge points for a unit variance of the samples, 1/px^2, and their number.
    information: f32,
    pub points: u16,
}

impl Block {
    #[inline]
    fn add(&mut self, told: &Told, model: &Model) {
        let Told { terms, reach, by_place, sums, .. } = told;
        let unit = reach * by_place;
        let (square, right) = (unit * unit * sums.pp, unit * sums.pr);
        let [dark, bright, x, y] = told.with_levels(model, unit * sums.p, unit * sums.lp);
        let blur = unit * model.contrast() * told.light * sums.bp;
        let shared = [dark, bright, x, y, blur];
        for i in 0..OWN {
            let weighted = square * terms[i];
            for j in 0..=i {
                self.m[i][j] += weighted * terms[j];
            }
            self.right[i] += right * terms[i];
            for j in 0..SHARED {
                self.cross[i][j] += terms[i] * shared[j];
            }
        }
        if sums.pp > 0.0 {
            self.scatter += sums.pr * sums.pr / sums.pp;
        }
        self.information += by_place * by_place * sums.pp;
        self.points = self.points.saturating_add(1);
    }
}

/// All of them.
#[derive(Clone, Debug)]
pub(super) struct Arrow {
    pub blocks: Vec<Block, MAX_CIRCLES>,
    pub shared: Matrix<SHARED>,
    pub right: [f32; SHARED],
    /// Squared residuals of the samples, and their number.
    pub squares: f32,
    samples: f32,
}

impl Arrow {
    pub fn new(model: &Model) -> Self {
        let mut shared = [[0.0; SHARED]; SHARED];
        for (i, weight) in model.prior().into_iter().enumerate() {
            shared[i][i] = weight;
        }
        let blocks = list(model.outlines.iter().map(|_| Block::default()));
        Self { blocks, shared, right: [0.0; SHARED], squares: 0.0, samples: 0.0 }
    }

    /// Adds a crossing of outline `k`.
    #[inline]
    pub fn add(&mut self, k: usize, told: &Told, model: &Model) {
        if let Some(block) = self.blocks.get_mut(k) {
            block.add(told, model);
        }
        let s = &told.sums;
        let [dark_dark, dark_bright, dark_x, dark_y] = told.with_levels(model, s.n - s.l, s.l - s.ll);
        let [_, bright_bright, bright_x, bright_y] = told.with_levels(model, s.l, s.ll);
        let (light, (x, y)) = (told.light, told.place);
        let mixed =
            (model.dark * dark_x + model.bright * bright_x, model.dark * dark_y + model.bright * bright_y);
        let by_blur = model.contrast() * light;
        let [blur_dark, blur_bright, blur_x, blur_y] = told.with_levels(model, by_blur * s.b, by_blur * s.lb);
        let rows = [
            [light * dark_dark, 0.0, 0.0, 0.0, 0.0],
            [light * dark_bright, light * bright_bright, 0.0, 0.0, 0.0],
            [light * dark_x, light * bright_x, x * mixed.0, 0.0, 0.0],
            [light * dark_y, light * bright_y, y * mixed.0, y * mixed.1, 0.0],
            [blur_dark, blur_bright, blur_x, blur_y, by_blur * by_blur * s.bb],
        ];
        for i in 0..SHARED {
            for j in 0..=i {
                self.shared[i][j] += rows[i][j];
            }
        }
        let [dark, bright, by_x, by_y] = told.with_levels(model, s.r, s.lr);
        for (right, sum) in self.right.iter_mut().zip([dark, bright, by_x, by_y, by_blur * s.br]) {
            *right += sum;
        }
        self.squares += s.rr;
        self.samples += s.n;
    }

    /// Adds a far stretch, whose level is `residual` beyond that of the model, which has the derivatives `terms` by dark, bright
    /// and the light's slopes.
    pub fn add_far(&mut self, far: &Far, terms: [f32; 4], residual: f32) {
        for i in 0..terms.len() {
            let weighted = far.pixels * terms[i];
            for j in 0..=i {
                self.shared[i][j] += weighted * terms[j];
            }
            self.right[i] += weighted * residual;
        }
        self.squares += far.pixels * residual * residual;
        self.samples += 1.0;
    }

    /// `None` where the crossings do not determine the unknowns.
    pub fn solve(&self) -> Option<Solved> {
        let (mut rest, mut right) = (self.shared, self.right);
        let mut parts = Vec::<Part, MAX_CIRCLES>::new();
        for block in &self.blocks {
            let factor = Factor::new(&block.m)?;
            let own = factor.solve(block.right);
            let by_shared: [[f32; OWN]; SHARED] =
                core::array::from_fn(|j| factor.solve(core::array::from_fn(|i| block.cross[i][j])));
            for i in 0..SHARED {
                for k in 0..OWN {
                    right[i] -= block.cross[k][i] * own[k];
                    for j in 0..=i {
                        rest[i][j] -= block.cross[k][i] * by_shared[j][k];
                    }
                }
            }
            parts.push(Part { factor, by_shared, own, scatter: 0.0, mean_square: 0.0 }).ok()?;
        }
        let factor = Factor::new(&rest)?;
        let shared = factor.solve(right);
        let mut gain = dot(&shared, &self.right);
        for (part, block) in parts.iter_mut().zip(&self.blocks) {
            for j in 0..SHARED {
                for k in 0..OWN {
                    part.own[k] -= part.by_shared[j][k] * shared[j];
                }
            }
            let taken = dot(&part.own, &block.right);
            gain += taken;
            let free = f32::from(block.points) - OWN as f32;
            let scatter = (block.scatter - taken).max(0.0);
            part.scatter = scatter / free.max(1.0);
            part.mean_square = scatter / block.information;
        }
        let free = self.samples - (OWN * self.blocks.len() + SHARED) as f32;
        let variance = (self.squares - gain).max(0.0) / free.max(1.0);
        Some(Solved { parts, shared, variance, factor })
    }
}

fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// The solution for an outline.
struct Part {
    factor: Factor<OWN>,
    /// How its terms go with what is shared, negative.
    by_shared: [[f32; OWN]; SHARED],
    own: [f32; OWN],
    /// Variance of a sample that the scatter of its edge points about the ellipse tells.
    scatter: f32,
    mean_square: f32,
}

/// The solution.
pub(super) struct Solved {
    parts: Vec<Part, MAX_CIRCLES>,
    shared: [f32; SHARED],
    /// Variance of a sample after the step.
    pub variance: f32,
    factor: Factor<SHARED>,
}

impl Solved {
    pub fn step(&self) -> Step {
        Step { own: list(self.parts.iter().map(|part| part.own)), shared: self.shared }
    }

    /// Variance of a sample that the scatter of the edge points of outline `k` about its ellipse tells.
    pub fn scatter(&self, k: usize) -> Option<f32> {
        self.parts.get(k).map(|part| part.scatter)
    }

    /// Mean square distance of the edge points of outline `k` from its ellipse after the step, each with its weight, px^2.
    pub fn mean_square(&self, k: usize) -> Option<f32> {
        self.parts.get(k).map(|part| part.mean_square)
    }

    /// Covariances of outline `k` for a unit variance of the samples.
    pub fn spread(&self, k: usize) -> Option<Spread> {
        let part = self.parts.get(k)?;
        let mut spread = Spread { own: [[0.0; 4]; 4], shared: [[0.0; 4]; 4] };
        for (i, (term, scale)) in CENTRE_TERMS.into_iter().enumerate() {
            let own = part.factor.solve(core::array::from_fn(|i| if i == term { scale } else { 0.0 }));
            let moved = self.factor.solve(part.by_shared.map(|terms| scale * entry(&terms, term)));
            for (j, (other, scale)) in CENTRE_TERMS.into_iter().enumerate() {
                let shared = part
                    .by_shared
                    .iter()
                    .zip(moved)
                    .fold(0.0, |sum, (by, moved)| sum + entry(by, other) * moved);
                spread.own[i][j] = scale * entry(&own, other);
                spread.shared[i][j] = scale * shared;
            }
        }
        Some(spread)
    }
}

/// Entry `i` of an outline's own terms.
fn entry(terms: &[f32; OWN], i: usize) -> f32 {
    terms.get(i).copied().unwrap_or(0.0)
}
