//! Where the edge passes on the axis of a crossing, and how blurred the edges are.

use super::{Blurred, Edges, Levels, Local, normal};
use crate::fit::Spread;
use crate::scan::{Crossing, EdgePoint, Pool};

/// Most Gauss-Newton steps for an edge point.
const STEPS: usize = 3;
/// A step below this, px, is the last: the next one would be its square, about 1e-3 px.
const SETTLED: f32 = 0.03;
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
/// Largest change of the blur in a pass, and of an edge point in a step, relative and px.
const MAX_CHANGE: f32 = 0.5;
/// Slope of the edge profile below which four samples hold no edge.
const MIN_SLOPE: f32 = 1e-3;

/// What the edges' profiles tell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blur {
    /// Standard deviation of the profile, px.
    pub sigma: f32,
    /// Standard deviation of a sample about it, as a share of the contrast.
    pub noise: f32,
}

/// The blur with which the profile fits best at a sample of crossings of every edge, with each edge in its best place.
pub(crate) fn measure_blur(edges: &Edges<'_>, pool: &Pool<'_>, levels: &Levels) -> Blur {
    let mut sigma = BLUR_START;
    let mut noise = f32::INFINITY;
    for pass in 0..BLUR_PASSES {
        let (mut slope, mut square) = (0.0, 0.0);
        let limit = BLUR_OUTLIER + BLUR_OUTLIER_SIGMAS * noise;
        let mut spread = Spread::default();
        for (k, edge) in edges.edges.iter().enumerate() {
            let Some(views) = edges.views(k) else { continue };
            for crossing in pool.iter(edge.crossings).step_by(edge.stride()) {
                let Some(local) = views.local(crossing) else { continue };
                let profile = Profile::new(&local, crossing, levels, sigma);
                let Some(placed) = profile.place() else { continue };
                // The blur of the first pass is none of this target's.
                if pass > 0 {
                    placed.add_noise(&mut spread);
                }
                if placed.misfit() <= limit {
                    let (s, q) = profile.blur_slope(placed.place);
                    slope += s;
                    square += q;
                }
            }
        }
        noise = spread.sigma();
        let change = if square > 0.0 { (slope / square).clamp(-MAX_CHANGE, MAX_CHANGE) } else { 0.0 };
        sigma = (sigma * (1.0 + change)).clamp(BLUR_RANGE.0, BLUR_RANGE.1);
        if pass > 0 && change.abs() < BLUR_SETTLED {
            break;
        }
    }
    Blur { sigma, noise }
}

/// Places an edge point at every crossing of edge `k`. Gives the standard deviation of the samples about it, as a share of the
/// contrast.
pub(crate) fn place(edges: &Edges<'_>, k: usize, pool: &mut Pool<'_>, levels: &Levels, sigma: f32) -> f32 {
    let mut noise = Spread::default();
    let (Some(edge), Some(views)) = (edges.edges.get(k), edges.views(k)) else { return 0.0 };
    pool.for_each_mut(edge.crossings, |crossing| {
        let placed = views.local(crossing).and_then(|local| {
            let placed = Profile::new(&local, crossing, levels, sigma).place()?;
            placed.add_noise(&mut noise);
            let [first, .., last] = placed.residuals;
            let round = |value: f32| crate::math::round(256.0 * value);
            Some(EdgePoint {
                offset: round(placed.place * local.sign()) as i16,
                excess: round(0.5 * (first + last)).clamp(-128, 127) as i8,
                misfit: round(placed.misfit()).clamp(0, 255) as u8,
            })
        });
        crossing.place(placed);
    });
    noise.sigma()
}

/// An edge in four samples.
struct Placed {
    /// Its place, towards light from the crossing's pixel, px.
    place: f32,
    /// Lightness of the samples beyond what the edge gives them.
    residuals: [f32; 4],
}

impl Placed {
    /// Adds what the samples tell of the noise: in the differences across the edge the light beside it and its place cancel.
    fn add_noise(&self, spread: &mut Spread) {
        let [a, b, c, d] = self.residuals;
        for difference in [a - d, b - c] {
            spread.add(0.5 * difference * difference);
        }
    }

    /// Largest residual.
    fn misfit(&self) -> f32 {
        self.residuals.iter().fold(0.0, |most, residual| most.max(residual.abs()))
    }
}

/// Four samples across an edge, as lightness less what the neighbouring edges add.
struct Profile {
    /// Places on the axis, towards light, px.
    places: [f32; 4],
    lightness: [f32; 4],
    edge: Blurred,
}

impl Profile {
    fn new(local: &Local, crossing: &Crossing, levels: &Levels, sigma: f32) -> Self {
        let (places, grey) = local.near(crossing);
        let edge = local.blurred(sigma);
        let scale = levels.scale(local.point(local.offset), local.axis);
        let from_edge = places.map(|place| place - local.offset);
        let neighbours = local.neighbours(from_edge, edge.k);
        let lightness = core::array::from_fn(|i| scale.lightness(grey[i], from_edge[i]) - neighbours[i]);
        Self { places, lightness, edge }
    }

    /// The place of the edge with the least sum of squares: a matched filter, iterated from the sample nearest to half
    /// lightness. `None` if these samples hold no edge.
    fn place(&self) -> Option<Placed> {
        let [p0, ..] = self.places;
        let [l0, l1, l2, l3] = self.lightness;
        let pairs = [(1.0, l1, l2), (0.0, l0, l1), (2.0, l2, l3)];
        let &(before, low, high) = pairs.iter().find(|(_, low, high)| *low < 0.5 && *high >= 0.5)?;
        // From the sample nearer to the middle, by the series of the inverse of the distribution.
        let (start, from) = if 0.5 - low < high - 0.5 { (before, low) } else { (before + 1.0, high) };
        let mut place = p0 + start - (inverse_normal(from) - 0.5 * self.edge.curvature) / self.edge.k;
        let mut residuals = [0.0; 4];
        for _ in 0..STEPS {
            let at = self.places.map(|x| {
                let (share, density) = normal(self.edge.deviation(x - place));
                (share, density * self.edge.slope(x - place))
            });
            let (mut slope, mut square) = (0.0, 0.0);
            for ((residual, (share, derivative)), lightness) in
                residuals.iter_mut().zip(at).zip(self.lightness)
            {
                *residual = lightness - share;
                slope -= derivative * *residual;
                square += derivative * derivative;
            }
            if square < MIN_SLOPE * self.edge.k * self.edge.k {
                return None;
            }
            let step = (slope / square).clamp(-MAX_CHANGE, MAX_CHANGE);
            place += step;
            if step.abs() < SETTLED {
                break;
            }
        }
        (place > p0 && place < p0 + 3.0).then_some(Placed { place, residuals })
    }

    /// Normal equation of the relative change of the blur, with the place free: `(right-hand side, square)`.
    fn blur_slope(&self, place: f32) -> (f32, f32) {
        // Residual, and derivatives by the logarithm of the blur and by the place.
        let at = self.places.map(|x| {
            let z = self.edge.deviation(x - place);
            let (share, density) = normal(z);
            (share, (self.edge.curvature - z) * density, density * self.edge.slope(x - place))
        });
        let (cross, square) = at.iter().fold((0.0, 0.0), |(cross, square), (_, blur, place)| {
            (cross + blur * place, square + place * place)
        });
        let share_of_place = cross / square.max(MIN_SLOPE * self.edge.k * self.edge.k);
        at.iter().zip(self.lightness).fold(
            (0.0, 0.0),
            |(slope, square), ((share, blur, place), lightness)| {
                let derivative = blur - share_of_place * place;
                (slope + derivative * (lightness - share), square + derivative * derivative)
            },
        )
    }
}

/// Standard deviations at which the step has reached `share`, from the first terms of the series about one half: good to
/// 1 % for shares of 0.2 to 0.8, to 10 % for 0.05 to 0.95.
fn inverse_normal(share: f32) -> f32 {
    let x = share - 0.5;
    let square = x * x;
    x * (2.506_628 + square * (2.624_933 + square * (5.770_333 + square * 15.066)))
}
