//! From the coded targets outwards.

use std::collections::BTreeMap;

use super::{Correspondence, MIN_CODED, MatchError, Measured, Pair, map::Map};
use crate::{layout::Layout, measure::distance};

/// Farthest that a measured target may be from where it is expected, as a share of the distance to the next target.
const REACH: f64 = 0.35;
/// The same in the end, in medians of all distances, but at least [`NEAR`].
const GATE: f64 = 8.0;
/// px.
const NEAR: f64 = 4.0;
/// Measured over expected size of a pair.
const SIZE: std::ops::RangeInclusive<f64> = 0.7..=1.4;
/// A step outwards takes the targets up to this many times the distance of the nearest from those that are paired.
const STEP: f64 = 1.5;
/// Times that all pairs are made anew in the end.
const ROUNDS: usize = 3;

/// Finds out which of the `measured` targets, in a frame of `size` px, is which of the `layout`.
///
/// # Errors
/// [`MatchError`]: what is missing.
pub fn correspond(
    measured: &[Measured],
    layout: &Layout,
    size: [u32; 2],
) -> Result<Correspondence, MatchError> {
    if measured.is_empty() {
        return Err(MatchError::NoTargets);
    }
    let coded = layout.targets.iter().filter(|target| target.id.is_some()).count();
    if coded < MIN_CODED {
        return Err(MatchError::Layout { coded });
    }
    let seeds = Seeds::new(measured, layout);
    if seeds.pairs.len() < MIN_CODED {
        return Err(MatchError::TooFewCoded {
            measured: measured.len(),
            usable: seeds.ids(layout),
            duplicates: seeds.duplicates,
            foreign: seeds.foreign,
        });
    }
    let positions = layout.targets.iter().map(|target| target.position).collect();
    let search = Search { measured, layout, size, positions };
    let found = search.best(&seeds.pairs).ok_or_else(|| MatchError::Collinear { ids: seeds.ids(layout) })?;
    let is_seed = |pair: &Pair| seeds.pairs.contains(&(pair.target, pair.measured));
    if found.pairs.iter().all(is_seed) && !found.missing.is_empty() && !found.unmatched.is_empty() {
        return Err(MatchError::Contradiction { ids: seeds.ids(layout) });
    }
    let contradicts = |&&(target, measured): &&(usize, usize)| {
        !found.pairs.iter().any(|pair| (pair.target, pair.measured) == (target, measured))
    };
    let contradicting = seeds.pairs.iter().filter(contradicts).filter_map(|seed| layout.targets[seed.0].id);
    let contradicting = contradicting.collect();
    Ok(Correspondence { foreign: seeds.foreign, duplicates: seeds.duplicates, contradicting, ..found })
}

/// What the ids tell.
struct Seeds {
    /// Numbers of target and measured target.
    pairs: Vec<(usize, usize)>,
    foreign: Vec<u16>,
    duplicates: Vec<u16>,
}

impl Seeds {
    fn new(measured: &[Measured], layout: &Layout) -> Self {
        let mut seen: BTreeMap<u16, Vec<usize>> = BTreeMap::new();
        for (index, one) in measured.iter().enumerate() {
            if let Some(id) = one.id {
                seen.entry(id).or_default().push(index);
            }
        }
        let mut seeds = Self { pairs: Vec::new(), foreign: Vec::new(), duplicates: Vec::new() };
        for (id, places) in seen {
            match (layout.targets.iter().position(|target| target.id == Some(id)), places.as_slice()) {
                (Some(target), &[measured]) => seeds.pairs.push((target, measured)),
                (Some(_), _) => seeds.duplicates.push(id),
                (None, _) => seeds.foreign.push(id),
            }
        }
        seeds
    }

    fn ids(&self, layout: &Layout) -> Vec<u16> {
        self.pairs.iter().filter_map(|&(target, _)| layout.targets[target].id).collect()
    }
}

/// Where a target is expected.
#[derive(Clone, Copy)]
struct Expected {
    place: [f64; 2],
    /// Distance to the next target, px.
    spacing: f64,
    /// Radius of its outer circle, px; 0 if it is not known.
    size: f64,
}

/// What one of them found near it.
enum Near {
    Nothing,
    One(usize),
    Several,
}

struct Search<'a> {
    measured: &'a [Measured],
    layout: &'a Layout,
    size: [u32; 2],
    positions: Vec<[f64; 3]>,
}

impl Search<'_> {
    /// With all seeds, or, where that leads nowhere, without the one that is in the way. `None` if they leave the map open.
    fn best(&self, seeds: &[(usize, usize)]) -> Option<Correspondence> {
        let all = self.grow(seeds);
        let good = |found: &Correspondence| {
            let all_paired =
                seeds.iter().all(|seed| found.pairs.iter().any(|pair| (pair.target, pair.measured) == *seed));
            all_paired && found.pairs.len() >= found.missing.len()
        };
        if seeds.len() == MIN_CODED || all.as_ref().is_some_and(good) {
            return all;
        }
        let without = |index: usize| {
            let mut rest = seeds.to_vec();
            rest.remove(index);
            self.grow(&rest)
        };
        let others = (0..seeds.len()).filter_map(without);
        all.into_iter()
            .chain(others)
            .reduce(|best, one| if one.pairs.len() > best.pairs.len() { one } else { best })
    }

    fn grow(&self, seeds: &[(usize, usize)]) -> Option<Correspondence> {
        let mut paired: Vec<Option<usize>> = vec![None; self.positions.len()];
        for &(target, measured) in seeds {
            paired[target] = Some(measured);
        }
        let mut map = Map::new(&self.pairs(&paired), &self.positions, self.size)?;
        let mut open: Vec<usize> = (0..paired.len()).filter(|&target| paired[target].is_none()).collect();
        while !open.is_empty() {
            let expected = self.expected(&map);
            let (next, rest) = self.frontier(&open, &paired);
            for target in next {
                if let Near::One(measured) = self.near(target, &expected, f64::INFINITY, &paired) {
                    paired[target] = Some(measured);
                }
            }
            map = map.refit(&self.pairs(&paired));
            open = rest;
        }
        let mut ambiguous = Vec::new();
        for _ in 0..ROUNDS {
            let expected = self.expected(&map);
            let gate = (GATE * self.median(&paired, &expected)).max(NEAR);
            let blank = vec![None; paired.len()];
            ambiguous.clear();
            for target in 0..paired.len() {
                let near = self.near(target, &expected, gate, &blank);
                paired[target] = if let Near::One(measured) = near { Some(measured) } else { None };
                if matches!(near, Near::Several) {
                    ambiguous.push(target);
                }
            }
            map = map.refit(&self.pairs(&paired));
        }
        Some(self.report(&map, &paired, ambiguous))
    }

    /// Those of the `open` targets that are next to paired ones, and the others.
    fn frontier(&self, open: &[usize], paired: &[Option<usize>]) -> (Vec<usize>, Vec<usize>) {
        let between = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let to_paired = |&target: &usize| {
            let there = (0..paired.len()).filter(|&other| paired[other].is_some());
            there
                .map(|other| between(self.positions[target], self.positions[other]))
                .fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<_> = open.iter().map(to_paired).collect();
        let limit = STEP * distances.iter().copied().fold(f64::INFINITY, f64::min);
        let (near, far): (Vec<_>, Vec<_>) =
            open.iter().zip(&distances).partition(|(_, distance)| **distance <= limit);
        let targets = |list: Vec<(&usize, &f64)>| list.into_iter().map(|(target, _)| *target).collect();
        (targets(near), targets(far))
    }

    fn expected(&self, map: &Map) -> Vec<Option<Expected>> {
        let places: Vec<_> = self.positions.iter().map(|&position| map.project(position)).collect();
        let expected = |(index, place): (usize, &Option<[f64; 2]>)| {
            let place = (*place)?;
            let others = places.iter().enumerate().filter(|&(other, _)| other != index);
            let spacing = others.filter_map(|(_, other)| *other).map(|other| distance(place, other));
            let radius = self.layout.targets[index].radii.first().copied().unwrap_or(0.0);
            let size = map.size(self.positions[index], radius).unwrap_or(0.0);
            Some(Expected { place, spacing: spacing.fold(f64::INFINITY, f64::min), size })
        };
        places.iter().enumerate().map(expected).collect()
    }

    /// What lies within [`REACH`] and `gate` (px) of `target` and may be it.
    fn near(
        &self,
        target: usize,
        expected: &[Option<Expected>],
        gate: f64,
        paired: &[Option<usize>],
    ) -> Near {
        let Some(here) = expected[target] else { return Near::Nothing };
        let limit = (REACH * here.spacing).min(gate);
        let free = |measured: &usize| !paired.contains(&Some(*measured));
        let within = |measured: &usize| distance(self.measured[*measured].centre, here.place) <= limit;
        let may = |measured: &usize| {
            let one = &self.measured[*measured];
            let id = one.id.is_none_or(|id| self.layout.targets[target].id == Some(id));
            let size = here.size == 0.0 || one.size == 0.0 || SIZE.contains(&(one.size / here.size));
            id && size
        };
        let mut candidates = (0..self.measured.len()).filter(within).filter(may).filter(free);
        match (candidates.next(), candidates.next()) {
            (Some(one), None) => Near::One(one),
            (None, _) => Near::Nothing,
            (Some(_), Some(_)) => Near::Several,
        }
    }

    fn pairs(&self, paired: &[Option<usize>]) -> Vec<super::map::Pair> {
        let pair = |(&position, measured): (&[f64; 3], &Option<usize>)| {
            measured.map(|measured| (position, self.measured[measured].centre))
        };
        self.positions.iter().zip(paired).filter_map(pair).collect()
    }

    fn median(&self, paired: &[Option<usize>], expected: &[Option<Expected>]) -> f64 {
        let off = |(measured, expected): (&Option<usize>, &Option<Expected>)| {
            Some(distance(self.measured[(*measured)?].centre, (*expected)?.place))
        };
        let mut distances: Vec<_> = paired.iter().zip(expected).filter_map(off).collect();
        distances.sort_by(f64::total_cmp);
        distances.get(distances.len() / 2).copied().unwrap_or(0.0)
    }

    fn report(&self, map: &Map, paired: &[Option<usize>], ambiguous: Vec<usize>) -> Correspondence {
        let expected = self.expected(map);
        let mut found = Correspondence { ambiguous, ..Correspondence::default() };
        for (target, (measured, expected)) in paired.iter().zip(expected).enumerate() {
            match (*measured, expected) {
                (Some(measured), Some(Expected { place, .. })) => {
                    let distance = distance(self.measured[measured].centre, place);
                    found.pairs.push(Pair { target, measured, distance });
                }
                (None, Some(expected)) if self.inside(&expected) && !found.ambiguous.contains(&target) => {
                    found.missing.push(target);
                }
                _ => {}
            }
        }
        let squares = found.pairs.iter().map(|pair| pair.distance * pair.distance);
        found.rms = (squares.sum::<f64>() / found.pairs.len().max(1) as f64).sqrt();
        let free = |measured: &usize| found.pairs.iter().all(|pair| pair.measured != *measured);
        found.unmatched = (0..self.measured.len()).filter(free).collect();
        found
    }

    /// Whether all of the target lies within the frame.
    fn inside(&self, Expected { place, size, .. }: &Expected) -> bool {
        let axis = |at: f64, side: u32| *size <= at && at <= f64::from(side) - 1.0 - size;
        axis(place[0], self.size[0]) && axis(place[1], self.size[1])
    }
}
