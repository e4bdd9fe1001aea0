//! Where a row passes the threshold.

use super::strips::{STRIP, Strips};

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

    /// Takes the dark runs of row `row` of the block in work, in a frame of this width. Returns how many did not fit.
    pub fn fill(&mut self, strips: &Strips<'_>, row: usize, width: u16) -> u32 {
        let mut found = 0;
        let mut push = |x: u16| {
            if let Some(slot) = self.data.get_mut(found) {
                slot.x = x;
            }
            found += 1;
        };
        // 1 if the last pixel was dark.
        let mut before = 0;
        for (x, dark) in strips.dark(row) {
            let mut changes = dark ^ (dark << 1 | before);
            before = dark >> (STRIP - 1);
            while changes != 0 {
                // What is beyond the frame repeats its last pixel, but may be of another cell.
                push((x + changes.trailing_zeros() as u16).min(width));
                changes &= changes - 1;
            }
        }
        if before != 0 {
            push(width);
        }
        // Runs are dropped whole, so that the list stays even.
        self.len = found.min(self.data.len() & !1);
        ((found - self.len) / 2) as u32
    }
}
