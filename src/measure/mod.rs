//! A candidate, a chain of concentric outlines, to a target: the order of the stages from edge points to the centre.
//!
//! 1. [`joint`], or where anything disturbs the target [`disturbed`], or where that is to be quick [`quick`]: levels, edge points and
//!    ellipses.
//! 2. [`choose`]: which of these make a target.
//! 3. [`combine`]: their centres to the true centre, with its covariance; [`known`]: the same with a known camera.
//!
//! From the edge points on everything is in undistorted px about the target's [`origin`].

mod calm;
mod choose;
mod combine;
mod distances;
mod disturbed;
mod ellipse;
pub(crate) mod joint;
mod known;
mod origin;
mod quick;
mod sectors;
mod together;

use crate::abilities::{ARCS, JOINT};
use crate::candidate;
use crate::code;
use crate::edge::{Edge, Edges, Levels};
use crate::fit::Adjusted;
use crate::math;
use crate::reject::Reject;
use crate::scan::{Outline, Scanner};
use crate::settings::{Compensation, Effort, Polarity, Settings, limits};
use crate::target::{Circle, Ellipse, Flags, MAX_CIRCLES, Target};
use choose::choose;
pub(crate) use choose::concentric;
use combine::{Centre, combine, measured_perspective, significant};
use disturbed::disturbed;
pub(crate) use ellipse::{Fitted, FittedList};
use heapless::Vec;
use joint::joint;
use known::{Known, known};
pub(crate) use origin::Origin;
use quick::quick;
pub(crate) use sectors::PARTS;
use together::{Together, rough};

/// Measures the target whose outermost outline is `head`.
pub(crate) fn measure(head: u16, scanner: &mut Scanner<'_>, settings: &Settings) -> Result<Target, Reject> {
    let head = outermost(head, scanner, settings);
    let origin = scanner.outlines.get(head).map(candidate::origin).ok_or(Reject::BufferFull)?;
    let given = !settings.spec.ratios().is_empty();
    let mut edges = collect(head, origin, scanner, given)?;
    if edges.len() < 2 {
        return Err(Reject::Alone);
    }
    let open = scanner.outlines.get(head).is_some_and(|outline| outline.is_open());
    let about = Origin::new(origin, settings.known_camera()).ok_or(Reject::NotElliptic)?;
    let mut calm = f32::INFINITY;
    if ARCS && edges.iter().any(|edge| edge.partial) {
        let plain = Origin::new(origin, None).ok_or(Reject::NotElliptic)?;
        rough(&mut edges, &scanner.pool, &plain);
    } else if let Some(found) = quickly(&Edges { edges: &edges, origin }, scanner, settings, &about) {
        return Ok(found);
    } else if JOINT {
        match undisturbed(&Edges { edges: &edges, origin }, scanner, settings, &about) {
            Ok(found) => return found,
            Err(noise) => calm = noise,
        }
    }
    disturbed(&Edges { edges: &edges, origin }, scanner, settings, (&about, open, calm))
}

/// A target that nothing disturbs, where that is to be quick.
#[inline(never)]
fn quickly(edges: &Edges<'_>, scanner: &Scanner<'_>, settings: &Settings, about: &Origin) -> Option<Target> {
    if settings.effort != Effort::Quick {
        return None;
    }
    let mut fitted = FittedList::new();
    let light = quick(edges, &scanner.pool, about, &mut fitted)?;
    let circles = choose(&fitted, settings, scanner.width()).ok()?;
    let target = assemble(&circles, settings, &light, about).ok()?;
    Some(target.less_sure(limits::ALONE_VARIANCE))
}

/// A target that is seen whole. Where anything disturbs it, the noise of a sample, see [`joint`].
#[inline(never)]
fn undisturbed(
    edges: &Edges<'_>,
    scanner: &Scanner<'_>,
    settings: &Settings,
    about: &Origin,
) -> Result<Result<Target, Reject>, f32> {
    let mut fitted = FittedList::new();
    let light = joint(edges, &scanner.pool, about, settings.code.is_some(), &mut fitted)?;
    let circles = choose(&fitted, settings, scanner.width());
    Ok(circles.and_then(|circles| assemble(&circles, settings, &light, about)))
}

/// The outermost outline of the chain that can be a circle of a target. What is around it and open by itself is none, nor are
/// arcs of the ring of segments of a code.
fn outermost(mut head: u16, scanner: &Scanner<'_>, settings: &Settings) -> u16 {
    let outlines = &scanner.outlines;
    let mut whole = head;
    while let Some(outline) = outlines.get(whole).filter(|outline| outline.is_partial()) {
        whole = outline.inner;
    }
    let whole = outlines.get(whole);
    let ring = |outline: &Outline, inner: &Outline| {
        let ratio = math::sqrt((inner.moments.area as f32 / outline.moments.area as f32).abs());
        let of_code = [code::INNER / code::OUTER, 1.0 / code::OUTER, 1.0 / code::INNER];
        of_code.into_iter().any(|wanted| (ratio / wanted - 1.0).abs() < limits::CODE_RATIO)
    };
    while let Some(outline) = outlines.get(head).filter(|outline| outline.is_partial())
        && let Some(inner) = outlines.get(outline.inner)
    {
        let coded = settings.code.is_some()
            && (ring(outline, inner) || whole.is_some_and(|whole| ring(outline, whole)));
        let open = outline.is_open() && (settings.spec.ratios().is_empty() || settings.code.is_some());
        if !open && !coded {
            break;
        }
        head = outline.inner;
    }
    head
}

/// The outlines of the chain as edges about `origin`, outermost first.
fn collect(
    head: u16,
    origin: (u16, u16),
    scanner: &Scanner<'_>,
    given: bool,
) -> Result<Vec<Edge, MAX_CIRCLES>, Reject> {
    let mut edges = Vec::new();
    let mut at = head;
    while let Some(outline) = scanner.outlines.get(at) {
        // Further ones in are marks in the middle.
        if edges.is_full() {
            break;
        }
        if outline.is_open() {
            // A mark in the middle can be one; the target around it is none the worse.
            if edges.len() >= 2 {
                break;
            }
            // Nor does it matter where the ratios are known: a letter has others.
            if !given {
                return Err(Reject::OpenOutline);
            }
        }
        let own = candidate::origin(outline);
        let shift = |own: u16, origin: u16| (i32::from(origin) - i32::from(own)) as f32;
        let shape = candidate::shape(outline)?.about(shift(own.0, origin.0), shift(own.1, origin.1));
        if edges.is_empty() && outline.is_partial() && shape.semi_axes().0 < limits::MIN_PARTIAL_SEMI_AXIS {
            return Err(Reject::TooSmall);
        }
        let _ = edges.push(Edge::new(shape, outline));
        at = outline.inner;
    }
    Ok(edges)
}

fn check_contrast(contrast: f32) -> Result<(), Reject> {
    // Also refuses NaN.
    if contrast >= f32::from(limits::MIN_CONTRAST) { Ok(()) } else { Err(Reject::LowContrast) }
}

/// What is known of a target beside its ellipses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    pub contrast: f32,
    pub noise: f32,
    pub blur: f32,
    pub clipped: bool,
    /// Variance that the uncertainty of the levels gives to either coordinate of the outer ellipse's centre, px^2.
    pub plane: f32,
    /// Variance of an edge point that the noise explains, px^2.
    pub edge_variance: f32,
}

impl Light {
    fn new(levels: &Levels, blur: f32, outer: Option<&Fitted>) -> Self {
        let outer = outer.map(|outer| outer.adjusted.shape).unwrap_or_default();
        Self {
            contrast: levels.contrast(),
            noise: levels.noise,
            blur,
            clipped: levels.clipped,
            plane: levels.plane_variance(&outer, blur),
            edge_variance: Self::edge_variance(levels.contrast(), levels.noise, blur),
        }
    }

    /// Variance of an edge point, px^2, that the noise gives where the edge has a blur of `blur` px: the bound for samples
    /// 1 px apart along it, and for a wide edge that for four samples in its middle.
    pub fn edge_variance(contrast: f32, noise: f32, blur: f32) -> f32 {
        let share = noise / contrast;
        // 2 sqrt(pi) blur, and blur^2 / (4 density(0)^2).
        share * share * blur * 3.545f32.max(1.571 * blur)
    }
}

/// The target that `circles` make, which are those of one target and have their ratios.
#[inline(never)]
pub(crate) fn assemble(
    circles: &FittedList,
    settings: &Settings,
    light: &Light,
    origin: &Origin,
) -> Result<Target, Reject> {
    let forms = Forms::new(circles, light.plane, origin).ok_or(Reject::NotConcentric)?;
    target(circles, &forms, settings, (light, origin))
}

/// The forms of the centre.
struct Forms {
    plain: Centre,
    eq7: Centre,
    exact: Centre,
    auto: Centre,
    /// How much of the correction `auto` makes.
    share: f32,
    known: Option<Known>,
}

impl Forms {
    /// Of circles that were measured each by itself.
    fn new(circles: &FittedList, plane: f32, origin: &Origin) -> Option<Self> {
        let t = measured_perspective(circles)?;
        let (exact, auto, share) = significant(circles, t, plane)?;
        Some(Self {
            plain: Centre::of(circles.first()?),
            eq7: combine(circles, 0.0)?,
            exact,
            auto,
            share,
            known: origin.lens().and_then(|lens| known(circles, lens, plane)),
        })
    }

    /// Of circles that were measured together.
    fn together(all: &Together, plane: f32, origin: &Origin) -> Option<Self> {
        let Together { circles, separate, covariance } = all;
        let with = |t: f32| Some(Centre { covariance: *covariance, ..combine(circles, t)? });
        let exact = with(measured_perspective(circles)?)?;
        Some(Self {
            plain: Centre::of(circles.first()?),
            eq7: with(0.0)?,
            exact,
            auto: exact,
            share: 1.0,
            known: origin.lens().and_then(|lens| known(separate, lens, plane)),
        })
    }
}

fn target(
    circles: &FittedList,
    forms: &Forms,
    settings: &Settings,
    (light, origin): (&Light, &Origin),
) -> Result<Target, Reject> {
    let outer = circles.first().ok_or(Reject::Alone)?;
    let (_, b) = outer.adjusted.shape.semi_axes();
    if b < limits::MIN_OUTER_SEMI_AXIS {
        return Err(Reject::TooSmall);
    }
    let Forms { plain, eq7, exact, auto, share, known } = *forms;
    let plane = light.plane;
    let chosen = match settings.compensation {
        Compensation::None => plain,
        Compensation::Eq7 => eq7,
        Compensation::Exact => exact,
        Compensation::Auto => auto,
        Compensation::Known => known.map_or(exact, |known| known.centre),
    };
    let covariance = chosen.total_covariance(plane);
    let mut target = Target {
        centre: origin.position(chosen.x, chosen.y),
        covariance: origin.covariance((chosen.x, chosen.y), &covariance),
        eq7: origin.position(eq7.x, eq7.y),
        exact: origin.position(exact.x, exact.y),
        normal: known.map(|known| known.normal),
        code: None,
        circles: Vec::new(),
        contrast: light.contrast,
        noise: light.noise,
        blur: light.blur,
        flags: flags(circles, settings, light),
    };
    target.flags.set(Flags::INSIGNIFICANT, share <= 0.0);
    for circle in circles {
        let _ = target.circles.push(report(circle, origin));
    }
    Ok(target)
}

fn report(circle: &Fitted, origin: &Origin) -> Circle {
    let Adjusted { shape, covariance, rms, points, .. } = circle.adjusted;
    Circle {
        ellipse: Ellipse { centre: origin.position(shape.cx, shape.cy), ..shape.to_ellipse() },
        covariance: origin.covariance((shape.cx, shape.cy), &covariance),
        rms,
        points,
        gap: circle.gap as f32 * (360.0 / PARTS as f32),
        ratio: circle.ratio,
        measured_ratio: circle.measured_ratio,
    }
}

fn flags(circles: &FittedList, settings: &Settings, light: &Light) -> Flags {
    let mut flags = Flags::default();
    flags.set(Flags::CLIPPED, light.clipped);
    flags.set(Flags::LOW_CONTRAST, light.contrast < limits::FLAG_CONTRAST);
    flags.set(Flags::LIGHT, settings.spec.polarity() == Polarity::Light);
    flags.set(Flags::MEASURED_RATIO, settings.spec.ratios().is_empty());
    let explained = limits::FLAG_RESIDUAL_NOISE * light.edge_variance;
    let mut outside = f32::INFINITY;
    for circle in circles {
        let (_, b) = circle.adjusted.shape.semi_axes();
        let square = circle.adjusted.rms * circle.adjusted.rms;
        flags.set(Flags::RESIDUAL, square > explained + limits::FLAG_RESIDUAL * limits::FLAG_RESIDUAL);
        // Arcs that close the circle hide nothing.
        flags.set(Flags::OCCLUDED, circle.gap > if circle.partial { 0 } else { limits::FLAG_GAP });
        flags.set(Flags::CUT, circle.cut);
        flags.set(Flags::SMALL, b.min(outside - b) < limits::FLAG_SMALL);
        outside = b;
    }
    flags
}
