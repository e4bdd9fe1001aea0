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
mod exact;
mod fixed;
mod line;
mod scene;
mod solve;
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
use crate::fit::{Adjusted, Spread};
use crate::list::list;
use crate::math;
use crate::scan::Pool;
use crate::settings::limits;
use crate::target::MAX_CIRCLES;
use arrow::{Arrow, PARTS, Part};
use fixed::{GREY, fixed, sector};
use heapless::Vec;
use scene::Scene;
use solve::Solved;
use start::start;
use view::{Samples, View};

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
const FAR_SIGMAS: f32 = 4.0;
/// Room in the light beside an edge, standard deviations of its mean over a part of a turn, ...
const UNEVEN_SIGMAS: f32 = 3.7;
/// ... which has so many of the 128 sectors.
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
/// Least noise of a sample, grey levels: that of rounding.
const ROUNDING: f32 = 0.29;

/// Which crossings are used, and which of these are not disturbed. Grey levels.
#[derive(Clone, Copy)]
struct Gate {
    /// Few of them only.
    few: bool,
    /// Largest residual of a sample; and beside its noise, of the light beside the edge.
    misfit: i32,
    excess: f32,
    noise: f32,
    /// Largest residual of a far stretch by the binary logarithm of its number of pixels.
    far: [i32; 5],
}

impl Gate {
    fn new(few: bool, misfit: f32, (far, excess): (f32, f32), noise: f32) -> Self {
        let far = [1.0, 0.707, 0.5, 0.354, 0.25].map(|root| grey(far + FAR_SIGMAS * noise * root));
        Self { few, misfit: grey(misfit), excess, noise, far }
    }

    /// Whether `count` crossings with this sum of excesses lie in uneven light.
    fn is_uneven(&self, excess: i32, count: u16) -> bool {
        let (sum, count) = (excess as f32 / (2 * GREY) as f32, f32::from(count));
        count > 0.0 && sum.abs() > self.excess * count + UNEVEN_SIGMAS * self.noise * math::sqrt(0.5 * count)
    }
}

/// A residual, which is less than the whole scale.
fn grey(level: f32) -> i32 {
    fixed(level.min(255.0), GREY)
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
    /// Differences of neighbouring samples beside the edges, grey levels: from few crossings only.
    calm: Spread,
}

/// The fitted ellipses of all `edges`, with the light. Where the target is not seen whole, or not like the model, the noise of a
/// sample as neighbouring samples tell it, in units of the contrast; infinite if that is not known either. `ringed` tells that there
/// may be a code around it.
pub(super) fn joint(
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    origin: &Origin,
    ringed: bool,
) -> Result<(FittedList, Light), f32> {
    let about = (origin, ringed);
    let Some((model, noise)) = begin(edges, pool, about) else { return Err(f32::INFINITY) };
    let calm = noise.calm / model.contrast();
    settle(model, edges, pool, (about, &noise)).ok_or(calm)
}

/// Noise of a sample, grey levels.
struct Noise {
    /// What the model leaves, ...
    all: f32,
    /// ... and what neighbouring samples tell: what disturbs the light has little part in that.
    calm: f32,
}

/// The model from few crossings.
fn begin(edges: &Edges<'_>, pool: &Pool<'_>, about: (&Origin, bool)) -> Option<(Model, Noise)> {
    if edges.edges.iter().any(|edge| edge.partial || edge.cut) {
        return None;
    }
    let (dark, bright, blur) = start(edges, pool)?;
    let outline = |edge: &Edge| {
        Outline::new(about.0.undistorted_shape(&edge.shape)?, if edge.dark_inside { -1.0 } else { 1.0 })
    };
    let outlines: Vec<_, MAX_CIRCLES> = list(edges.edges.iter().map_while(outline));
    if outlines.len() < edges.edges.len() {
        return None;
    }
    let mut model = Model { outlines, dark, bright, gx: 0.0, gy: 0.0, blur };
    let noise = settle_few(&mut model, edges, pool, about)?;
    Some((model, noise))
}

/// Steps with all crossings, until they settle.
fn settle(
    mut model: Model,
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    ((origin, ringed), noise): ((&Origin, bool), &Noise),
) -> Option<(FittedList, Light)> {
    let size = edges.edges.first()?.shape.semi_axes().0;
    for _ in 0..STEPS {
        let contrast = model.contrast();
        let scene = Scene::new(&model, size, noise.all, ringed);
        // The model is less exact where edges blur into each other.
        let uneven = limits::UNEVEN * contrast * if scene.overlapping { 1.0 } else { 0.5 };
        let room = (2.0 * uneven, uneven);
        let gate = Gate::new(false, limits::MISFIT * contrast + SIGMAS * noise.all, room, noise.calm);
        let pass = pass(&scene, edges, pool, origin, &gate)?;
        let solved = pass.arrow.solve(&scene, size)?;
        let settled = if scene.overlapping { SETTLED_OVERLAPPING } else { SETTLED };
        let moved = model.take(&solved.step(), size)?;
        if moved < settled {
            check_contrast(model.contrast()).ok()?;
            return pass.is_clean().then(|| result(&model, &pass, &solved))?;
        }
    }
    None
}

/// Steps with few crossings, until they settle.
fn settle_few(
    model: &mut Model,
    edges: &Edges<'_>,
    pool: &Pool<'_>,
    (origin, ringed): (&Origin, bool),
) -> Option<Noise> {
    let size = edges.edges.first()?.shape.semi_axes().0;
    let mut misfit = FOREIGN * model.contrast();
    for step in 0..FEW_STEPS {
        let gate = Gate::new(true, misfit, (misfit, f32::INFINITY), 0.0);
        let scene = Scene::new(model, size, ROUNDING, ringed);
        let pass = pass(&scene, edges, pool, origin, &gate)?;
        let solved = pass.arrow.solve(&scene, size)?;
        let moved = model.take(&solved.step(), size)?;
        let noise = math::sqrt(solved.variance).max(ROUNDING);
        // The first step finds the light; what fits it badly is not known before.
        if step > 0 && moved < SETTLED_FEW {
            let calm = (CALM_ROOM * pass.calm.sigma()).max(ROUNDING);
            return Some(Noise { all: noise, calm: noise.min(calm) });
        }
        misfit = (FOREIGN_FEW * model.contrast() + SIGMAS * noise).min(0.5 * FOREIGN * model.contrast());
    }
    None
}

/// A pass over the crossings. `None` if an outline is no ellipse.
fn pass(scene: &Scene<'_>, edges: &Edges<'_>, pool: &Pool<'_>, origin: &Origin, gate: &Gate) -> Option<Pass> {
    let mut pass = Pass {
        arrow: Arrow::new(),
        seen: Vec::new(),
        used: 0,
        spoiled: 0,
        uneven: 0,
        clipped: 0,
        far: 0,
        strange: 0,
        calm: Spread::default(),
    };
    for (k, edge) in edges.edges.iter().enumerate() {
        let track = scene.track(k)?;
        pass.arrow.next();
        let mut seen = Sectors(0);
        let mut light = [(0, 0u16); PARTS];
        let mut parts = [Part::default(); PARTS];
        let stride = if gate.few { edge.stride() } else { 1 };
        for crossing in pool.iter(edge.crossings).step_by(stride) {
            let Some(view) = View::new(scene, &track, crossing, origin) else { continue };
            let sector = sector(view.direction());
            seen.0 |= 1 << sector;
            let part = sector as usize / SECTORS_OF_PART;
            let Some(samples) = view.samples() else { continue };
            if samples.misfit > gate.misfit {
                pass.spoiled += 1;
                continue;
            }
            pass.used += 1;
            if gate.few {
                pass.add_calm(&samples);
            }
            if let (Some((sum, count)), Some(part)) = (light.get_mut(part), parts.get_mut(part)) {
                *sum += samples.excess;
                *count += 1;
                pass.arrow.add(part, &view, &samples.sums, scene);
            }
            pass.add_far(&view, gate);
        }
        pass.arrow.add_parts(&parts, scene);
        pass.uneven += light.iter().filter(|(sum, count)| gate.is_uneven(*sum, *count)).count() as u32;
        let _ = pass.seen.push(seen.closed(track.outline.minor));
    }
    Some(pass)
}

impl Pass {
    fn add_calm(&mut self, samples: &Samples) {
        for difference in samples.differences() {
            let difference = difference as f32 / GREY as f32;
            self.calm.add(0.5 * difference * difference);
        }
    }

    #[inline]
    fn add_far(&mut self, view: &View<'_>, gate: &Gate) {
        let clipped = view.far(|far| {
            self.far += 1;
            if gate.far.get(far.log as usize).is_none_or(|&limit| far.residual.abs() > limit) {
                self.strange += 1;
            } else {
                self.arrow.add_far(&far);
            }
        });
        self.clipped += u32::from(clipped);
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
        let (points, scatter, seen) = (solved.points(k)?, solved.scatter(k)?, pass.seen.get(k)?);
        if scatter > MAX_SCATTER * solved.variance {
            return None;
        }
        // The noise of the samples is known better than the scatter of the edge points, unless that is clearly larger.
        let chance = 1.0 + CHANCE * math::sqrt(2.0 / f32::from(points));
        let variance = if scatter > chance * solved.variance { scatter } else { solved.variance };
        let frame_covariance = solved.spread(k)?.own.map(|row| row.map(|entry| entry * variance));
        let adjusted = Adjusted {
            shape: outline.shape,
            covariance: outline.frame.covariance(&frame_covariance),
            frame_covariance,
            rms: math::sqrt(solved.mean_square(k)?),
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
