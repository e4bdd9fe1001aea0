//! The step that the sums of a pass ask for: the arrow is solved block by block.

use super::arrow::{Arrow, Block, SHARED_BITS, Slot};
use super::part::{OWN_BITS, RESIDUAL_BITS, RIGHT_BITS, SUM_BITS};
use super::scene::Scene;
use crate::appearance::{OWN, SHARED, Step};
use crate::fit::{CENTRE_TERMS, Factor, Matrix, add_scaled, dot};
use crate::fixed::{GREY, ONE};
use crate::list::list;

/// Grey levels of one in the units of the sums.
const LEVELS: f32 = 256.0;
/// What is one in the sums: of products of derivatives, of those of the terms with residuals, of those of what is shared with these,
/// and of squared residuals.
const SUM_ONE: f32 = (1 << SUM_BITS) as f32;
const SHARED_ONE: f32 = (1 << (SUM_BITS - SHARED_BITS)) as f32;
const OWN_RIGHT_ONE: f32 = (1 << OWN_BITS) as f32;
const RESIDUAL_ONE: f32 = (1 << RESIDUAL_BITS) as f32;
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

impl Block {
    /// Solves them, and takes what they tell of what is shared from its equations.
    fn solve(
        &self,
        equations: &Equations,
        rest: &mut Matrix<SHARED>,
        right: &mut [f32; SHARED],
    ) -> Option<Solved> {
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
        let square = (self.squares as f32).max(1.0) / f32::from(self.points.max(1));
        let scatter = SUM_ONE / RESIDUAL_ONE * self.residuals as f32 / square;
        let information = equations.by_place * equations.by_place / SUM_ONE * self.information as f32;
        let (right, points) = (equations.right, self.points);
        Some(Solved { factor, crosses, own, right, scatter, information, points })
    }
}

impl Arrow {
    /// Equations of what is shared, with what is known of it beforehand.
    fn shared_equations(&self, scene: &Scene<'_>, size: f32) -> (Matrix<SHARED>, [f32; SHARED]) {
        let (model, units) = (scene.model(), units(scene, size));
        let mut m = [[0.0; SHARED]; SHARED];
        for (i, weight) in model.prior().into_iter().enumerate() {
            for j in 0..=i {
                m[i][j] = units[i] * units[j] / SHARED_ONE * self.shared[i][j] as f32;
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

    /// The step that they ask for. `None` where the crossings do not determine the unknowns.
    #[inline(never)]
    pub fn solve(&mut self, scene: &Scene<'_>, size: f32) -> Option<Step> {
        let (mut rest, all_right) = self.shared_equations(scene, size);
        let mut right = all_right;
        for (k, slot) in self.outlines.iter_mut().enumerate() {
            let Slot::Sums(block) = slot else { return None };
            let solved = block.solve(&block.equations(scene, k, size)?, &mut rest, &mut right)?;
            *slot = Slot::Solved(solved);
        }
        let factor = Factor::new(&rest)?;
        let shared = factor.solve(right);
        let mut gain = dot(&shared, &all_right);
        for slot in &mut self.outlines {
            if let Slot::Solved(solved) = slot {
                gain += solved.complete(&shared);
            }
        }
        let free = (self.samples - (OWN * self.outlines.len() + SHARED) as i32).max(1);
        let variance = (self.squares as f32 / SQUARE_ONE - gain).max(0.0) / free as f32;
        self.solved = Some(Shared { variance, factor });
        let own = self
            .outlines
            .iter()
            .map(|slot| if let Slot::Solved(solved) = slot { solved.own } else { [0.0; OWN] });
        Some(Step { own: list(own), shared })
    }

    /// The solution for outline `k`.
    pub fn solution(&self, k: usize) -> Option<&Solved> {
        if let Slot::Solved(solved) = self.outlines.get(k)? { Some(solved) } else { None }
    }

    /// The whole system, blocks first.
    #[cfg(test)]
    pub fn whole<const N: usize>(&self, scene: &Scene<'_>, size: f32) -> (Matrix<N>, [f32; N]) {
        let mut m = [[0.0; N]; N];
        let mut right = [0.0; N];
        let end = OWN * self.outlines.len();
        let (shared, of_shared) = self.shared_equations(scene, size);
        for (k, slot) in self.outlines.iter().enumerate() {
            let Slot::Sums(block) = slot else { panic!("solved") };
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

/// The solution for an outline.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    factor: Factor<OWN>,
    /// Of its equations by what is shared, the first half of the solution.
    crosses: [[f32; OWN]; SHARED],
    own: [f32; OWN],
    right: [f32; OWN],
    /// What moving each edge point by itself would take from the squares.
    scatter: f32,
    /// Inverse variances of the edge points for a unit variance of the samples, 1/px^2, and their number.
    information: f32,
    pub points: u16,
}

/// That for what is shared.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    /// Variance of a sample after the step.
    pub variance: f32,
    factor: Factor<SHARED>,
}

impl Solved {
    /// Completes the solution with that for what is shared. Gives what it takes from the squares.
    fn complete(&mut self, shared: &[f32; SHARED]) -> f32 {
        for (cross, shared) in self.crosses.iter().zip(shared) {
            add_scaled(&mut self.own, -shared, cross);
        }
        self.own = self.factor.whole(self.factor.scaled(&self.own));
        let taken = dot(&self.own, &self.right);
        self.scatter = (self.scatter - taken).max(0.0);
        taken
    }

    /// Variance of a sample that the scatter of the edge points about the ellipse tells.
    pub fn scatter(&self) -> f32 {
        self.scatter / (f32::from(self.points) - OWN as f32).max(1.0)
    }

    /// Mean square distance of the edge points from the ellipse after the step, each with its weight, px^2.
    pub fn mean_square(&self) -> f32 {
        self.scatter / self.information
    }

    /// Covariance of the stretch and centre in the ellipse's frame, for a unit variance of the samples, where what is shared is
    /// known.
    pub fn covariance(&self) -> Matrix<4> {
        products(&self.factor, &self.centre())
    }

    /// What it is more because that is measured too.
    pub fn more(&self, shared: &Shared) -> Matrix<4> {
        let moved = self.centre().map(|half| {
            let scaled = self.factor.scaled(&half);
            shared.factor.half(self.crosses.map(|cross| dot(&cross, &scaled)))
        });
        products(&shared.factor, &moved)
    }

    /// First halves of the solutions for its stretch and centre.
    fn centre(&self) -> [[f32; OWN]; 4] {
        CENTRE_TERMS.map(|(term, scale)| {
            self.factor.half(core::array::from_fn(|i| if i == term { scale } else { 0.0 }))
        })
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
