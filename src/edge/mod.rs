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
pub(crate) use place::{Blur, measure_blur, place};

use crate::fit::Shape;
use crate::math;
use crate::scan::{Axis, Crossing, CrossingList, Outline};
use profile::Blurred;
pub(crate) use profile::{mean_tail, normal, normal_fixed};

/// Crossings of an outline that are used for the blur and for a first look at the levels.
const FEW: u16 = 16;
/// Farthest that a crossing may lie from its outline's ellipse, px.
const MAX_DISTANCE: f32 = 2.0;
/// Farthest that another edge can lie to have a part in a sample's level, px on the axis.
const MAX_GAP: f32 = 9.0;
/// Least distance on the axis from an edge to the middle between it and the other side of its own circle, px.
const MIN_HALF_CHORD: f32 = 2.5;

/// The edge of one circle of a candidate. Edges are sorted from the outermost to the innermost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// Ellipse about the candidate's origin.
    pub shape: Shape,
    /// Its semi-minor axis, px.
    minor: f32,
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
        let Outline { partial, cut, crossings, .. } = *outline;
        let (_, minor) = shape.semi_axes();
        Self { shape, minor, dark_inside: outline.moments.area > 0, partial, cut, crossings }
    }

    /// The same with a better ellipse.
    pub fn with_shape(&self, shape: Shape) -> Self {
        Self { shape, minor: shape.semi_axes().1, ..*self }
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
    /// Curvature of the edge, 1/px, positive where it bends away from light.
    curvature: f32,
    /// Distance to the next edge on the light side.
    light_gap: f32,
    /// Distance to the next edge on the dark side.
    dark_gap: f32,
}

/// The far stretch on the dark side, the outermost near samples and the far stretch on the light side.
struct Outer {
    /// Place of the pixel nearest to the edge, towards light from the crossing's pixel, px.
    first: [f32; 4],
    levels: [f32; 4],
    /// Number of pixels.
    pixels: [f32; 4],
}

/// An edge and those next to it, as crossings on one axis see them: coordinates along and across the axis, about the
/// candidate's origin.
#[derive(Clone, Copy, Debug)]
struct View {
    edge: Shape,
    /// Its determinant.
    det: f32,
    /// The next edge on the light side and on the dark side, where it is near enough to have a part in the samples.
    light: Option<Shape>,
    dark: Option<Shape>,
    dark_inside: bool,
}

/// The [`View`]s of an edge.
#[derive(Clone, Copy, Debug)]
struct Views {
    row: View,
    column: View,
    origin: (i32, i32),
}

impl Edges<'_> {
    fn views(&self, k: usize) -> Option<Views> {
        let edge = self.edges.get(k)?;
        let near = |k: Option<usize>| {
            let next = self.edges.get(k?).filter(|next| next.dark_inside != edge.dark_inside)?;
            // Between similar ellipses the gap is narrowest on the minor axis.
            Some(next.shape).filter(|_| (next.minor - edge.minor).abs() < MAX_GAP + 1.0)
        };
        let (outer, inner) = (near(k.checked_sub(1)), near(Some(k + 1)));
        let (light, dark) = if edge.dark_inside { (outer, inner) } else { (inner, outer) };
        let row =
            View { edge: edge.shape, det: edge.shape.det(), light, dark, dark_inside: edge.dark_inside };
        let origin = (i32::from(self.origin.0), i32::from(self.origin.1));
        Some(Views { row, column: row.transposed(), origin })
    }
}

impl Views {
    /// `None` if the other axis is the better one here, or the crossing does not belong to this edge.
    fn local(&self, crossing: &Crossing) -> Option<Local> {
        let x = (i32::from(crossing.x) - self.origin.0) as f32;
        let y = (i32::from(crossing.y()) - self.origin.1) as f32;
        let [_, n0, n1, n2, n3, _] = crossing.near.map(i32::from);
        let rising = n2 + n3 > n0 + n1;
        let sign = if rising { 1.0 } else { -1.0 };
        let (passage, axis) = match crossing.axis() {
            Axis::Row => (self.row.passage(x, y, rising)?, (sign, 0.0)),
            Axis::Column => (self.column.passage(y, x, rising)?, (0.0, sign)),
        };
        let Passage { along, ahead, curvature, light_gap, dark_gap } = passage;
        Some(Local { x, y, axis, along, offset: sign * (ahead - 0.5), curvature, light_gap, dark_gap })
    }
}

/// Where an ellipse passes a crossing, seen from the middle of the crossing's inner samples, px.
struct Passage {
    along: f32,
    /// Distance on the axis.
    ahead: f32,
    curvature: f32,
    light_gap: f32,
    dark_gap: f32,
}

impl View {
    fn transposed(&self) -> Self {
        let [light, dark] = [self.light, self.dark].map(|next| next.map(|shape| shape.transposed()));
        Self { edge: self.edge.transposed(), light, dark, ..*self }
    }

    /// The passage before the pixel at `u` along and `v` across the axis; `rising` if the pixel is on the light side.
    fn passage(&self, u: f32, v: f32, rising: bool) -> Option<Passage> {
        let u = u - 0.5;
        let ((gu, gv), (du, dv)) = self.edge.gradient(u, v);
        if gu.abs() < gv.abs() || rising != ((gu > 0.0) == self.dark_inside) {
            return None;
        }
        // As `Shape::distance`, with the divisions independent of each other: this is the innermost loop.
        let norm = math::sqrt(gu * gu + gv * gv);
        let radius = math::sqrt(du * gu + dv * gv);
        let depth = (radius - 1.0) * radius;
        if !(depth.abs() <= MAX_DISTANCE * norm) {
            return None;
        }
        // Half the chord on the axis: a tip so narrow that the other side has a part in the samples.
        if gu.abs() < MIN_HALF_CHORD * self.edge.axx {
            return None;
        }
        let along = gu.abs() / norm;
        // On the ellipse it is det A / |A p|^3; seen from beside, that of the similar ellipse through the point.
        let radius_by_norm = radius / norm;
        let curvature = self.det * radius_by_norm * radius_by_norm * radius_by_norm;
        let gap = |next: &Option<Shape>| {
            let there = next.as_ref()?.distance(u, v)?;
            Some((there - depth / norm).abs() / along).filter(|&gap| gap < MAX_GAP)
        };
        Some(Passage {
            along,
            ahead: -depth / gu,
            curvature: if self.dark_inside { curvature } else { -curvature },
            light_gap: gap(&self.light).unwrap_or(f32::INFINITY),
            dark_gap: gap(&self.dark).unwrap_or(f32::INFINITY),
        })
    }
}

impl Local {
    /// The near samples in order of growing lightness: places towards light from (x, y), and levels.
    fn near(&self, crossing: &Crossing) -> ([f32; 4], [f32; 4]) {
        let [_, a, b, c, d, _] = crossing.near.map(f32::from);
        self.towards_light([-2.0, -1.0, 0.0, 1.0], [a, b, c, d])
    }

    fn outer(&self, crossing: &Crossing) -> Outer {
        let ([_, a, _, _, d, _], [before, after]) = (crossing.near.map(f32::from), crossing.far());
        let ((before, first), (after, last)) = (before.mean(), after.mean());
        let (first, levels) = self.towards_light([-4.0, -2.0, 1.0, 3.0], [first, a, d, last]);
        let pixels = if self.sign() > 0.0 { [before, 1.0, 1.0, after] } else { [after, 1.0, 1.0, before] };
        Outer { first, levels, pixels }
    }

    fn towards_light(&self, places: [f32; 4], levels: [f32; 4]) -> ([f32; 4], [f32; 4]) {
        let [a, b, c, d] = levels;
        // The samples lie symmetrically about half a pixel before (x, y).
        if self.sign() > 0.0 {
            (places, [a, b, c, d])
        } else {
            (places.map(|place| place + 1.0), [d, c, b, a])
        }
    }

    fn sign(&self) -> f32 {
        self.axis.0 + self.axis.1
    }

    /// What the neighbouring edges add to the lightness at `places` from this edge, for a blur of `1 / k` px along the axis.
    fn neighbours(&self, places: [f32; 4], k: f32) -> [f32; 4] {
        let mut sum = [0.0; 4];
        if self.light_gap < f32::INFINITY {
            sum = places.map(|p| -normal((p - self.light_gap) * k).0);
        }
        if self.dark_gap < f32::INFINITY {
            let dark = places.map(|p| normal(-(p + self.dark_gap) * k).0);
            sum = core::array::from_fn(|i| sum[i] + dark[i]);
        }
        sum
    }

    /// This edge under a blur of `sigma` px.
    fn blurred(&self, sigma: f32) -> Blurred {
        let across = math::sqrt(1.0 - (self.along * self.along).min(1.0)) / sigma;
        Blurred { k: self.along / sigma, across, curvature: self.curvature * sigma }
    }

    /// Point on the axis at `place`, about the origin, px.
    fn point(&self, place: f32) -> (f32, f32) {
        (self.x + place * self.axis.0, self.y + place * self.axis.1)
    }
}
