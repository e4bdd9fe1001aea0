//! The levels of a target: one dark and one bright level under one plane of illumination.

use super::{Edges, Local, normal};
use crate::fit::{Factor, Matrix};
use crate::scan::Pool;

/// A residual above this share of the contrast is no flat area: dirt, a mark, another object.
const OUTLIER: f32 = 0.25;
/// Lightness that the levels of an edge are expected to have at the far samples before the near ones are asked.
const CLEAR: f32 = 0.5;

/// Dark and bright level at the origin; the level at (x, y) px from it is that times 1 + gx x + gy y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    pub dark: f32,
    pub bright: f32,
    pub gx: f32,
    pub gy: f32,
    /// More than one far sample in ten at the end of the grey scale.
    pub clipped: bool,
}

impl Levels {
    /// A first look at the levels, from some of the crossings and for a blur of `sigma` px.
    pub fn first(edges: &Edges<'_>, pool: &Pool<'_>, sigma: f32) -> Option<Self> {
        // With both levels 1 the first plane is additive and only the levels are of use; the second is relative to them.
        let unknown = Self { dark: 1.0, bright: 1.0, gx: 0.0, gy: 0.0, clipped: false };
        let levels =
            unknown.refine(edges, pool, sigma, Pass::First)?.refine(edges, pool, sigma, Pass::First)?;
        levels.refine(edges, pool, sigma, Pass::Robust { every: false })
    }

    /// The levels by least squares over the samples of every crossing, each with the lightness that the ellipses and a
    /// blur of `sigma` px give it. Shading is multiplicative, so the plane's slope is proportional to the level. What is
    /// far from `self` is left out.
    pub fn refined(&self, edges: &Edges<'_>, pool: &Pool<'_>, sigma: f32) -> Option<Self> {
        self.refine(edges, pool, sigma, Pass::Robust { every: true })
    }

    /// Bright minus dark at the origin, grey levels.
    pub fn contrast(&self) -> f32 {
        self.bright - self.dark
    }

    /// The levels along an axis through `point`, px from the origin, in the direction of the unit vector `axis`.
    pub fn scale(&self, (x, y): (f32, f32), (ax, ay): (f32, f32)) -> Scale {
        let light = 1.0 + self.gx * x + self.gy * y;
        let slope = (self.gx * ax + self.gy * ay) / light;
        let gain = 1.0 / (light * self.contrast());
        Scale { gain, slope: gain * slope, dark: self.dark / self.contrast() }
    }

    fn refine(&self, edges: &Edges<'_>, pool: &Pool<'_>, sigma: f32, pass: Pass) -> Option<Self> {
        let mut normals = Normals::default();
        // Coordinates in units of the target's size keep the system well scaled.
        let size = edges.edges.first().map(|outer| outer.shape.semi_axes().0)?;
        for (k, edge) in edges.edges.iter().enumerate() {
            let stride = if pass == (Pass::Robust { every: true }) { 1 } else { edge.stride() };
            for crossing in pool.iter(edge.crossings).step_by(stride) {
                let Some(local) = edges.local(k, crossing) else { continue };
                let [near_dark, _, _, near_light] = local.near(crossing);
                let [far_dark, far_light] = local.far(crossing);
                for (far, near) in [(far_dark, near_dark), (far_light, near_light)] {
                    let sample = Sample::new(&local, far, sigma);
                    normals.count_clipped(far.1);
                    let sample =
                        if sample.weight > CLEAR { sample } else { Sample::new(&local, near, sigma) };
                    let expected = self.level(&sample);
                    if pass == Pass::First || (sample.level - expected).abs() < OUTLIER * self.contrast() {
                        normals.add(&sample, self.mixed(sample.lightness), size);
                    }
                }
            }
        }
        normals.solve(size)
    }

    fn mixed(&self, lightness: f32) -> f32 {
        self.dark + (self.bright - self.dark) * lightness
    }

    fn level(&self, sample: &Sample) -> f32 {
        self.mixed(sample.lightness) * (1.0 + self.gx * sample.x + self.gy * sample.y)
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
    /// Few or all of the crossings, without outliers.
    Robust { every: bool },
}

/// A grey level with the lightness that it should have.
struct Sample {
    x: f32,
    y: f32,
    level: f32,
    lightness: f32,
    /// 1 where the area is flat, falling towards the middle of an edge.
    weight: f32,
}

impl Sample {
    fn new(local: &Local, (place, level): (f32, f32), sigma: f32) -> Self {
        let k = local.along / sigma;
        let lightness = normal((place - local.offset) * k).0 + local.neighbours(place, k);
        let flat = 1.0 - 2.0 * lightness.min(1.0 - lightness).max(0.0);
        let (x, y) = local.point(place);
        Self { x, y, level, lightness, weight: flat * flat * flat * flat }
    }
}

/// Normal equations for dark, bright and the two slopes.
#[derive(Default)]
struct Normals {
    m: Matrix<4>,
    right: [f32; 4],
    samples: u16,
    clipped: u16,
}

impl Normals {
    fn count_clipped(&mut self, level: f32) {
        self.samples = self.samples.saturating_add(1);
        if level <= 0.0 || level >= 255.0 {
            self.clipped = self.clipped.saturating_add(1);
        }
    }

    fn add(&mut self, sample: &Sample, mixed: f32, size: f32) {
        let terms =
            [1.0 - sample.lightness, sample.lightness, mixed * sample.x / size, mixed * sample.y / size];
        for i in 0..4 {
            let weighted = sample.weight * terms[i];
            for j in 0..=i {
                self.m[i][j] += weighted * terms[j];
            }
            self.right[i] += weighted * sample.level;
        }
    }

    fn solve(&self, size: f32) -> Option<Levels> {
        let [dark, bright, gx, gy] = Factor::new(&self.m)?.solve(self.right);
        let clipped = self.clipped > self.samples / 10;
        Some(Levels { dark, bright, gx: gx / size, gy: gy / size, clipped })
    }
}
