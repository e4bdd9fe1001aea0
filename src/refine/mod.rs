//! Refinement: targets that were found are measured again on the pixels, when the image is in memory.
//!
//! [`polish`] fits the ellipses, the two levels under one plane of light and the blur together, to every pixel near the
//! outlines: Gauss-Newton steps to the maximum of the likelihood under white noise. Pixels that the sensor has clipped are
//! left out, and so are those that do not fit.
//!
//! 1. `pixel`: the level that a pixel should have.
//! 2. `normals`: the equations of a step.
//! 3. [`polish`]: steps until they settle; then the stages after the ellipse fit as for any target.

mod normals;
mod pixel;

use crate::appearance::{Model, Outline, Spread};
use crate::detector::Image;
use crate::fit::Adjusted;
use crate::math;
use crate::measure::{Fitted, FittedList, Light, Origin, PARTS, assemble, concentric};
use crate::settings::{Polarity, Settings};
use crate::target::{Circle, Flags, Target};
use heapless::Vec;
use normals::Normals;
use pixel::{Expected, Slope};

/// How far from an outline the pixels are looked at, px: for the levels well beyond the edge.
const REACH: f32 = 16.0;
/// Most steps.
const STEPS: usize = 8;
/// A step below this, px, is the last.
const SETTLED: f32 = 5e-4;
/// A residual above this share of the contrast is no pixel of the target ...
const FOREIGN: f32 = 0.25;
/// ... nor one above this many standard deviations, but ...
const OUTLIER: f32 = 5.0;
/// ... never one below this share: a response that is not linear bends the profile by so much.
const TOLERATED: f32 = 0.08;
/// Farthest that the centre may move, px: the edge points are better than that.
const FARTHEST: f32 = 0.5;
/// Lightness from that of a flat area up to which a pixel tells the levels at first.
const FLAT: f32 = 0.15;
/// Measures `target` again on the pixels of `image`, in which a [`Detector`](crate::Detector) with the same `settings` has
/// found it. On success its places, covariances, contrast, noise, blur and flags are the new ones, with
/// [`Flags::REFINED`]; on failure (a part of the target is not seen, the pixels do not determine the model, or contradict the edge points) it is left as it
/// was.
///
/// The centre's error falls to within some per cent of the Cramer-Rao bound, and the bias that whole-pixel samples leave
/// to some hundred-thousandths of a pixel. The work is up to eight passes over the target's bounding box; the stack holds
/// about 30 KiB.
#[must_use]
pub fn polish(image: &Image<'_>, settings: &Settings, target: &mut Target) -> bool {
    let Some(better) = polished(image, settings, target) else { return false };
    *target = better;
    true
}

fn polished(image: &Image<'_>, settings: &Settings, target: &Target) -> Option<Target> {
    // What lies over a target is no part of the model, and its border would pass for the target's own.
    if target.flags.contains(Flags::OCCLUDED) || target.flags.contains(Flags::CUT) {
        return None;
    }
    let window = Window::new(image, settings, target)?;
    let mut model = start(&window, settings, target)?;
    window.find_levels(&mut model, target.noise)?;
    let mut noise = target.noise;
    let mut limit = FOREIGN * model.contrast();
    for pass in 0..STEPS {
        let normals = window.normals(&model, noise, limit);
        let factor = normals.factor()?;
        let moved = model.take(&normals.step(&factor), window.size)?;
        let variance = normals.variance();
        noise = math::sqrt(normals.noise());
        limit = (OUTLIER * noise).max(TOLERATED * model.contrast()).min(FOREIGN * model.contrast());
        if moved < SETTLED || pass + 1 == STEPS {
            let spread = |k| normals.spread(&factor, k);
            return window.assemble(&model, settings, target, (&spread, variance, noise));
        }
    }
    None
}

/// The model with the target's ellipses and first guesses of the levels.
fn start(window: &Window<'_>, settings: &Settings, target: &Target) -> Option<Model> {
    let mut outlines = Vec::new();
    // What is inside the outer circle, then alternately.
    let mut inside = if settings.spec.polarity() == Polarity::Dark { -1.0 } else { 1.0 };
    let (mut dark, mut bright) = (0.0, 0.0);
    for circle in &target.circles {
        let outline = Outline::new(window.origin.shape(circle)?, inside)?;
        let (within, beyond) = window.sides(&outline)?;
        // Circles between which one was left out make no model.
        if (beyond > within) != (inside < 0.0) {
            return None;
        }
        dark += within.min(beyond);
        bright += within.max(beyond);
        outlines.push(outline).ok()?;
        inside = -inside;
    }
    // Near blurred edges the levels are not reached; the edge points know the contrast better.
    let middle = 0.5 * (dark + bright) / outlines.len() as f32;
    let (dark, bright) = (middle - 0.5 * target.contrast, middle + 0.5 * target.contrast);
    Some(Model { outlines, dark, bright, gx: 0.0, gy: 0.0, blur: target.blur })
}

/// The part of the image that holds the target.
struct Window<'i> {
    image: &'i Image<'i>,
    origin: Origin,
    /// The outer semi-major axis, px: the unit of the light's slopes.
    size: f32,
    /// First and last column and row.
    columns: (i32, i32),
    rows: (i32, i32),
}

impl<'i> Window<'i> {
    fn new(image: &'i Image<'i>, settings: &Settings, target: &Target) -> Option<Self> {
        let outer = target.circles.first()?.ellipse;
        let origin = Origin::of(target, settings.known_camera())?;
        let pixel = origin.pixel;
        // Distortion changes sizes by less than that, or there is no target.
        let reach = (1.25 * outer.a + REACH) as i32 + 1;
        let range = |at: u16, end: u16| {
            let at = i32::from(at);
            ((at - reach).max(0), (at + reach).min(i32::from(end) - 1))
        };
        let (width, height) = image.size();
        Some(Self {
            image,
            origin,
            size: outer.a,
            columns: range(pixel.0, width),
            rows: range(pixel.1, height),
        })
    }

    /// Mean levels inside and outside an outline, 2.5 px from it.
    fn sides(&self, outline: &Outline) -> Option<(f32, f32)> {
        const AWAY: f32 = 2.5;
        const PLACES: usize = 16;
        let (mut within, mut beyond, mut count) = (0.0, 0.0, 0.0);
        for i in 0..PLACES {
            let (s, c) = math::approx::sincos(i as f32 * (core::f32::consts::TAU / PLACES as f32));
            let (x, y) = outline.frame.inverse(c, s);
            let share = AWAY / math::sqrt(x * x + y * y);
            let at = |factor: f32| {
                let place = (outline.shape.cx + factor * x, outline.shape.cy + factor * y);
                let (x, y) = self.origin.seen(place);
                self.level(math::round(x), math::round(y))
            };
            if let (Some(inner), Some(outer)) = (at(1.0 - share.min(1.0)), at(1.0 + share)) {
                within += f32::from(inner);
                beyond += f32::from(outer);
                count += 1.0;
            }
        }
        (count > 0.0).then(|| (within / count, beyond / count))
    }

    /// The pixel `(dx, dy)` from the origin.
    fn level(&self, dx: i32, dy: i32) -> Option<u8> {
        let (x, y) = self.origin.pixel;
        self.image.level(i32::from(x) + dx, i32::from(y) + dy)
    }

    /// Levels and light from the pixels that edges hardly reach; edges and blur are only known to a tenth of a pixel yet.
    fn find_levels(&self, model: &mut Model, noise: f32) -> Option<()> {
        // The first time without the light's slope, which is not known at all.
        for limit in [2.0 * FOREIGN, FOREIGN] {
            let mut normals = Normals::new(0, 1.0 / self.size);
            normals.add_prior(model);
            self.for_each(model, |pixel, place, expected| {
                let residual = f32::from(pixel) - model.level(expected);
                let seen = (1..255).contains(&pixel);
                let flat = expected.lightness.min(1.0 - expected.lightness) < FLAT;
                if flat && seen && residual.abs() < limit * model.contrast() {
                    normals.add(model, expected, place, residual);
                }
            });
            model.take(&normals.step(&normals.factor()?), self.size)?;
        }
        (model.contrast() > 4.0 * noise.min(2.0)).then_some(())
    }

    /// The equations of a step, from the pixels that fit to `limit` grey levels.
    fn normals(&self, model: &Model, noise: f32, limit: f32) -> Normals {
        let mut normals = Normals::new(model.outlines.len(), 1.0 / self.size);
        normals.add_prior(model);
        // Where noise reaches the end of the scale the mean is no longer the level.
        let (least, most) = (noise, 255.0 - noise);
        self.for_each(model, |pixel, place, expected| {
            let level = model.level(expected);
            let residual = f32::from(pixel) - level;
            if level > least && level < most && residual.abs() < limit {
                normals.add(model, expected, place, residual);
            }
        });
        normals
    }

    /// Calls `f` with level, place and model of each pixel near an outline.
    fn for_each(&self, model: &Model, mut f: impl FnMut(u8, (f32, f32), &Expected)) {
        let (x0, y0) = self.origin.pixel;
        let tight = model.tight();
        for y in self.rows.0..=self.rows.1 {
            for x in self.columns.0..=self.columns.1 {
                let Some(pixel) = self.image.level(x, y) else { continue };
                let seen = ((x - i32::from(x0)) as f32, (y - i32::from(y0)) as f32);
                let Some(place) = self.origin.place(seen) else { continue };
                let lens = |place| Slope(self.origin.slope(place));
                if let Some(expected) = model.at(place, &tight, lens, REACH) {
                    f(pixel, place, &expected);
                }
            }
        }
    }

    /// The target with the new ellipses.
    fn assemble(
        &self,
        model: &Model,
        settings: &Settings,
        target: &Target,
        (spread, variance, noise): (&dyn Fn(usize) -> Spread, f32, f32),
    ) -> Option<Target> {
        let mut circles = FittedList::new();
        for (k, (outline, old)) in model.outlines.iter().zip(&target.circles).enumerate() {
            let fitted = fitted(outline, &spread(k), variance, old);
            let fitted = match circles.first() {
                Some(outer) => {
                    let measured = concentric(outer, &fitted, self.image.size().0)?;
                    let given = !target.flags.contains(Flags::MEASURED_RATIO);
                    Fitted { ratio: if given { old.ratio } else { measured.ratio }, ..measured }
                }
                None => fitted,
            };
            circles.push(fitted).ok()?;
        }
        let contrast = model.contrast();
        let frame = model.outlines.first()?.frame;
        let plane = frame.covariance(&spread(0).shared.map(|row| row.map(|entry| entry * variance)));
        let light = Light {
            contrast,
            noise,
            blur: model.blur,
            clipped: target.flags.contains(Flags::CLIPPED),
            plane: 0.5 * (plane.xx + plane.yy),
            edge_variance: 3.545 * model.blur * noise * noise / (contrast * contrast),
        };
        let mut better = assemble(&circles, settings, &light, &self.origin).ok()?;
        better.code = target.code;
        better.flags.set(Flags::REFINED, true);
        for hidden in [Flags::CUT, Flags::OCCLUDED] {
            better.flags.set(hidden, target.flags.contains(hidden));
        }
        let (dx, dy) = better.centre.offset_from(target.centre);
        (dx * dx + dy * dy < FARTHEST * FARTHEST).then_some(better)
    }
}

fn fitted(outline: &Outline, spread: &Spread, variance: f32, old: &Circle) -> Fitted {
    let frame_covariance = spread.own.map(|row| row.map(|entry| entry * variance));
    let adjusted = Adjusted {
        shape: outline.shape,
        covariance: outline.frame.covariance(&frame_covariance),
        frame_covariance,
        rms: old.rms,
        points: old.points,
    };
    let gap = math::round(old.gap * (PARTS as f32 / 360.0)).max(0) as u32;
    let dark_inside = outline.inside < 0.0;
    Fitted {
        adjusted,
        edge: 0,
        dark_inside,
        partial: false,
        cut: false,
        gap,
        ratio: 1.0,
        measured_ratio: 1.0,
    }
}
