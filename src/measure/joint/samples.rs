//! What the samples of a crossing are beyond the model.

use super::part::Residuals;
use crate::scan::NEAR;

/// What the near samples tell. All is 0 of samples that do not count.
#[derive(Default)]
pub(super) struct Samples {
    /// Lightness, its changes with the logarithm of the blur and with the place, and the residual of each, ...
    pub lightness: [i32; NEAR],
    pub by_blur: [i32; NEAR],
    pub by_place: [i32; NEAR],
    pub single: [i32; NEAR],
    /// ... whether it counts, and how many do.
    pub own: [bool; NEAR],
    pub n: i32,
    pub residuals: Residuals,
}

/// A far stretch.
pub(super) enum Stretch {
    /// Tells nothing because the scale ends, or because of edges.
    Clipped,
    Mixed,
    Clear(Far),
}

/// A far stretch that is clear of edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Far {
    /// Binary logarithm of its number of pixels.
    pub log: u32,
    /// On the light side.
    pub bright: bool,
    /// Level beyond that of the model.
    pub residual: i32,
    /// Px / 2 about the origin.
    pub place: (i32, i32),
}

impl Samples {
    /// Largest residual.
    pub fn misfit(&self) -> i32 {
        self.single.iter().fold(0, |most, &single| most.max(single.abs()))
    }

    /// Twice what light there is too much beside the edge.
    pub fn excess(&self) -> i32 {
        let [_, before, .., after, _] = self.single;
        before + after
    }

    /// Differences of the residuals of the two outermost samples on either side: in them whatever changes the light over more than a
    /// pixel cancels, and so does an edge that is off.
    #[inline]
    pub fn differences(&self) -> impl Iterator<Item = i32> {
        let [a, b, .., c, d] = self.own;
        let [first, second, .., third, fourth] = self.single;
        [(a && b, first - second), (c && d, fourth - third)]
            .into_iter()
            .filter_map(|(both, difference)| both.then_some(difference))
    }
}
