//! All outcomes, and what is asked of them.

use std::collections::BTreeSet;

use super::{
    cell::Cell,
    grid::RANGE,
    method::METHODS,
    run::{Group, Outcome},
    statistics::Figures,
};

/// What came of a grid.
#[derive(Clone, Debug)]
pub struct Study {
    /// Frames of a cell where nothing else is said.
    pub frames: u32,
    /// By cell, slice by slice.
    pub outcomes: Vec<Outcome>,
}

impl Study {
    /// The cells of this slice.
    pub fn slice<'s>(&'s self, name: &'s str) -> impl Iterator<Item = &'s Outcome> {
        self.outcomes.iter().filter(move |outcome| outcome.cell.slice == name)
    }

    /// The cells in the range of the goals, each once.
    pub fn range(&self) -> Vec<&Outcome> {
        let mut seen = BTreeSet::new();
        let wanted = |outcome: &&Outcome| {
            RANGE.contains(&outcome.cell.slice)
                && outcome.cell.in_range()
                && seen.insert(outcome.cell.label())
        };
        self.outcomes.iter().filter(wanted).collect()
    }

    /// The same with the figures of a method, where the target was found at all.
    pub fn range_figures(&self, method: &str) -> Vec<(&Cell, Figures)> {
        self.range()
            .into_iter()
            .filter_map(|outcome| Some((&outcome.cell, outcome.figures(method)?)))
            .collect()
    }

    /// Figures of a method over all frames of the slice whose cells are `wanted`.
    pub fn pooled(&self, slice: &str, method: &str, wanted: impl Fn(&Cell) -> bool) -> Option<Figures> {
        let outcomes = self.slice(slice).filter(|outcome| wanted(&outcome.cell));
        let groups: Vec<_> = outcomes.flat_map(|outcome| &outcome.groups).collect();
        Figures::new(&groups, index(method)?)
    }
}

impl Outcome {
    /// Figures of the method with this name. `None` when the target was found in no frame.
    pub fn figures(&self, method: &str) -> Option<Figures> {
        let groups: Vec<&Group> = self.groups.iter().collect();
        Figures::new(&groups, index(method)?)
    }
}

/// Of the method with this name.
pub fn index(method: &str) -> Option<usize> {
    METHODS.iter().position(|known| known.name == method)
}
