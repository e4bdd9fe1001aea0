//! Which of a candidate's edges make a target.

use super::combine::{combine, measured_perspective};
use super::ellipse::{Fitted, FittedList, push};
use crate::candidate::Offset;
use crate::centre::Pencil;
use crate::fit::{Adjusted, Frame};
use crate::list::rolled;
use crate::math;
use crate::reject::Reject;
use crate::settings::{Polarity, Settings, limits};

/// The circles that make a target, outermost first, with their ratios.
pub(super) fn choose(fitted: &FittedList, settings: &Settings, width: u16) -> Result<FittedList, Reject> {
    let mut cause = Reject::Ratio;
    for (k, outer) in fitted.iter().enumerate() {
        let inside = fitted.get(k + 1..).unwrap_or(&[]);
        if outer.dark_inside != (settings.spec.polarity() == Polarity::Dark) || inside.is_empty() {
            continue;
        }
        let mut circles = FittedList::new();
        let _ = push(&mut circles, outer);
        for circle in rolled(inside).filter_map(|inner| concentric(outer, inner, width)) {
            let _ = push(&mut circles, &circle);
        }
        if circles.len() < 2 {
            cause = Reject::NotConcentric;
            continue;
        }
        let chosen = match settings.spec.ratios() {
            [] => {
                circles.retain(|circle| circle.ratio >= limits::MIN_MEASURED_RATIO);
                drop_marks(&mut circles);
                Some(circles).filter(|chosen| chosen.len() >= 2)
            }
            wanted => match_lines(&circles, wanted).or_else(|| match_circles(&circles, wanted)),
        };
        if let Some(chosen) = chosen {
            return Ok(chosen);
        }
    }
    Err(cause)
}

/// `inner` with its measured ratio, if it can be a circle concentric with `outer`.
pub(crate) fn concentric(outer: &Fitted, inner: &Fitted, width: u16) -> Option<Fitted> {
    let (large, small) = (outer.adjusted.shape, inner.adjusted.shape);
    let b = small.semi_axes().1;
    let frame = Frame::new(&large)?;
    let centre = frame.vector(small.cx - large.cx, small.cy - large.cy);
    let matrix = frame.matrix(&small);
    let area_ratio = math::sqrt(large.det() / small.det());
    // Circles that nearly coincide are the two sides of a line: there the pencil has no single root.
    let (ratio, split) = if area_ratio < limits::PENCIL_AREA_RATIO {
        let pencil = Pencil::new(centre, matrix)?;
        (pencil.ratio, pencil.split)
    } else {
        let half = 0.5 * (matrix.0 - matrix.2);
        (math::sqrt(area_ratio), math::sqrt(half * half + matrix.1 * matrix.1) / (matrix.0 + matrix.2))
    };
    let offset = math::sqrt(centre.0 * centre.0 + centre.1 * centre.1);
    let max_offset = Offset { width, grid: limits::FITTED_CENTRE }.limit(large.semi_axes(), area_ratio);
    let max_split = limits::MAX_SPLIT + limits::SPLIT_PER_RESIDUAL * inner.adjusted.rms / b;
    let fits = b >= limits::MIN_INNER_SEMI_AXIS && ratio < 1.0 && offset <= max_offset && split <= max_split;
    fits.then_some(Fitted { ratio, measured_ratio: ratio, ..*inner })
}

/// Relative tolerance of the ratio of an inner circle.
fn ratio_tolerance(inner: &Fitted) -> f32 {
    limits::RATIO_TOLERANCE + limits::RATIO_TOLERANCE_EDGE / inner.adjusted.shape.semi_axes().1
}

/// For each wanted ratio the circle that comes nearest to it. Its ratio is then the wanted one, unless that is farther off
/// than edges displaced by uneven light or the print explain. The outer circle is the first.
fn match_circles(circles: &FittedList, wanted: &[f32]) -> Option<FittedList> {
    let (outer, inside) = circles.split_first()?;
    let mut matched = FittedList::new();
    push(&mut matched, outer)?;
    for &ratio in wanted {
        let off = |circle: &&Fitted| (circle.ratio / ratio - 1.0).abs();
        let best = rolled(inside).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if off(&best) > ratio_tolerance(best) {
            return None;
        }
        let ratio =
            if off(&best) <= ratio_tolerance(best) - limits::RATIO_DISTRUST { ratio } else { best.ratio };
        push(&mut matched, &Fitted { ratio, ..*best })?;
    }
    Some(matched)
}

/// The same for circles drawn as lines: the wanted radii are those of the lines' middles. Both sides of each line are
/// taken, with their measured ratios.
fn match_lines(circles: &FittedList, wanted: &[f32]) -> Option<FittedList> {
    let first = circles.first()?;
    let line = |pair| line(pair, first.dark_inside);
    let (outer, a, b) = line(circles.get(..2)?)?;
    let mut matched = FittedList::new();
    push(&mut matched, a)?;
    push(&mut matched, b)?;
    for &ratio in wanted {
        let off = |(middle, ..): &(f32, &Fitted, &Fitted)| (middle / (outer * ratio) - 1.0).abs();
        let inside = rolled(circles.windows(2)).skip(1).filter_map(line);
        let best = inside.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if off(&best) > ratio_tolerance(best.2) {
            return None;
        }
        push(&mut matched, best.1)?;
        push(&mut matched, best.2)?;
    }
    Some(matched)
}

/// The middle of the line whose sides two circles can be, in units of the outer circle, and these.
fn line(pair: &[Fitted], dark_inside: bool) -> Option<(f32, &Fitted, &Fitted)> {
    match pair {
        [a, b] if a.dark_inside == dark_inside && b.dark_inside != a.dark_inside => {
            (b.ratio > limits::LINE_RATIO * a.ratio).then_some((0.5 * (a.ratio + b.ratio), a, b))
        }
        _ => None,
    }
}

/// A mark in the middle can be round without being concentric: the innermost of three or more circles goes while it does
/// not lie where the others put it.
fn drop_marks(circles: &mut FittedList) {
    while circles.len() > 2 {
        let Some(innermost) = circles.pop() else { return };
        if mark_offset(circles, &innermost)
            .is_some_and(|(offset, sigma)| offset <= limits::MARK_SIGMAS * sigma + limits::MARK_OFFSET)
        {
            let _ = push(circles, &innermost);
            return;
        }
    }
}

/// Distance of a circle's ellipse centre from where the others put it, and the standard deviation of that, px.
fn mark_offset(others: &FittedList, circle: &Fitted) -> Option<(f32, f32)> {
    let t = measured_perspective(others)?;
    let line = combine(others, t)?;
    let (x, y) = line.at(circle.ratio, t, others);
    let Adjusted { shape, covariance, .. } = circle.adjusted;
    let (dx, dy) = (shape.cx - x, shape.cy - y);
    let variance = covariance.xx + covariance.yy + line.covariance.xx + line.covariance.yy;
    Some((math::sqrt(dx * dx + dy * dy), math::sqrt(variance)))
}
