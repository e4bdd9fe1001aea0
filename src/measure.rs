//! A candidate, a chain of concentric outlines, to a target: the order of the stages from edge points to the centre.

use crate::candidate::{self, Offset};
use crate::centre::{Pencil, perspective, weights};
use crate::edge::{self, Edge, Edges, Levels};
use crate::fit::{Adjusted, Adjustment, Frame, Shape, Sums};
use crate::math;
use crate::reject::Reject;
use crate::scan::{Axis, Crossing, Pool, Scanner};
use crate::settings::{Compensation, Polarity, Settings, limits};
use crate::target::{Circle, Covariance, Flags, MAX_CIRCLES, Position, Target};
use heapless::Vec;

/// First guess of the blur, px, for the first look at the levels.
const BLUR_GUESS: f32 = 0.8;
/// Sectors in which edge points are looked for.
const SECTORS: u32 = 32;

/// An edge after its fit.
#[derive(Clone, Copy, Debug)]
struct Fitted {
    adjusted: Adjusted,
    dark_inside: bool,
    /// Longest run of sectors without an edge point, of 32.
    gap: u32,
    /// Radius in units of the outer circle's.
    ratio: f32,
}

type FittedList = Vec<Fitted, MAX_CIRCLES>;

/// Measures the target whose outermost outline is `head`.
pub(crate) fn measure(head: u16, scanner: &mut Scanner<'_>, settings: &Settings) -> Result<Target, Reject> {
    let origin = scanner.outlines.get(head).map(candidate::origin).ok_or(Reject::BufferFull)?;
    let edges = collect(head, origin, scanner)?;
    if edges.len() < 2 {
        return Err(Reject::Alone);
    }
    let edges = Edges { edges: &edges, origin };
    let pool = &mut scanner.pool;
    let levels = Levels::first(&edges, pool, BLUR_GUESS).ok_or(Reject::LowContrast)?;
    check_contrast(&levels)?;
    let blur = edge::measure_blur(&edges, pool, &levels);
    let levels = levels.refined(&edges, pool, blur).ok_or(Reject::LowContrast)?;
    check_contrast(&levels)?;
    let fitted = fit_all(&edges, pool, &levels, blur)?;
    let circles = choose(&fitted, settings, scanner.width())?;
    assemble(&circles, settings, &levels, blur, origin)
}

/// The outlines of the chain as edges about `origin`, outermost first.
fn collect(head: u16, origin: (u16, u16), scanner: &Scanner<'_>) -> Result<Vec<Edge, MAX_CIRCLES>, Reject> {
    let mut edges = Vec::new();
    let mut at = head;
    while let Some(outline) = scanner.outlines.get(at) {
        // Further ones in are marks in the middle.
        if edges.is_full() {
            break;
        }
        let own = candidate::origin(outline);
        let shift = |own: u16, origin: u16| (i32::from(origin) - i32::from(own)) as f32;
        let shape = candidate::shape(outline)?.about(shift(own.0, origin.0), shift(own.1, origin.1));
        let dark_inside = outline.moments.area > 0;
        let _ = edges.push(Edge::new(shape, dark_inside, outline.crossings));
        at = outline.inner;
    }
    Ok(edges)
}

fn check_contrast(levels: &Levels) -> Result<(), Reject> {
    // Also refuses NaN.
    if levels.contrast() >= f32::from(limits::MIN_CONTRAST) { Ok(()) } else { Err(Reject::LowContrast) }
}

/// Fits every edge. Those that are no ellipse are left out; an error if less than two remain.
fn fit_all(edges: &Edges<'_>, pool: &mut Pool<'_>, levels: &Levels, blur: f32) -> Result<FittedList, Reject> {
    let mut fitted = FittedList::new();
    let mut cause = Reject::Alone;
    for (k, edge) in edges.edges.iter().enumerate() {
        edge::place(edges, k, pool, levels, blur);
        match fit(edge, pool, edges.origin) {
            Ok(fit) => {
                let _ = fitted.push(fit);
            }
            Err(reject) => cause = reject,
        }
    }
    if fitted.len() < 2 { Err(cause) } else { Ok(fitted) }
}

/// Fits the ellipse of one edge to its edge points.
fn fit(edge: &Edge, pool: &Pool<'_>, origin: (u16, u16)) -> Result<Fitted, Reject> {
    let mut sums = Sums::default();
    let points = || pool.iter(edge.crossings).filter_map(|crossing| edge_point(crossing, origin));
    points().for_each(|(x, y)| sums.add(x, y));
    let start = sums.fit().ok_or(Reject::NotElliptic)?;
    let mut step = adjust(start, points(), f32::INFINITY)?;
    let limit = limits::OUTLIER * step.adjusted.rms.max(1.0 / 256.0);
    if step.farthest > limit {
        step = adjust(step.adjusted.shape, points(), limit)?;
    }
    let Step { adjusted, sectors, .. } = step;
    let (_, b) = adjusted.shape.semi_axes();
    let gap = longest_gap(sectors);
    if gap > limits::MAX_GAP {
        return Err(Reject::OpenOutline);
    }
    // Also refuses NaN.
    if !(adjusted.rms <= limits::MAX_RMS + limits::MAX_RMS_PER_AXIS * b) {
        return Err(Reject::NotElliptic);
    }
    Ok(Fitted { adjusted, dark_inside: edge.dark_inside, gap, ratio: 1.0 })
}

/// Edge point of a crossing about the origin, 1/256 px.
fn edge_point(crossing: &Crossing, origin: (u16, u16)) -> Option<(i32, i32)> {
    let offset = i32::from(crossing.offset()?);
    let x = 256 * (i32::from(crossing.x) - i32::from(origin.0));
    let y = 256 * (i32::from(crossing.y()) - i32::from(origin.1));
    Some(match crossing.axis() {
        Axis::Row => (x + offset, y),
        Axis::Column => (x, y + offset),
    })
}

/// An adjustment with what else the points tell.
struct Step {
    adjusted: Adjusted,
    /// Sectors in which there are points, one bit each.
    sectors: u32,
    /// Distance of the farthest point that was used from the ellipse before the step, px.
    farthest: f32,
}

/// One step from `shape` with the points nearer to it than `limit` px.
fn adjust(shape: Shape, points: impl Iterator<Item = (i32, i32)>, limit: f32) -> Result<Step, Reject> {
    let mut adjustment = Adjustment::new(shape).ok_or(Reject::NotElliptic)?;
    let (mut sectors, mut farthest) = (0u32, 0.0f32);
    for (x, y) in points {
        let (x, y) = (x as f32 / 256.0, y as f32 / 256.0);
        let point = adjustment.view(x, y);
        let distance = point.square_distance();
        if distance < limit * limit {
            adjustment.add(&point);
            farthest = farthest.max(distance);
            let turn = math::approx::atan2(point.v, point.u) * (0.5 / core::f32::consts::PI) + 1.0;
            sectors |= 1u32.rotate_left((turn * SECTORS as f32) as u32 % SECTORS);
        }
    }
    let adjusted = adjustment.finish().ok_or(Reject::NotElliptic)?;
    Ok(Step { adjusted, sectors, farthest: math::sqrt(farthest) })
}

/// Longest run of sectors without a point, around the circle.
fn longest_gap(sectors: u32) -> u32 {
    let mut empty = !sectors;
    let mut longest = 0;
    while empty != 0 && longest < SECTORS {
        empty &= empty.rotate_left(1);
        longest += 1;
    }
    longest
}

/// Appends to a list that is never longer than the one it is made of.
fn list(items: impl Iterator<Item = Fitted>) -> FittedList {
    let mut list = FittedList::new();
    for item in items.take(MAX_CIRCLES) {
        let _ = list.push(item);
    }
    list
}

/// The circles that make a target, outermost first, with their ratios.
fn choose(fitted: &FittedList, settings: &Settings, width: u16) -> Result<FittedList, Reject> {
    let mut cause = Reject::Ratio;
    for (k, outer) in fitted.iter().enumerate() {
        let inside = fitted.get(k + 1..).unwrap_or(&[]);
        if outer.dark_inside != (settings.spec.polarity() == Polarity::Dark) || inside.is_empty() {
            continue;
        }
        let concentric = inside.iter().filter_map(|inner| concentric(outer, inner, width));
        let circles = list(core::iter::once(*outer).chain(concentric));
        if circles.len() < 2 {
            cause = Reject::NotConcentric;
            continue;
        }
        let chosen = match settings.spec.ratios() {
            [] => {
                let mut chosen =
                    list(circles.iter().copied().filter(|c| c.ratio >= limits::MIN_MEASURED_RATIO));
                drop_marks(&mut chosen);
                Some(chosen).filter(|chosen| chosen.len() >= 2)
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
fn concentric(outer: &Fitted, inner: &Fitted, width: u16) -> Option<Fitted> {
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
    fits.then_some(Fitted { ratio, ..*inner })
}

/// Relative tolerance of the ratio of an inner circle.
fn ratio_tolerance(inner: &Fitted) -> f32 {
    limits::RATIO_TOLERANCE + limits::RATIO_TOLERANCE_EDGE / inner.adjusted.shape.semi_axes().1
}

/// For each wanted ratio the circle that comes nearest to it. Its ratio is then the wanted one, unless that is farther off
/// than edges displaced by uneven light or the print explain. The outer circle is the first.
fn match_circles(circles: &FittedList, wanted: &[f32]) -> Option<FittedList> {
    let (outer, inside) = circles.split_first()?;
    let mut matched = list(core::iter::once(*outer));
    for &ratio in wanted {
        let off = |circle: &&Fitted| (circle.ratio / ratio - 1.0).abs();
        let best = inside.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if off(&best) > ratio_tolerance(best) {
            return None;
        }
        let ratio = if off(&best) <= 0.25 * ratio_tolerance(best) { ratio } else { best.ratio };
        matched.push(Fitted { ratio, ..*best }).ok()?;
    }
    Some(matched)
}

/// The same for circles drawn as lines: the wanted radii are those of the lines' middles. Both sides of each line are
/// taken, with their measured ratios.
fn match_lines(circles: &FittedList, wanted: &[f32]) -> Option<FittedList> {
    let first = circles.first()?;
    let line = |pair: &[Fitted]| match pair {
        [a, b] if a.dark_inside == first.dark_inside && b.dark_inside != a.dark_inside => {
            (b.ratio > limits::LINE_RATIO * a.ratio).then_some((0.5 * (a.ratio + b.ratio), *a, *b))
        }
        _ => None,
    };
    let (outer, a, b) = line(circles.get(..2)?)?;
    let mut matched = list([a, b].into_iter());
    for &ratio in wanted {
        let off = |(middle, ..): &(f32, Fitted, Fitted)| (middle / (outer * ratio) - 1.0).abs();
        let inside = circles.windows(2).skip(1).filter_map(line);
        let best = inside.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if off(&best) > ratio_tolerance(&best.2) {
            return None;
        }
        matched.push(best.1).ok()?;
        matched.push(best.2).ok()?;
    }
    Some(matched)
}

/// A mark in the middle can be round without being concentric: the innermost of three or more circles goes while it does
/// not lie where the others put it.
fn drop_marks(circles: &mut FittedList) {
    while circles.len() > 2 {
        let Some(innermost) = circles.pop() else { return };
        if mark_offset(circles, &innermost)
            .is_some_and(|(offset, sigma)| offset <= limits::MARK_SIGMAS * sigma + limits::MARK_OFFSET)
        {
            let _ = circles.push(innermost);
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

/// A centre with its covariance, about the origin, px.
#[derive(Clone, Copy, Debug)]
struct Centre {
    x: f32,
    y: f32,
    covariance: Covariance,
}

impl Centre {
    fn of(adjusted: &Adjusted) -> Self {
        Self { x: adjusted.shape.cx, y: adjusted.shape.cy, covariance: adjusted.covariance }
    }

    /// Where the line through this centre and the ellipse centres puts that of the circle with `ratio`: B = C + K g, with K
    /// by least squares.
    fn at(&self, ratio: f32, t: f32, circles: &FittedList) -> (f32, f32) {
        let g = |ratio: f32| ratio * ratio / (1.0 - t * ratio * ratio);
        let (mut kx, mut ky, mut norm) = (0.0, 0.0, 0.0);
        for circle in circles {
            let weight = g(circle.ratio) / variance(circle);
            kx += weight * (circle.adjusted.shape.cx - self.x);
            ky += weight * (circle.adjusted.shape.cy - self.y);
            norm += weight * g(circle.ratio);
        }
        (self.x + g(ratio) * kx / norm, self.y + g(ratio) * ky / norm)
    }

    /// Mean square of the ellipse centres' distances from the line in units of their variance, where it is above 1: three
    /// or more circles show errors that the residuals of each alone do not.
    fn misfit(&self, circles: &FittedList, t: f32) -> f32 {
        let Some(free) = circles.len().checked_sub(2).filter(|&free| free > 0) else { return 1.0 };
        let squares = circles.iter().fold(0.0, |sum, circle| {
            let (x, y) = self.at(circle.ratio, t, circles);
            let (dx, dy) = (circle.adjusted.shape.cx - x, circle.adjusted.shape.cy - y);
            sum + (dx * dx + dy * dy) / variance(circle)
        });
        (squares / free as f32).max(1.0)
    }

    fn position(&self, origin: (u16, u16)) -> Position {
        Position::from_origin(i32::from(origin.0), i32::from(origin.1), self.x, self.y)
    }
}

/// The weighted sum of the ellipse centres; `t` is the perspective, 0 for eq. (7).
fn combine(circles: &FittedList, t: f32) -> Option<Centre> {
    let mut inputs = Vec::<(f32, f32), MAX_CIRCLES>::new();
    for circle in circles {
        inputs.push((circle.ratio, variance(circle))).ok()?;
    }
    let outer = circles.first()?.adjusted.shape;
    let mut centre = Centre { x: outer.cx, y: outer.cy, covariance: Covariance::default() };
    for (weight, circle) in weights(&inputs, t)?.iter().zip(circles) {
        let Adjusted { shape, covariance, .. } = circle.adjusted;
        // About the outer centre: the weights sum to 1, so only differences of centres count.
        centre.x += weight * (shape.cx - outer.cx);
        centre.y += weight * (shape.cy - outer.cy);
        let square = weight * weight;
        centre.covariance.xx += square * covariance.xx;
        centre.covariance.xy += square * covariance.xy;
        centre.covariance.yy += square * covariance.yy;
    }
    let excess = centre.misfit(circles, t);
    centre.covariance.xx *= excess;
    centre.covariance.xy *= excess;
    centre.covariance.yy *= excess;
    Some(centre)
}

/// Variance of a circle's ellipse centre, both coordinates together. A picture without noise has none, and the weights
/// need one.
fn variance(circle: &Fitted) -> f32 {
    circle.adjusted.covariance.xx + circle.adjusted.covariance.yy + 1e-12
}

/// t of [`crate::centre::perspective`] from the outer and the innermost circle.
fn measured_perspective(circles: &FittedList) -> Option<f32> {
    let (outer, inner) = (circles.first()?.adjusted.shape, circles.last()?);
    let small = inner.adjusted.shape;
    Some(perspective(outer.square(small.cx - outer.cx, small.cy - outer.cy), inner.ratio))
}

fn assemble(
    circles: &FittedList,
    settings: &Settings,
    levels: &Levels,
    blur: f32,
    origin: (u16, u16),
) -> Result<Target, Reject> {
    let outer = circles.first().ok_or(Reject::Alone)?;
    let degenerate = Reject::NotConcentric;
    let (_, b) = outer.adjusted.shape.semi_axes();
    if b < limits::MIN_OUTER_SEMI_AXIS {
        return Err(Reject::TooSmall);
    }
    let plain = Centre::of(&outer.adjusted);
    let eq7 = combine(circles, 0.0).ok_or(degenerate)?;
    let exact = measured_perspective(circles).and_then(|t| combine(circles, t)).ok_or(degenerate)?;
    let chosen = match settings.compensation {
        Compensation::None => plain,
        Compensation::Eq7 => eq7,
        Compensation::Exact => exact,
    };
    let mut target = Target {
        centre: chosen.position(origin),
        covariance: chosen.covariance,
        eq7: eq7.position(origin),
        exact: exact.position(origin),
        circles: Vec::new(),
        contrast: levels.contrast(),
        blur,
        flags: flags(circles, settings, levels),
    };
    let added = |c: &Covariance| c.xx + c.yy - plain.covariance.xx - plain.covariance.yy;
    let (dx, dy) = (plain.x - exact.x, plain.y - exact.y);
    target.flags.set(Flags::INSIGNIFICANT, dx * dx + dy * dy < added(&exact.covariance));
    for circle in circles {
        let Adjusted { shape, covariance, rms, points } = circle.adjusted;
        let ellipse = shape.to_ellipse(i32::from(origin.0), i32::from(origin.1));
        let _ = target.circles.push(Circle { ellipse, covariance, rms, points, ratio: circle.ratio });
    }
    Ok(target)
}

fn flags(circles: &FittedList, settings: &Settings, levels: &Levels) -> Flags {
    let mut flags = Flags::default();
    flags.set(Flags::CLIPPED, levels.clipped);
    flags.set(Flags::LOW_CONTRAST, levels.contrast() < limits::FLAG_CONTRAST);
    flags.set(Flags::LIGHT, settings.spec.polarity() == Polarity::Light);
    flags.set(Flags::MEASURED_RATIO, settings.spec.ratios().is_empty());
    let mut outside = f32::INFINITY;
    for circle in circles {
        let (_, b) = circle.adjusted.shape.semi_axes();
        let high = limits::MAX_RMS + limits::MAX_RMS_PER_AXIS * b;
        flags.set(Flags::RESIDUAL, circle.adjusted.rms > 0.5 * high);
        flags.set(Flags::OCCLUDED, circle.gap > limits::FLAG_GAP);
        flags.set(Flags::SMALL, b.min(outside - b) < limits::FLAG_SMALL);
        outside = b;
    }
    flags
}
