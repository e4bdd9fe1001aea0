//! Where around an ellipse there are edge points, how far from it they are there, and in what light.

use crate::math;
use crate::settings::limits;

/// Gaps are counted in parts of a turn.
pub(crate) const PARTS: u32 = 32;
/// Sectors of an ellipse.
const SECTORS: u32 = 128;
/// Shortest stretch of an outline without edge points that is a gap, px: where the outline bends most there may be none in
/// half of that.
const GAP: f32 = 5.0;
/// What hides a part of the edge reaches so far beyond its own border in the profiles, px: blur, and samples beside the edge.
const BORDER: f32 = 1.4;

/// Sectors of an ellipse, one bit each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sectors(pub u128);

impl Sectors {
    /// The bit of the sector of a point in the frame where the ellipse is the unit circle.
    pub fn sector(u: f32, v: f32) -> u128 {
        1 << index(u, v, SECTORS)
    }

    /// The same without short gaps, of an ellipse with this semi-minor axis, px.
    #[inline(never)]
    pub fn closed(self, minor: f32) -> Self {
        let steps = steps(0.5 * GAP, minor);
        let mut sectors = self;
        for _ in 0..steps {
            sectors = sectors.grown();
        }
        for _ in 0..steps {
            sectors = sectors.shrunk();
        }
        Self(sectors.0 | self.0)
    }

    /// The same without what is beside the gaps.
    pub fn without_ends(self, minor: f32) -> Self {
        (0..steps(BORDER, minor)).fold(self.closed(minor), |sectors, _| sectors.shrunk())
    }

    /// With the sectors before and after.
    fn grown(self) -> Self {
        Self(self.0 | self.0.rotate_left(1) | self.0.rotate_right(1))
    }

    /// Without the first and the last ones.
    fn shrunk(self) -> Self {
        Self(self.0 & self.0.rotate_left(1) & self.0.rotate_right(1))
    }

    /// Longest gap, in 32nds of a turn, rounded up.
    pub fn longest_gap(self) -> u32 {
        let mut empty = !self.0;
        let mut longest = 0;
        while empty != 0 && longest < SECTORS {
            empty &= empty.rotate_left(1);
            longest += 1;
        }
        (longest * PARTS).div_ceil(SECTORS)
    }
}

/// Number of sectors in which a stretch of an ellipse with this semi-minor axis ends, px.
fn steps(stretch: f32, minor: f32) -> u32 {
    const SHARE: f32 = SECTORS as f32 / core::f32::consts::TAU;
    (SHARE * stretch / minor.max(1.0) + 1.0) as u32
}

/// Which of `count` sectors, a power of two, holds the point.
#[inline(never)]
fn index(u: f32, v: f32, count: u32) -> u32 {
    let turn = math::approx::atan2(v, u) * (0.5 / core::f32::consts::PI) + 1.0;
    (turn * count as f32) as u32 & (count - 1)
}

/// Shortest sector in which the light is measured, px: each has two crossings or more of a whole outline.
const SHORTEST: f32 = 2.9;

/// Places around a circle at which the light is one by itself.
pub(super) const PLACES: usize = 8;

/// Light beside the edge by sector: 16 to 128 sectors of about 3 to 6 px.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectorLight {
    count: u32,
    /// Sum of the excess, 1/256 of the contrast, and number of edge points.
    sums: [(i16, u8); SECTORS as usize],
}

impl SectorLight {
    /// For an ellipse with this semi-minor axis, px.
    pub fn new(minor: f32) -> Self {
        let fit = core::f32::consts::TAU * minor / SHORTEST;
        let count = [128, 64, 32].into_iter().find(|&count| count as f32 <= fit).unwrap_or(16);
        Self { count, sums: [(0, 0); SECTORS as usize] }
    }

    /// Adds the excess of a point.
    pub fn add(&mut self, u: f32, v: f32, excess: i8) {
        if let Some((sum, count)) = self.sums.get_mut(index(u, v, self.count) as usize) {
            *sum = sum.saturating_add(i16::from(excess));
            *count = count.saturating_add(1);
        }
    }

    /// Variance of the light from place to place around the circle, each an eighth of a turn, in these sectors: without what the
    /// noise gives, in units of the contrast.
    pub fn variance(&self, sectors: Sectors, noise: f32) -> f32 {
        let mut places = [(0.0f32, 0.0f32); PLACES];
        let each = SECTORS / self.count.max(1);
        for (i, &(sum, count)) in (0..self.count).zip(&self.sums) {
            if sectors.0 >> (i * each) & 1 != 0
                && let Some((all, points)) = places.get_mut((i * PLACES as u32 / self.count.max(1)) as usize)
            {
                *all += f32::from(sum) / 256.0;
                *points += f32::from(count);
            }
        }
        let (sum, points, squares, filled) = places.iter().filter(|(_, points)| *points > 0.0).fold(
            (0.0, 0.0, 0.0, 0.0),
            |(sum, points, squares, filled), &(more, count)| {
                (sum + more, points + count, squares + more * more / count, filled + 1.0)
            },
        );
        if filled < 2.0 {
            return 0.0;
        }
        let chance = 0.5 * noise * noise * (filled - 1.0 + 2.0 * math::sqrt(2.0 * filled));
        ((squares - sum * sum / points - chance) / points).max(0.0)
    }

    /// The sectors whose mean is that of most, and that hardly other than none, for noise in units of the contrast.
    pub fn even(&self, noise: f32) -> Sectors {
        let mean = |sum: i16, count: u8| f32::from(sum) / (256.0 * f32::from(count.max(1)));
        let filled =
            || self.sums.iter().filter(|(_, count)| *count > 0).map(|&(sum, count)| mean(sum, count));
        let middle = median(filled).clamp(-limits::UNEVEN, limits::UNEVEN);
        // Each of the sectors here is some of those of the mask.
        let each = SECTORS / self.count.max(1);
        let (mut filled, mut uneven, mut suspect) = (Sectors(0), Sectors(0), Sectors(0));
        for (i, &(sum, count)) in self.sums.iter().enumerate().filter(|(_, (_, count))| *count > 0) {
            let sigma = noise / math::sqrt(2.0 * f32::from(count));
            let excess = (mean(sum, count) - middle).abs();
            let bits = (u128::MAX >> (SECTORS - each)) << (i as u32 * each % SECTORS);
            let mark = |sectors: &mut Sectors, over: bool| sectors.0 |= if over { bits } else { 0 };
            mark(&mut filled, true);
            mark(&mut uneven, excess > limits::UNEVEN + limits::UNEVEN_SIGMAS * sigma);
            mark(&mut suspect, excess > 0.2 * limits::UNEVEN + sigma);
        }
        // Glare and shadows have no border: what is beside uneven light is judged by less.
        for _ in 0..SECTORS {
            let grown = Sectors(uneven.0 | (uneven.grown().0 & suspect.0));
            if grown.0 == uneven.0 {
                break;
            }
            uneven = grown;
        }
        Sectors(filled.0 & !uneven.0)
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
