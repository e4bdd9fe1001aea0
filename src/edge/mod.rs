//! Crossings -> edge points.
//!
//! Everything here works on the concentric outlines of one candidate, whose shapes are known well enough to say on
//! which side of which edge a sample lies.
//!
//! 1. [`Levels`]: dark and bright level and one illumination plane for the target.
//! 2. [`measure_blur`]: the standard deviation of the edges' profile.
//! 3. [`place`]: matched filter of the four samples at each crossing.
//!
//! With less effort: [`Levels::of_flat`], then [`Probit`], which places an edge point between two samples.

mod flat;
mod levels;
mod light;
mod local;
mod place;
mod probit;
mod profile;
mod survey;
mod trace;

pub(crate) use levels::Levels;
pub(crate) use place::{Blur, measure_blur, place};
pub(crate) use probit::Probit;
pub(crate) use profile::{normal, normal_fixed, normal_near};
pub(crate) use survey::{Point, Survey};

use crate::fit::Shape;
use crate::scan::{CrossingList, Outline};
use crate::target::MAX_CIRCLES;
use heapless::Vec;
use local::Views;
use trace::Trace;

/// Crossings of an outline that are used for the blur and for a first look at the levels.
const FEW: u16 = 16;
/// Farthest that another edge can lie to have a part in a sample's level, px on the axis.
const MAX_GAP: f32 = 9.0;

/// The edge of one circle of a candidate. Edges are sorted from the outermost to the innermost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// Ellipse about the candidate's origin.
    pub shape: Shape,
    /// Its semi-axes, px.
    pub axes: (f32, f32),
    /// Dark inside, light outside.
    pub dark_inside: bool,
    /// Only arcs of it are seen.
    pub partial: bool,
    /// The frame's border cuts it.
    pub cut: bool,
    pub crossings: CrossingList,
}

impl Edge {
    pub fn new(shape: Shape, outline: &Outline) -> Self {
        let Outline { cut, crossings, .. } = *outline;
        let (partial, axes) = (outline.is_partial(), shape.semi_axes());
        Self { shape, axes, dark_inside: outline.moments.area > 0, partial, cut, crossings }
    }

    /// The same with a better ellipse.
    pub fn with_shape(&self, shape: Shape) -> Self {
        Self { shape, axes: shape.semi_axes(), ..*self }
    }

    /// Every how many crossings one is taken for what the whole target shares: an odd number, because a row leaves one on
    /// the left and one on the right, and an even one would take only one side.
    pub fn stride(&self) -> usize {
        usize::from(self.crossings.len() / FEW) | 1
    }
}

/// The edges of a candidate about its integer origin, px.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<'e> {
    pub edges: &'e [Edge],
    pub origin: (u16, u16),
}

/// The ellipses of all edges as rows and columns see them.
pub(crate) struct Lines(Vec<Option<Trace>, MAX_CIRCLES>);

impl Edges<'_> {
    /// Not inlined, so that it is made where it stays.
    #[inline(never)]
    pub fn lines(&self) -> Lines {
        let mut lines = Vec::new();
        for edge in self.edges {
            if lines.push(Trace::new(&edge.shape, edge.axes.1)).is_err() {
                break;
            }
        }
        Lines(lines)
    }

    #[inline(never)]
    fn views<'l>(&self, k: usize, Lines(lines): &'l Lines) -> Option<Views<'l>> {
        let edge = self.edges.get(k)?;
        let near = |k: Option<usize>| {
            let next = self.edges.get(k?).filter(|next| next.dark_inside != edge.dark_inside)?;
            // Between similar ellipses the gap is narrowest on the minor axis.
            let near = (next.axes.1 - edge.axes.1).abs() < MAX_GAP + 1.0;
            lines.get(k?).filter(|_| near)?.as_ref()
        };
        let (outer, inner) = (near(k.checked_sub(1)), near(Some(k + 1)));
        let (light, dark) = if edge.dark_inside { (outer, inner) } else { (inner, outer) };
        Some(Views {
            edge: lines.get(k)?.as_ref()?,
            light,
            dark,
            dark_inside: edge.dark_inside,
            origin: self.origin,
        })
    }
}
