//! The levels of a target: one dark and one bright level under one plane of illumination.

use super::{Blur, Edges, Local, Outer, mean_tail, normal};
use crate::fit::{Factor, Matrix, Shape, Spread};
use crate::math;
use crate::scan::{Crossing, Pool};

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
const CLEAR: f32 = 0.5;

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
    pub fn first(edges: &Edges<'_>, pool: &Pool<'_>, sigma: f32, covered: bool) -> Option<Self> {
        // With both levels 1 the first plane is additive: it is that of the mean level.
        let unknown = Self {
            dark: 1.0,
            bright: 1.0,
            gx: 0.0,
            gy: 0.0,
            slopes: (0.0, 0.0, 0.0),
            noise: 0.0,
            spread: 0.0,
            pixels: 0.0,
            clipped: false,
        };
        let blur = Blur { sigma, noise: 0.0 };
        let first = unknown.refine((edges, pool), &blur, Pass::First, covered)?;
        let mean = 0.5 * (first.dark + first.bright);
        let levels = Self { gx: first.gx / mean, gy: first.gy / mean, ..first };
        levels.refine((edges, pool), &blur, Pass::Look, covered)
    }

    /// The levels by least squares over the samples of every crossing, each with the lightness that the ellipses and the
    /// blur give it. Shading is multiplicative, so the plane's slope is proportional to the level. What is
    /// far from `self` is left out; where something covers a part of the target, what is far from most.
    pub fn refined(&self, edges: &Edges<'_>, pool: &Pool<'_>, blur: &Blur, covered: bool) -> Option<Self> {
        self.refine((edges, pool), blur, Pass::All, covered)
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
        let slope = self.contrast() * normal(0.0).1 / sigma;
        let shift = 0.5 * (self.dark + self.bright) / slope;
        let (xx, xy, yy) = self.slopes;
        // Half the trace of the slopes' covariance times the inverse of the ellipse's matrix.
        let spread = (outer.ayy * xx - 2.0 * outer.axy * xy + outer.axx * yy) / (2.0 * outer.det());
        (shift * shift * spread).max(0.0)
    }

    /// The levels along an axis through `point`, px from the origin, in the direction of the unit vector `axis`.
    pub fn scale(&self, (x, y): (f32, f32), (ax, ay): (f32, f32)) -> Scale {
        let light = 1.0 + self.gx * x + self.gy * y;
        let slope = (self.gx * ax + self.gy * ay) / light;
        let gain = 1.0 / (light * self.contrast());
        Scale { gain, slope: gain * slope, dark: self.dark / self.contrast() }
    }

    fn refine(
        &self,
        (edges, pool): (&Edges<'_>, &Pool<'_>),
        blur: &Blur,
        pass: Pass,
        covered: bool,
    ) -> Option<Self> {
        let Blur { sigma, noise } = *blur;
        let mut normals = Normals::default();
        // Coordinates in units of the target's size keep the system well scaled.
        let scale = edges.edges.first().map(|outer| 1.0 / outer.shape.semi_axes().0)?;
        let limit = match pass {
            Pass::First => f32::INFINITY,
            Pass::Look => OUTLIER * self.contrast(),
            Pass::All if covered => COVERED_OUTLIER * self.contrast() + COVERED_OUTLIER_SIGMAS * self.spread,
            Pass::All => (LAST_OUTLIER + LAST_OUTLIER_SIGMAS * noise).min(OUTLIER) * self.contrast(),
        };
        // Far samples reach to what covers a part of the target; wide edges leave no others.
        let nearest = covered && sigma < SHARP;
        for (k, edge) in edges.edges.iter().enumerate() {
            let Some(views) = edges.views(k) else { continue };
            let stride = if pass == Pass::All { 1 } else { edge.stride() };
            for crossing in pool.iter(edge.crossings).step_by(stride) {
                let Some(local) = views.local(crossing) else { continue };
                let samples = Samples::new(&local, crossing, sigma);
                for sample in [samples.better_of(0, 1, nearest), samples.better_of(3, 2, nearest)] {
                    normals.count_clipped(sample.far_level, self.noise);
                    let (x, y) = local.point(sample.place);
                    let mixed = self.mixed(sample.lightness);
                    let expected = mixed * (1.0 + self.gx * x + self.gy * y);
                    let residual = sample.level - expected;
                    normals.spread.add(residual * residual);
                    if residual.abs() < limit {
                        normals.add(&sample, (mixed * x * scale, mixed * y * scale), residual);
                    }
                }
            }
        }
        normals.solve(scale)
    }

    fn mixed(&self, lightness: f32) -> f32 {
        self.dark + (self.bright - self.dark) * lightness
    }
}

/// Grey levels to lightness, 0 dark to 1 bright, along an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    gain: f32,
    slope: f32,
    dark: f32,
}

impl Scale {
    /// Lightness of `level` at `place` px from the point on the axis. The light's reciprocal is taken as linear there: for
    /// 1 % change of light over a pixel that is right to 1e-4 within the samples.
    pub fn lightness(&self, level: f32, place: f32) -> f32 {
        level * (self.gain - self.slope * place) - self.dark
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
    place: f32,
    level: f32,
    lightness: f32,
    /// 1 where the area is flat, falling towards the middle of an edge.
    flatness: f32,
    pixels: f32,
    /// Level of the far stretch on this side.
    far_level: f32,
}

/// The far stretch and the near sample on the dark side, then the near sample and the far stretch on the light side.
struct Samples {
    places: [f32; 4],
    levels: [f32; 4],
    lightness: [f32; 4],
    flatness: [f32; 4],
    pixels: [f32; 4],
}

impl Samples {
    fn new(local: &Local, crossing: &Crossing, sigma: f32) -> Self {
        let Outer { first, levels, pixels } = local.outer(crossing);
        let edge = local.blurred(sigma);
        let [d, _, _, l] = pixels;
        let mean = |z: [f32; 4]| -> [f32; 4] { core::array::from_fn(|i| mean_tail(z[i], edge.k, pixels[i])) };
        let [h0, h1, h2, h3] = first.map(|place| place - local.offset);
        let [z0, z1, z2, z3] = [h0, h1, h2, h3].map(|h| edge.deviation(h));
        let [t0, t1, t2, t3] = mean([z0, z1, -z2, -z3]);
        let mut lightness = [t0, t1, 1.0 - t2, 1.0 - t3];
        // The next edge is nearest to the last pixel of a stretch.
        let last = [h0 + 1.0 - d, h1, h2, h3 + l - 1.0];
        if local.light_gap < f32::INFINITY {
            let tails = mean(last.map(|h| (h - local.light_gap) * edge.k));
            lightness = core::array::from_fn(|i| lightness[i] - tails[i]);
        }
        if local.dark_gap < f32::INFINITY {
            let tails = mean(last.map(|h| -(h + local.dark_gap) * edge.k));
            lightness = core::array::from_fn(|i| lightness[i] + tails[i]);
        }
        let [p0, p1, p2, p3] = first;
        let places = [p0 - 0.5 * (d - 1.0), p1, p2, p3 + 0.5 * (l - 1.0)];
        let flatness = lightness.map(|lightness| {
            let flat = 1.0 - 2.0 * lightness.min(1.0 - lightness).max(0.0);
            flat * flat * flat * flat
        });
        Self { places, levels, lightness, flatness, pixels }
    }

    /// The far stretch of a side if it is clear of all edges, or else the near sample; always that where it is `nearest`
    /// that counts.
    fn better_of(&self, far: usize, near: usize, nearest: bool) -> Sample {
        let clear = self.flatness[far] > CLEAR && !nearest;
        let pick = |values: &[f32; 4]| if clear { values[far] } else { values[near] };
        Sample {
            place: pick(&self.places),
            level: pick(&self.levels),
            lightness: pick(&self.lightness),
            flatness: pick(&self.flatness),
            pixels: pick(&self.pixels),
            far_level: self.levels[far],
        }
    }
}

/// Normal equations for dark, bright and the two slopes.
#[derive(Default)]
struct Normals {
    m: Matrix<4>,
    right: [f32; 4],
    /// Weighted sum of the squared residuals of the pass before, and of the weights, for one pixel.
    squares: f32,
    weights: f32,
    spread: Spread,
    samples: u32,
    clipped: u32,
}

impl Normals {
    /// The mean of pixels at the end of the scale is off it by some of their `noise`.
    fn count_clipped(&mut self, level: f32, noise: f32) {
        let off = noise + 0.5;
        self.samples += 1;
        self.clipped += u32::from(level <= off || level >= 255.0 - off);
    }

    /// Adds a sample; `gx` and `gy` are its derivatives by the two slopes, `residual` what the levels before leave.
    fn add(&mut self, sample: &Sample, (gx, gy): (f32, f32), residual: f32) {
        let weight = sample.flatness * sample.pixels;
        let terms = [1.0 - sample.lightness, sample.lightness, gx, gy];
        // The whole matrix, because rows of four are done at once where the processor can.
        let weighted = terms.map(|term| weight * term);
        for i in 0..4 {
            for j in 0..4 {
                self.m[i][j] += weighted[i] * terms[j];
            }
        }
        for i in 0..4 {
            self.right[i] += weighted[i] * sample.level;
        }
        self.squares += weight * residual * residual;
        self.weights += sample.flatness;
    }

    fn solve(&self, scale: f32) -> Option<Levels> {
        let factor = Factor::new(&self.m)?;
        let [dark, bright, gx, gy] = factor.solve(self.right);
        let variance = self.squares / self.weights;
        let of_slopes = variance * scale * scale;
        let [_, _, xx, xy] = factor.solve([0.0, 0.0, of_slopes, 0.0]);
        let [_, _, _, yy] = factor.solve([0.0, 0.0, 0.0, of_slopes]);
        let clipped = self.clipped > self.samples / 10;
        // Where the scale ends the light may change unseen.
        let unseen = if clipped { CLIPPED_SLOPE * CLIPPED_SLOPE * scale * scale } else { 0.0 };
        let (xx, yy) = (xx + unseen, yy + unseen);
        Some(Levels {
            dark,
            bright,
            gx: gx * scale,
            gy: gy * scale,
            slopes: (xx, xy, yy),
            noise: math::sqrt(variance),
            spread: self.spread.sigma(),
            // The first two terms of each sample sum to 1.
            pixels: self.m[0][0] + 2.0 * self.m[0][1] + self.m[1][1],
            clipped,
        })
    }
}
