//! A target circle by circle: where not all of it is seen or anything disturbs it, and where there is no joint estimate.
//!
//! The stages one after the other, each of which leaves its room on the stack to the next.

use super::calm::calm;
use super::choose::choose;
use super::ellipse::{Fitted, FittedList, Source, fit, push};
use super::origin::Origin;
use super::together::together;
use super::{Forms, Light, assemble, check_contrast, target};
use crate::abilities::{ARCS, JOINT};
use crate::edge::{self, Blur, Edge, Edges, Levels, Lines};
use crate::reject::Reject;
use crate::scan::{Pool, Scanner};
use crate::settings::{Settings, limits};
use crate::target::Target;

/// Most further passes over the levels of a target with something in front of it: each leaves more of that out.
const LEVEL_PASSES: usize = 3;
/// First guess of the blur, px, for the first look at the levels.
const BLUR_GUESS: f32 = 0.8;

/// A target of which not everything is seen, or in front of which something is; `open` tells that its outline is, `calm` is the noise of a
/// sample as [`joint`] gives it.
#[inline(never)]
pub(super) fn disturbed(
    edges: &Edges<'_>,
    scanner: &mut Scanner<'_>,
    settings: &Settings,
    (about, open, calm): (&Origin, bool, f32),
) -> Result<Target, Reject> {
    let covered = ARCS && edges.edges.iter().any(|edge| edge.partial);
    let mut fitted = FittedList::new();
    let mut seen = place_edges(edges, &mut scanner.pool, (about, covered), &mut fitted)?;
    seen.calm = seen.noise.min(calm);
    let source = seen.source(edges.edges, &scanner.pool, about);
    if fitted.is_empty() {
        fit_all(&source, &mut fitted)?;
    }
    combine_disturbed(&fitted, &source, settings, (&seen, scanner.width(), open))
}

/// What is known of a disturbed target when its edge points are placed.
struct Seen {
    levels: Levels,
    blur: f32,
    /// Noise of a sample as [`Source`] has it.
    noise: f32,
    calm: f32,
    /// Something is in front of it, or may be.
    covered: bool,
    spoiled: bool,
}

impl Seen {
    fn source<'a, 'p>(&self, edges: &'a [Edge], pool: &'a Pool<'p>, origin: &'a Origin) -> Source<'a, 'p> {
        Source { edges, pool, origin, noise: self.noise, calm: self.calm, blur: self.blur }
    }
}

/// Places the edge points, or fits all edges at once where that can be.
#[inline(never)]
fn place_edges(
    edges: &Edges<'_>,
    pool: &mut Pool<'_>,
    (about, covered): (&Origin, bool),
    fitted: &mut FittedList,
) -> Result<Seen, Reject> {
    let lines = edges.lines();
    let first = Levels::first((edges, &lines), pool, BLUR_GUESS, covered).ok_or(Reject::LowContrast)?;
    check_contrast(first.contrast())?;
    let blur = edge::measure_blur((edges, &lines), pool, &first);
    // What the joint estimate has refused is not calm.
    if !JOINT && !covered && about.lens().is_none() {
        if let Some((levels, noise)) = calm((edges, &lines), pool, about, (&first, &blur), fitted) {
            return Ok(Seen { levels, blur: blur.sigma, noise, calm: noise, covered, spoiled: false });
        }
        fitted.clear();
    }
    let (levels, blur, spoiled) = disturbed_levels((edges, &lines), pool, covered, (first, blur))?;
    // What disturbs one edge does not disturb all.
    let noise = (0..edges.edges.len())
        .fold(f32::INFINITY, |least, k| least.min(edge::place((edges, &lines), k, pool, (&levels, blur))));
    Ok(Seen { levels, blur, noise, calm: noise, covered, spoiled })
}

#[inline(never)]
fn combine_disturbed(
    fitted: &FittedList,
    source: &Source<'_, '_>,
    settings: &Settings,
    (seen, width, open): (&Seen, u16, bool),
) -> Result<Target, Reject> {
    let given = !settings.spec.ratios().is_empty();
    let about = source.origin;
    let circles = choose(fitted, settings, width)?;
    let light = Light::new(&seen.levels, seen.blur, circles.first());
    let found = if circles.iter().any(Fitted::is_occluded) {
        let all = together(&circles, source, given)?;
        if open && !all.has_ratios(settings.spec.ratios()) {
            return Err(Reject::OpenOutline);
        }
        let forms = Forms::together(&all, light.plane, about).ok_or(Reject::NotConcentric)?;
        target(&all.circles, &forms, settings, (&light, about))
    } else {
        assemble(&circles, settings, &light, about)
    };
    // What the joint estimate has refused is spoiled. Without it there is only what the levels and the gaps show.
    let spoiled = JOINT || seen.spoiled || circles.iter().any(Fitted::has_gap);
    let excess = match (seen.covered, spoiled) {
        (true, _) => limits::COVERED_VARIANCE,
        (false, true) => limits::SPOILED_VARIANCE,
        (false, false) => limits::ALONE_VARIANCE,
    };
    found.map(|target| target.less_sure(excess))
}

/// Levels and blur of a target of which not everything is seen (`covered`), or in front of which something may be; and whether
/// something is.
#[inline(never)]
fn disturbed_levels(
    target: (&Edges<'_>, &Lines),
    pool: &Pool<'_>,
    covered: bool,
    (levels, mut blur): (Levels, Blur),
) -> Result<(Levels, f32, bool), Reject> {
    let mut levels = levels.refined(target, pool, &blur, covered).ok_or(Reject::LowContrast)?;
    check_contrast(levels.contrast())?;
    let is_spoiled =
        |levels: &Levels, blur: &Blur| levels.noise > limits::DISTURBED * blur.noise * levels.contrast();
    for _ in 0..LEVEL_PASSES {
        if !covered && !is_spoiled(&levels, &blur) {
            break;
        }
        blur = edge::measure_blur(target, pool, &levels);
        levels = levels.refined(target, pool, &blur, covered).ok_or(Reject::LowContrast)?;
        check_contrast(levels.contrast())?;
    }
    let spoiled = is_spoiled(&levels, &blur);
    if spoiled {
        levels = levels.disturbed();
    }
    Ok((levels, blur.sigma, spoiled))
}

/// Fits every edge. Those that are no ellipse are left out; an error if less than two remain.
#[inline(never)]
fn fit_all(source: &Source<'_, '_>, fitted: &mut FittedList) -> Result<(), Reject> {
    let mut cause = Reject::Alone;
    for k in 0..source.edges.len() {
        match fit(source, k) {
            Ok(fit) => {
                let _ = push(fitted, &fit);
            }
            Err(reject) => cause = reject,
        }
    }
    if fitted.len() < 2 { Err(cause) } else { Ok(()) }
}
