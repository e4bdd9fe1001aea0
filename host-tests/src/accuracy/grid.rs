//! The conditions of the study: lines through its middle, one or two things varied at a time.

use super::cell::Cell;

/// Outer radii of the pooled set, mm.
pub const POOLED_RADII: [f64; 6] = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
/// Tilts of the pooled set, degrees.
pub const POOLED_TILTS: [f64; 6] = [12.0, 24.0, 36.0, 48.0, 60.0, 72.0];
/// Noise of the pooled set, grey levels.
pub const POOLED_NOISE: [f64; 4] = [0.0, 1.0, 2.0, 5.0];

/// How much of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// A few cells of each slice.
    Quick,
    /// Everything.
    Full,
}

impl Extent {
    /// The values of a slice, or those that stand for them.
    fn pick<const N: usize>(self, all: [f64; N], few: &[f64]) -> Vec<f64> {
        if self == Self::Full { all.to_vec() } else { few.to_vec() }
    }

    /// All cells.
    pub fn cells(self) -> Vec<Cell> {
        let base = Cell::default();
        let mut cells = Vec::new();
        let mut add = |slice: &'static str, cell: Cell| cells.push(Cell { slice, ..cell });
        for radius in self.pick([10.0, 15.0, 20.0, 30.0, 50.0, 100.0], &[10.0, 20.0, 50.0]) {
            for tilt in self.pick([0.0, 15.0, 30.0, 45.0, 60.0], &[0.0, 30.0, 60.0]) {
                add("size", Cell { radius, tilt, ..base.clone() });
            }
        }
        for radius in [15.0, 30.0] {
            for psf in self.pick([0.4, 0.5, 0.7, 1.0, 1.22, 1.5], &[0.4, 0.7, 1.5]) {
                add("blur", Cell { radius, psf, ..base.clone() });
            }
        }
        for contrast in [40.0, 80.0, 150.0] {
            for noise in self.pick([0.0, 1.0, 2.0, 3.0, 5.0, 10.0], &[1.0, 3.0]) {
                add("noise", Cell { contrast, noise, ..base.clone() });
            }
        }
        for radius in self.pick([15.0, 30.0, 60.0], &[30.0]) {
            for shading in self.pick([0.0, 0.1, 0.3], &[0.3]) {
                add("shading", Cell { radius, shading, ..base.clone() });
            }
        }
        for shading in [0.0, 0.3] {
            for gamma in self.pick([0.6, 1.0, 1.8, 2.2], &[0.6, 2.2]) {
                add("gamma", Cell { gamma, shading, ..base.clone() });
            }
            for gain in self.pick([1.0, 1.5, 2.0], &[1.5]) {
                add("gain", Cell { gain, shading, ..base.clone() });
            }
        }
        for ratio in self.pick([0.3, 0.43, 0.5, 0.6, 0.8], &[0.3, 0.8]) {
            add("ratio", Cell { ratio, ..base.clone() });
        }
        for place in [[0.0, 0.0], [560.0, 430.0]] {
            for k1 in self.pick([0.0, -0.3], &[0.0]) {
                for radius in [30.0, 60.0] {
                    add("place", Cell { place, k1, radius, ..base.clone() });
                }
            }
        }
        for radius in self.pick([15.0, 20.0, 30.0, 50.0], &[20.0]) {
            for psf in self.pick([0.5, 0.7, 1.0], &[0.5, 1.0]) {
                add("bias", Cell { radius, psf, noise: 0.5, draws: 20, ..base.clone() });
            }
        }
        for noise in POOLED_NOISE {
            for radius in self.pick(POOLED_RADII, &[10.0, 30.0]) {
                for tilt in self.pick(POOLED_TILTS, &[12.0, 48.0, 72.0]) {
                    add("pooled", pooled(radius, tilt, noise));
                }
            }
        }
        cells
    }
}

/// A cell of the set of 36 that is pooled to one figure; `radius` in mm.
fn pooled(radius: f64, tilt: f64, noise: f64) -> Cell {
    let radius = radius * 2580.0 / 800.0;
    Cell { radius, tilt, noise, psf: 0.8, black: 30.0, contrast: 190.0, draws: 1, ..Cell::default() }
}
