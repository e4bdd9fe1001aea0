//! Which closed outlines can be circles of a target, and which of them belong together.
//!
//! Inner outlines close before the ones around them. A closed outline that is an ellipse waits, at the head of the chain
//! of concentric ones inside it, until nothing that is still open can close around it.

use crate::fit::Shape;
use crate::math;
use crate::reject::Reject;
use crate::scan::{NONE, Outline, Outlines, Scanner};
use crate::settings::limits;

/// Outlines that wait for one around them: a list through [`Outline::next`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    head: u16,
}

impl Waiting {
    pub const EMPTY: Self = Self { head: NONE };

    /// Takes a closed outline. An error is the reason why it is none of a target; its slot is then still in use.
    pub fn add(&mut self, label: u16, scanner: &mut Scanner<'_>) -> Result<(), Reject> {
        let outline = *scanner.outlines.get(label).ok_or(Reject::BufferFull)?;
        let shape = shape(&outline)?;
        let limit = Offset { width: scanner.width(), grid: limits::GRID_CENTRE };
        let inner =
            self.take_inner(|inner| concentric(&outline, &shape, inner, &limit), &mut scanner.outlines);
        let ready = ready_row(&outline, scanner);
        if let Some(outline) = scanner.outlines.get_mut(label) {
            (outline.inner, outline.ready, outline.next) = (inner, ready, self.head);
            self.head = label;
        }
        Ok(())
    }

    /// The head of a chain that nothing can close around any more after `rows` rows.
    pub fn take_ready(&mut self, rows: u16, outlines: &mut Outlines<'_>) -> Option<u16> {
        self.take(outlines, |_, outline| outline.ready <= rows)
    }

    /// Takes the largest waiting outline that is `concentric`.
    fn take_inner(&mut self, concentric: impl Fn(&Outline) -> bool, outlines: &mut Outlines<'_>) -> u16 {
        let (mut at, mut best, mut area) = (self.head, NONE, 0);
        while let Some(inner) = outlines.get(at) {
            if inner.moments.area.abs() > area && concentric(inner) {
                (best, area) = (at, inner.moments.area.abs());
            }
            at = inner.next;
        }
        self.take(outlines, |label, _| label == best).unwrap_or(NONE)
    }

    /// Takes the first outline out of the list for which `wanted` holds.
    fn take(&mut self, outlines: &mut Outlines<'_>, wanted: impl Fn(u16, &Outline) -> bool) -> Option<u16> {
        let (mut before, mut at) = (NONE, self.head);
        while let Some(outline) = outlines.get(at).copied() {
            if wanted(at, &outline) {
                match outlines.get_mut(before) {
                    Some(before) => before.next = outline.next,
                    None => self.head = outline.next,
                }
                return Some(at);
            }
            (before, at) = (at, outline.next);
        }
        None
    }
}

/// The pixel about which an outline is calculated: the middle of its bounding box.
pub(crate) fn origin(outline: &Outline) -> (u16, u16) {
    (outline.left.midpoint(outline.right), outline.top.midpoint(outline.bottom))
}

/// The ellipse with the outline's moments, about [`origin`].
pub(crate) fn shape(outline: &Outline) -> Result<Shape, Reject> {
    if outline.cut {
        return Err(Reject::CutByFrame);
    }
    if outline.width().min(outline.height()) < limits::MIN_EXTENT {
        return Err(Reject::TooSmall);
    }
    if outline.lossy {
        return Err(Reject::BufferFull);
    }
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
    let shape = Shape::from_moments(cx, cy, mxx, mxy, myy).ok_or(Reject::NotElliptic)?;
    let (a, b) = shape.semi_axes();
    let excess = (area.abs() / (core::f32::consts::PI * a * b) - 1.0).abs();
    if !(excess <= limits::AREA_TOLERANCE + limits::AREA_TOLERANCE_GRID / b) {
        return Err(Reject::NotElliptic);
    }
    // Far fewer crossings than a circle has: its border is the threshold's, not an edge.
    let expected = 4.0 * math::sqrt(a * b);
    if f32::from(outline.crossings.len()) < 0.5 * expected {
        return Err(Reject::LowContrast);
    }
    Ok(shape)
}

/// Whether `inner`, closed before, can be a concentric circle inside `outline`.
fn concentric(outline: &Outline, shape: &Shape, inner: &Outline, offset: &Offset) -> bool {
    if !outline.surrounds(inner) || inner.bottom > outline.bottom {
        return false;
    }
    let (ox, oy) = origin(outline);
    let area = inner.moments.area as f32;
    let from = |sum: i64, origin: u16| (sum - i64::from(origin) * inner.moments.area) as f32 / area;
    let (dx, dy) = (from(inner.moments.x, ox) - shape.cx, from(inner.moments.y, oy) - shape.cy);
    let area_ratio = (area / outline.moments.area as f32).abs();
    let limit = offset.limit(shape.semi_axes(), area_ratio);
    shape.square(dx, dy) <= limit * limit
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
    let mut ready = 0;
    for transition in scanner.last_transitions() {
        let Some(outline) = scanner.outlines.get(transition.label) else { continue };
        let width = i32::from(outline.width());
        let aside = (middle(outline.left, outline.right) - cx).abs();
        if outline.cut
            || outline.lossy
            || !outline.surrounds(inner)
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
