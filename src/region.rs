//! Parts of a frame to which the search is limited.

use crate::scan::BLOCK_ROWS;

/// A part of a frame, px; the first and the last pixel are in it.
///
/// The scan works in cells, and takes in all those that the region touches: 4 rows high, 32 columns wide. It begins at the
/// region as at the border of a frame, with what is outside taken for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Region {
    /// First row.
    pub top: u16,
    /// Last row.
    pub bottom: u16,
    /// First column.
    pub left: u16,
    /// Last column.
    pub right: u16,
}

impl Region {
    /// Blocks of rows that it touches, first and last.
    fn blocks(&self) -> (u16, u16) {
        (self.top / BLOCK_ROWS as u16, self.bottom / BLOCK_ROWS as u16)
    }
}

/// The regions of a frame under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Regions<'r> {
    /// Those not yet reached; `None`: the whole frame.
    rest: Option<&'r [Region]>,
    /// After the last block of those that were reached.
    until: u16,
    /// Height of the frame, in blocks.
    blocks: u16,
}

impl<'r> Regions<'r> {
    /// The whole frame.
    pub const fn all() -> Self {
        Self { rest: None, until: 0, blocks: 0 }
    }

    /// Those of `list`, or the number of the first that does not lie within the frame or begins above the one before.
    pub fn new(list: &'r [Region], (width, height): (u16, u16)) -> Result<Self, usize> {
        let mut above = 0;
        for (at, region) in list.iter().enumerate() {
            let Region { top, bottom, left, right } = *region;
            if top < above || top > bottom || bottom >= height || left > right || right >= width {
                return Err(at);
            }
            above = top;
        }
        Ok(Self { rest: Some(list), until: 0, blocks: height.div_ceil(BLOCK_ROWS as u16) })
    }

    /// Whether it is the whole frame.
    pub fn are_all(&self) -> bool {
        self.rest.is_none()
    }

    /// Whether the pixels of row `y` are looked at: those of a region, and of two blocks above and below it, in which its
    /// edge profiles may reach.
    pub fn need(&self, y: u16) -> bool {
        let Some(rest) = self.rest else { return true };
        let block = y / BLOCK_ROWS as u16;
        self.is_under_way(block) || rest.first().is_some_and(|next| next.blocks().0 <= block + 2)
    }

    /// Whether a region has not ended more than a block above this one.
    pub fn is_under_way(&self, block: u16) -> bool {
        self.until > 0 && block <= self.until.saturating_add(1)
    }

    /// The next region that begins in `block` or above: its columns, and the block after its last one. A region that the
    /// frame ends does not end.
    pub fn reach(&mut self, block: u16) -> Option<(u16, u16, u16)> {
        let (next, rest) = self.rest?.split_first()?;
        let (top, bottom) = next.blocks();
        if top > block {
            return None;
        }
        self.rest = Some(rest);
        let until = if bottom + 1 >= self.blocks { u16::MAX } else { bottom + 1 };
        self.until = self.until.max(until);
        Some((next.left, next.right, until))
    }
}
