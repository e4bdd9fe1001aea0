//! The last rows of the frame.

use super::kernel::{Line, WORDS};
use super::strips::STRIP;

/// Rows in a block, the unit in which thresholds change.
pub(crate) const BLOCK_ROWS: usize = 4;
/// Blocks kept: the one in work and its neighbours above and below.
pub(crate) const KEPT_BLOCKS: usize = 3;
pub(crate) const KEPT_ROWS: usize = BLOCK_ROWS * KEPT_BLOCKS;

/// Ring of the last 12 rows, each padded to whole strips with its last pixel.
#[derive(Debug)]
pub(crate) struct Rows<'s> {
    /// Words, so that whole ones can be taken in and compared.
    data: &'s mut [u32],
    width: u16,
    height: u16,
    pushed: u16,
    /// Words of a row, and where the next one goes.
    stride: usize,
    next: usize,
}

impl<'s> Rows<'s> {
    pub fn new(data: &'s mut [u32]) -> Self {
        Self { data, width: 0, height: 0, pushed: 0, stride: 0, next: 0 }
    }

    pub fn capacity(&self) -> usize {
        self.data.len() / KEPT_ROWS * size_of::<u32>()
    }

    pub fn begin(&mut self, width: u16, height: u16) {
        (self.width, self.height, self.pushed) = (width, height, 0);
        (self.stride, self.next) = (usize::from(width).div_ceil(STRIP) * WORDS, 0);
    }

    pub fn width(&self) -> u16 {
        self.width
    }

    pub fn height(&self) -> u16 {
        self.height
    }

    /// Number of rows taken so far.
    pub fn pushed(&self) -> u16 {
        self.pushed
    }

    /// Whether the newest row is the last of its block.
    pub fn block_complete(&self) -> bool {
        self.pushed.is_multiple_of(BLOCK_ROWS as u16)
    }

    /// Counts a row whose pixels nobody looks at.
    pub fn skip(&mut self) {
        self.advance();
    }

    /// Counts a row; gives its place.
    fn advance(&mut self) -> core::ops::Range<usize> {
        let place = self.next..self.next + self.stride;
        self.pushed += 1;
        self.next = if place.end == KEPT_ROWS * self.stride { 0 } else { place.end };
        place
    }

    pub fn push(&mut self, row: &[u8]) {
        let place = self.advance();
        let Some(kept) = self.data.get_mut(place) else { return };
        // A row that begins at a word is copied by words.
        if let Ok(words) = bytemuck::try_cast_slice::<u8, Line>(row) {
            copy(kept.as_chunks_mut().0, words);
        } else if let Some((kept, padding)) = bytemuck::cast_slice_mut(kept).split_at_mut_checked(row.len()) {
            kept.copy_from_slice(row);
            padding.fill(row.last().copied().unwrap_or(0));
        }
    }

    /// Row `y`, padded; it must be one of the last 12. Rows beyond the frame repeat the nearest one.
    pub fn row(&self, y: u16) -> &[u8] {
        bytemuck::cast_slice(self.words(y))
    }

    /// The same, strip by strip.
    pub fn lines(&self, y: u16) -> &[Line] {
        self.words(y).as_chunks().0
    }

    fn words(&self, y: u16) -> &[u32] {
        let slot = self.slot(y.min(self.pushed.saturating_sub(1)));
        self.data.get(slot).unwrap_or(&[])
    }

    /// As many rows, row `y` the first, which must be one of the last 12 or above the frame, as are kept; those outside the
    /// frame repeat the nearest.
    pub fn rows_after(&self, y: i32) -> [&[u8]; KEPT_ROWS] {
        let last = i32::from(self.pushed.saturating_sub(1));
        core::array::from_fn(|i| self.row((y + i as i32).clamp(0, last) as u16))
    }

    fn slot(&self, y: u16) -> core::ops::Range<usize> {
        let first = usize::from(y) % KEPT_ROWS * self.stride;
        first..first + self.stride
    }
}

#[cfg(all(target_arch = "arm", target_os = "none"))]
use crate::arm::copy;

/// Copies lines by twos, each of which the compiler copies in place; a loop over single ones it would replace by a routine
/// that is slow on small processors.
#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn copy(to: &mut [Line], from: &[Line]) {
    let ((to, last), (from, odd)) = (to.as_chunks_mut(), from.as_chunks());
    for ([a, b], [c, d]) in to.iter_mut().zip(from) {
        (*a, *b) = (*c, *d);
    }
    if let ([a], [c]) = (last, odd) {
        *a = *c;
    }
}
