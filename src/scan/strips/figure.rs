//! Which cells tell of the noise.

use super::super::kernel;
use super::super::noise::{Noise, Ranges};
use super::super::rows::Rows;
use super::{CELLS_WANTED, STRIP, Strips};

/// Width of a cell, px.
const CELL: usize = 8;

/// Cells of a frame from this strip on that its right border does not cut: beyond it the last pixel is repeated, without noise.
pub(super) fn cells(strip: usize, width: u16) -> usize {
    usize::from(width).saturating_sub(strip * STRIP) / CELL
}

/// Whether nearly all cells of a block are `restless`, which is for the noise. In a narrow frame a target and uneven light do that,
/// too.
pub(super) fn is_crowded(restless: &Ranges, width: u16) -> bool {
    restless.count >= CELLS_WANTED / 2 && 8 * usize::from(restless.count) >= 7 * cells(0, width)
}

impl Strips<'_> {
    /// Takes the noise figure from the first block.
    pub(super) fn look_at_first(&mut self, rows: &Rows<'_>) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|row| rows.lines(row));
        self.noise = Noise::NONE;
        // A narrow frame has few cells; the pixels between the samples make more.
        for (a, b) in [(b, d), (d, b), (a, c), (c, a)] {
            if self.noise.cells.count < CELLS_WANTED {
                for (i, (a, b)) in a.iter().zip(b).enumerate() {
                    self.noise.cells.add(kernel::extremes(a, b), cells(i, rows.width()));
                }
            }
        }
        self.noise.settle();
    }
}
