//! Where the axis of a crossing passes an ellipse, in f32: where a lens distorts the image, and where edges bend much or blur into
//! each other.

use crate::appearance::Outline;
use crate::fit;
use crate::fit::Shape;
use crate::fixed::{BEND, ONE, PX, fixed};
use crate::math;
use crate::measure::Origin;
use crate::scan::Axis;

/// The axis of a crossing: vectors along and across it in the undistorted plane, for 1 px in the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    pub along: (f32, f32),
    pub across: (f32, f32),
}

impl Axes {
    /// Square of the change of areas from the image to the undistorted plane.
    fn areas(&self) -> f32 {
        let areas = self.along.0 * self.across.1 - self.along.1 * self.across.0;
        areas * areas
    }
}

/// The middle of a crossing, and its axis there, in the undistorted plane about the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    middle: (f32, f32),
    axes: Axes,
}

impl Place {
    /// Of a middle along and across the axis, px / 2 about the origin.
    pub fn new(axis: Axis, (along, across): (i32, i32), origin: &Origin) -> Option<Self> {
        let (along, across) = (0.5 * along as f32, 0.5 * across as f32);
        let row = axis == Axis::Row;
        let middle = origin.place(if row { (along, across) } else { (across, along) })?;
        let [xx, xy, yx, yy] = origin.slope(middle);
        let (x, y) = ((xx, yx), (xy, yy));
        let axes = if row { Axes { along: x, across: y } } else { Axes { along: y, across: x } };
        Some(Self { middle, axes })
    }

    /// The same with where the axis passes an outline. Not inlined, because few images are seen through a lens that is known.
    #[inline(never)]
    pub fn with_passage(
        axis: Axis,
        middle: (i32, i32),
        origin: &Origin,
        outline: &Outline,
    ) -> Option<(Self, fit::Passage)> {
        let place = Self::new(axis, middle, origin)?;
        Some((place, place.passage(outline)?))
    }

    /// The place `at` on the axis from an outline's centre, in the undistorted plane, and how much larger areas are there.
    pub fn beside_centre(&self, outline: &Outline, at: i32) -> ((f32, f32), f32) {
        let at = at as f32 / PX as f32;
        let (x, y) = (self.middle.0 + at * self.axes.along.0, self.middle.1 + at * self.axes.along.1);
        ((x - outline.shape.cx, y - outline.shape.cy), math::sqrt(self.axes.areas()))
    }

    /// Distance of the place `at` on the axis from an outline, positive outside, and half the curvature there.
    pub fn distance(&self, outline: &Outline, at: i32) -> (i32, i32) {
        let at = at as f32 / PX as f32;
        let place = (self.middle.0 + at * self.axes.along.0, self.middle.1 + at * self.axes.along.1);
        let (distance, curvature) = distance(outline, place, &self.axes);
        (bounded(distance, DEEPEST, PX), bounded(0.5 * curvature, 1.0, BEND))
    }

    /// Where the axis passes an outline.
    pub fn passage(&self, outline: &Outline) -> Option<fit::Passage> {
        let passage = Passage::new(&outline.shape, self.middle, &self.axes)?;
        let inverse = 1.0 / passage.norm;
        let share = |x: f32| fixed(x * inverse, ONE);
        let change = |x: f32| bounded(x * inverse, 1.0, BEND);
        let (u, v) = outline.frame.vector(passage.from_centre.0, passage.from_centre.1);
        Some(fit::Passage {
            at: bounded(passage.at, AWAY, PX),
            cosines: (share(passage.gradient.0), share(passage.gradient.1)),
            change: (change(passage.change.0), change(passage.change.1)),
            bend: bounded(0.5 * passage.curvature(outline, &self.axes), 1.0, BEND),
            reach: bounded(inverse / outline.major, 1.5, ONE),
            direction: (fixed(u, ONE), fixed(v, ONE)),
        })
    }
}

/// Largest distances that are told from each other, px: from an outline, and to it along the axis.
const DEEPEST: f32 = 11.0;
const AWAY: f32 = 4.0;

/// `x` where one is `one`, but at most `most`.
fn bounded(x: f32, most: f32, one: i32) -> i32 {
    fixed(x.clamp(-most, most), one)
}

/// The place where the axis passes an ellipse. Lengths in px of the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// On the axis, from the middle of the crossing.
    pub at: f32,
    /// From the ellipse's centre.
    pub from_centre: (f32, f32),
    /// Half the gradient of its conic along and across the axis, and how that changes along the axis.
    pub gradient: (f32, f32),
    pub change: (f32, f32),
    /// Length of the gradient.
    pub norm: f32,
}

impl Passage {
    /// The nearer one to `middle`. `None` where the axis misses the ellipse.
    pub fn new(shape: &Shape, middle: (f32, f32), axes: &Axes) -> Option<Self> {
        let (slope, from) = shape.gradient(middle.0, middle.1);
        let bent = shape.product(axes.along);
        let (along, bend) = (dot(slope, axes.along), dot(bent, axes.along));
        let excess = dot(from, slope) - 1.0;
        let square = along * along - bend * excess;
        if !(square > 0.0) {
            return None;
        }
        let root = math::sqrt(square);
        let root = if along < 0.0 { -root } else { root };
        let at = -excess / (along + root);
        let across_bend = dot(bent, axes.across);
        let across = dot(slope, axes.across) + at * across_bend;
        let norm = math::sqrt(square + across * across);
        Some(Self {
            at,
            from_centre: (from.0 + at * axes.along.0, from.1 + at * axes.along.1),
            gradient: (root, across),
            change: (bend, across_bend),
            norm,
        })
    }

    /// Curvature of the ellipse there, 1/px.
    pub fn curvature(&self, outline: &Outline, axes: &Axes) -> f32 {
        let inverse = 1.0 / self.norm;
        outline.det * axes.areas() * inverse * inverse * inverse
    }
}

/// Distance of a place from an outline, px, positive outside, and the curvature of the nearest place on it, 1/px: exact near the
/// outline and for a circle.
pub(super) fn distance(outline: &Outline, (x, y): (f32, f32), axes: &Axes) -> (f32, f32) {
    let (slope, from) = outline.shape.gradient(x, y);
    let radius = math::sqrt(dot(from, slope)).max(CENTRE);
    let (along, across) = (dot(slope, axes.along), dot(slope, axes.across));
    let reach = radius / math::sqrt(along * along + across * across);
    let curvature = outline.det * axes.areas() * reach * reach * reach;
    let depth = radius - 1.0;
    let inverse = 1.0 / radius;
    // The place in the same direction from the centre is not the nearest one: the outline curves away between them.
    let aside = depth * depth * (dot(from, from) * inverse * inverse - reach * reach).max(0.0);
    (depth * reach + 0.5 * curvature * aside, curvature)
}

/// Closest to the centre that a place has a direction from it, in units of the ellipse.
const CENTRE: f32 = 1e-3;

/// Product of two vectors.
pub(super) fn dot((ax, ay): (f32, f32), (bx, by): (f32, f32)) -> f32 {
    ax * bx + ay * by
}
