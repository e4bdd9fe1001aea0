//! The levels of a target: one dark and one bright level under one plane of illumination.

mod normals;

use super::light::{Light, LightThere};
use super::local::{FAR, Local, NEAR};
use super::place::{Blur, Sharpness};
use super::profile::{Blurred, PEAK, mean_tail};
use super::{Edges, Lines};
use crate::fit::Shape;
use crate::fixed::{GREY, ONE, PX, fixed, scale};
use crate::scan::{Axis, Crossing, Pool, Stretch};
use normals::{Normals, TERM};

/// A residual above this share of the contrast is no flat area: dirt, a mark, another object.
const OUTLIER: f32 = 0.25;
/// The same in the last pass, with room for this many standard deviations of the noise.
const LAST_OUTLIER: f32 = 0.04;
const LAST_OUTLIER_SIGMAS: f32 = 4.0;
/// The same where something lies before the target, with room for this many robust standard deviations of the residuals.
const COVERED_OUTLIER: f32 = 0.01;
const COVERED_OUTLIER_SIGMAS: f32 = 3.0;
/// Blur, px, up to which the near samples tell the levels.
const SHARP: f32 = 1.1;
/// Pixels whose levels are independent of each other where something lies before the target: eight places of eight pixels.
const INDEPENDENT: f32 = 64.0;
/// Standard deviation of the light's slope along either axis where a level is clipped, relative change over the outer
/// semi-major axis: one sixth over the whole target.
const CLIPPED_SLOPE: f32 = 1.0 / 12.0;
/// Lightness that the levels of an edge are expected to have at the far samples before the near ones are asked.
const CLEAR: i32 = ONE / 2;
/// Standard deviations to the border of a far stretch beyond which the edge has no part in it: less than 1/2000 of the contrast.
const UNREACHED: i32 = 11 * PX / 4;
/// Level with which the first plane is additive, as both levels.
const EVEN: f32 = 128.0;
/// How far beyond the target the samples reach, px: the unit of places is so much more than its semi-major axis.
const BEYOND: f32 = 16.0;
/// Unit of the levels that the light's slopes change, grey levels: keeps the system well scaled.
const SLOPE: f32 = 256.0;

/// Dark and bright level at the origin; the level at (x, y) px from it is that times 1 + gx x + gy y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    pub dark: f32,
    pub bright: f32,
    pub gx: f32,
    pub gy: f32,
    /// Covariance (xx, xy, yy) of the two slopes, 1/px^2.
    pub(super) slopes: (f32, f32, f32),
    /// Standard deviation of the samples about the levels of the pass before, grey levels.
    pub noise: f32,
    /// The same without what most of them do not show.
    pub(super) spread: f32,
    /// Pixels in the samples, each as far as it counted.
    pub(super) pixels: f32,
    /// More than one far sample in ten at the end of the grey scale.
    pub clipped: bool,
}

impl Levels {
    /// A first look at the levels, from some of the crossings and for a blur of `sigma` px.
    pub fn first(target: (&Edges<'_>, &Lines), pool: &Pool<'_>, sigma: f32, covered: bool) -> Option<Self> {
        let unknown = Self {
            dark: EVEN,
            bright: EVEN,
            gx: 0.0,
            gy: 0.0,
            slopes: (0.0, 0.0, 0.0),
            noise: 0.0,
            spread: 0.0,
            pixels: 0.0,
            clipped: false,
        };
        let blur = Blur { sigma, noise: 0.0 };
        let first = unknown.refine(target, pool, &blur, (Pass::First, covered))?;
        let share = 2.0 * EVEN / (first.dark + first.bright);
        let levels = Self { gx: share * first.gx, gy: share * first.gy, ..first };
        levels.refine(target, pool, &blur, (Pass::Look, covered))
    }

    /// The levels by least squares over the samples of every crossing, each with the lightness that the ellipses and the
    /// blur give it. Shading is multiplicative, so the plane's slope is proportional to the level. What is
    /// far from `self` is left out; where something covers a part of the target, what is far from most.
    pub fn refined(
        &self,
        target: (&Edges<'_>, &Lines),
        pool: &Pool<'_>,
        blur: &Blur,
        covered: bool,
    ) -> Option<Self> {
        self.refine(target, pool, blur, (Pass::All, covered))
    }

    /// The same where something lies before the target, whose residuals are not independent: as if there were only so many of
    /// them as it has places where that can differ.
    pub fn disturbed(&self) -> Self {
        let factor = (self.pixels / INDEPENDENT).max(1.0);
        let (xx, xy, yy) = self.slopes;
        Self { slopes: (factor * xx, factor * xy, factor * yy), ..*self }
    }

    /// Bright minus dark at the origin, grey levels.
    pub fn contrast(&self) -> f32 {
        self.bright - self.dark
    }

    /// Variance, px^2, that the uncertainty of the plane gives to either coordinate of the centre of `outer`, whose edge has
    /// a blur of `sigma` px. A plane that is wrong by g per px moves the edge at x by g x (middle level) / (slope of the
    /// edge), and so the ellipse towards one side; the mean over the two directions is taken.
    pub fn plane_variance(&self, outer: &Shape, sigma: f32) -> f32 {
        let slope = self.contrast() * PEAK / sigma;
        let shift = 0.5 * (self.dark + self.bright) / slope;
        let (xx, xy, yy) = self.slopes;
        // Half the trace of the slopes' covariance times the inverse of the ellipse's matrix.
        let spread = (outer.ayy * xx - 2.0 * outer.axy * xy + outer.axx * yy) / (2.0 * outer.det());
        (shift * shift * spread).max(0.0)
    }

    #[inline(never)]
    fn refine(
        &self,
        (edges, lines): (&Edges<'_>, &Lines),
        pool: &Pool<'_>,
        blur: &Blur,
        (pass, covered): (Pass, bool),
    ) -> Option<Self> {
        let mut gauge = Gauge::new(self, edges, blur, (pass, covered))?;
        for (k, edge) in edges.edges.iter().enumerate() {
            let Some(views) = edges.views(k, lines) else { continue };
            let stride = if pass == Pass::All { 1 } else { edge.stride() };
            for crossing in pool.iter(edge.crossings).step_by(stride) {
                let Some(local) = &views.local(crossing) else { continue };
                gauge.add(local, crossing, &local.blurred(&gauge.sharpness), &gauge.light.at(local));
            }
        }
        gauge.levels()
    }
}

/// A pass over the crossings.
pub(super) struct Gauge<'l> {
    before: &'l Levels,
    pub light: Light,
    pub sharpness: Sharpness,
    /// Unit of places, px, and its reciprocal.
    unit: f32,
    by_unit: i32,
    /// Largest residual.
    limit: i32,
    covered: bool,
    nearest: bool,
    /// Where the grey scale ends.
    ends: (i32, i32),
    normals: Normals,
}

impl<'l> Gauge<'l> {
    /// Of all crossings, of a target that nothing covers.
    pub fn of_all(before: &'l Levels, edges: &Edges<'_>, blur: &Blur) -> Option<Self> {
        Self::new(before, edges, blur, (Pass::All, false))
    }

    fn new(
        before: &'l Levels,
        edges: &Edges<'_>,
        &Blur { sigma, noise }: &Blur,
        (pass, covered): (Pass, bool),
    ) -> Option<Self> {
        let unit = edges.edges.first()?.axes.0 + BEYOND;
        let grey = |level: f32| fixed(level.min(1e3), GREY);
        let limit = match pass {
            Pass::First => f32::INFINITY,
            Pass::Look => OUTLIER * before.contrast(),
            Pass::All if covered => {
                COVERED_OUTLIER * before.contrast() + COVERED_OUTLIER_SIGMAS * before.spread
            }
            Pass::All => (LAST_OUTLIER + LAST_OUTLIER_SIGMAS * noise).min(OUTLIER) * before.contrast(),
        };
        Some(Self {
            before,
            light: Light::new(before),
            sharpness: Sharpness::new(sigma),
            unit,
            by_unit: fixed(1.0 / unit, 1 << 27),
            limit: grey(limit),
            covered,
            // Far samples reach to what covers a part of the target; wide edges leave no others.
            nearest: covered && sigma < SHARP,
            ends: (grey(before.noise + 0.5), grey(254.5 - before.noise)),
            normals: Normals::default(),
        })
    }

    /// Adds the samples of a crossing; `edge` is its profile there.
    #[inline]
    pub fn add(&mut self, local: &Local, crossing: &Crossing, edge: &Blurred, there: &LightThere) {
        let [dark, .., light] = local.near(crossing);
        let [before, after] = crossing.far();
        let (of_dark, of_light) = if local.sign > 0 { (before, after) } else { (after, before) };
        let across = self.place(local.middle.1);
        self.add_side((local, edge, there), (-1, of_dark, dark), across);
        self.add_side((local, edge, there), (1, of_light, light), across);
    }

    /// A place, px / 2, in units of the target.
    #[inline]
    fn place(&self, at: i32) -> i32 {
        const LESS: u32 = ONE.ilog2() - TERM + 14;
        (at * self.by_unit + (1 << (LESS - 1))) >> LESS
    }

    /// Adds what is on the dark side (-1) or on the light side (1).
    #[inline(always)]
    fn add_side(
        &mut self,
        (local, edge, there): (&Local, &Blurred, &LightThere),
        (side, far, near): (i32, Stretch, i32),
        across: i32,
    ) {
        let sample = Sample::new((local, edge), (side, far, near), self.nearest);
        let normals = &mut self.normals;
        normals.samples += 1;
        normals.clipped += u32::from(sample.far_level <= self.ends.0 || sample.far_level >= self.ends.1);
        let place = side * sample.place;
        let residual = sample.level - scale(self.light.mixed(sample.lightness), there.beside(place));
        if self.covered {
            normals.spread.add_fixed(residual, GREY.ilog2());
        }
        if residual.abs() < self.limit {
            let along = self.place(local.middle.0 + local.sign * place);
            let place = if local.axis == Axis::Row { (along, across) } else { (across, along) };
            let [of_dark, of_light] = &mut self.normals.sides;
            if side < 0 { of_dark } else { of_light }.add(&sample, place, residual);
        }
    }

    pub fn levels(&self) -> Option<Levels> {
        self.normals.solve(self.before, self.unit)
    }
}

/// How a pass over the crossings is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pass {
    /// Few of the crossings, all of their samples.
    First,
    /// Few of the crossings, without outliers.
    Look,
    /// All of the crossings, without outliers.
    All,
}

/// A mean grey level with the lightness that it should have.
struct Sample {
    /// On the axis of the crossing, away from the edge, px / 2.
    place: i32,
    level: i32,
    lightness: i32,
    /// 1 where the area is flat, falling towards the middle of an edge.
    flatness: i32,
    /// Binary logarithm of the number of pixels.
    log: u32,
    /// Level of the far stretch on this side.
    far_level: i32,
}

impl Sample {
    /// Of the dark side (-1) or of the light side (1): the far stretch if it is clear of all edges, or else the near sample; always
    /// that where it is `nearest` that counts.
    #[inline(always)]
    fn new((local, edge): (&Local, &Blurred), (side, far, near): (i32, Stretch, i32), nearest: bool) -> Self {
        let (log, sum) = far.sum();
        let far_level = (i32::from(sum) * GREY) >> log;
        if !nearest {
            let lightness =
                clear(local, edge, (side, log)).unwrap_or_else(|| lightness(local, edge, (side, FAR), log));
            let flatness = flatness(lightness);
            if flatness > CLEAR {
                let place = 6 + (1 << log);
                return Self { place, level: far_level, lightness, flatness, log, far_level };
            }
        }
        let lightness = lightness(local, edge, (side, NEAR[3]), 0);
        let flatness = flatness(lightness);
        Self { place: 3, level: near * GREY, lightness, flatness, log: 0, far_level }
    }
}

/// Lightness of a far stretch of more than one pixel that no edge reaches.
#[inline(always)]
fn clear(local: &Local, edge: &Blurred, (side, log): (i32, u32)) -> Option<i32> {
    let border = side * edge.deviation(side * FAR - local.at) - (edge.k >> 2);
    (log > 0 && border >= UNREACHED && local.is_alone()).then_some(if side > 0 { ONE } else { 0 })
}

/// Lightness of a stretch of pixels, of which the nearest is at `first` px on the light side (1) or the dark side (-1).
#[inline(never)]
fn lightness(local: &Local, edge: &Blurred, (side, first): (i32, i32), log: u32) -> i32 {
    let k = edge.k >> 1;
    let h = side * first - local.at;
    let tail = mean_tail(-side * edge.deviation(h), k, log);
    let mut lightness = if side > 0 { ONE - tail } else { tail };
    // The next edge is nearest to the last pixel of a stretch.
    let last = h + side * ((PX << log) - PX);
    if let Some(gap) = local.light_gap {
        lightness -= mean_tail(edge.straight(last - gap), k, log);
    }
    if let Some(gap) = local.dark_gap {
        lightness += mean_tail(-edge.straight(last + gap), k, log);
    }
    lightness
}

fn flatness(lightness: i32) -> i32 {
    let flat = ONE - 2 * lightness.min(ONE - lightness).max(0);
    let square = scale(flat, flat);
    scale(square, square)
}
