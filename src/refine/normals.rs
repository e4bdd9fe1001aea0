//! Normal equations of all outlines, the levels and the blur together.
//!
//! Each outline has five unknowns of its own, the terms of its conic; what they share comes last, so that the leading part
//! of the factor is that of the outlines alone.

use super::pixel::Expected;
use crate::appearance::{Model, OWN, SHARED, Spread, Step};
use crate::fit::{CENTRE_TERMS, Factor, Matrix};
use crate::target::MAX_CIRCLES;
use heapless::Vec;

const OUTLINES: usize = OWN * MAX_CIRCLES;
const ALL: usize = OUTLINES + SHARED;

#[derive(Clone, Debug)]
pub(super) struct Normals {
    m: Matrix<ALL>,
    right: [f32; ALL],
    outlines: usize,
    /// 1 / the target's size, 1/px.
    scale: f32,
    /// Squared residuals of all pixels.
    squares: f32,
    pixels: f32,
    /// Those at edges, weighted with their part in the outlines.
    edge_squares: f32,
    edge_weights: f32,
}

impl Normals {
    pub fn new(outlines: usize, scale: f32) -> Self {
        let mut m = [[0.0; ALL]; ALL];
        // Unknowns of outlines that are not there.
        for i in OWN * outlines..OUTLINES {
            m[i][i] = 1.0;
        }
        Self {
            m,
            right: [0.0; ALL],
            outlines,
            scale,
            squares: 0.0,
            pixels: 0.0,
            edge_squares: 0.0,
            edge_weights: 0.0,
        }
    }

    /// Adds what is known beforehand.
    pub fn add_prior(&mut self, model: &Model) {
        for (i, weight) in model.prior().into_iter().enumerate() {
            self.m[OUTLINES + i][OUTLINES + i] += weight;
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
        // Derivatives of the level in the order of the unknowns, without those that are zero.
        let mut terms = Vec::<(usize, f32), ALL>::new();
        let mut weight = 0.0;
        for edge in expected.edges.iter().filter(|edge| edge.outline < self.outlines) {
            let change = contrast * edge.change;
            weight += change * change;
            let (u, v) = (edge.u, edge.v);
            for (i, term) in [u * u - v * v, 2.0 * u * v, 1.0, u, v].into_iter().enumerate() {
                let _ = terms.push((OWN * edge.outline + i, change * term));
            }
        }
        for (i, term) in shared.into_iter().enumerate() {
            let _ = terms.push((OUTLINES + i, term));
        }
        for (k, &(i, a)) in terms.iter().enumerate() {
            let (Some(row), Some(right)) = (self.m.get_mut(i), self.right.get_mut(i)) else { continue };
            for &(j, b) in terms.iter().take(k + 1) {
                if let Some(entry) = row.get_mut(j) {
                    *entry += a * b;
                }
            }
            *right += a * residual;
        }
        self.squares += residual * residual;
        self.pixels += 1.0;
        self.edge_squares += weight * residual * residual;
        self.edge_weights += weight;
    }

    /// Variance of a pixel.
    pub fn noise(&self) -> f32 {
        let free = self.pixels - (OWN * self.outlines + SHARED) as f32;
        self.squares / free.max(1.0)
    }

    /// The same for covariances: at edges, where the model is put to the test, if that is larger.
    pub fn variance(&self) -> f32 {
        let edge = if self.edge_weights > 0.0 { self.edge_squares / self.edge_weights } else { 0.0 };
        self.noise().max(edge)
    }

    /// `None` if the pixels do not determine the unknowns.
    pub fn factor(&self) -> Option<Factor<ALL>> {
        Factor::new(&self.m)
    }

    /// The solution.
    pub fn step(&self, factor: &Factor<ALL>) -> Step {
        let solved = factor.solve(self.right);
        let mut own = Vec::new();
        for outline in solved.chunks_exact(OWN).take(self.outlines) {
            let _ = own.push(core::array::from_fn(|i| outline.get(i).copied().unwrap_or(0.0)));
        }
        Step { own, shared: core::array::from_fn(|i| solved[OUTLINES + i]) }
    }

    /// Covariances of outline `k`.
    pub fn spread(&self, factor: &Factor<ALL>, k: usize) -> Spread {
        let rows = |solve: &dyn Fn([f32; ALL]) -> [f32; ALL]| -> Matrix<4> {
            CENTRE_TERMS.map(|(term, scale)| {
                let mut unit = [0.0; ALL];
                if let Some(entry) = unit.get_mut(OWN * k + term) {
                    *entry = scale;
                }
                let solved = solve(unit);
                CENTRE_TERMS.map(|(term, scale)| scale * solved.get(OWN * k + term).copied().unwrap_or(0.0))
            })
        };
        let own = rows(&|unit| factor.solve_first(unit, OUTLINES));
        let all = rows(&|unit| factor.solve(unit));
        let shared = core::array::from_fn(|i| core::array::from_fn(|j| all[i][j] - own[i][j]));
        Spread { own, shared }
    }
}
