//! Where the axis of a crossing passes an ellipse.

use crate::appearance::Outline;
use crate::fit::Shape;
use crate::math;

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
    /// |cosine| of the angle between axis and normal.
    pub cosine: f32,
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
            cosine: root.abs() / norm,
        })
    }

    /// Curvature of the ellipse there, 1/px.
    pub fn curvature(&self, outline: &Outline, axes: &Axes) -> f32 {
        let inverse = 1.0 / self.norm;
        outline.det * axes.areas() * inverse * inverse * inverse
    }

    /// 1 if the place `from` px farther on the axis is nearer to this edge than to the other side of the ellipse, and the
    /// axis the steeper one there, else 0: so each pixel counts once, though rows and columns both pass it.
    #[inline]
    pub fn owns(&self, from: f32) -> f32 {
        let along = self.gradient.0 + self.change.0 * from;
        let across = self.gradient.1 + self.change.1 * from;
        let owned = along.abs() >= across.abs() && along * self.gradient.0 > 0.0;
        if owned { 1.0 } else { 0.0 }
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
