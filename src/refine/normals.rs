//! Normal equations of all outlines, the levels and the blur.
//!
//! Every outline has five unknowns of its own; what they share has five more. So the matrix is a row of 5 x 5 blocks on the
//! diagonal with a border, and the border is eliminated last (Schur complement).

use super::model::{Expected, Model};
use crate::fit::{Factor, Matrix, frame_covariance};
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Dark, bright, the light's slopes in units of the target's size, logarithm of the blur.
pub(super) const SHARED: usize = 5;

/// Equations of one outline.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    own: Matrix<5>,
    /// Own rows, shared columns.
    border: [[f32; SHARED]; 5],
    right: [f32; 5],
}

#[derive(Clone, Debug)]
pub(super) struct Normals {
    blocks: Vec<Block, MAX_CIRCLES>,
    shared: Matrix<SHARED>,
    right: [f32; SHARED],
    /// 1 / the target's size, 1/px.
    scale: f32,
    /// Squared residuals: of all pixels, and of those at edges weighted with their part in the outlines.
    pub squares: f32,
    pub pixels: f32,
    edge_squares: f32,
    edge_weights: f32,
}

/// A step of every unknown.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub own: Vec<[f32; 5], MAX_CIRCLES>,
    pub shared: [f32; SHARED],
}

/// Covariances of an outline's stretch and centre in the frame where it is the unit circle, for a unit variance of the
/// levels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    /// Of the outline by itself.
    pub own: Matrix<4>,
    /// What the shared unknowns add to it.
    pub shared: Matrix<4>,
}

impl Normals {
    pub fn new(outlines: usize, scale: f32) -> Self {
        let mut blocks = Vec::new();
        for _ in 0..outlines {
            let _ = blocks.push(Block::default());
        }
        let shared = [[0.0; SHARED]; SHARED];
        Self {
            blocks,
            shared,
            right: [0.0; SHARED],
            scale,
            squares: 0.0,
            pixels: 0.0,
            edge_squares: 0.0,
            edge_weights: 0.0,
        }
    }

    /// What is known of the shared unknowns beforehand, with the weight of one pixel: keeps a level that is seen nowhere
    /// in bounds.
    pub fn add_prior(&mut self, contrast: f32) {
        let weights = [1.0, 1.0, contrast * contrast, contrast * contrast, contrast * contrast];
        for (i, weight) in weights.into_iter().enumerate() {
            self.shared[i][i] += weight;
        }
    }

    /// Adds the pixel at `(x, y)`, whose level is `residual` above what is `expected`.
    pub fn add(&mut self, model: &Model, expected: &Expected, (x, y): (f32, f32), residual: f32) {
        let Expected { lightness, light, .. } = *expected;
        let level = model.dark + model.contrast() * lightness;
        let contrast = model.contrast() * light;
        let shared = [
            (1.0 - lightness) * light,
            lightness * light,
            level * x * self.scale,
            level * y * self.scale,
            contrast * expected.by_blur,
        ];
        for i in 0..SHARED {
            for j in 0..SHARED {
                self.shared[i][j] += shared[i] * shared[j];
            }
            self.right[i] += shared[i] * residual;
        }
        let mut weight = 0.0;
        for edge in &expected.edges {
            let Some(block) = self.blocks.get_mut(edge.outline) else { continue };
            let change = contrast * edge.change;
            let (u, v) = (edge.u, edge.v);
            let terms = [u * u - v * v, 2.0 * u * v, 1.0, u, v].map(|term| change * term);
            for i in 0..5 {
                for j in 0..5 {
                    block.own[i][j] += terms[i] * terms[j];
                    block.border[i][j] += terms[i] * shared[j];
                }
                block.right[i] += terms[i] * residual;
            }
            weight += change * change;
        }
        self.squares += residual * residual;
        self.pixels += 1.0;
        self.edge_squares += weight * residual * residual;
        self.edge_weights += weight;
    }

    /// Variance of a pixel.
    pub fn noise(&self) -> f32 {
        let free = self.pixels - (5 * self.blocks.len() + SHARED) as f32;
        self.squares / free.max(1.0)
    }

    /// The same for covariances: at edges, where the model is put to the test, if that is larger.
    pub fn variance(&self) -> f32 {
        let edge = if self.edge_weights > 0.0 { self.edge_squares / self.edge_weights } else { 0.0 };
        self.noise().max(edge)
    }

    /// The solution with the covariances of the outlines' centres. `None` if the pixels do not determine it.
    pub fn solve(&self) -> Option<(Step, Vec<Spread, MAX_CIRCLES>)> {
        let mut schur = self.shared;
        let mut right = self.right;
        let mut factors = Vec::<(Factor<5>, [[f32; 5]; SHARED]), MAX_CIRCLES>::new();
        for block in &self.blocks {
            let factor = Factor::new(&block.own)?;
            let column = |j: usize| core::array::from_fn(|i| block.border[i][j]);
            // Columns of (own)^-1 border.
            let solved: [[f32; 5]; SHARED] = core::array::from_fn(|j| factor.solve(column(j)));
            for i in 0..SHARED {
                for j in 0..SHARED {
                    schur[i][j] -= (0..5).fold(0.0, |sum, k| sum + block.border[k][i] * solved[j][k]);
                }
                right[i] -= (0..5).fold(0.0, |sum, k| sum + solved[i][k] * block.right[k]);
            }
            factors.push((factor, solved)).ok()?;
        }
        let complement = Factor::new(&schur)?;
        let shared = complement.solve(right);
        let mut step = Step { own: Vec::new(), shared };
        let mut spreads = Vec::new();
        for (block, (factor, solved)) in self.blocks.iter().zip(&factors) {
            let mut own = factor.solve(block.right);
            for (i, own) in own.iter_mut().enumerate() {
                *own -= (0..SHARED).fold(0.0, |sum, j| sum + solved[j][i] * shared[j]);
            }
            step.own.push(own).ok()?;
            spreads
                .push(Spread { own: frame_covariance(factor, 1.0), shared: shared_part(&complement, solved) })
                .ok()?;
        }
        Some((step, spreads))
    }
}

/// A centre moves by minus half of the last two terms.
fn shared_part(complement: &Factor<SHARED>, solved: &[[f32; 5]; SHARED]) -> Matrix<4> {
    let terms = [(0, 1.0), (1, 1.0), (3, -0.5), (4, -0.5)];
    let rows: [[f32; SHARED]; 4] = terms.map(|(i, scale)| core::array::from_fn(|j| scale * solved[j][i]));
    rows.map(|row| {
        let spread = complement.solve(row);
        rows.map(|other| other.iter().zip(spread).fold(0.0, |sum, (a, b)| sum + a * b))
    })
}
