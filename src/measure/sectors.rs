//! Where around an ellipse there are edge points, how far from it they are there, and in what light.

use crate::math;
use crate::settings::limits;

/// Gaps are counted in parts of a turn.
pub(crate) const PARTS: u32 = 32;
/// Shortest sector, px: each has two crossings or more of a whole outline.
const SHORTEST: f32 = 2.9;

/// Sectors of an ellipse, one bit each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sectors(pub u128, u32);

impl Sectors {
    /// For an ellipse with this semi-minor axis, px: 16 to 128 sectors of about 3 to 6 px.
    pub fn new(minor: f32) -> Self {
        let fit = core::f32::consts::TAU * minor / SHORTEST;
        let count = [128, 64, 32].into_iter().find(|&count| count as f32 <= fit);
        Self(0, count.unwrap_or(16))
    }

    /// All of them.
    pub fn all(minor: f32) -> Self {
        let Self(_, count) = Self::new(minor);
        Self(u128::MAX >> (128 - count), count)
    }

    /// The bit of the sector of a point in the frame where the ellipse is the unit circle.
    pub fn sector(&self, u: f32, v: f32) -> u128 {
        1 << self.index(u, v)
    }

    fn index(&self, u: f32, v: f32) -> u32 {
        let turn = math::approx::atan2(v, u) * (0.5 / core::f32::consts::PI) + 1.0;
        (turn * self.1 as f32) as u32 & (self.1 - 1)
    }

    /// Marks the sector as one with an edge in it. Gives the sixteenth of a turn that it is in.
    pub fn mark(&mut self, u: f32, v: f32) -> usize {
        let index = self.index(u, v);
        self.0 |= 1 << index;
        (16 * index / self.1.max(1)) as usize
    }

    /// The same without those beside a gap. A single empty sector is none: where the outline bends most there may be no point
    /// in it.
    pub fn without_ends(&self) -> u128 {
        let empty = self.empty();
        let pairs = empty & self.turned(empty, 1);
        self.0 & !self.beside(pairs | self.turned(pairs, self.1 - 1))
    }

    /// The sectors before and after these.
    fn beside(&self, sectors: u128) -> u128 {
        self.turned(sectors, 1) | self.turned(sectors, self.1 - 1)
    }

    /// Longest gap, in 32nds of a turn, rounded up.
    pub fn longest_gap(&self) -> u32 {
        let mut empty = self.empty();
        let mut longest = 0;
        while empty != 0 && longest < self.1 {
            empty &= self.turned(empty, 1);
            longest += 1;
        }
        (longest * PARTS).div_ceil(self.1.max(1))
    }

    fn empty(&self) -> u128 {
        !self.0 & self.mask()
    }

    fn mask(&self) -> u128 {
        u128::MAX >> (128 - self.1.clamp(1, 128))
    }

    fn turned(&self, bits: u128, by: u32) -> u128 {
        (bits << by | bits >> (self.1 - by)) & self.mask()
    }
}

/// Most and fewest sectors whose residuals are summed up, and points that each should have: fewer tell nothing of their
/// neighbours, more would average over the waves that a dent leaves around an ellipse.
const MOST_SUMS: usize = 32;
const FEWEST_SUMS: usize = 8;
const POINTS: usize = 3;
/// What is left of the mean square sum on average, in units of that of independent residuals, because a fit of five terms has
/// taken its part.
const FITTED: f32 = 0.7;

/// Residuals by sector.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectorSums {
    sums: [(f32, u16); MOST_SUMS],
    sectors: usize,
    squares: f32,
    count: u16,
}

impl SectorSums {
    /// For this number of points.
    pub fn new(points: u16) -> Self {
        let sectors = (usize::from(points) / POINTS).clamp(FEWEST_SUMS, MOST_SUMS);
        Self { sums: [(0.0, 0); MOST_SUMS], sectors, squares: 0.0, count: 0 }
    }

    /// Adds a residual, px.
    pub fn add(&mut self, u: f32, v: f32, residual: f32) {
        let turn = 0.5 + math::approx::atan2(v, u) * (0.5 / core::f32::consts::PI);
        let sector = ((turn * self.sectors as f32) as usize).min(self.sectors - 1);
        if let Some((sum, count)) = self.sums.get_mut(sector) {
            *sum += residual;
            *count += 1;
            self.squares += residual * residual;
            self.count += 1;
        }
    }

    /// Mean square of the sums in units of that of independent residuals, less its scatter; at least 1.
    pub fn excess(&self) -> f32 {
        let (mut total, mut filled) = (0.0, 0.0);
        for &(sum, count) in self.sums.iter().filter(|(_, count)| *count > 0) {
            total += sum * sum / f32::from(count);
            filled += 1.0;
        }
        let variance = self.squares / f32::from(self.count.max(1));
        // Also takes NaN, where there are no residuals.
        if variance > 0.0 { (total / (filled * variance) - FITTED).max(1.0) } else { 1.0 }
    }
}

/// Most sectors.
const MOST: usize = 128;

/// Light beside the edge by sector.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectorLight {
    sectors: Sectors,
    /// Sum of the excess, 1/256 of the contrast, and number of edge points.
    sums: [(i16, u8); MOST],
}

impl SectorLight {
    /// For an ellipse with this semi-minor axis, px.
    pub fn new(minor: f32) -> Self {
        Self { sectors: Sectors::new(minor), sums: [(0, 0); MOST] }
    }

    /// Adds the excess of a point.
    pub fn add(&mut self, u: f32, v: f32, excess: i8) {
        let sector = self.sectors.sector(u, v);
        if let Some((sum, count)) = self.sums.get_mut(sector.trailing_zeros() as usize) {
            *sum = sum.saturating_add(i16::from(excess));
            *count = count.saturating_add(1);
        }
    }

    /// The sectors whose mean is that of most, and that hardly other than none, for noise in units of the contrast.
    pub fn even(&self, noise: f32) -> Sectors {
        let mean = |sum: i16, count: u8| f32::from(sum) / (256.0 * f32::from(count.max(1)));
        let filled =
            || self.sums.iter().filter(|(_, count)| *count > 0).map(|&(sum, count)| mean(sum, count));
        let middle = median(filled).clamp(-limits::UNEVEN, limits::UNEVEN);
        let (mut filled, mut uneven, mut suspect) = (0u128, 0u128, 0u128);
        for (i, &(sum, count)) in self.sums.iter().enumerate().filter(|(_, (_, count))| *count > 0) {
            let sigma = noise / math::sqrt(2.0 * f32::from(count));
            let excess = (mean(sum, count) - middle).abs();
            let mark = |over: bool| u128::from(over) << i;
            filled |= mark(true);
            uneven |= mark(excess > limits::UNEVEN + limits::UNEVEN_SIGMAS * sigma);
            suspect |= mark(excess > 0.2 * limits::UNEVEN + sigma);
        }
        // Glare and shadows have no border: what is beside uneven light is judged by less.
        for _ in 0..self.sectors.1 {
            let grown = uneven | (self.sectors.beside(uneven) & suspect);
            if grown == uneven {
                break;
            }
            uneven = grown;
        }
        Sectors(filled & !uneven, self.sectors.1)
    }
}

/// The median of some numbers from -1/2 to 1/2, to 1/256.
fn median<I: Iterator<Item = f32>>(numbers: impl Fn() -> I) -> f32 {
    let (mut low, mut high) = (-0.5, 0.5);
    for _ in 0..7 {
        let middle = 0.5 * (low + high);
        let (below, count) =
            numbers().fold((0, 0), |(below, count), x| (below + usize::from(x < middle), count + 1));
        if 2 * below < count { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
