extern crate std;
use super::*;
use crate::edge::Edge;
use crate::fit::rough;
use crate::scan::{Axis, Crossing, CrossingList, EdgePoint, Outline, Seen, Stretch};
use std::vec::Vec;

const AT: (u16, u16) = (500, 500);
const RATIO: f64 = 0.5;
/// Noise of the samples, in units of the contrast, and what that makes of an edge point, px.
const NOISE: (f32, f64) = (0.0133, 0.02);

/// Circles about `c` under perspective: the image of the one with radius r is c + r S e / (1 + r p.e), e the unit vectors.
type Scene = [f64; 7];

const SCENE: Scene = [0.3, -0.2, 30.0, 4.0, 22.0, 0.02, -0.012];

/// Radius of the circle through the place.
fn radius([cx, cy, a, b, d, px, py]: &Scene, x: f64, y: f64) -> f64 {
    let (dx, dy, det) = (x - cx, y - cy, a * d - b * b);
    let (u, v) = ((d * dx - b * dy) / det, (a * dy - b * dx) / det);
    u.hypot(v) / (1.0 - px * u - py * v)
}

/// Its gradient.
fn gradient(scene: &Scene, x: f64, y: f64) -> (f64, f64) {
    let by = |dx: f64, dy: f64| (radius(scene, x + dx, y + dy) - radius(scene, x - dx, y - dy)) / 2e-4;
    (by(1e-4, 0.0), by(0.0, 1e-4))
}

/// Distance from the circle of `ratio`, px.
fn distance(scene: &Scene, ratio: f64, (x, y): (f64, f64)) -> f64 {
    let (gx, gy) = gradient(scene, x, y);
    (radius(scene, x, y) - ratio) / gx.hypot(gy)
}

struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A place where a row or a column passes a circle.
#[derive(Clone, Copy)]
struct Point {
    axis: Axis,
    /// The pixel about the origin, and how far the edge is from it, px.
    pixel: (i32, i32),
    offset: f64,
    excess: i8,
}

impl Point {
    fn place(&self) -> (f64, f64) {
        let (x, y) = (f64::from(self.pixel.0), f64::from(self.pixel.1));
        // On the grid of edge points.
        let offset = (256.0 * self.offset).round() / 256.0;
        if self.axis == Axis::Row { (x + offset, y) } else { (x, y + offset) }
    }

    /// Direction from the centre, turns.
    fn turn(&self) -> f64 {
        let (x, y) = self.place();
        (y - SCENE[1]).atan2(x - SCENE[0]) / std::f64::consts::TAU + 0.5
    }
}

/// Where rows and columns pass the circle of `ratio` on the steeper axis.
fn points(ratio: f64) -> Vec<Point> {
    let mut all = Vec::new();
    for axis in [Axis::Row, Axis::Column] {
        let at = |along: f64, across: i32| match axis {
            Axis::Row => (along, f64::from(across)),
            Axis::Column => (f64::from(across), along),
        };
        let depth = |along: f64, across: i32| {
            let (x, y) = at(along, across);
            radius(&SCENE, x, y) - ratio
        };
        for across in -50..=50 {
            for first in -50..50 {
                let (mut low, mut high) = (f64::from(first), f64::from(first) + 1.0);
                let sign = depth(low, across);
                if sign * depth(high, across) > 0.0 {
                    continue;
                }
                for _ in 0..40 {
                    let middle = (low + high) / 2.0;
                    if sign * depth(middle, across) > 0.0 { low = middle } else { high = middle }
                }
                let (x, y) = at(low, across);
                let (gx, gy) = gradient(&SCENE, x, y);
                let pixel = if axis == Axis::Row { (first + 1, across) } else { (across, first + 1) };
                if (gx.abs() > gy.abs()) == (axis == Axis::Row) {
                    all.push(Point { axis, pixel, offset: low - f64::from(first) - 1.0, excess: 0 });
                }
            }
        }
    }
    all
}

/// What is seen of either circle, between two directions, turns.
fn arcs(seen: [(f64, f64); 2], mut change: impl FnMut(&mut Point)) -> [Vec<Point>; 2] {
    let mut k = 0;
    [1.0, RATIO].map(|ratio| {
        let (from, to) = seen[k];
        k += 1;
        let mut points = points(ratio);
        points.retain(|point| (from..to).contains(&point.turn()));
        points.iter_mut().for_each(&mut change);
        points
    })
}

/// The ellipse of the whole circle.
fn whole(ratio: f64) -> Shape {
    let fixed = |x: f64| (4096.0 * x).round() as i32;
    let places =
        points(ratio).iter().map(Point::place).map(|(x, y)| (fixed(x), fixed(y))).collect::<Vec<_>>();
    rough(places.into_iter(), 31.0).unwrap()
}

fn solve(arcs: &[Vec<Point>; 2]) -> (Together, (f64, f64)) {
    let mut slots = std::vec![Crossing::ZERO; 1000];
    let mut pool = Pool::new(&mut slots);
    let origin = Origin::new(AT, None).unwrap();
    let (mut edges, mut circles) = (Vec::new(), FittedList::new());
    for (k, (points, ratio)) in arcs.iter().zip([1.0, RATIO]).enumerate() {
        let mut list = CrossingList::EMPTY;
        for point in points {
            let [x, y] =
                [(AT.0, point.pixel.0), (AT.1, point.pixel.1)].map(|(at, d)| (i32::from(at) + d) as u16);
            let mut crossing = Crossing::new(point.axis, (x, y), [0; 6], [Stretch::of(&[0], 0); 2]);
            let offset = (256.0 * point.offset).round() as i16;
            crossing.place(Some(EdgePoint { offset, excess: point.excess, misfit: 0 }));
            *pool.push(&mut list).unwrap() = crossing;
        }
        let mut outline = Outline::ZERO;
        (outline.crossings, outline.seen) = (list, Seen::Arcs);
        // A first guess that is off by half a pixel.
        let shape = Shape { cx: whole(ratio).cx + 0.4, cy: whole(ratio).cy - 0.3, ..whole(ratio) };
        edges.push(Edge::new(shape, &outline));
        let adjusted = Adjusted {
            shape,
            covariance: Covariance::default(),
            frame_covariance: [[0.0; 4]; 4],
            rms: 0.0,
            points: 0,
        };
        let (ratio, dark_inside) = (ratio as f32, k == 0);
        let fitted = Fitted {
            adjusted,
            edge: k,
            dark_inside,
            partial: true,
            cut: false,
            gap: 0,
            ratio,
            measured_ratio: ratio,
        };
        circles.push(fitted).unwrap();
    }
    let source =
        Source { edges: &edges, pool: &pool, origin: &origin, noise: NOISE.0, calm: NOISE.0, blur: 0.8 };
    let all = together(&circles, &source, true).unwrap();
    let centre = combine(&all.circles, measured_perspective(&all.circles).unwrap()).unwrap();
    (all, (f64::from(centre.x), f64::from(centre.y)))
}

/// Of the slow model.
const UNKNOWN: usize = 8;
type Unknowns = [[f64; UNKNOWN]; UNKNOWN];

/// The slow obvious model: Gauss-Newton steps for the seven numbers of the scene and the size of the inner circle, derivatives by
/// differences. Gives the centre and its covariance for a variance of 1.
fn slow(arcs: &[Vec<Point>; 2]) -> ((f64, f64), [f64; 3]) {
    let (mut scene, mut size) = (SCENE, RATIO);
    let mut inverse = [[0.0; UNKNOWN]; UNKNOWN];
    for _ in 0..6 {
        let (mut m, mut right) = ([[0.0; UNKNOWN]; UNKNOWN], [0.0; UNKNOWN]);
        for (points, inner) in arcs.iter().zip([0.0, 1.0]) {
            for point in points {
                let place = point.place();
                let ratio = if inner > 0.0 { size } else { 1.0 };
                let slopes: [f64; UNKNOWN] = core::array::from_fn(|i| {
                    let by = if i < 5 { 1e-3 } else { 1e-5 };
                    let moved = |by: f64| {
                        let mut scene = scene;
                        match scene.get_mut(i) {
                            Some(number) => *number += by,
                            None => return distance(&scene, ratio + inner * by, place),
                        }
                        distance(&scene, ratio, place)
                    };
                    (moved(by) - moved(-by)) / (2.0 * by)
                });
                let residual = distance(&scene, ratio, place);
                for i in 0..UNKNOWN {
                    right[i] -= slopes[i] * residual;
                    for j in 0..UNKNOWN {
                        m[i][j] += slopes[i] * slopes[j];
                    }
                }
            }
        }
        inverse = inverted(m);
        let step = inverse.map(|row| row.iter().zip(right).map(|(a, b)| a * b).sum::<f64>());
        scene.iter_mut().chain([&mut size]).zip(step).for_each(|(number, step)| *number += step);
    }
    ((scene[0], scene[1]), [inverse[0][0], inverse[0][1], inverse[1][1]])
}

/// By Gauss and Jordan.
fn inverted(mut m: Unknowns) -> Unknowns {
    let mut inverse: Unknowns =
        core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))));
    for i in 0..UNKNOWN {
        let by = 1.0 / m[i][i];
        (m[i], inverse[i]) = (m[i].map(|x| x * by), inverse[i].map(|x| x * by));
        for j in (0..UNKNOWN).filter(|&j| j != i) {
            let by = m[j][i];
            for k in 0..UNKNOWN {
                m[j][k] -= by * m[i][k];
                inverse[j][k] -= by * inverse[i][k];
            }
        }
    }
    inverse
}

fn apart(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// What is left out at either end of an arc, turns.
const ENDS: f64 = 0.025;
/// Different halves of the circles.
const HALVES: [(f64, f64); 2] = [(0.1, 0.62), (0.3, 0.95)];

#[test]
fn arcs_without_noise_give_the_centre() {
    for seen in [HALVES, [(0.0, 1.0), (0.4, 0.9)], [(0.0, 0.55), (0.0, 0.55)]] {
        let (all, centre) = solve(&arcs(seen, |_| ()));
        assert!(apart(centre, (SCENE[0], SCENE[1])) < 3e-3, "{centre:?} of {seen:?}");
        // Teeth: the centre of either ellipse is another.
        let outer = all.circles[0].adjusted.shape;
        assert!(apart((f64::from(outer.cx), f64::from(outer.cy)), centre) > 0.2);
    }
}

/// Errors are those of the slow model without the points beside the gaps, and the covariance is theirs.
#[test]
fn noisy_arcs_give_what_the_slow_model_gives() {
    let mut random = Random(5);
    let (mut fast, mut obvious, mut normalised, trials) = (0.0, 0.0, 0.0, 100);
    for _ in 0..trials {
        let arcs = arcs(HALVES, |point| point.offset += NOISE.1 * random.normal());
        let mut k = 0;
        let used = arcs.clone().map(|mut points| {
            let (from, to) = HALVES[k];
            k += 1;
            points.retain(|point| (from + ENDS..to - ENDS).contains(&point.turn()));
            points
        });
        let ((all, centre), (wanted, [xx, _, yy])) = (solve(&arcs), slow(&used));
        let sigma = NOISE.1 * (xx + yy).sqrt();
        assert!(apart(centre, wanted) < 5.0 * sigma, "{centre:?} for {wanted:?}, sigma {sigma}");
        let (dx, dy) = (centre.0 - SCENE[0], centre.1 - SCENE[1]);
        let [xx, xy, yy] = [all.covariance.xx, all.covariance.xy, all.covariance.yy].map(f64::from);
        normalised += (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy) / 2.0;
        fast += dx * dx + dy * dy;
        obvious += apart(wanted, (SCENE[0], SCENE[1])).powi(2);
    }
    let (ratio, normalised) = ((fast / obvious).sqrt(), (normalised / f64::from(trials)).sqrt());
    assert!((0.9..1.1).contains(&ratio) && (0.8..1.25).contains(&normalised), "{ratio} {normalised}");
}

/// What lies on an arc displaces some of its points: they are left out.
#[test]
fn displaced_points_are_left_out() {
    let mut random = Random(8);
    let (mut left_out, mut used) = (0.0, 0.0);
    for place in [0.15, 0.2, 0.35, 0.4, 0.5, 0.55] {
        let mut noisy = arcs(HALVES, |point| point.offset += NOISE.1 * random.normal());
        let undisturbed = solve(&noisy).1;
        for point in noisy.iter_mut().flatten().filter(|point| (place..place + 0.04).contains(&point.turn()))
        {
            point.offset += 0.6;
        }
        left_out += apart(solve(&noisy).1, undisturbed).powi(2);
        used += apart(slow(&noisy).0, undisturbed).powi(2);
    }
    let (left_out, used) = (left_out.sqrt(), used.sqrt());
    // Teeth: with all points the error would be several times as large.
    assert!(left_out < 0.06 && used > 3.0 * left_out, "{left_out} {used}");
}

/// Light that varies around the circle, and residuals above the noise, are less sure by more than their own scatter; light that is
/// the same everywhere is not.
#[test]
fn what_moves_points_together_makes_the_centre_less_sure() {
    let variance = |change: &dyn Fn(&mut Point)| {
        let mut random = Random(9);
        let (all, _) = solve(&arcs([(0.0, 0.7); 2], |point| {
            point.offset += NOISE.1 * random.normal();
            change(point);
        }));
        f64::from(all.covariance.xx + all.covariance.yy)
    };
    let wave = |point: &Point, waves: f64| (waves * std::f64::consts::TAU * point.turn()).sin();
    let calm = variance(&|_| ());
    let even = variance(&|point| point.excess = 4);
    let light = variance(&|point| point.excess = (4.0 * wave(point, 2.0)).round() as i8);
    let moved = variance(&|point| point.offset += 0.05 * wave(point, 7.0));
    assert!((even / calm - 1.0).abs() < 0.01, "{even} for {calm}");
    assert!(light > 2.0 * calm, "{light} for {calm}");
    // By its own scatter it would be (0.02^2 + 0.05^2 / 2) / 0.02^2, which is 4.
    assert!(moved > 12.0 * calm, "{moved} for {calm}");
}
