//! Ellipses, levels, light and blur of a target together, from its stored crossings: Gauss-Newton steps to the maximum of the
//! likelihood under white noise (Kay 1993, "Fundamentals of Statistical Signal Processing: Estimation Theory", section 7.7).
//!
//! This is for a target that is seen whole. Where anything disturbs it, [`joint`] gives up, and the stages that sort out what is
//! disturbed take over.
//!
//! 1. [`start`]: first guesses.
//! 2. [`View`]: a crossing as the model has it.
//! 3. [`Arrow`]: the equations of a step.
//! 4. [`joint`]: steps on few crossings until they settle, then on all.

mod arrow;
mod passage;
mod scene;
mod start;
#[cfg(test)]
mod tests;
mod view;

use super::ellipse::{Fitted, FittedList};
use super::origin::Origin;
use super::sectors::Sectors;
use super::{Light, check_contrast};
use crate::appearance::{Model, Outline};
use crate::edge::{Edge, Edges};
use crate::fit::Adjusted;
use crate::list::list;
use crate::math;
use crate::scan::Pool;
use crate::settings::limits;
use crate::target::MAX_CIRCLES;
use arrow::{Arrow, Solved};
use heapless::Vec;
use scene::Scene;
use start::start;
use view::View;

/// Most steps with few crossings, and with all.
const FEW_STEPS: usize = 5;
const STEPS: usize = 4;
/// A step with few crossings below this, px, is the last, because its own noise is as large; ...
const SETTLED_FEW: f32 = 0.1;
/// ... one with all below this: the next would be its square over the blur.
const SETTLED: f32 = 0.05;
/// The same where edges blur into each other, which the equations leave out.
const SETTLED_OVERLAPPING: f32 = 0.01;
/// Residual, as a share of the contrast, that is no target at first, ...
const FOREIGN: f32 = 0.5;
/// ... and while few crossings are used, with room for so many standard deviations of the noise.
const FOREIGN_FEW: f32 = 0.1;
const SIGMAS: f32 = 5.0;
/// Room in the light beside an edge, standard deviations of its mean over a part of a turn, ...
const UNEVEN_SIGMAS: f32 = 3.7;
/// ... of which there are so many.
const PARTS: usize = 16;
/// One in so many far stretches may be of another level.
const STRANGE_SHARE: u32 = 30;
/// Share of the crossings that may be left out, and how many of a small target.
const SPOILED_SHARE: u32 = 200;
const SPOILED: u32 = 1;
/// Standard deviations of a variance that are chance.
const CHANCE: f32 = 2.5;
/// Scatter of the edge points in units of what the noise explains, above which they are disturbed.
const MAX_SCATTER: f32 = 3.0;
/// Least noise of a sample, grey levels: that of rounding.
const ROUNDING: f32 = 0.29;

/// Which crossings are used, and which of these are not disturbed. Grey levels.
#[derive(Clone, Copy)]
struct Gate {
    /// Few of them only.
    few: bool,
    /// Largest residual of a sample; and beside its noise, of a far stretch and of the light beside the edge.
    misfit: f32,
    far: f32,
    excess: f32,
    noise: f32,
}

impl Gate {
    /// Whether `count` crossings with this sum of excesses lie in uneven light.
    fn is_uneven(&self, sum: f32, count: f32) -> bool {
        count > 0.0 && sum.abs() > self.excess * count + UNEVEN_SIGMAS * self.noise * math::sqrt(0.5 * count)
    }
}

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
}

/// The fitted ellipses of all `edges`, with the light. `None` where the target is not seen whole, or not like the model.
/// `ringed` tells that there may be a code around it.
pub(super) fn joint(
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    origin: &Origin,
    ringed: bool,
) -> Option<(FittedList, Light)> {
    if edges.edges.iter().any(|edge| edge.partial || edge.cut) {
        return None;
    }
    let (dark, bright, blur) = start(edges, pool)?;
    let outline = |edge: &Edge| {
        Outline::new(origin.undistorted_shape(&edge.shape)?, if edge.dark_inside { -1.0 } else { 1.0 })
    };
    let outlines: Vec<_, MAX_CIRCLES> = list(edges.edges.iter().map_while(outline));
    if outlines.len() < edges.edges.len() {
        return None;
    }
    let mut model = Model { outlines, dark, bright, gx: 0.0, gy: 0.0, blur };
    let size = edges.edges.first()?.shape.semi_axes().0;
    let noise = settle_few(&mut model, edges, pool, (origin, ringed))?;
    for _ in 0..STEPS {
        let contrast = model.contrast();
        let scene = Scene::new(&model, size, noise, ringed);
        // The model is less exact where edges blur into each other.
        let uneven = limits::UNEVEN * if scene.overlapping { 1.0 } else { 0.5 };
        let gate = Gate {
            few: false,
            misfit: limits::MISFIT * contrast + SIGMAS * noise,
            far: limits::UNEVEN * contrast,
            excess: uneven * contrast,
            noise,
        };
        let pass = pass(&scene, edges, pool, origin, &gate);
        let solved = pass.arrow.solve()?;
        let moved = model.take(&solved.step(), size)?;
        if moved < if scene.overlapping { SETTLED_OVERLAPPING } else { SETTLED } {
            check_contrast(model.contrast()).ok()?;
            return pass.is_clean().then(|| result(&model, &pass, &solved))?;
        }
    }
    None
}

/// Steps with few crossings, until they settle. Gives the noise of a sample.
fn settle_few(
    model: &mut Model,
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    (origin, ringed): (&Origin, bool),
) -> Option<f32> {
    let size = edges.edges.first()?.shape.semi_axes().0;
    let mut misfit = FOREIGN * model.contrast();
    for step in 0..FEW_STEPS {
        let gate = Gate { few: true, misfit, far: misfit, excess: f32::INFINITY, noise: 0.0 };
        let solved =
            pass(&Scene::new(model, size, ROUNDING, ringed), edges, pool, origin, &gate).arrow.solve()?;
        let moved = model.take(&solved.step(), size)?;
        let noise = math::sqrt(solved.variance).max(ROUNDING);
        // The first step finds the light; what fits it badly is not known before.
        if step > 0 && moved < SETTLED_FEW {
            return Some(noise);
        }
        misfit = (FOREIGN_FEW * model.contrast() + SIGMAS * noise).min(0.5 * FOREIGN * model.contrast());
    }
    None
}

/// A pass over the crossings.
fn pass(scene: &Scene, edges: &Edges<'_>, pool: &Pool<'_>, origin: &Origin, gate: &Gate) -> Pass {
    let model = &scene.model;
    let mut pass = Pass {
        arrow: Arrow::new(model),
        seen: Vec::new(),
        used: 0,
        spoiled: 0,
        uneven: 0,
        clipped: 0,
        far: 0,
        strange: 0,
    };
    for (k, (edge, outline)) in edges.edges.iter().zip(&model.outlines).enumerate() {
        let mut seen = Sectors(0);
        let mut light = [(0.0, 0.0); PARTS];
        let stride = if gate.few { edge.stride() } else { 1 };
        for crossing in pool.iter(edge.crossings).step_by(stride) {
            let Some(view) = View::new(scene, k, crossing, origin) else { continue };
            let (u, v) = view.direction();
            let part = if gate.few { 0 } else { seen.mark(u, v) };
            let Some(samples) = view.samples() else { continue };
            if samples.misfit() > gate.misfit {
                pass.spoiled += 1;
                continue;
            }
            pass.used += 1;
            if let Some((sum, count)) = light.get_mut(part) {
                *sum += samples.excess();
                *count += 1.0;
            }
            pass.arrow.add(k, &view.told(&samples), model);
            pass.add_far(scene, &view, gate);
        }
        pass.uneven += light.iter().filter(|(sum, count)| gate.is_uneven(*sum, *count)).count() as u32;
        let _ = pass.seen.push(seen.closed(outline.minor));
    }
    pass
}

impl Pass {
    fn add_far(&mut self, scene: &Scene, view: &View<'_>, gate: &Gate) {
        let model = &scene.model;
        let (far, clipped) = view.far();
        self.clipped += u32::from(clipped);
        for far in far.into_iter().flatten() {
            let (x, y) = far.place;
            let light = 1.0 + model.gx * x + model.gy * y;
            let mixed = model.dark + model.contrast() * far.lightness;
            let residual = far.level - mixed * light;
            self.far += 1;
            if residual.abs() > far.limit(gate.far, gate.noise) {
                self.strange += 1;
            } else {
                let (dark, bright) = ((1.0 - far.lightness) * light, far.lightness * light);
                let terms = [dark, bright, mixed * x / scene.size, mixed * y / scene.size];
                self.arrow.add_far(&far, terms, residual);
            }
        }
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

fn result(model: &Model, pass: &Pass, solved: &Solved) -> Option<(FittedList, Light)> {
    let mut circles = FittedList::new();
    for (k, outline) in model.outlines.iter().enumerate() {
        let (block, scatter, seen) = (pass.arrow.blocks.get(k)?, solved.scatter(k)?, pass.seen.get(k)?);
        if scatter > MAX_SCATTER * solved.variance {
            return None;
        }
        // The noise of the samples is known better than the scatter of the edge points, unless that is clearly larger.
        let chance = 1.0 + CHANCE * math::sqrt(2.0 / f32::from(block.points));
        let variance = if scatter > chance * solved.variance { scatter } else { solved.variance };
        let frame_covariance = solved.spread(k)?.own.map(|row| row.map(|entry| entry * variance));
        let adjusted = Adjusted {
            shape: outline.shape,
            covariance: outline.frame.covariance(&frame_covariance),
            frame_covariance,
            rms: math::sqrt(solved.mean_square(k)?),
            points: block.points,
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
        circles.push(fitted).ok()?;
    }
    let frame = model.outlines.first()?.frame;
    let plane = solved.spread(0)?.shared.map(|row| row.map(|entry| entry * solved.variance));
    let plane = frame.covariance(&plane);
    let (contrast, noise) = (model.contrast(), math::sqrt(solved.variance));
    let light = Light {
        contrast,
        noise,
        blur: model.blur,
        clipped: pass.clipped > pass.used / 5,
        plane: 0.5 * (plane.xx + plane.yy),
        edge_variance: Light::edge_variance(contrast, noise, model.blur),
    };
    Some((circles, light))
}
