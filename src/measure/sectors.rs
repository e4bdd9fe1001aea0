//! Where around an ellipse there are edge points, how far from it they are there, and in what light.

use crate::fixed::{Inverse, sector};
use crate::list::rolled;
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

/// Sectors of an ellipse, one bit each, in words: small processors have no longer ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sectors([u32; WORDS]);

const WORDS: usize = (SECTORS / u32::BITS) as usize;

impl Sectors {
    pub const NONE: Self = Self([0; WORDS]);
    pub const ALL: Self = Self([u32::MAX; WORDS]);

    pub fn mark(&mut self, sector: u32) {
        if let Some(marks) = self.0.get_mut((sector / u32::BITS) as usize) {
            *marks |= 1 << (sector % u32::BITS);
        }
    }

    pub fn has(&self, sector: u32) -> bool {
        self.0.get((sector / u32::BITS) as usize).is_some_and(|marks| marks >> (sector % u32::BITS) & 1 != 0)
    }

    /// Those that both have, and those that either has.
    fn and(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] & other.0[i]))
    }

    fn or(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] | other.0[i]))
    }

    /// Those that `other` does not have.
    pub fn without(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|i| self.0[i] & !other.0[i]))
    }

    /// The same without short gaps, of an ellipse with this semi-minor axis, px.
    #[inline(never)]
    pub fn closed(&self, minor: f32) -> Self {
        let steps = steps(0.5 * GAP, minor);
        let grown = (0..steps).fold(*self, |sectors, _| sectors.grown());
        (0..steps).fold(grown, |sectors, _| sectors.shrunk()).or(self)
    }

    /// The same without what is beside the gaps.
    #[inline(never)]
    pub fn without_ends(&self, minor: f32) -> Self {
        (0..steps(BORDER, minor)).fold(self.closed(minor), |sectors, _| sectors.shrunk())
    }

    /// With the sectors before and after.
    #[inline(never)]
    fn grown(&self) -> Self {
        let [a, b, c, d] = self.0;
        let grow = |before: u32, at: u32, after: u32| at | at << 1 | before >> 31 | at >> 1 | after << 31;
        Self([grow(d, a, b), grow(a, b, c), grow(b, c, d), grow(c, d, a)])
    }

    /// Without the first and the last ones.
    fn shrunk(&self) -> Self {
        Self::ALL.without(&Self::ALL.without(self).grown())
    }

    /// Longest gap, in 32nds of a turn, rounded up.
    #[inline(never)]
    pub fn longest_gap(&self) -> u32 {
        let mut empty = self.0.map(|marks| !marks);
        let mut longest = 0;
        while empty != [0; WORDS] && longest < SECTORS {
            let mut carry = empty[WORDS - 1];
            for marks in &mut empty {
                let before = *marks << 1 | carry >> (u32::BITS - 1);
                carry = *marks;
                *marks &= before;
            }
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

/// Which sector holds a place in the frame where the ellipse is the unit circle.
#[inline(never)]
pub(super) fn sector_of((u, v): (i32, i32)) -> u32 {
    let by_radius = Inverse::of_root(u.unsigned_abs().pow(2) + v.unsigned_abs().pow(2));
    by_radius.map_or(0, |by_radius| sector((by_radius.cosine(u), by_radius.cosine(v))))
}

/// Shortest sector in which the light is measured, px: each has two crossings or more of a whole outline.
const SHORTEST: f32 = 2.9;

/// Places around a circle at which the light is one by itself.
pub(super) const PLACES: usize = 8;

/// Light beside the edge by sector: 16 to 128 sectors of about 3 to 6 px.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectorLight {
    count: u32,
    /// Binary logarithm of how many of the others each has.
    log: u32,
    /// Largest excess.
    most: u8,
    /// Sum of the excess, 1/256 of the contrast, and number of edge points.
    sums: [(i16, u8); SECTORS as usize],
}

impl SectorLight {
    /// For an ellipse with this semi-minor axis, px.
    pub fn new(minor: f32) -> Self {
        let fit = core::f32::consts::TAU * minor / SHORTEST;
        let log = (0..3).find(|log| (SECTORS >> log) as f32 <= fit).unwrap_or(3);
        Self { count: SECTORS >> log, log, most: 0, sums: [(0, 0); SECTORS as usize] }
    }

    /// Adds the excess of a point in a [`sector_of`].
    pub fn add(&mut self, sector: u32, excess: i8) {
        self.most = self.most.max(excess.unsigned_abs());
        if let Some((sum, count)) = self.sums.get_mut((sector >> self.log) as usize) {
            *sum = sum.saturating_add(i16::from(excess));
            *count = count.saturating_add(1);
        }
    }

    /// Variance of the light from place to place around the circle, each an eighth of a turn, in these sectors: without what the
    /// noise gives, in units of the contrast.
    fn variance(&self, sectors: Sectors, noise: f32) -> f32 {
        let mut places = [(0, 0); PLACES];
        for (i, &(sum, count)) in rolled((0..self.count).zip(&self.sums)) {
            let first = i << self.log;
            if sectors.has(first)
                && let Some((all, points)) = places.get_mut((first / (SECTORS / PLACES as u32)) as usize)
            {
                *all += i32::from(sum);
                *points += u32::from(count);
            }
        }
        let places = places.map(|(all, points)| (all as f32 / 256.0, points as f32));
        let (sum, points, squares, filled) = rolled(&places).filter(|(_, points)| *points > 0.0).fold(
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

    /// The sectors in which the light beside the edge is the same as around most of the circle, and the variance of the light in them
    /// from place to place, in units of the contrast. The noise is that of the samples, and the same without what disturbs them.
    #[inline(never)]
    pub fn judged(&self, (noise, calm): (f32, f32)) -> (Sectors, f32) {
        // Where nothing disturbs the light there is nothing to sort out.
        let disturbed = f32::from(self.most) > 256.0 * (limits::UNEVEN + 3.0 * noise);
        let even = if disturbed { self.even(noise) } else { Sectors::ALL };
        (even, self.variance(even, calm))
    }

    /// The sectors whose mean is that of most, and that hardly other than none, for noise in units of the contrast.
    fn even(&self, noise: f32) -> Sectors {
        let middle = self.median().clamp(-limits::UNEVEN, limits::UNEVEN);
        // Each of the sectors here is some of those of the mask.
        let each = 1 << self.log;
        let (mut filled, mut uneven, mut suspect) = (Sectors::NONE, Sectors::NONE, Sectors::NONE);
        for (i, &(sum, count)) in rolled(self.sums.iter().enumerate()).filter(|(_, (_, count))| *count > 0) {
            let count = f32::from(count);
            // All for the sum of the sector.
            let sigma = noise * math::sqrt(0.5 * count);
            let excess = (f32::from(sum) / 256.0 - middle * count).abs();
            let is_uneven = excess > limits::UNEVEN * count + limits::UNEVEN_SIGMAS * sigma;
            let is_suspect = excess > 0.2 * limits::UNEVEN * count + sigma;
            for (sectors, over) in [(&mut filled, true), (&mut uneven, is_uneven), (&mut suspect, is_suspect)]
            {
                rolled(0..if over { each } else { 0 }).for_each(|k| sectors.mark(i as u32 * each + k));
            }
        }
        // Glare and shadows have no border: what is beside uneven light is judged by less.
        for _ in 0..SECTORS {
            let grown = uneven.or(&suspect.and(&uneven.grown()));
            if grown == uneven {
                break;
            }
            uneven = grown;
        }
        filled.without(&uneven)
    }

    /// The median of the filled sectors' means, to 1/256.
    fn median(&self) -> f32 {
        let (mut low, mut high) = (-128, 128);
        for _ in 0..7 {
            let middle = (low + high) / 2;
            let (mut below, mut filled) = (0, 0);
            for &(sum, count) in rolled(&self.sums).filter(|(_, count)| *count > 0) {
                below += u32::from(i32::from(sum) < middle * i32::from(count));
                filled += 1;
            }
            if 2 * below < filled { low = middle } else { high = middle }
        }
        (low + high) as f32 / 512.0
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn sectors_are_even_parts_of_a_turn() {
        for i in 0..4096 {
            let turn = (i as f32 + 0.5) / 4096.0;
            let (v, u) = libm::sincosf(turn * core::f32::consts::TAU);
            for length in [0.4, 1.0, 1.4] {
                let place = ((16_384.0 * length * u) as i32, (16_384.0 * length * v) as i32);
                // Two in a thousand of a radian are 1/25 of a sector.
                let (sector, exact) = (sector_of(place), turn * SECTORS as f32);
                let off = (exact - sector as f32 - 0.5).abs();
                assert!(off.min(SECTORS as f32 - off) < 0.54, "{sector} for {exact}");
            }
        }
    }

    #[test]
    fn gaps_grow_and_close_around_the_turn() {
        let mut sectors = Sectors::NONE;
        let marked = [0, 31, 32, 100, 127];
        marked.into_iter().for_each(|sector| sectors.mark(sector));
        let all = |sectors: Sectors| (0..128).filter(|&sector| sectors.has(sector)).collect::<Vec<_>>();
        assert_eq!(all(sectors), marked);
        assert_eq!(all(sectors.grown()), [0, 1, 30, 31, 32, 33, 99, 100, 101, 126, 127]);
        assert_eq!(all(sectors.grown().shrunk()), marked);
        // From 33 to 99.
        assert_eq!(sectors.longest_gap(), 67u32.div_ceil(4));
        let mut one = Sectors::NONE;
        one.mark(64);
        assert_eq!((one.longest_gap(), Sectors::NONE.longest_gap(), Sectors::ALL.longest_gap()), (32, 32, 0));
    }
}
