//! The local threshold, and which pixels are below it.
//!
//! A block of four rows is divided into strips 32 px wide, and these into four cells. A cell's threshold is the middle
//! between the darkest and the brightest sample of the 3 x 3 cells about it, if these differ by more than noise does. In flat
//! surroundings there is no edge to place; there the threshold of the cell above is kept, so that the inside of a large
//! dark circle stays dark, and is only pushed away where the light drifts towards it, so that shading makes no edge of its
//! own.
//!
//! One pixel in four is a sample: four in a row, then the next four two rows below. No circle is so small that it passes
//! between them. A strip is calm as long as its samples stay in the window in which they were when it was last measured; in
//! calm surroundings nothing else is done to it, and its pixels are all taken to be on one side.

use super::kernel::{self, Best, Bytes as _, Line, MOST, ONES, TOP, WORDS};
use super::noise::{Noise, Ranges};
use super::rows::{BLOCK_ROWS, Rows};
use super::runs::Budget;
use crate::list::rolled;
use crate::region::Regions;
use crate::settings::Polarity;

mod calm;
mod figure;
mod given;
mod inside;
#[cfg(test)]
mod tests;
mod threshold;

pub(super) use calm::calm;
use figure::{cells, is_crowded};
use threshold::{Columns, column, thresholds};

/// Width of a strip, px.
pub(crate) const STRIP: usize = 4 * WORDS;
/// Bytes needed for the strips, in widths of the frame.
pub(crate) const STRIP_WIDTHS: usize = 2;
/// Cells whose ranges make a noise figure.
const CELLS_WANTED: u16 = 64;
/// Blocks in one of which a strip tells of the noise though it is calm ...
const CHOSEN_BLOCKS: u16 = 2;
/// ... and from one such strip to the next, times that: coprime to most numbers of strips.
const CHOSEN_STEP: usize = 11;
/// Rows of a block with samples.
const SAMPLED: [u16; 2] = [1, 3];

/// A strip. Levels are halved, and words have a byte for each cell.
pub(super) type Strip = [u32; SIZE];
const SIZE: usize = 16;
/// Smallest samples of the cells in the blocks above, in and below the work.
const LOW: usize = 0;
/// Largest samples.
const HIGH: usize = LOW + 3;
/// Thresholds of the block in work.
const THRESHOLDS: usize = HIGH + 3;
/// Dark pixels of its rows, one bit each.
const DARK: usize = THRESHOLDS + 1;
/// Lower end of the window, as [`kernel::within`] takes it.
pub(crate) const WINDOW: usize = DARK + BLOCK_ROWS;
/// Flags.
pub(crate) const FLAGS: usize = WINDOW + 1;
/// The next strip that is of interest in the block in work.
const NEXT: usize = FLAGS + 1;

/// The block after the last in which a region of the frame has it.
const UNTIL: usize = NEXT + 1;

/// Flags: restless in the newest block and in the two before.
pub(crate) const RESTLESS: u32 = 0b111;
/// Flag: calm, but at another level than the strip on the right or on the left.
const STEP_RIGHT: u32 = 1 << 3;
const STEP_LEFT: u32 = 1 << 4;
/// Flag: dark.
const SIDE: u32 = 1 << 5;
/// Flags of a strip that is not all on one side.
const ACTIVE: u32 = RESTLESS | STEP_RIGHT | STEP_LEFT;

/// Smallest and largest samples of the cells of a strip.
pub(super) type Extremes = [u32; 2];
/// Those of nothing.
const NOTHING: Extremes = [MOST, 0];
/// A strip of which nothing is known, on paper for targets of this polarity: until an edge tells better, what is flat is
/// taken for the paper.
fn unknown(targets: Polarity) -> Strip {
    let ([low, high], mut strip) = (NOTHING, [0; SIZE]);
    (strip[LOW], strip[LOW + 1], strip[LOW + 2]) = (low, low, low);
    (strip[HIGH], strip[HIGH + 1], strip[HIGH + 2]) = (high, high, high);
    if targets == Polarity::Light {
        (strip[THRESHOLDS], strip[FLAGS]) = (MOST, SIDE);
    }
    strip
}
/// No strip.
const END: u32 = u32::MAX;
/// No [`SIDE`]: an active strip ends differently in each row.
const BOTH: u32 = u32::MAX;

/// The strips of a frame.
#[derive(Debug)]
pub(crate) struct Strips<'s> {
    data: &'s mut [u32],
    count: usize,
    blocks: u16,
    /// Blocks since a strip was restless.
    calm_blocks: u16,
    /// The first strip that is of interest in the block in work.
    first: u32,
    noise: Noise,
    targets: Polarity,
    /// Whether the dark pixels come from elsewhere, and the word of a strip that has those of the first row of the block.
    given: bool,
    dark: usize,
}

impl<'s> Strips<'s> {
    pub fn new(data: &'s mut [u32]) -> Self {
        let noise = Noise::NONE;
        let targets = Polarity::Dark;
        Self {
            data,
            count: 0,
            blocks: 0,
            calm_blocks: 0,
            first: END,
            noise,
            targets,
            given: false,
            dark: DARK,
        }
    }

    pub fn begin(&mut self, width: u16, targets: Polarity) {
        self.count = usize::from(width).div_ceil(STRIP);
        (self.blocks, self.first, self.given, self.dark) = (0, END, false, DARK);
        self.targets = targets;
        rolled(self.all_mut()).for_each(|strip| *strip = unknown(targets));
    }

    fn all_mut(&mut self) -> &mut [Strip] {
        strips_mut(self.data, self.count)
    }

    fn get(&self, at: usize) -> Option<&Strip> {
        self.data.as_chunks().0.get(..self.count)?.get(at)
    }

    /// Whether the dark pixels come from elsewhere.
    pub fn are_given(&self) -> bool {
        self.given
    }

    /// Blocks measured so far.
    pub fn blocks(&self) -> u16 {
        self.blocks
    }

    /// Smallest difference of grey levels that counts as an edge.
    pub fn min_contrast(&self) -> u8 {
        self.noise.contrast * 2
    }

    /// Looks at the samples of the next block of rows (the last row is repeated where the frame ends), as far as they lie in
    /// a region. A frame with regions takes the noise for that of the last one without.
    pub fn measure(&mut self, rows: &Rows<'_>, regions: &mut Regions<'_>) {
        let is_whole = regions.are_all();
        if !is_whole && !self.enters(regions) {
            return;
        }
        let frame = rows.width();
        let first = self.blocks * BLOCK_ROWS as u16;
        let [a, b] = SAMPLED.map(|row| rows.lines(first + row));
        if self.blocks == 0 && is_whole {
            self.look_at_first(rows);
        }
        let contrast = self.noise.contrast;
        let width = u32::from(contrast) * ONES;
        if self.blocks.is_multiple_of(CHOSEN_BLOCKS) && is_whole {
            // A strip that is not chosen for its edges.
            let chosen = usize::from(self.blocks) * CHOSEN_STEP % self.count.max(1);
            if let (Some(a), Some(b)) = (a.get(chosen), b.get(chosen)) {
                self.noise.cells.add(kernel::extremes(a, b), cells(chosen, frame));
            }
        }
        // Most blocks have none, and it is large.
        let mut restless = None;
        let mut inside = if is_whole { 0..self.count } else { 0..0 };
        loop {
            if inside.is_empty() && !is_whole {
                inside = self.inside(inside.end);
            }
            let Self { data, count, blocks, .. } = &mut *self;
            // Every other word, and the others in the next block.
            let even = blocks.is_multiple_of(2);
            let strips = strips_mut(data, *count);
            let from = inside.start;
            let (looked, lines) = (strips.get_mut(inside.clone()), a.get(from..));
            let (looked, lines) = (looked.unwrap_or_default(), lines.unwrap_or_default());
            inside.start +=
                if even { calm::<0>(looked, lines, width) } else { calm::<1>(looked, lines, width) };
            if inside.is_empty() {
                // No strips, or the last of a region.
                if inside.start == from || is_whole {
                    break;
                }
                continue;
            }
            let i = inside.start;
            let (Some(strip), Some(a), Some(b)) = (strips.get_mut(i), a.get(i), b.get(i)) else { break };
            inside.start += 1;
            age(strip);
            let extremes = kernel::extremes(a, b);
            restless.get_or_insert(Ranges::NONE).add(extremes, cells(i, frame));
            take(strip, extremes, contrast);
        }
        if is_whole {
            self.settle(restless.as_ref(), frame);
        }
        self.blocks += 1;
        self.calm_blocks += 1;
        if restless.is_some() {
            self.calm_blocks = 0;
            self.find_steps(contrast);
        }
    }

    /// Opens the regions that begin with the block; whether any is under way. Otherwise the block is over.
    fn enters(&mut self, regions: &mut Regions<'_>) -> bool {
        while let Some(region) = regions.reach(self.blocks) {
            self.open(region);
        }
        let under_way = regions.is_under_way(self.blocks);
        if under_way {
            self.leave();
        } else {
            self.blocks += 1;
            self.calm_blocks += 1;
        }
        under_way
    }

    /// Takes what the strips that are not calm tell of the noise, and settles what is known of it. Where there are too many of
    /// them they count alone, with their edges.
    #[inline(always)]
    fn settle(&mut self, restless: Option<&Ranges>, frame: u16) {
        let crowded = restless.filter(|restless| is_crowded(restless, frame));
        match (crowded, restless) {
            (Some(crowded), _) if self.blocks > 0 => self.noise.cells = *crowded,
            (_, Some(restless)) => self.noise.add_flat(restless),
            _ => (),
        }
        if crowded.is_some() || self.noise.cells.count >= CELLS_WANTED {
            self.noise.settle();
        }
    }

    /// Compares strips that were measured with those beside them.
    fn find_steps(&mut self, contrast: u8) {
        let strips = self.all_mut();
        for i in 1..strips.len() {
            let Some([left, right]) = strips.get_mut(i - 1..=i) else { break };
            if (left[FLAGS] | right[FLAGS]) & 1 != 0 {
                let [a, b] = [&*left, &*right].map(|strip| strip[WINDOW] & 0xff);
                let step = a != 0 && b != 0 && 2 * a.abs_diff(b) >= u32::from(contrast);
                left[FLAGS] = left[FLAGS] & !STEP_RIGHT | if step { STEP_RIGHT } else { 0 };
                right[FLAGS] = right[FLAGS] & !STEP_LEFT | if step { STEP_LEFT } else { 0 };
            }
        }
    }

    /// Moves the thresholds to the block above the newest measured, and finds the dark pixels of its rows. Strips that are too
    /// busy for the budget are left out; returns how many runs were dropped with them.
    pub fn resolve(&mut self, rows: &Rows<'_>, budget: &mut Budget) -> u32 {
        if self.given {
            return self.resolve_given(budget);
        }
        if self.first == END && self.calm_blocks > 2 {
            return 0;
        }
        let mut dropped = 0;
        let first = self.blocks.saturating_sub(2) * BLOCK_ROWS as u16;
        let lines = [0, 1, 2, 3].map(|i| rows.lines(first + i));
        // A frame is light outside.
        let (mut side, mut last, mut columns) = (0, END, Columns::NONE);
        self.first = END;
        let mut i = 0;
        while let Some(at) = self.next_of_interest(i, side) {
            let Some(strip) = self.all_mut().get_mut(at) else { break };
            let flags = strip[FLAGS];
            if flags & ACTIVE != 0 {
                i = at + 1;
                let dark = self.resolve_active(at, &mut columns, lines.map(|row| row.get(at)));
                if let Some(runs) = budget.take_strip(dark) {
                    dropped += runs;
                    continue;
                }
                side = BOTH;
            } else {
                side = flags & SIDE;
                strip[DARK..WINDOW].fill(if side != 0 { !0 } else { 0 });
            }
            self.follow(last, at as u32);
            last = at as u32;
            i = at + 1;
        }
        dropped
    }

    /// The first strip from `from` on that is not all on the side `side`.
    fn next_of_interest(&self, from: usize, side: u32) -> Option<usize> {
        let strips = self.data.as_chunks::<SIZE>().0.get(from..self.count)?;
        Some(from + strips.iter().position(|strip| strip[FLAGS] & (ACTIVE | SIDE) != side)?)
    }

    /// The same for a strip that has edges. Returns its dark pixels.
    fn resolve_active(
        &mut self,
        i: usize,
        columns: &mut Columns,
        lines: [Option<&Line>; BLOCK_ROWS],
    ) -> [u32; BLOCK_ROWS] {
        let column = |i: Option<usize>| i.and_then(|i| self.get(i)).map_or(NOTHING, column);
        if columns.at == i && i > 0 {
            let [_, left, here] = columns.extremes;
            columns.extremes = [left, here, column(Some(i + 1))];
        } else {
            columns.extremes = [column(i.checked_sub(1)), column(Some(i)), column(Some(i + 1))];
        }
        columns.at = i + 1;
        let about = columns.about();
        let (contrast, targets) = (self.noise.contrast, self.targets);
        let Some(strip) = self.all_mut().get_mut(i) else { return [0; BLOCK_ROWS] };
        let thresholds = thresholds(strip[THRESHOLDS], about, contrast, targets);
        strip[THRESHOLDS] = thresholds;
        let dark = Best::dark(lines, thresholds);
        let [a, b, c, d] = dark;
        (strip[DARK], strip[DARK + 1], strip[DARK + 2], strip[DARK + 3]) = (a, b, c, d);
        strip[FLAGS] &= !SIDE;
        match kernel::at_least(strip[LOW + 2], thresholds) {
            0 => strip[FLAGS] |= SIDE,
            MOST => (),
            // Not to be left alone.
            _ => strip[WINDOW] = 0,
        }
        dark
    }

    /// Puts strip `i` after `last` in the list of those that are of interest.
    fn follow(&mut self, last: u32, i: u32) {
        if let Some(strip) = self.all_mut().get_mut(i as usize) {
            strip[NEXT] = END;
        }
        match self.all_mut().get_mut(last as usize) {
            Some(strip) => strip[NEXT] = i,
            None => self.first = i,
        }
    }

    /// Whether no row of the block in work has a dark pixel.
    pub fn all_light(&self) -> bool {
        self.first == END
    }

    /// The strips in which row `row` of the block in work may change sides: first columns, and dark pixels one bit each.
    pub fn dark(&self, row: usize) -> impl Iterator<Item = (u16, u32)> {
        let mut at = self.first;
        core::iter::from_fn(move || {
            let strip = self.get(at as usize)?;
            let x = at as u16 * STRIP as u16;
            at = strip[NEXT];
            Some((x, *strip.get(self.dark + row)?))
        })
    }
}

fn strips_mut(data: &mut [u32], count: usize) -> &mut [Strip] {
    data.as_chunks_mut().0.get_mut(..count).unwrap_or_default()
}

/// The block in work becomes the one above it, and the newest is taken to be as the one before.
#[inline(never)]
fn age(strip: &mut Strip) {
    (strip[LOW], strip[LOW + 1]) = (strip[LOW + 1], strip[LOW + 2]);
    (strip[HIGH], strip[HIGH + 1]) = (strip[HIGH + 1], strip[HIGH + 2]);
    strip[FLAGS] = strip[FLAGS] & !RESTLESS | strip[FLAGS] << 1 & RESTLESS;
}

/// Takes the extremes of the newest block, and a window about them if they are near to each other.
fn take(strip: &mut Strip, [low, high]: Extremes, contrast: u8) {
    (strip[LOW + 2], strip[HIGH + 2]) = (low, high);
    strip[FLAGS] |= 1;
    let least = low.to_le_bytes().into_iter().fold(u8::MAX, u8::min);
    let most = high.to_le_bytes().into_iter().fold(0, u8::max);
    let middle = (least + most).div_ceil(2);
    let first = middle.saturating_sub((contrast - 1) / 2);
    strip[WINDOW] = if most - least < contrast { TOP - u32::from(first) * ONES } else { 0 };
}
