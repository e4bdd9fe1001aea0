//! Small symmetric linear systems.

/// Symmetric matrix; only the lower triangle (column <= row) is read.
pub(crate) type Matrix<const N: usize, T = f32> = [[T; N]; N];

/// L D L^T of a symmetric positive definite matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<const N: usize> {
    /// Unit lower triangle, without its diagonal.
    l: Matrix<N>,
    /// The reciprocals of D: a division costs several products.
    inverse: [f32; N],
}

impl<const N: usize> Factor<N> {
    /// `None` if the matrix is not positive definite to the precision of f32.
    pub fn new(m: &Matrix<N>) -> Option<Self> {
        let mut factor = Self { l: [[0.0; N]; N], inverse: [0.0; N] };
        factor.decompose(m).then_some(factor)
    }

    #[inline(never)]
    fn decompose(&mut self, m: &Matrix<N>) -> bool {
        let Self { l, inverse } = self;
        for j in 0..N {
            // The row of L D.
            let mut row = m[j];
            let mut pivot = row[j];
            for k in 0..j {
                for i in 0..k {
                    row[k] -= row[i] * l[k][i];
                }
                l[j][k] = row[k] * inverse[k];
                pivot -= row[k] * l[j][k];
            }
            // Also refuses NaN. What is left of the diagonal after cancellation must be more than rounding.
            if !(pivot > m[j][j] * 4.0 * f32::EPSILON) {
                return false;
            }
            inverse[j] = 1.0 / pivot;
        }
        true
    }

    /// The solution of the system with this right-hand side.
    pub fn solve(&self, b: [f32; N]) -> [f32; N] {
        self.solve_first(b, N)
    }

    /// The solution of the system of the first `count` unknowns alone; the others stay as they are in `b`.
    pub fn solve_first(&self, mut b: [f32; N], count: usize) -> [f32; N] {
        let count = count.min(N);
        self.forward(&mut b, count);
        for i in 0..count {
            b[i] *= self.inverse[i];
        }
        self.backward(&mut b, count);
        b
    }

    /// The first half of a solution: L^-1 b. The product of two of these, one of them [scaled](Self::scaled), is that of the one
    /// right-hand side with the solution of the other.
    pub fn half(&self, mut b: [f32; N]) -> [f32; N] {
        self.forward(&mut b, N);
        b
    }

    /// D^-1 of the first half.
    pub fn scaled(&self, half: &[f32; N]) -> [f32; N] {
        core::array::from_fn(|i| self.inverse[i] * half[i])
    }

    /// The solution from its first half, scaled.
    pub fn whole(&self, mut b: [f32; N]) -> [f32; N] {
        self.backward(&mut b, N);
        b
    }

    #[inline(never)]
    fn forward(&self, b: &mut [f32; N], count: usize) {
        for i in 0..count.min(N) {
            for k in 0..i {
                b[i] -= self.l[i][k] * b[k];
            }
        }
    }

    #[inline(never)]
    fn backward(&self, b: &mut [f32; N], count: usize) {
        let count = count.min(N);
        for i in (0..count).rev() {
            for k in i + 1..count {
                b[i] -= self.l[k][i] * b[k];
            }
        }
    }
}

/// Sum of the products.
#[inline(never)]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// Adds `factor` times the terms to as many entries of a row.
#[inline(never)]
pub(crate) fn add_scaled(row: &mut [f32], factor: f32, terms: &[f32]) {
    for (entry, term) in row.iter_mut().zip(terms) {
        *entry += factor * term;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_it_was_made_of() {
        let m: Matrix<3> = [[4.0, 0.0, 0.0], [2.0, 5.0, 0.0], [0.5, 1.0, 3.0]];
        let x = [1.0, -2.0, 0.5];
        let full = |i: usize, j: usize| if i >= j { m[i][j] } else { m[j][i] };
        let b = core::array::from_fn(|i| (0..3).map(|j| full(i, j) * x[j]).sum());
        let solved = Factor::new(&m).unwrap().solve(b);
        for (a, b) in solved.iter().zip(x) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn refuses_singular_and_nan() {
        assert!(Factor::new(&[[1.0, 0.0], [1.0, 1.0]]).is_none());
        assert!(Factor::new(&[[f32::NAN, 0.0], [1.0, 1.0]]).is_none());
        assert!(Factor::new(&[[0.0f32]]).is_none());
    }
}
