//! The step that the sums of a pass ask for: the arrow is solved block by block.

use super::arrow::{Arrow, Block, RIGHT_BITS, SUM_BITS};
use super::scene::Scene;
use crate::appearance::{OWN, SHARED, Spread, Step};
use crate::fit::{CENTRE_TERMS, Factor, Matrix};
use crate::fixed::{GREY, ONE};
use crate::list::list;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Grey levels of one in the units of the sums.
const LEVELS: f32 = 256.0;
/// What is one in the sums: of products of derivatives, of those of the terms with residuals, of those of what is shared with these,
/// and of squared residuals.
const SUM_ONE: f32 = (1 << SUM_BITS) as f32;
const OWN_RIGHT_ONE: f32 = ONE as f32 * ONE as f32 * GREY as f32;
const RIGHT_ONE: f32 = (1 << RIGHT_BITS) as f32 * ONE as f32;
const SQUARE_ONE: f32 = (GREY * GREY) as f32;

/// An outline's equations.
struct Equations {
    m: Matrix<OWN>,
    right: [f32; OWN],
    /// By what is shared.
    crosses: [[f32; OWN]; SHARED],
    /// Change of the level for 1 px outwards.
    by_place: f32,
}

/// Derivatives by what is shared, in the units of the sums.
fn units(scene: &Scene<'_>, size: f32) -> [f32; SHARED] {
    let slope = LEVELS * scene.unit / size;
    [1.0, 1.0, slope, slope, scene.model().contrast()]
}

impl Block {
    fn equations(&self, scene: &Scene<'_>, k: usize, size: f32) -> Option<Equations> {
        let (model, outline) = (scene.model(), scene.outline(Some(k))?);
        let by_place = outline.inside * model.contrast() / model.blur;
        let unit = -0.5 * outline.major * by_place;
        let square = unit * unit / SUM_ONE;
        let units = units(scene, size).map(|shared| unit / SUM_ONE * shared);
        Some(Equations {
            m: self.m.map(|row| row.map(|entry| square * entry as f32)),
            right: self.right.map(|sum| unit / OWN_RIGHT_ONE * sum as f32),
            crosses: core::array::from_fn(|j| self.cross.map(|row| units[j] * row[j] as f32)),
            by_place,
        })
    }
}

impl Arrow {
    /// Equations of what is shared, with what is known of it beforehand.
    fn shared_equations(&self, scene: &Scene<'_>, size: f32) -> (Matrix<SHARED>, [f32; SHARED]) {
        let (model, units) = (scene.model(), units(scene, size));
        let mut m = [[0.0; SHARED]; SHARED];
        for (i, weight) in model.prior().into_iter().enumerate() {
            for j in 0..=i {
                m[i][j] = units[i] * units[j] / SUM_ONE * self.shared[i][j] as f32;
            }
            m[i][i] += weight;
        }
        let mut all: [f32; SHARED] = core::array::from_fn(|i| units[i] / RIGHT_ONE * self.right[i] as f32);
        let light = (scene.unit * model.gx, scene.unit * model.gy);
        for (i, (side, level)) in self.sides.iter().zip([model.dark, model.bright]).enumerate() {
            let (matrix, right) = side.equations(level * scene.unit / size, light);
            for (row, a) in [i, 2, 3].into_iter().enumerate() {
                for (column, b) in [i, 2, 3].into_iter().enumerate().take(row + 1) {
                    m[a][b] += matrix[row][column];
                }
                all[a] += right[row];
            }
        }
        (m, all)
    }

    /// `None` where the crossings do not determine the unknowns.
    pub fn solve(&self, scene: &Scene<'_>, size: f32, solved: &mut Solved) -> Option<()> {
        let (mut rest, all_right) = self.shared_equations(scene, size);
        let mut right = all_right;
        let parts = &mut solved.parts;
        parts.clear();
        for (k, block) in self.blocks.iter().enumerate() {
            let equations = block.equations(scene, k, size)?;
            let factor = Factor::new(&equations.m)?;
            let own = factor.half(equations.right);
            let crosses = equations.crosses.map(|cross| factor.half(cross));
            for i in 0..SHARED {
                let scaled = factor.scaled(&crosses[i]);
                right[i] -= dot(&scaled, &own);
                for j in i..SHARED {
                    rest[j][i] -= dot(&crosses[j], &scaled);
                }
            }
            // As if every crossing told as much of its place as they do on average.
            let square = (block.squares as f32).max(1.0) / f32::from(block.points.max(1));
            let scatter = block.residuals as f32 / (SUM_ONE * square);
            let information = equations.by_place * equations.by_place / SUM_ONE * block.information as f32;
            let (right, points) = (equations.right, block.points);
            parts.push(Part { factor, crosses, own, right, scatter, information, points }).ok()?;
        }
        let factor = Factor::new(&rest)?;
        let shared = factor.solve(right);
        let mut gain = dot(&shared, &all_right);
        for part in parts {
            for (cross, shared) in part.crosses.iter().zip(shared) {
                for (own, cross) in part.own.iter_mut().zip(cross) {
                    *own -= cross * shared;
                }
            }
            part.own = part.factor.whole(part.factor.scaled(&part.own));
            let taken = dot(&part.own, &part.right);
            gain += taken;
            part.scatter = (part.scatter - taken).max(0.0);
        }
        let free = (self.samples - (OWN * self.blocks.len() + SHARED) as i32).max(1);
        let variance = (self.squares as f32 / SQUARE_ONE - gain).max(0.0) / free as f32;
        (solved.shared, solved.variance, solved.factor) = (shared, variance, Some(factor));
        Some(())
    }

    /// The whole system, blocks first.
    #[cfg(test)]
    pub fn whole<const N: usize>(&self, scene: &Scene<'_>, size: f32) -> (Matrix<N>, [f32; N]) {
        let mut m = [[0.0; N]; N];
        let mut right = [0.0; N];
        let end = OWN * self.blocks.len();
        let (shared, of_shared) = self.shared_equations(scene, size);
        for (k, block) in self.blocks.iter().enumerate() {
            let own = block.equations(scene, k, size).unwrap();
            for i in 0..OWN {
                right[OWN * k + i] = own.right[i];
                m[OWN * k + i][OWN * k..OWN * k + OWN].copy_from_slice(&own.m[i]);
                for j in 0..SHARED {
                    m[end + j][OWN * k + i] = own.crosses[j][i];
                }
            }
        }
        right[end..].copy_from_slice(&of_shared);
        for i in 0..SHARED {
            m[end + i][end..].copy_from_slice(&shared[i]);
        }
        (m, right)
    }

    /// Sum of the squared residuals.
    #[cfg(test)]
    pub fn squares(&self) -> f32 {
        self.squares as f32 / SQUARE_ONE
    }
}

fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// The solution for an outline.
struct Part {
    factor: Factor<OWN>,
    /// Of its equations by what is shared, the first half of the solution.
    crosses: [[f32; OWN]; SHARED],
    own: [f32; OWN],
    right: [f32; OWN],
    /// What moving each edge point by itself would take from the squares.
    scatter: f32,
    /// Inverse variances of the edge points for a unit variance of the samples, 1/px^2, and their number.
    information: f32,
    points: u16,
}

/// The solution.
pub(super) struct Solved {
    parts: Vec<Part, MAX_CIRCLES>,
    shared: [f32; SHARED],
    /// Variance of a sample after the step.
    pub variance: f32,
    factor: Option<Factor<SHARED>>,
}

impl Solved {
    /// None yet. Not inlined, so that it is made where it stays.
    #[inline(never)]
    pub fn new() -> Self {
        Self { parts: Vec::new(), shared: [0.0; SHARED], variance: 0.0, factor: None }
    }

    pub fn step(&self) -> Step {
        Step { own: list(self.parts.iter().map(|part| part.own)), shared: self.shared }
    }

    /// Variance of a sample that the scatter of the edge points of outline `k` about its ellipse tells.
    pub fn scatter(&self, k: usize) -> Option<f32> {
        self.parts.get(k).map(|part| part.scatter / (f32::from(part.points) - OWN as f32).max(1.0))
    }

    /// Mean square distance of the edge points of outline `k` from its ellipse after the step, each with its weight, px^2.
    pub fn mean_square(&self, k: usize) -> Option<f32> {
        self.parts.get(k).map(|part| part.scatter / part.information)
    }

    /// Edge points of outline `k`.
    pub fn points(&self, k: usize) -> Option<u16> {
        self.parts.get(k).map(|part| part.points)
    }

    /// Covariances of outline `k` for a unit variance of the samples.
    pub fn spread(&self, k: usize) -> Option<Spread> {
        let (part, factor) = (self.parts.get(k)?, self.factor.as_ref()?);
        let unit = |term: usize, scale: f32| core::array::from_fn(|i| if i == term { scale } else { 0.0 });
        let own = CENTRE_TERMS.map(|(term, scale)| part.factor.half(unit(term, scale)));
        let moved = own.map(|half| {
            let scaled = part.factor.scaled(&half);
            factor.half(part.crosses.map(|cross| dot(&cross, &scaled)))
        });
        Some(Spread { own: products(&part.factor, &own), shared: products(factor, &moved) })
    }
}

/// Products of right-hand sides with the solutions of each other, from the first halves of these.
fn products<const N: usize>(factor: &Factor<N>, halves: &[[f32; N]; 4]) -> Matrix<4> {
    let mut products = [[0.0; 4]; 4];
    for i in 0..4 {
        let scaled = factor.scaled(&halves[i]);
        for j in i..4 {
            products[i][j] = dot(&halves[j], &scaled);
            products[j][i] = products[i][j];
        }
    }
    products
}
