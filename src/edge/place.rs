//! Where the edge passes on the axis of a crossing, and how blurred the edges are.

use super::light::{Light, LightThere};
use super::local::{Local, NEAR};
use super::profile::{Blurred, normal_fixed};
use super::{Edges, Levels, Lines};
use crate::fit::Spread;
use crate::fixed::{ONE, PX, fixed, scale};
use crate::scan::{Crossing, EdgePoint, Pool};

/// Most Gauss-Newton steps for an edge point.
const STEPS: usize = 3;
/// A step below this, px, is the last.
const SETTLED: i32 = PX / 10;
/// Most passes over the samples for the blur.
const BLUR_PASSES: usize = 5;
/// Relative change of the blur that ends them.
const BLUR_SETTLED: f32 = 0.01;
/// First guess of the blur, px: a sharp lens and the pixel's own box.
const BLUR_START: f32 = 0.8;
/// Misfit of a profile above which it tells nothing of the blur, as a share of the contrast, with room for this many standard
/// deviations of the samples in the pass before.
const BLUR_OUTLIER: f32 = 0.04;
const BLUR_OUTLIER_SIGMAS: f32 = 4.0;
/// The blur is kept in this range, px.
const BLUR_RANGE: (f32, f32) = (0.29, 6.0);
/// Largest change of the blur in a pass, relative, and of an edge point in a step, px.
const MAX_CHANGE: f32 = 0.5;
const MAX_STEP: i32 = PX / 2;
/// Sum of the squared densities, each with the unit of shares, below which four samples hold no edge: 1e-3.
const MIN_SQUARE: i32 = 268_435;

/// What the edges' profiles tell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blur {
    /// Standard deviation of the profile, px.
    pub sigma: f32,
    /// Standard deviation of a sample about it, as a share of the contrast.
    pub noise: f32,
}

/// A blur, px, and its reciprocal, with half the unit of shares.
pub(super) struct Sharpness {
    pub blur: i32,
    pub sharpness: i32,
}

impl Sharpness {
    pub fn new(sigma: f32) -> Self {
        Self { blur: fixed(sigma, PX), sharpness: fixed(1.0 / sigma, ONE / 2) }
    }
}

/// The blur with which the profile fits best at a sample of crossings of every edge, with each edge in its best place.
#[inline(never)]
pub(crate) fn measure_blur((edges, lines): (&Edges<'_>, &Lines), pool: &Pool<'_>, levels: &Levels) -> Blur {
    let light = Light::new(levels);
    let mut sigma = BLUR_START;
    let mut noise = f32::INFINITY;
    for pass in 0..BLUR_PASSES {
        let (mut slope, mut square) = (0, 0);
        let limit = fixed(BLUR_OUTLIER + BLUR_OUTLIER_SIGMAS * noise, ONE);
        let mut spread = Spread::default();
        let sharpness = Sharpness::new(sigma);
        for (k, edge) in edges.edges.iter().enumerate() {
            let Some(views) = edges.views(k, lines) else { continue };
            for crossing in pool.iter(edge.crossings).step_by(edge.stride()) {
                let Some(local) = &views.local(crossing) else { continue };
                let profile = Profile::new(local, crossing, (&light, &light.at(local)), &sharpness);
                let Some(placed) = profile.place() else { continue };
                // The blur of the first pass is none of this target's.
                if pass > 0 {
                    placed.add_noise(&mut spread);
                }
                if placed.misfit() <= limit {
                    let (s, q) = profile.blur_slope(placed.place);
                    slope += i64::from(s);
                    square += i64::from(q);
                }
            }
        }
        noise = spread.sigma();
        let change = if square > 0 { slope as f32 / square as f32 } else { 0.0 };
        let change = change.clamp(-MAX_CHANGE, MAX_CHANGE);
        sigma = (sigma * (1.0 + change)).clamp(BLUR_RANGE.0, BLUR_RANGE.1);
        if pass > 0 && change.abs() < BLUR_SETTLED {
            break;
        }
    }
    Blur { sigma, noise }
}

/// Places an edge point at every crossing of edge `k`. Gives the standard deviation of the samples about it, as a share of the
/// contrast.
#[inline(never)]
pub(crate) fn place(
    (edges, lines): (&Edges<'_>, &Lines),
    k: usize,
    pool: &mut Pool<'_>,
    (levels, sigma): (&Levels, f32),
) -> f32 {
    let mut noise = Spread::default();
    let (light, sharpness) = (Light::new(levels), Sharpness::new(sigma));
    let (Some(edge), Some(views)) = (edges.edges.get(k), edges.views(k, lines)) else { return 0.0 };
    pool.for_each_mut(edge.crossings, |crossing| {
        let placed = views.local(crossing).and_then(|local| {
            let placed = Profile::new(&local, crossing, (&light, &light.at(&local)), &sharpness).place()?;
            placed.add_noise(&mut noise);
            let share = |residual: i32, bits: u32| (residual + (1 << (bits - 1))) >> bits;
            Some(EdgePoint {
                offset: (share(local.sign * placed.place, 4) - 128) as i16,
                excess: placed.excess().clamp(-128, 127) as i8,
                misfit: share(placed.misfit(), 6).clamp(0, 255) as u8,
            })
        });
        crossing.place(placed);
    });
    noise.sigma()
}

/// An edge in four samples.
pub(super) struct Placed {
    /// Its place on the axis, towards light, px.
    pub place: i32,
    /// Lightness of the samples beyond what the edge gives them.
    pub residuals: [i32; 4],
    /// Sums of the densities there, and of their squares.
    pub densities: (i32, i32),
}

impl Placed {
    /// What the samples tell of the noise: in differences across the edge the light beside it and its place cancel.
    pub fn differences(&self) -> [i32; 2] {
        let [a, b, c, d] = self.residuals;
        [a - d, b - c]
    }

    fn add_noise(&self, spread: &mut Spread) {
        /// Of the reciprocal root of 2, and bits of a residual less one.
        const ROOT: i32 = 11_585;
        for difference in self.differences() {
            spread.add_fixed(scale(difference, ROOT), ONE.ilog2());
        }
    }

    /// Lightness beside the edge, 1/256 of the contrast.
    pub fn excess(&self) -> i32 {
        let [first, .., last] = self.residuals;
        (first + last + (1 << 6)) >> 7
    }

    /// Largest residual.
    pub fn misfit(&self) -> i32 {
        self.residuals.iter().fold(0, |most, residual| most.max(residual.abs()))
    }
}

/// Four samples across an edge, as lightness less what the neighbouring edges add.
pub(super) struct Profile {
    lightness: [i32; 4],
    pub edge: Blurred,
    /// Blur along the axis, px.
    width: i32,
}

impl Profile {
    #[inline]
    pub fn new(
        local: &Local,
        crossing: &Crossing,
        (light, there): (&Light, &LightThere),
        sharpness: &Sharpness,
    ) -> Self {
        let edge = local.blurred(sharpness);
        let contrast = scale(light.contrast, there.middle).max(1);
        let (by_contrast, dark) = ((1 << 28) / contrast, scale(light.dark, there.middle));
        // Relative change of the light over a pixel, with 4 times the unit of shares; the light's reciprocal is that of its contrast,
        // because a division takes small processors long.
        let by_light = ((by_contrast >> 4) * light.contrast.max(1)) >> 10;
        let slope = ((there.slope >> 2) * by_light) >> 16;
        let near = local.near(crossing);
        let mut lightness = core::array::from_fn(|i| {
            let level = near[i] << 6;
            let level = level - ((level * ((slope * (2 * i as i32 - 3)) >> 1)) >> 16);
            ((level - dark).clamp(-2 * contrast, 3 * contrast) * by_contrast) >> 14
        });
        if !local.is_alone() {
            for (lightness, at) in lightness.iter_mut().zip(NEAR) {
                *lightness -= local.neighbours(at - local.at, &edge);
            }
        }
        Self { lightness, edge, width: (sharpness.blur * (local.by_cosine >> 1)) >> 13 }
    }

    /// The place of the edge with the least sum of squares: a matched filter, iterated from the sample nearest to half
    /// lightness. `None` if these samples hold no edge.
    #[inline]
    fn place(&self) -> Option<Placed> {
        const HALF: i32 = ONE / 2;
        let [l0, l1, l2, l3] = self.lightness;
        let [p0, p1, p2, p3] = NEAR;
        let pairs = [((l1, p1), (l2, p2)), ((l0, p0), (l1, p1)), ((l2, p2), (l3, p3))];
        let &(low, high) = pairs.iter().find(|((low, _), (high, _))| *low < HALF && *high >= HALF)?;
        // From the sample nearer to the middle, by the series of the inverse of the distribution.
        let (from, start) = if HALF - low.0 < high.0 - HALF { low } else { high };
        self.place_from(start - self.along(inverse_normal(from) - self.edge.lead))
    }

    /// The same from a place near it.
    #[inline]
    pub fn place_from(&self, mut place: i32) -> Option<Placed> {
        let mut residuals = [0; 4];
        let mut sums = (0, 0);
        for _ in 0..STEPS {
            let (mut slope, mut square, mut densities) = (0, 0, [0; 4]);
            for i in 0..4 {
                let (share, density) = normal_fixed(self.edge.deviation(NEAR[i] - place));
                residuals[i] = self.lightness[i] - share;
                densities[i] = density;
                slope -= density * residuals[i];
                square += density * density;
            }
            if square < MIN_SQUARE {
                return None;
            }
            sums = (densities.iter().sum(), square);
            let deviations = slope / (square >> 12);
            let step = self.along(deviations).clamp(-MAX_STEP, MAX_STEP);
            place += step;
            if step.abs() < SETTLED {
                // What the step leaves, to first order.
                for (residual, density) in residuals.iter_mut().zip(densities) {
                    *residual += (density * deviations) >> 12;
                }
                break;
            }
        }
        let [first, .., last] = NEAR;
        (place > first && place < last).then_some(Placed { place, residuals, densities: sums })
    }

    /// A length on the axis from standard deviations.
    fn along(&self, deviations: i32) -> i32 {
        (deviations.clamp(-4 * PX, 4 * PX) * self.width) >> 12
    }

    /// Normal equation of the relative change of the blur, with the place free: `(right-hand side, square)`.
    fn blur_slope(&self, place: i32) -> (i32, i32) {
        // Residual, and derivatives by the logarithm of the blur and by the place.
        let (mut right, mut right_of_place, mut cross, mut square, mut square_of_place) = (0, 0, 0, 0, 0);
        for (at, lightness) in NEAR.into_iter().zip(self.lightness) {
            let z = self.edge.deviation(at - place);
            let (share, density) = normal_fixed(z);
            let by_blur = (density * (2 * self.edge.lead - z)) >> 12;
            let residual = lightness - share;
            right += by_blur * residual;
            right_of_place += density * residual;
            cross += by_blur * density;
            square += by_blur * by_blur;
            square_of_place += density * density;
        }
        let share_of_place = cross / (square_of_place.max(MIN_SQUARE) >> 14);
        let part = |product: i32| (i64::from(product) * i64::from(share_of_place)) >> 14;
        (right - part(right_of_place) as i32, (square - part(cross) as i32).max(0))
    }
}

/// Standard deviations at which the step has reached `share`, from the first terms of the series about one half: good to
/// 1 % for shares of 0.2 to 0.8, to 10 % for 0.05 to 0.95.
pub(super) fn inverse_normal(share: i32) -> i32 {
    /// For the quarter that standard deviations have as many bits less than shares.
    const SERIES: [i32; 4] = [10_267, 10_752, 23_635, 61_710];
    let [a, b, c, d] = SERIES;
    let x = (share - ONE / 2).clamp(-ONE / 2, ONE / 2);
    let square = scale(x, x);
    scale(x, a + scale(square, b + scale(square, c + scale(square, d))))
}
