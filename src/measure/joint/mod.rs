//! Ellipses, levels, light and blur of a target together, from its stored crossings: Gauss-Newton steps to the maximum of the
//! likelihood under white noise (Kay 1993, "Fundamentals of Statistical Signal Processing: Estimation Theory", section 7.7).
//!
//! This is for a target that is seen whole. Where anything disturbs it, [`joint`] gives up, and the stages that sort out what is
//! disturbed take over.
//!
//! 1. [`start`]: first guesses.
//! 2. [`View`]: a crossing as the model has it.
//! 3. [`Part`]: what the crossings of a part of a turn tell together.
//! 4. [`Arrow`]: the equations of a step.
//! 5. [`joint`]: steps on few crossings until they settle, then on all.

mod arrow;
mod exact;
mod gate;
mod part;
mod samples;
mod scene;
mod series;
mod solve;
mod start;
#[cfg(test)]
mod tests;
mod view;

use super::ellipse::{Fitted, FittedList, push};
use super::origin::Origin;
use super::sectors::{PLACES, Sectors};
use super::{Light, check_contrast};
use crate::appearance::{Model, Outline, Step};
use crate::edge::{Edge, Edges};
use crate::fit::{Adjusted, Spread};
use crate::fixed::{GREY, sector};
use crate::math;
use crate::scan::Pool;
use crate::settings::limits;
use crate::target::MAX_CIRCLES;
use arrow::Arrow;
use core::f32::consts::FRAC_1_SQRT_2;
use gate::Gate;
use heapless::Vec;
use part::{FULL, PARTS, Part};
use samples::{Samples, Stretch};
use scene::{Scene, Track};
use start::start;
use view::View;

/// Most steps with few crossings, and with all.
const FEW_STEPS: usize = 5;
const STEPS: usize = 4;
/// A step with few crossings below this, px, is the last, because its own noise is nearly as large, and more of them save little; or
/// below the second where edges merge, where that is much less.
const SETTLED_FEW: f32 = 0.2;
const SETTLED_FEW_WELL: f32 = 0.1;
/// The first one is if it also changes the blur by less than this share, and leaves less noise than this share of the contrast: so
/// little that nothing foreign hides in it.
const SETTLED_BLUR: f32 = 0.1;
const QUIET: f32 = 0.04;
/// ... one with all below this: the next would be its square over the blur.
const SETTLED: f32 = 0.05;
/// The same where edges merge, which the equations leave out, or where the points scatter.
const SETTLED_WELL: f32 = 0.01;
/// Residual, as a share of the contrast, that is no target at first, ...
const FOREIGN: f32 = 0.5;
/// ... and while few crossings are used, with room for so many standard deviations of the noise.
const FOREIGN_FEW: f32 = 0.1;
const SIGMAS: f32 = 5.0;
/// Sectors of a part of a turn, of 128.
const SECTORS_OF_PART: usize = 128 / PARTS;
/// One in so many far stretches may be of another level.
const STRANGE_SHARE: u32 = 30;
/// Share of the crossings that may be left out, and how many of a small target.
const SPOILED_SHARE: u32 = 200;
const SPOILED: u32 = 1;
/// Standard deviations of a variance that are chance.
const CHANCE: f32 = 2.5;
/// Scatter of the edge points in units of what the noise explains, above which they are disturbed.
const MAX_SCATTER: f32 = 3.0;
/// Room for chance in the noise that neighbouring samples tell.
const CALM_ROOM: f32 = 1.25;
/// Residuals this many times as large as that noise are a pattern: dirt, a scratch, a shadow's border.
const FOREIGN_NOISE: f32 = 1.4;
/// Least noise of a sample, grey levels: that of rounding.
const ROUNDING: f32 = 0.29;

/// What the crossings tell of the next step.
struct Pass {
    arrow: Arrow,
    /// Sectors of each outline in which there are edge points.
    seen: Vec<Sectors, MAX_CIRCLES>,
    used: u32,
    /// Crossings that do not fit, in uneven light, and with a clipped level.
    spoiled: u32,
    uneven: u32,
    clipped: u32,
    /// Far stretches that tell the levels, and those of another level.
    far: u32,
    strange: u32,
    /// Differences of neighbouring samples beside the edges, grey levels: from few crossings only.
    calm: Spread,
}

/// A target, and room for a step: one for all steps, because it is large.
struct Steps<'a> {
    edges: &'a Edges<'a>,
    pool: &'a Pool<'a>,
    origin: &'a Origin,
    /// There may be a code around it.
    ringed: bool,
    /// Semi-major axis of the outermost outline, px.
    size: f32,
    pass: &'a mut Pass,
}

/// Noise of a sample, grey levels.
struct Noise {
    /// What the model leaves, ...
    all: f32,
    /// ... and what neighbouring samples tell: what disturbs the light has little part in that.
    calm: f32,
}

/// The fitted ellipses of all `edges` into `circles`, and the light. Where the target is not seen whole, or not like the model, the
/// noise of a sample as neighbouring samples tell it, in units of the contrast; infinite if that is not known either. `ringed` tells
/// that there may be a code around it.
#[inline(never)]
pub(super) fn joint(
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    origin: &Origin,
    ringed: bool,
    circles: &mut FittedList,
) -> Result<Light, f32> {
    let mut calm = f32::INFINITY;
    settle(edges, pool, (origin, ringed), circles, &mut calm).ok_or(calm)
}

/// The same; `calm` is set as soon as it is known.
fn settle(
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    (origin, ringed): (&Origin, bool),
    circles: &mut FittedList,
    calm: &mut f32,
) -> Option<Light> {
    if edges.edges.iter().any(|edge| edge.partial || edge.cut) {
        return None;
    }
    let (dark, bright, blur) = start(edges, pool)?;
    let mut outlines = Vec::new();
    for edge in edges.edges {
        let shape = origin.undistorted_shape(&edge.shape)?;
        outlines.push(Outline::new(shape, if edge.dark_inside { -1.0 } else { 1.0 })?).ok()?;
    }
    let mut model = Model { outlines, dark, bright, gx: 0.0, gy: 0.0, blur };
    let size = edges.edges.first()?.shape.semi_axes().0;
    let mut pass = Pass::new();
    let mut steps = Steps { edges, pool, origin, ringed, size, pass: &mut pass };
    let noise = steps.settle_few(&mut model)?;
    *calm = noise.calm / model.contrast();
    for _ in 0..STEPS {
        let contrast = model.contrast();
        let scene = Scene::new(&model, size, noise.all, ringed);
        let overlapping = scene.overlapping;
        let settled = if scene.merging { SETTLED_WELL } else { SETTLED };
        // The model is less exact where edges blur into each other.
        let uneven = limits::UNEVEN * contrast * if overlapping { 1.0 } else { 0.5 };
        let room = (2.0 * uneven, uneven);
        let gate = Gate::new(false, limits::MISFIT * contrast + SIGMAS * noise.all, room, noise.calm);
        let step = steps.next(&scene, &gate)?;
        let moved = model.take(&step, size)?;
        if moved < settled {
            check_contrast(model.contrast()).ok()?;
            if !steps.pass.is_clean() {
                return None;
            }
            circles.clear();
            let light = result(&model, steps.pass, noise.calm, circles);
            // Points scatter too while the light is still off.
            if light.is_some() || moved < SETTLED_WELL {
                return light;
            }
        }
    }
    None
}

impl Steps<'_> {
    /// Steps with few crossings, until they settle.
    fn settle_few(&mut self, model: &mut Model) -> Option<Noise> {
        let mut misfit = FOREIGN * model.contrast();
        for step in 0..FEW_STEPS {
            let gate = Gate::new(true, misfit, (misfit, f32::INFINITY), 0.0);
            let scene = Scene::new(model, self.size, ROUNDING, self.ringed);
            let settled = if scene.merging { SETTLED_FEW_WELL } else { SETTLED_FEW };
            let taken = self.next(&scene, &gate)?;
            let moved = model.take(&taken, self.size)?;
            let noise = math::sqrt(self.pass.arrow.solved.as_ref()?.variance).max(ROUNDING);
            // The first step finds the light; what fits it badly is not known before.
            let known = step > 0
                || noise < QUIET * model.contrast() && taken.shared.iter().last()?.abs() < SETTLED_BLUR;
            if known && moved < settled {
                // A difference has the noise of two samples.
                let calm = (CALM_ROOM * FRAC_1_SQRT_2 * self.pass.calm.sigma()).max(ROUNDING);
                return Some(Noise { all: noise, calm: noise.min(calm) });
            }
            misfit = (FOREIGN_FEW * model.contrast() + SIGMAS * noise).min(0.5 * FOREIGN * model.contrast());
        }
        None
    }

    /// A step. `None` if an outline is no ellipse.
    #[inline(never)]
    fn next(&mut self, scene: &Scene<'_>, gate: &Gate) -> Option<Step> {
        self.pass.clear();
        for (k, edge) in self.edges.edges.iter().enumerate() {
            self.add_edge(scene, &scene.track(k)?, edge, gate);
        }
        self.pass.arrow.solve(scene, self.size)
    }

    fn add_edge(&mut self, scene: &Scene<'_>, track: &Track<'_>, edge: &Edge, gate: &Gate) {
        let pass = &mut *self.pass;
        pass.arrow.next();
        let mut seen = Sectors::NONE;
        let mut parts = [Part::default(); PARTS];
        let mut samples = Samples::default();
        let mut lights = [(0, 0); PARTS];
        let stride = if gate.few { edge.stride() } else { 1 };
        for crossing in self.pool.iter(edge.crossings).step_by(stride) {
            let mut room = None;
            let Some(view) = View::new(scene, track, crossing, self.origin, &mut room) else { continue };
            let sector = sector(view.direction());
            let part = sector as usize / SECTORS_OF_PART;
            let (part, light) = (parts.get_mut(part), lights.get_mut(part));
            let (Some(part), Some((light, count))) = (part, light) else { continue };
            seen.mark(sector);
            view.samples(&mut samples);
            if samples.n == 0 {
                continue;
            }
            if gate.refuses(&samples) {
                pass.spoiled += 1;
                continue;
            }
            pass.used += 1;
            if gate.few {
                pass.add_calm(&samples);
            }
            *light += samples.excess();
            *count += 1;
            part.add(&view, &samples, scene);
            pass.add_far(part, &view, gate);
            if part.crossings == FULL {
                pass.arrow.add(part, scene);
                *part = Part::default();
            }
        }
        pass.uneven += lights.iter().filter(|(excess, count)| gate.is_uneven(*excess, *count)).count() as u32;
        for part in &parts {
            pass.arrow.add(part, scene);
        }
        let _ = pass.seen.push(seen.closed(track.own.outline.minor));
    }
}

impl Pass {
    /// Not inlined, so that it is made where it stays.
    #[inline(never)]
    fn new() -> Self {
        Self {
            arrow: Arrow::new(),
            seen: Vec::new(),
            used: 0,
            spoiled: 0,
            uneven: 0,
            clipped: 0,
            far: 0,
            strange: 0,
            calm: Spread::default(),
        }
    }

    fn clear(&mut self) {
        self.arrow.clear();
        self.seen.clear();
        [self.used, self.spoiled, self.uneven, self.clipped, self.far, self.strange] = [0; 6];
        self.calm = Spread::default();
    }

    fn add_calm(&mut self, samples: &Samples) {
        for difference in samples.differences() {
            self.calm.add_fixed(difference, GREY.ilog2());
        }
    }

    /// Adds the far stretches of a crossing.
    #[inline(never)]
    fn add_far(&mut self, part: &mut Part, view: &View<'_>, gate: &Gate) {
        // One after the other and not in a loop, which would keep what both share on the stack.
        let before = self.add_stretch(part, &view.far(-1), gate);
        let after = self.add_stretch(part, &view.far(1), gate);
        self.clipped += u32::from(before || after);
    }

    /// Adds one of them. Gives whether it is clipped.
    #[inline]
    fn add_stretch(&mut self, part: &mut Part, stretch: &Stretch, gate: &Gate) -> bool {
        if let Stretch::Clear(far) = stretch {
            self.far += 1;
            if gate.far.get(far.log as usize).is_none_or(|&limit| far.residual.abs() > limit) {
                self.strange += 1;
            } else {
                part.add_far(far);
            }
        }
        matches!(stretch, Stretch::Clipped)
    }

    /// Whether nothing disturbs the target.
    fn is_clean(&self) -> bool {
        let whole = |seen: &Sectors| seen.longest_gap() <= limits::FLAG_GAP;
        self.spoiled <= SPOILED + self.used / SPOILED_SHARE
            && self.strange <= self.far / STRANGE_SHARE
            && self.uneven == 0
            && self.seen.iter().all(whole)
    }
}

/// Factor on the covariance of an ellipse through so many points because residuals with this variance are not independent: what
/// neighbouring samples do not have too moves the points of a place all together.
fn excess(variance: f32, calm: f32, points: u16) -> f32 {
    let explained = calm * calm / variance;
    if explained * (FOREIGN_NOISE * FOREIGN_NOISE) >= 1.0 {
        return 1.0;
    }
    1.0 + f32::from(points) / PLACES as f32 * (1.0 - explained)
}

#[inline(never)]
fn result(model: &Model, pass: &Pass, calm: f32, circles: &mut FittedList) -> Option<Light> {
    let shared = pass.arrow.solved.as_ref()?;
    for (k, outline) in model.outlines.iter().enumerate() {
        let (solved, seen) = (pass.arrow.solution(k)?, pass.seen.get(k)?);
        let (points, scatter) = (solved.points, solved.scatter());
        if scatter > MAX_SCATTER * shared.variance {
            return None;
        }
        // The noise of the samples is known better than the scatter of the edge points, unless that is clearly larger.
        let chance = 1.0 + CHANCE * math::sqrt(2.0 / f32::from(points));
        let variance = if scatter > chance * shared.variance { scatter } else { shared.variance };
        let frame_variance = variance * excess(variance, calm, points);
        let frame_covariance = solved.covariance().map(|row| row.map(|entry| entry * frame_variance));
        let adjusted = Adjusted {
            shape: outline.shape,
            covariance: outline.frame.covariance(&frame_covariance),
            frame_covariance,
            rms: math::sqrt(solved.mean_square()),
            points,
        };
        let (dark_inside, gap) = (outline.inside < 0.0, seen.longest_gap());
        let fitted = Fitted {
            adjusted,
            edge: k,
            dark_inside,
            partial: false,
            cut: false,
            gap,
            ratio: 1.0,
            measured_ratio: 1.0,
        };
        push(circles, &fitted)?;
    }
    let plane = model.outlines.first()?.frame.covariance(&pass.arrow.solution(0)?.more(shared));
    let (contrast, noise) = (model.contrast(), math::sqrt(shared.variance));
    Some(Light {
        contrast,
        noise,
        blur: model.blur,
        clipped: pass.clipped > pass.used / 5,
        plane: 0.5 * shared.variance * (plane.xx + plane.yy),
        edge_variance: Light::edge_variance(contrast, noise, model.blur),
    })
}
