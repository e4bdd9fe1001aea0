//! Crossings -> edge points.
//!
//! Everything here works on the concentric outlines of one candidate, whose shapes are known well enough to say on
//! which side of which edge a sample lies.
//!
//! 1. [`Levels`]: dark and bright level and one illumination plane for the target.
//! 2. [`measure_blur`]: the standard deviation of the edges' profile.
//! 3. [`place`]: matched filter of the four samples at each crossing.

mod levels;
mod place;
mod profile;

pub(crate) use levels::Levels;
pub(crate) use place::{measure_blur, place};

use crate::fit::Shape;
use crate::scan::{Axis, Crossing, CrossingList};
use profile::normal;

/// Crossings of an outline that are used for the blur and for a first look at the levels.
const FEW: u16 = 16;
/// Farthest that a crossing may lie from its outline's ellipse, px.
const MAX_DISTANCE: f32 = 2.0;
/// Farthest that another edge can lie to have a part in a sample's level, px on the axis.
const MAX_GAP: f32 = 9.0;

/// The edge of one circle of a candidate. Edges are sorted from the outermost to the innermost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// Ellipse about the candidate's origin.
    pub shape: Shape,
    /// Its semi-minor axis, px.
    minor: f32,
    /// Dark inside, light outside.
    pub dark_inside: bool,
    pub crossings: CrossingList,
}

impl Edge {
    pub fn new(shape: Shape, dark_inside: bool, crossings: CrossingList) -> Self {
        Self { shape, minor: shape.semi_axes().1, dark_inside, crossings }
    }

    /// Every how many crossings one is taken for what the whole target shares: an odd number, because a row leaves one on
    /// the left and one on the right, and an even one would take only one side.
    fn stride(&self) -> usize {
        usize::from(self.crossings.len() / FEW) | 1
    }
}

/// The edges of a candidate about its integer origin, px.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<'e> {
    pub edges: &'e [Edge],
    pub origin: (u16, u16),
}

/// A crossing as seen from its edge. Lengths on the crossing's axis, px.
#[derive(Clone, Copy, Debug)]
struct Local {
    /// The pixel `(x, y)` of the crossing about the origin.
    x: f32,
    y: f32,
    /// Unit vector of the axis towards light.
    axis: (f32, f32),
    /// |cosine| of the angle between axis and normal.
    along: f32,
    /// Where the ellipse passes, counted towards light from `(x, y)`.
    offset: f32,
    /// Distance to the next edge on the light side.
    light_gap: f32,
    /// Distance to the next edge on the dark side.
    dark_gap: f32,
}

impl Edges<'_> {
    /// `None` if the other axis is the better one here, or the crossing does not belong to this edge.
    fn local(&self, k: usize, crossing: &Crossing) -> Option<Local> {
        let edge = self.edges.get(k)?;
        let x = (i32::from(crossing.x) - i32::from(self.origin.0)) as f32;
        let y = (i32::from(crossing.y()) - i32::from(self.origin.1)) as f32;
        // The passage is half a pixel before (x, y).
        let (mx, my) = if crossing.axis() == Axis::Row { (x - 0.5, y) } else { (x, y - 0.5) };
        let [n0, n1, n2, n3] = crossing.near.map(i16::from);
        let rising = n2 + n3 > n0 + n1;
        let ((gx, gy), _) = edge.shape.gradient(mx, my);
        let (along, across) = if crossing.axis() == Axis::Row { (gx, gy) } else { (gy, gx) };
        let dominant =
            along.abs() > across.abs() || (along.abs() == across.abs() && crossing.axis() == Axis::Row);
        if !dominant || rising != ((along > 0.0) == edge.dark_inside) {
            return None;
        }
        let here = edge.shape.locate(mx, my).filter(|here| here.distance.abs() <= MAX_DISTANCE)?;
        let cosine = if crossing.axis() == Axis::Row { here.nx } else { here.ny };
        let along = cosine.abs();
        let towards_light = if rising { 1.0 } else { -1.0 };
        let gap = |neighbour: Option<&Edge>| {
            // Between similar ellipses the gap is narrowest on the minor axis.
            let near = |n: &&Edge| (n.minor - edge.minor).abs() < MAX_GAP + 1.0;
            let there =
                neighbour.filter(|n| n.dark_inside != edge.dark_inside).filter(near)?.shape.locate(mx, my)?;
            Some((there.distance - here.distance).abs() / along).filter(|&gap| gap < MAX_GAP)
        };
        let outer = gap(k.checked_sub(1).and_then(|k| self.edges.get(k))).unwrap_or(f32::INFINITY);
        let inner = gap(self.edges.get(k + 1)).unwrap_or(f32::INFINITY);
        let (light_gap, dark_gap) = if edge.dark_inside { (outer, inner) } else { (inner, outer) };
        let axis = match crossing.axis() {
            Axis::Row => (towards_light, 0.0),
            Axis::Column => (0.0, towards_light),
        };
        let offset = -towards_light * (0.5 + here.distance / cosine);
        Some(Local { x, y, axis, along, offset, light_gap, dark_gap })
    }
}

impl Local {
    /// Samples in order of growing lightness: `(place towards light from (x, y), level)`.
    fn near(&self, crossing: &Crossing) -> [(f32, f32); 4] {
        let [a, b, c, d] = crossing.near.map(f32::from);
        if self.towards_light() > 0.0 {
            [(-2.0, a), (-1.0, b), (0.0, c), (1.0, d)]
        } else {
            [(-1.0, d), (0.0, c), (1.0, b), (2.0, a)]
        }
    }

    /// The samples where the edge is over, in the same way.
    fn far(&self, crossing: &Crossing) -> [(f32, f32); 2] {
        let [a, b] = crossing.far().map(f32::from);
        if self.towards_light() > 0.0 { [(-4.0, a), (3.0, b)] } else { [(-3.0, b), (4.0, a)] }
    }

    fn towards_light(&self) -> f32 {
        self.axis.0 + self.axis.1
    }

    /// What the neighbouring edges add to the lightness at `place`, for a blur of `1 / k` px along the axis.
    fn neighbours(&self, place: f32, k: f32) -> f32 {
        let p = place - self.offset;
        let light = if self.light_gap < f32::INFINITY { normal((p - self.light_gap) * k).0 } else { 0.0 };
        let dark = if self.dark_gap < f32::INFINITY { normal(-(p + self.dark_gap) * k).0 } else { 0.0 };
        dark - light
    }

    /// Point on the axis at `place`, about the origin, px.
    fn point(&self, place: f32) -> (f32, f32) {
        (self.x + place * self.axis.0, self.y + place * self.axis.1)
    }
}
