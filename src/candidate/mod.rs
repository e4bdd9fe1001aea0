//! Which closed outlines can be circles of a target, and which of them belong together.
//!
//! Inner outlines close before the ones around them. A closed outline that is an ellipse waits, at the head of the chain
//! of concentric ones inside it, until nothing that is still open can close around it.

//!
//! 1. [`Waiting`]: the chains, and what closes around or inside them.
//! 2. [`broken`]: outlines that are no ellipse, but of which arcs of one are left.

mod broken;
#[cfg(test)]
mod tests;
mod waiting;

pub(crate) use waiting::Waiting;

use crate::arcs::Arc;
use crate::fit::Shape;
use crate::math;
use crate::reject::Reject;
use crate::scan::{Moments, NONE, Outline, Scanner, Seen};
use crate::settings::limits;

/// Semi-minor axis below that of any outline of [`limits::MIN_EXTENT`], px: that of a row of pixels is 0.58.
const LEAST_SEMI_AXIS: f32 = 0.5;

/// Farthest that the middle of a concentric outline can lie, in widths of the one around it: what the search adds to the
/// distance of two centres makes up to 4 semi-axes of the narrowest outline.
const FARTHEST: u32 = 3;

/// The pixel about which an outline is calculated: the middle of its bounding box.
pub(crate) fn origin(outline: &Outline) -> (u16, u16) {
    (outline.left.midpoint(outline.right), outline.top.midpoint(outline.bottom))
}

/// Whether a waiting outline is whole and has nothing concentric inside it.
pub(crate) fn is_alone(outline: &Outline) -> bool {
    outline.inner == NONE && !outline.is_partial() && !outline.is_open()
}

/// The ellipse with the outline's moments, about [`origin`].
pub(crate) fn shape(outline: &Outline) -> Result<Shape, Reject> {
    if outline.is_partial() {
        return moments_shape(outline);
    }
    if outline.cut {
        return Err(Reject::CutByFrame);
    }
    if outline.width().min(outline.height()) < limits::MIN_EXTENT {
        return Err(Reject::TooSmall);
    }
    if outline.lossy {
        return Err(Reject::BufferFull);
    }
    let shape = moments_shape(outline)?;
    // pi a b = pi / root.
    let root = math::sqrt(shape.det());
    let excess = (outline.moments.area.abs() as f32 * root / core::f32::consts::PI - 1.0).abs();
    let fits = |b: f32| excess <= limits::AREA_TOLERANCE + limits::AREA_TOLERANCE_GRID / b;
    // Most are decided without the axes.
    if !fits(f32::INFINITY) && (!fits(LEAST_SEMI_AXIS) || !fits(shape.semi_axes().1)) {
        return Err(Reject::NotElliptic);
    }
    // Far fewer crossings than a circle has: its border is the threshold's, not an edge. 4 sqrt(a b) are expected.
    let half = 0.5 * f32::from(outline.crossings.len());
    if half * half * root < 1.0 {
        return Err(Reject::LowContrast);
    }
    Ok(shape)
}

/// The ellipse of any outline's moments, about [`origin`].
fn moments_shape(outline: &Outline) -> Result<Shape, Reject> {
    let (ox, oy) = origin(outline);
    let (ox, oy) = (i64::from(ox), i64::from(oy));
    let m = &outline.moments;
    let area = m.area as f32;
    let mean = |sum: i64| sum as f32 / area;
    let (cx, cy) = (mean(m.x - ox * m.area), mean(m.y - oy * m.area));
    // A pixel is a square: 1/12 px^2 of its own.
    let mxx = mean(m.xx - 2 * ox * m.x + ox * ox * m.area) - cx * cx + 1.0 / 12.0;
    let myy = mean(m.yy - 2 * oy * m.y + oy * oy * m.area) - cy * cy + 1.0 / 12.0;
    let mxy = mean(m.xy - ox * m.y - oy * m.x + ox * oy * m.area) - cx * cy;
    Shape::from_moments(cx, cy, mxx, mxy, myy).ok_or(Reject::NotElliptic)
}

/// Makes the outline that of `arc` about `about`, in a frame of this width and height: from here on it counts as a whole ellipse,
/// which the frame cuts if it reaches beyond it.
fn set_arc(outline: &mut Outline, arc: &Arc, about: (u16, u16), (width, height): (u16, u16)) {
    let Arc { shape, dark_inside } = arc;
    let (half_x, half_y) = shape.extent();
    let place =
        |origin: u16, offset: f32| (f32::from(origin) + offset).clamp(0.0, f32::from(u16::MAX)) as u16;
    (outline.left, outline.right) =
        (place(about.0, shape.cx - half_x), place(about.0, shape.cx + half_x + 1.0));
    (outline.top, outline.bottom) = (place(about.1, shape.cy - half_y), place(about.1, shape.cy + half_y));
    let beyond = |origin: u16, offset: f32, half: f32, size: u16| {
        let middle = f32::from(origin) + offset;
        middle < half || middle + half > f32::from(size) - 1.0
    };
    outline.cut = beyond(about.0, shape.cx, half_x, width) || beyond(about.1, shape.cy, half_y, height);
    outline.moments = Moments::of_ellipse(shape, about, *dark_inside);
    outline.seen = Seen::Arcs;
}

/// What of [`concentric`] whole numbers tell: it refuses what this refuses.
fn can_be_concentric(outline: &Outline, inner: &Outline) -> bool {
    let inside = || outline.surrounds(inner) && inner.bottom <= outline.bottom;
    inner.moments.area.abs() < outline.moments.area.abs()
        && (outline.is_partial() || inner.is_partial() || inside())
        && are_near(outline, inner)
}

/// Whether `inner` can be a concentric circle inside `outline`, in a frame of this width.
fn concentric(outline: &Outline, shape: &Shape, inner: &Outline, width: u16) -> bool {
    can_be_concentric(outline, inner) && has_centre_of(outline, shape, inner, width)
}

/// Whether the centres of both, `inner` the smaller one, are as near as perspective and uncertainty allow.
fn has_centre_of(outline: &Outline, shape: &Shape, inner: &Outline, width: u16) -> bool {
    let (ox, oy) = origin(outline);
    let area = inner.moments.area as f32;
    let from = |sum: i64, origin: u16| (sum - i64::from(origin) * inner.moments.area) as f32 / area;
    let (dx, dy) = (from(inner.moments.x, ox) - shape.cx, from(inner.moments.y, oy) - shape.cy);
    let area_ratio = (area / outline.moments.area as f32).abs();
    let partial = outline.is_partial() || inner.is_partial();
    let grid = if partial { limits::ARC_CENTRE } else { limits::GRID_CENTRE };
    let limit = Offset { width, grid }.limit(shape.semi_axes(), area_ratio);
    area_ratio < 1.0 && shape.square(dx, dy) <= limit * limit
}

/// Whether the middle of `inner` is not farther from that of `outline` than any tolerance allows; also where the frame cuts its
/// box.
fn are_near(outline: &Outline, inner: &Outline) -> bool {
    let ((x, y), (inner_x, inner_y)) = (origin(outline), origin(inner));
    let near = |a: u16, b: u16, size: u16| u32::from(a.abs_diff(b)) <= FARTHEST * u32::from(size);
    outline.cut || near(x, inner_x, outline.width()) && near(y, inner_y, outline.height())
}

/// How far apart the ellipse centres of concentric circles can be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Offset {
    /// Width of the frame, px.
    pub width: u16,
    /// Uncertainty of the centres, px.
    pub grid: f32,
}

impl Offset {
    /// Largest distance in units of the outer ellipse with semi-axes `a`, `b`: B1 - B2 is sqrt(t) (1 - ratio^2) of it.
    pub fn limit(&self, (a, b): (f32, f32), area_ratio: f32) -> f32 {
        let focal_length = limits::MIN_FOCAL_LENGTH * f32::from(self.width);
        (a / focal_length).min(limits::MAX_PERSPECTIVE) * (1.0 - area_ratio) + self.grid / b
    }
}

/// Number of rows after which none of the open outlines can close around `inner` and be concentric with it.
fn ready_row(inner: &Outline, scanner: &Scanner<'_>) -> u16 {
    let middle = |first: u16, last: u16| i32::from(first) + i32::from(last);
    let (cx, cy) = (middle(inner.left, inner.right), middle(inner.top, inner.bottom));
    // What is left of a broken outline may close beside it until then.
    let mut ready = if inner.is_partial() { i32::from(inner.bottom) + 4 } else { 0 };
    for transition in scanner.last_transitions() {
        let Some(outline) = scanner.outlines.get(transition.label) else { continue };
        let width = i32::from(outline.width());
        let aside = (middle(outline.left, outline.right) - cx).abs();
        if outline.lossy
            || !outline.is_around(inner)
            || width > limits::MAX_GROWTH * i32::from(inner.width())
            || aside > width / 2
        {
            continue;
        }
        // Seen so far from its top; its bottom is about as far below the centre.
        let top = i32::from(outline.top);
        let bottom = cy - top;
        let slack = (bottom - top) / 8 + 4;
        if bottom - slack < i32::from(scanner.height()) {
            ready = ready.max(bottom + slack);
        }
    }
    ready.clamp(0, i32::from(u16::MAX)) as u16
}
