//! Fixed buffers, sized by the caller.

use crate::scan::{Crossing, KEPT_BLOCKS, Outline, STRIP, STRIP_WIDTHS, Transition};

/// Transitions of a row that fit for each outline in the table.
const TRANSITIONS_PER_OUTLINE: usize = 4;

/// The memory of a [`Detector`](crate::Detector); its size does not depend on the height of the frame.
///
/// * `WIDTH`: widest frame, px; a multiple of 32, at most 4096.
/// * `OUTLINES`: outlines that can be open or waiting at the same time; at most 65534. An open target has one for each
///   circle; clutter that crosses the same rows counts too. Four transitions a row for each of them.
/// * `CROSSINGS`: places where the rows and columns under way cross an outline; at most 65535. A circle of radius R px
///   takes about 6.2 R of them from its first row until its target is measured.
///
/// All zero at first, so that a `static` costs no flash.
#[derive(Debug)]
pub struct Storage<const WIDTH: usize, const OUTLINES: usize, const CROSSINGS: usize> {
    /// Four rows a block, so a word for each column.
    rows: [[u32; WIDTH]; KEPT_BLOCKS],
    strips: Words<[[u8; WIDTH]; STRIP_WIDTHS]>,
    transitions: [[[Transition; TRANSITIONS_PER_OUTLINE]; OUTLINES]; 2],
    outlines: [Outline; OUTLINES],
    crossings: [Crossing; CROSSINGS],
}

impl<const WIDTH: usize, const OUTLINES: usize, const CROSSINGS: usize> Storage<WIDTH, OUTLINES, CROSSINGS> {
    /// Size in bytes.
    pub const BYTES: usize = size_of::<Self>();

    const CHECKED: () = {
        assert!(
            WIDTH.is_multiple_of(STRIP) && WIDTH <= crate::MAX_WIDTH as usize,
            "WIDTH: a multiple of 32 up to 4096"
        );
        assert!(OUTLINES < u16::MAX as usize, "OUTLINES: at most 65534");
        assert!(CROSSINGS <= u16::MAX as usize, "CROSSINGS: at most 65535");
    };

    /// Empty storage. Wrong sizes do not compile.
    pub const fn new() -> Self {
        const { Self::CHECKED };
        Self {
            rows: [[0; WIDTH]; KEPT_BLOCKS],
            strips: Words([[0; WIDTH]; STRIP_WIDTHS]),
            transitions: [[[Transition::ZERO; TRANSITIONS_PER_OUTLINE]; OUTLINES]; 2],
            outlines: [Outline::ZERO; OUTLINES],
            crossings: [Crossing::ZERO; CROSSINGS],
        }
    }

    pub(crate) fn buffers(&mut self) -> Buffers<'_> {
        let [previous, current] = &mut self.transitions;
        Buffers {
            rows: self.rows.as_flattened_mut(),
            strips: bytemuck::try_cast_slice_mut(self.strips.0.as_flattened_mut()).unwrap_or_default(),
            previous: previous.as_flattened_mut(),
            current: current.as_flattened_mut(),
            outlines: &mut self.outlines,
            crossings: &mut self.crossings,
        }
    }
}

impl<const WIDTH: usize, const OUTLINES: usize, const CROSSINGS: usize> Default
    for Storage<WIDTH, OUTLINES, CROSSINGS>
{
    fn default() -> Self {
        Self::new()
    }
}

/// Bytes that can be taken as words.
#[derive(Debug)]
#[repr(align(4))]
struct Words<T>(T);

/// [`Storage`] without its sizes, so that the code that uses it is compiled once.
#[derive(Debug)]
pub(crate) struct Buffers<'s> {
    pub rows: &'s mut [u32],
    pub strips: &'s mut [u32],
    pub previous: &'s mut [Transition],
    pub current: &'s mut [Transition],
    pub outlines: &'s mut [Outline],
    pub crossings: &'s mut [Crossing],
}
