//! A model, prepared for the crossings of its outlines.

use crate::appearance::{Model, Outline};
use crate::list::list;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Standard deviations of the blur beyond which an edge is over.
const BAND: f32 = 3.0;
/// How far the near samples and the far stretches of a crossing reach from an edge, px, with room for its place.
const NEAR: f32 = 3.0;
const FAR: f32 = 19.5;
/// Radius of curvature at the ends of the major axis below which a parabola is not good enough for the samples of an edge, px.
const TIGHT: f32 = 4.0;

/// The outlines next to one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Next {
    /// Those that have a part in its samples: on the light side and on the dark side.
    pub near: [Option<usize>; 2],
    /// Those that its far stretches may reach: outside and inside.
    pub far: [Option<usize>; 2],
}

pub(super) struct Scene {
    pub model: Model,
    pub next: Vec<Next, MAX_CIRCLES>,
    /// The target's size, px: the unit of the light's slopes.
    pub size: f32,
    /// Edges blur into each other.
    pub overlapping: bool,
    /// These, or edges that bend much: every sample is seen by itself.
    pub tight: bool,
    /// Grey levels beyond which noise reaches the ends of the scale, so that the mean is no longer the level.
    pub ends: (f32, f32),
    /// Around the target there may be the segments of a code: what is far outside of it tells nothing.
    pub ringed: bool,
}

impl Scene {
    pub fn new(model: &Model, size: f32, noise: f32, ringed: bool) -> Self {
        let next: Vec<Next, MAX_CIRCLES> = list((0..model.outlines.len()).map(|k| next(model, k)));
        let bent = |outline: &Outline| {
            let (a, b) = outline.shape.semi_axes();
            b * b < TIGHT * a
        };
        let overlapping = next.iter().any(|next| next.near != [None; 2]);
        let tight = overlapping || model.outlines.iter().any(bent);
        Self { model: model.clone(), next, size, overlapping, tight, ends: (noise, 255.0 - noise), ringed }
    }

    pub fn outline(&self, k: Option<usize>) -> Option<&Outline> {
        self.model.outlines.get(k?)
    }
}

fn next(model: &Model, k: usize) -> Next {
    let outline = model.outlines.get(k);
    let within = |next: Option<usize>, reach: f32| {
        let (outline, other) = (outline?, model.outlines.get(next?)?);
        // Between similar ellipses the gap is narrowest on the minor axis.
        let gap = (other.minor - outline.minor).abs();
        next.filter(|_| other.inside != outline.inside && gap < reach + BAND * model.blur)
    };
    let (outer, inner) = (k.checked_sub(1), Some(k + 1));
    let near = [within(outer, NEAR), within(inner, NEAR)];
    let dark_inside = outline.is_some_and(|outline| outline.inside < 0.0);
    let [outside, inside] = near;
    Next {
        near: if dark_inside { near } else { [inside, outside] },
        far: [within(outer, FAR), within(inner, FAR)],
    }
}
