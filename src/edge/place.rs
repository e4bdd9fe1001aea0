//! Where the edge passes on the axis of a crossing, and how blurred the edges are.

use super::{Blurred, Edges, Levels, Local, normal};
use crate::scan::{Crossing, Pool};

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
/// The blur is kept in this range, px.
const BLUR_RANGE: (f32, f32) = (0.29, 6.0);
/// Largest change of the blur in a pass, and of an edge point in a step, relative and px.
const MAX_CHANGE: f32 = 0.5;
/// Largest difference of a sample from the profile, as a share of the contrast (curved response, gradients), ...
const MISFIT: f32 = 0.08;
/// ... plus this many standard deviations of the noise: more is something else in front of the edge.
const MISFIT_SIGMAS: f32 = 4.5;
/// Slope of the edge profile below which four samples hold no edge.
const MIN_SLOPE: f32 = 1e-3;

/// Standard deviation of the edges' profile, px: the one with which the profile fits best at a sample of crossings of
/// every edge, with each edge in its best place.
pub(crate) fn measure_blur(edges: &Edges<'_>, pool: &Pool<'_>, levels: &Levels) -> f32 {
    let mut sigma = BLUR_START;
    for _ in 0..BLUR_PASSES {
        let (mut slope, mut square) = (0.0, 0.0);
        for (k, edge) in edges.edges.iter().enumerate() {
            let Some(views) = edges.views(k) else { continue };
            for crossing in pool.iter(edge.crossings).step_by(edge.stride()) {
                let Some(local) = views.local(crossing) else { continue };
                let profile = Profile::new(&local, crossing, levels, sigma);
                if let Some(Placed { place, .. }) = profile.place(f32::INFINITY) {
                    let (s, q) = profile.blur_slope(place);
                    slope += s;
                    square += q;
                }
            }
        }
        let change = if square > 0.0 { (slope / square).clamp(-MAX_CHANGE, MAX_CHANGE) } else { 0.0 };
        sigma = (sigma * (1.0 + change)).clamp(BLUR_RANGE.0, BLUR_RANGE.1);
        if change.abs() < BLUR_SETTLED {
            break;
        }
    }
    sigma
}

/// Places an edge point at every crossing of edge `k`.
pub(crate) fn place(edges: &Edges<'_>, k: usize, pool: &mut Pool<'_>, levels: &Levels, sigma: f32) {
    let (Some(edge), Some(views)) = (edges.edges.get(k), edges.views(k)) else { return };
    let tolerance = MISFIT + MISFIT_SIGMAS * edges.noise / levels.contrast();
    pool.for_each_mut(edge.crossings, |crossing| {
        let placed = views.local(crossing).and_then(|local| {
            let Placed { place, excess } = Profile::new(&local, crossing, levels, sigma).place(tolerance)?;
            let round = |value: f32| crate::math::round(256.0 * value);
            Some((round(place * local.sign()) as i16, round(excess).clamp(-128, 127) as i8))
        });
        crossing.place(placed);
    });
}

/// An edge in four samples.
struct Placed {
    /// Its place, towards light from the crossing's pixel, px.
    place: f32,
    /// Lightness of the outer samples beyond what the levels give them.
    excess: f32,
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
    /// lightness. `None` if these samples hold no edge, or one from which a lightness differs by more than `tolerance`.
    fn place(&self, tolerance: f32) -> Option<Placed> {
        let [p0, ..] = self.places;
        let [l0, l1, l2, l3] = self.lightness;
        let pairs = [(1.0, l1, l2), (0.0, l0, l1), (2.0, l2, l3)];
        let &(before, low, high) = pairs.iter().find(|(_, low, high)| *low < 0.5 && *high >= 0.5)?;
        // From the sample nearer to the middle, by the series of the inverse of the distribution.
        let (start, from) = if 0.5 - low < high - 0.5 { (before, low) } else { (before + 1.0, high) };
        let mut place = p0 + start - (inverse_normal(from) - 0.5 * self.edge.curvature) / self.edge.k;
        let (mut misfit, mut excess) = (0.0f32, 0.0);
        for _ in 0..STEPS {
            let at = self.places.map(|x| {
                let (share, density) = normal(self.edge.deviation(x - place));
                (share, density * self.edge.slope(x - place))
            });
            let (mut slope, mut square) = (0.0, 0.0);
            misfit = 0.0;
            for ((share, derivative), lightness) in at.iter().zip(self.lightness) {
                slope += derivative * (share - lightness);
                square += derivative * derivative;
                misfit = (share - lightness).abs().max(misfit);
            }
            let [(first, _), .., (last, _)] = at;
            excess = 0.5 * (l0 - first + l3 - last);
            if square < MIN_SLOPE * self.edge.k * self.edge.k {
                return None;
            }
            let step = (slope / square).clamp(-MAX_CHANGE, MAX_CHANGE);
            place += step;
            if step.abs() < SETTLED {
                break;
            }
        }
        (place > p0 && place < p0 + 3.0 && misfit <= tolerance).then_some(Placed { place, excess })
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
