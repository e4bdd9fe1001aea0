//! Where a row passes the threshold.

use super::threshold::{CELL, Cells, state};

/// Pixels compared at a time: two cells.
const PIXELS: usize = 2 * CELL;
/// Cells passed over at a time where nothing changes.
const GROUP: usize = 8;

/// The first pixel of a run: a row turns dark at the even entries of its list and light at the odd ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transition {
    /// Column of the first pixel after the change.
    pub x: u16,
    /// Outline that it belongs to.
    pub label: u16,
}

impl Transition {
    pub const ZERO: Self = Self { x: 0, label: 0 };
}

/// The transitions of a row, in order; an even number, because what is outside the frame counts as light.
#[derive(Debug)]
pub(crate) struct TransitionList<'s> {
    data: &'s mut [Transition],
    len: usize,
}

impl<'s> TransitionList<'s> {
    pub fn new(data: &'s mut [Transition]) -> Self {
        Self { data, len: 0 }
    }

    pub fn clear(&mut self) {
        self.len = 0;
    }

    pub fn as_slice(&self) -> &[Transition] {
        self.data.get(..self.len).unwrap_or(&[])
    }

    pub fn as_mut_slice(&mut self) -> &mut [Transition] {
        self.data.get_mut(..self.len).unwrap_or(&mut [])
    }

    /// Finds the dark runs of `row`, padded to whole cells. Returns how many did not fit.
    pub fn fill(&mut self, row: &[u8], cells: &Cells<'_>, width: u16) -> u32 {
        let mut runs = Runs { list: self, found: 0, dark: 0 };
        let row = row.chunks(GROUP * CELL).zip(cells.thresholds().chunks(GROUP));
        for (i, ((pixels, thresholds), states)) in row.zip(cells.states().chunks(GROUP)).enumerate() {
            // Most of a frame is the same for many pixels.
            let same = if runs.dark == 0 { state::LIGHT } else { state::DARK };
            if states != [same; GROUP] {
                runs.add((i * GROUP * CELL) as u16, pixels, thresholds);
            }
        }
        if runs.dark != 0 {
            runs.push(width);
        }
        // Runs are dropped whole, so that the list stays even.
        let found = runs.found;
        self.len = found.min(self.data.len() & !1);
        ((found - self.len) / 2) as u32
    }
}

/// The dark runs of a row under way.
struct Runs<'l, 's> {
    list: &'l mut TransitionList<'s>,
    found: usize,
    /// 1 if the last pixel was dark.
    dark: u8,
}

impl Runs<'_, '_> {
    /// The cells from column `x` on.
    fn add(&mut self, mut x: u16, pixels: &[u8], thresholds: &[u8]) {
        for (pixels, &thresholds) in pixels.as_chunks::<PIXELS>().0.iter().zip(thresholds.as_chunks::<2>().0)
        {
            let mask = below(pixels, thresholds);
            let mut changes = mask ^ (mask << 1 | self.dark);
            self.dark = mask >> (PIXELS - 1);
            while changes != 0 {
                self.push(x + changes.trailing_zeros() as u16);
                changes &= changes - 1;
            }
            x += PIXELS as u16;
        }
    }

    fn push(&mut self, x: u16) {
        if let Some(slot) = self.list.data.get_mut(self.found) {
            slot.x = x;
        }
        self.found += 1;
    }
}

/// One bit for each pixel of two cells that is below the cell's threshold, first pixel lowest.
///
/// All eight at once: the comparison of bytes in a word, then the gathering of their top bits by a multiplication.
fn below(pixels: &[u8; PIXELS], [left, right]: [u8; 2]) -> u8 {
    const TOP: u64 = 0x8080_8080_8080_8080;
    let x = u64::from_le_bytes(*pixels);
    let t = u64::from(left) * 0x0101_0101 + u64::from(right) * 0x0101_0101_0000_0000;
    // Difference of the low seven bits with a guard bit, then corrected by the top bits.
    let low = (x | TOP) - (t & !TOP);
    let less = ((!x & t) | (!(x ^ t) & !low)) & TOP;
    ((less >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_half_has_its_own_threshold() {
        assert_eq!(below(&[100; PIXELS], [101, 100]), 0x0f);
        assert_eq!(below(&[100; PIXELS], [0, 255]), 0xf0);
    }

    #[test]
    fn below_agrees_with_a_comparison_for_every_pair() {
        for threshold in 0..=255u8 {
            for level in 0..=255u8 {
                for place in 0..PIXELS {
                    let mut pixels = [threshold; PIXELS];
                    pixels[place] = level;
                    assert_eq!(below(&pixels, [threshold; 2]), u8::from(level < threshold) << place);
                }
            }
        }
    }
}
