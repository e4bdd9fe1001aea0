//! The levels of a target: one dark and one bright level under one plane of illumination.

use super::light::Light;
use super::local::{FAR, Local, NEAR};
use super::place::{Blur, Sharpness};
use super::profile::{Blurred, PEAK, mean_tail};
use super::{Edges, Lines};
use crate::fit::{Factor, Shape, Spread};
use crate::fixed::{GREY, ONE, PX, fixed, scale};
use crate::math;
use crate::scan::{Axis, Crossing, Pool};

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
    slopes: (f32, f32, f32),
    /// Standard deviation of the samples about the levels of the pass before, grey levels.
    pub noise: f32,
    /// The same without what most of them do not show.
    spread: f32,
    /// Pixels in the samples, each as far as it counted.
    pixels: f32,
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
        let Blur { sigma, noise } = *blur;
        let mut normals = Normals::default();
        let unit = edges.edges.first()?.shape.semi_axes().0 + BEYOND;
        let grey = |level: f32| fixed(level.min(1e3), GREY);
        let limit = grey(match pass {
            Pass::First => f32::INFINITY,
            Pass::Look => OUTLIER * self.contrast(),
            Pass::All if covered => COVERED_OUTLIER * self.contrast() + COVERED_OUTLIER_SIGMAS * self.spread,
            Pass::All => (LAST_OUTLIER + LAST_OUTLIER_SIGMAS * noise).min(OUTLIER) * self.contrast(),
        });
        // Far samples reach to what covers a part of the target; wide edges leave no others.
        let nearest = covered && sigma < SHARP;
        let (light, sharpness) = (Light::new(self), Sharpness::new(sigma));
        let by_unit = fixed(1.0 / unit, 1 << 27);
        let ends = (grey(self.noise + 0.5), grey(254.5 - self.noise));
        for (k, edge) in edges.edges.iter().enumerate() {
            let Some(views) = edges.views(k, lines) else { continue };
            let stride = if pass == Pass::All { 1 } else { edge.stride() };
            for crossing in pool.iter(edge.crossings).step_by(stride) {
                let Some(local) = views.local(crossing) else { continue };
                let at = light.at(&local);
                let samples = Sample::both(&local, crossing, &local.blurred(&sharpness), nearest);
                for ((sample, side), sums) in samples.iter().zip([-1, 1]).zip(&mut normals.sides) {
                    normals.samples += 1;
                    normals.clipped += u32::from(sample.far_level <= ends.0 || sample.far_level >= ends.1);
                    let place = side * sample.place;
                    let residual = sample.level - scale(light.mixed(sample.lightness), at.beside(place));
                    normals.spread.add_fixed(residual, GREY.ilog2());
                    if residual.abs() < limit {
                        let along = local.middle.0 + local.sign * place;
                        let [along, across] =
                            [along, local.middle.1].map(|at| (at * by_unit) >> (ONE.ilog2() - TERM + 14));
                        let place = if local.axis == Axis::Row { (along, across) } else { (across, along) };
                        sums.add(sample, place, residual);
                    }
                }
            }
        }
        normals.solve(self, unit)
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
    /// Of the dark side and of the light side: the far stretch if it is clear of all edges, or else the near sample; always that
    /// where it is `nearest` that counts.
    #[inline]
    fn both(local: &Local, crossing: &Crossing, edge: &Blurred, nearest: bool) -> [Self; 2] {
        let [dark, .., light] = local.near(crossing);
        let [before, after] = crossing.far().map(|stretch| {
            let (log, sum) = stretch.sum();
            (log, (i32::from(sum) * GREY) >> log)
        });
        let far = if local.sign > 0 { [before, after] } else { [after, before] };
        let [of_dark, of_light] = [(-1, dark), (1, light)];
        [(of_dark, far[0]), (of_light, far[1])].map(|((side, near), (log, far_level))| {
            if !nearest {
                let lightness = lightness(local, edge, (side, FAR), log);
                let flatness = flatness(lightness);
                if flatness > CLEAR {
                    let place = 6 + (1 << log);
                    return Self { place, level: far_level, lightness, flatness, log, far_level };
                }
            }
            let lightness = lightness(local, edge, (side, NEAR[3]), 0);
            let flatness = flatness(lightness);
            Self { place: 3, level: near * GREY, lightness, flatness, log: 0, far_level }
        })
    }
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

/// Bits of the number of pixels as a weight, and of places in units of the target.
const WEIGHT: u32 = 4;
const TERM: u32 = 9;

/// Weighted sums over the samples on one side of the edges.
#[derive(Clone, Copy, Default)]
struct Side {
    weight: u32,
    lightness: i64,
    /// Of places, and of their products.
    x: i32,
    y: i32,
    xx: i64,
    xy: i64,
    yy: i64,
    /// Of what the levels before leave, by itself and with the places; and of its squares.
    residual: i64,
    residual_x: i64,
    residual_y: i64,
    squares: u64,
    /// Sum of the weights for one pixel.
    weights: u32,
}

impl Side {
    #[inline]
    fn add(&mut self, sample: &Sample, (x, y): (i32, i32), residual: i32) {
        let weight = (sample.flatness << sample.log) >> (ONE.ilog2() - WEIGHT);
        self.weight += weight.unsigned_abs();
        self.lightness += i64::from(weight * sample.lightness);
        let (wx, wy) = (weight * x, weight * y);
        self.x += wx;
        self.y += wy;
        self.xx += i64::from(wx * x);
        self.xy += i64::from(wx * y);
        self.yy += i64::from(wy * y);
        let weighted = weight * residual;
        self.residual += i64::from(weighted);
        let weighted = (weighted + (1 << (WEIGHT - 1))) >> WEIGHT;
        self.residual_x += i64::from(weighted * x);
        self.residual_y += i64::from(weighted * y);
        self.squares += u64::from(weighted.unsigned_abs()) * u64::from(residual.unsigned_abs());
        self.weights += sample.flatness.unsigned_abs() >> (ONE.ilog2() - WEIGHT);
    }
}

/// What the samples tell of the changes of dark, bright and the two slopes.
#[derive(Default)]
struct Normals {
    /// Dark and bright.
    sides: [Side; 2],
    spread: Spread,
    samples: u32,
    clipped: u32,
}

impl Normals {
    /// The levels after `before`; places are in units of `unit` px. All samples of a side have its mean lightness here: their own
    /// hardly differs, and what they leave is that from their own.
    #[inline(never)]
    fn solve(&self, before: &Levels, unit: f32) -> Option<Levels> {
        const PIXEL: f32 = 1.0 / (1 << WEIGHT) as f32;
        const PLACE: f32 = 1.0 / (1 << TERM) as f32;
        const LEVEL: f32 = 1.0 / GREY as f32;
        let (mut m, mut right) = ([[0.0; 4]; 4], [0.0; 4]);
        let (mut squares, mut weights) = (0.0, 0.0);
        for side in &self.sides {
            let lightness = side.lightness as f32 / (ONE as f32 * side.weight.max(1) as f32);
            let level = (before.dark + before.contrast() * lightness) / SLOPE;
            let place = level * PIXEL * PLACE;
            let product = level * level * PIXEL * PLACE * PLACE;
            let [weight, x, y] = [PIXEL * side.weight as f32, place * side.x as f32, place * side.y as f32];
            let own = [1.0 - lightness, lightness];
            for i in 0..2 {
                for j in 0..=i {
                    m[i][j] += weight * own[i] * own[j];
                }
                m[2][i] += own[i] * x;
                m[3][i] += own[i] * y;
                right[i] += own[i] * PIXEL * LEVEL * side.residual as f32;
            }
            m[2][2] += product * side.xx as f32;
            m[3][2] += product * side.xy as f32;
            m[3][3] += product * side.yy as f32;
            right[2] += level * PLACE * LEVEL * side.residual_x as f32;
            right[3] += level * PLACE * LEVEL * side.residual_y as f32;
            squares += LEVEL * LEVEL * side.squares as f32;
            weights += PIXEL * side.weights as f32;
        }
        let factor = Factor::new(&m)?;
        let [dark, bright, gx, gy] = factor.solve(right);
        let scale = 1.0 / (SLOPE * unit);
        let variance = squares / weights;
        let of_slopes = variance * scale * scale;
        let [_, _, xx, xy] = factor.solve([0.0, 0.0, of_slopes, 0.0]);
        let [_, _, _, yy] = factor.solve([0.0, 0.0, 0.0, of_slopes]);
        let clipped = self.clipped > self.samples / 10;
        // Where the scale ends the light may change unseen.
        let most = CLIPPED_SLOPE / (unit - BEYOND);
        let unseen = if clipped { most * most } else { 0.0 };
        let (xx, yy) = (xx + unseen, yy + unseen);
        Some(Levels {
            dark: before.dark + dark,
            bright: before.bright + bright,
            gx: before.gx + gx * scale,
            gy: before.gy + gy * scale,
            slopes: (xx, xy, yy),
            noise: math::sqrt(variance),
            spread: self.spread.sigma(),
            pixels: PIXEL * self.sides.iter().fold(0, |sum, side| sum + side.weight) as f32,
            clipped,
        })
    }
}
