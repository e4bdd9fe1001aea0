//! Against the projective map itself, in double precision, and against the normal equations in full.

extern crate std;

use super::*;
use std::vec;
use std::vec::Vec;

/// Uniform numbers; twelve of them make a normal one.
struct Random(u32);

impl Random {
    fn normal(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(self.0 >> 8) / f64::from(1u32 << 24) - 0.5
        };
        (0..12).map(|_| uniform()).sum()
    }
}

/// Where concentric circles appear: the point at `r` e of the plane at centre + S (r e) / (1 + r p . e).
struct Camera {
    centre: [f64; 2],
    s: [[f64; 2]; 2],
    p: [f64; 2],
}

const CAMERA: Camera = Camera { centre: [0.3, -0.6], s: [[31.0, 4.0], [-2.0, 17.0]], p: [0.04, -0.03] };
const RATIOS: [f32; 3] = [1.0, 0.7, 0.4];

impl Camera {
    /// The image of the point of the circle with radius `r` at the angle `t`.
    fn point(&self, r: f64, t: f64) -> [f64; 2] {
        let (sin, cos) = (libm::sin(t), libm::cos(t));
        let scale = r / (1.0 + r * (self.p[0] * cos + self.p[1] * sin));
        [0, 1].map(|i| self.centre[i] + scale * (self.s[i][0] * cos + self.s[i][1] * sin))
    }

    /// The ellipse of that circle: |q|^2 = r^2 (1 - p . q)^2 with q = S^-1 (x - centre).
    fn shape(&self, r: f64) -> Shape {
        let ([[a, b], [c, d]], [px, py], rr) = (self.s, self.p, r * r);
        let det = a * d - b * c;
        let inverse = [[d / det, -b / det], [-c / det, a / det]];
        let kappa = px * px + py * py;
        let middle = [-rr * px / (1.0 - rr * kappa), -rr * py / (1.0 - rr * kappa)];
        let level = rr / (1.0 - rr * kappa);
        let m = [[1.0 - rr * px * px, -rr * px * py], [-rr * px * py, 1.0 - rr * py * py]];
        let entry = |i: usize, j: usize| {
            let terms = (0..4).map(|n| inverse[n / 2][i] * m[n / 2][n % 2] * inverse[n % 2][j]);
            (terms.sum::<f64>() / level) as f32
        };
        let at = |i: usize| (self.centre[i] + self.s[i][0] * middle[0] + self.s[i][1] * middle[1]) as f32;
        Shape { cx: at(0), cy: at(1), axx: entry(0, 0), axy: entry(0, 1), ayy: entry(1, 1) }
    }

    fn family(&self) -> Concentric {
        Concentric::new(self.shape(1.0), (self.centre[0] as f32, self.centre[1] as f32)).unwrap()
    }
}

/// Points of a circle over the share of a turn that is seen, displaced by `noise` px towards any side.
fn arc(ratio: f32, seen: f64, count: usize, mut noise: impl FnMut() -> f64) -> Vec<(f32, f32)> {
    let points = (0..count).map(|i| {
        let [x, y] =
            CAMERA.point(f64::from(ratio), 0.7 + seen * std::f64::consts::TAU * i as f64 / count as f64);
        ((x + noise()) as f32, (y + noise()) as f32)
    });
    points.collect()
}

/// The step from `family`, with the number of each circle's points.
fn step(family: &Concentric, arcs: &[(f32, Vec<(f32, f32)>)]) -> ConcentricStep {
    let mut adjustment = ConcentricAdjustment::new();
    for (ratio, points) in arcs {
        let member = family.member(*ratio, 0.0);
        adjustment.next_circle();
        points.iter().for_each(|&(x, y)| adjustment.add(&member, &member.view(x, y)));
    }
    adjustment.finish(family).unwrap()
}

/// The centre of the circles.
fn centre(family: &Concentric) -> [f64; 2] {
    let (dx, dy) = family.frame.inverse(family.s.0, family.s.1);
    [f64::from(family.outer.cx + dx), f64::from(family.outer.cy + dy)]
}

fn noisy_arcs(random: &mut Random, sigma: f64) -> Vec<(f32, Vec<(f32, f32)>)> {
    RATIOS.map(|ratio| (ratio, arc(ratio, 0.6, 60, || sigma * random.normal()))).to_vec()
}

#[test]
fn circles_under_perspective_are_its_members() {
    let family = CAMERA.family();
    for ratio in [1.0f32, 0.8, 0.5, 0.3] {
        let member = family.member(ratio, 0.0);
        for (x, y) in arc(ratio, 1.0, 50, || 0.0) {
            assert!(member.view(x, y).distance().abs() < 2e-5);
        }
        let (found, wanted) = (member.shape().unwrap(), CAMERA.shape(f64::from(ratio)));
        assert!((found.cx - wanted.cx).abs() < 1e-5 && (found.cy - wanted.cy).abs() < 1e-5);
        for (found, wanted) in [(found.axx, wanted.axx), (found.axy, wanted.axy), (found.ayy, wanted.ayy)] {
            assert!((found - wanted).abs() < 1e-5 * wanted.abs(), "{ratio}");
        }
    }
    // The centre of the outer ellipse is another: without perspective the members are too far out.
    let plain = Concentric::new(family.outer, (family.outer.cx, family.outer.cy)).unwrap();
    let farthest = arc(0.5, 1.0, 50, || 0.0)
        .iter()
        .fold(0.0f32, |far, &(x, y)| far.max(plain.member(0.5, 0.0).view(x, y).distance().abs()));
    assert!(farthest > 0.1, "{farthest}");
}

#[test]
fn a_size_of_its_own_displaces_the_edge_all_around() {
    let family = CAMERA.family();
    let (plain, wider) =
        (family.member(0.5, 0.0).shape().unwrap(), family.member(0.5, 0.02).shape().unwrap());
    assert_eq!((plain.cx, plain.cy), (wider.cx, wider.cy));
    let (a, wide) = (plain.semi_axes().0, wider.semi_axes().0);
    // 0.25 of the outer square becomes 0.27, but for perspective.
    assert!((wide / a - libm::sqrtf(0.27 / 0.25)).abs() < 1e-3, "{}", wide / a);
    assert!(family.member(0.5, -0.3).shape().is_none());
}

#[test]
fn terms_are_the_derivatives() {
    let family = CAMERA.family();
    let small = 1e-3;
    for ratio in RATIOS {
        let member = family.member(ratio, 0.0);
        for (x, y) in arc(ratio, 1.0, 17, || 0.0) {
            let view = member.view(x, y);
            let terms = member.terms(&view);
            for (i, term) in terms.into_iter().enumerate() {
                let moved = |h: f32| {
                    let mut change = [0.0; SHARED];
                    change[i] = h;
                    family.moved(&change).unwrap().member(ratio, 0.0).view(x, y).distance()
                };
                let slope = (moved(small) - moved(-small)) / (2.0 * small);
                let expected = math::sqrt(view.weight) * term;
                assert!((slope - expected).abs() < 0.02, "{ratio}, {i}: {slope} for {expected}");
            }
        }
    }
}

/// All unknowns in one system, in double precision: the shared ones and the size of each inner circle. Gives the solution and the
/// inverse.
fn dense(family: &Concentric, arcs: &[(f32, Vec<(f32, f32)>)]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = SHARED + arcs.len() - 1;
    // Right-hand side, then the columns of the identity.
    let mut rows = vec![vec![0.0; 2 * n + 1]; n];
    for (k, (ratio, points)) in arcs.iter().enumerate() {
        let member = family.member(*ratio, 0.0);
        for &(x, y) in points {
            let view = member.view(x, y);
            let mut terms: Vec<f64> = member.terms(&view).map(f64::from).to_vec();
            terms.extend((1..arcs.len()).map(|own| if own == k { -1.0 } else { 0.0 }));
            for i in 0..n {
                let weighted = f64::from(view.weight) * terms[i];
                (0..n).for_each(|j| rows[i][j] += weighted * terms[j]);
                rows[i][n] -= weighted * f64::from(view.residual);
            }
        }
    }
    (0..n).for_each(|i| rows[i][n + 1 + i] = 1.0);
    for pivot in 0..n {
        let largest =
            (pivot..n).max_by(|&a, &b| rows[a][pivot].abs().total_cmp(&rows[b][pivot].abs())).unwrap();
        rows.swap(pivot, largest);
        let scale = rows[pivot][pivot];
        rows[pivot].iter_mut().for_each(|entry| *entry /= scale);
        let row = rows[pivot].clone();
        for (_, other) in rows.iter_mut().enumerate().filter(|(i, _)| *i != pivot) {
            let factor = other[pivot];
            other.iter_mut().zip(&row).for_each(|(entry, of_pivot)| *entry -= factor * of_pivot);
        }
    }
    (rows.iter().map(|row| row[n]).collect(), rows.iter().map(|row| row[n + 1..].to_vec()).collect())
}

#[test]
fn the_step_is_that_of_all_unknowns_in_one_system() {
    let mut random = Random(5);
    let family = CAMERA.family();
    let arcs = noisy_arcs(&mut random, 0.1);
    let found = step(&family, &arcs);
    let (solution, inverse) = dense(&family, &arcs);
    for (k, size) in found.sizes.iter().enumerate().skip(1) {
        assert!((f64::from(*size) - solution[SHARED + k - 1]).abs() < 1e-5, "{k}");
    }
    let shared: [f32; SHARED] = core::array::from_fn(|i| solution[i] as f32);
    let wanted = centre(&family.moved(&shared).unwrap());
    for (found, wanted) in centre(&found.family).iter().zip(wanted) {
        assert!((found - wanted).abs() < 2e-4, "{found} {wanted}");
    }
    // The covariance of the centre of any circle, from the inverse and from how it moves.
    for ratio in [0.0, 0.4, 1.0] {
        let at = |i: usize, h: f32| {
            let mut change = [0.0; SHARED];
            change[i] = h;
            let moved = family.moved(&change).unwrap();
            let shape = moved.member(ratio, 0.0).shape();
            shape.map_or(centre(&moved), |shape| [f64::from(shape.cx), f64::from(shape.cy)])
        };
        let slope = |i: usize| [0, 1].map(|axis| (at(i, 0.01)[axis] - at(i, -0.01)[axis]) / 0.02);
        let slopes: Vec<_> = (0..SHARED).map(slope).collect();
        let entry = |a: usize, b: usize| {
            let pairs = (0..SHARED * SHARED).map(|n| (n / SHARED, n % SHARED));
            let sum: f64 = pairs.map(|(i, j)| slopes[i][a] * inverse[i][j] * slopes[j][b]).sum();
            f64::from(found.variance) * sum
        };
        let covariance = found.covariance(ratio);
        for (got, wanted) in [(covariance.xx, entry(0, 0)), (covariance.yy, entry(1, 1))] {
            assert!((f64::from(got) / wanted - 1.0).abs() < 0.02, "{ratio}: {got} {wanted}");
        }
        let scale = libm::sqrt(entry(0, 0) * entry(1, 1));
        assert!((f64::from(covariance.xy) - entry(0, 1)).abs() < 0.02 * scale, "{ratio}");
    }
}

/// Three fifths of each circle: what is reported is how the centres scatter, and each circle by itself is far less sure.
#[test]
fn covariance_is_that_of_the_centres() {
    let mut random = Random(11);
    let sigma = 0.05;
    let trials = 1500;
    for ratio in [0.0f32, 1.0] {
        let (mut actual, mut reported, mut free) = ([0.0f64; 3], [0.0f64; 3], 0.0f64);
        for _ in 0..trials {
            let arcs = noisy_arcs(&mut random, sigma);
            let step = step(&CAMERA.family(), &arcs);
            let [x, y] = if ratio == 0.0 {
                let ([x, y], [x0, y0]) = (centre(&step.family), CAMERA.centre);
                [x - x0, y - y0]
            } else {
                let (outer, truth) = (step.family.outer, CAMERA.shape(1.0));
                [f64::from(outer.cx - truth.cx), f64::from(outer.cy - truth.cy)]
            };
            let covariance = step.covariance(ratio);
            for ((sum, told), (square, c)) in actual.iter_mut().zip(&mut reported).zip([
                (x * x, covariance.xx),
                (x * y, covariance.xy),
                (y * y, covariance.yy),
            ]) {
                *sum += square / f64::from(trials);
                *told += f64::from(c) / f64::from(trials);
            }
            free += f64::from(step.variance) / f64::from(trials);
        }
        // The points scatter by sigma along the normal.
        assert!((free / (sigma * sigma) - 1.0).abs() < 0.03, "{free}");
        let scale = libm::sqrt(reported[0] * reported[2]);
        for (n, (actual, reported)) in actual.iter().zip(reported).enumerate() {
            let room = 0.12 * if n == 1 { scale } else { reported };
            assert!((actual - reported).abs() < room, "ratio {ratio}, {n}: {actual} {reported}");
        }
        let alone = {
            let mut adjustment = super::super::Adjustment::new(CAMERA.shape(1.0)).unwrap();
            for point in arc(1.0, 0.6, 60, || sigma * random.normal()) {
                adjustment.add_point(point);
            }
            adjustment.finish().unwrap().covariance
        };
        assert!(ratio == 0.0 || f64::from(alone.xx + alone.yy) > 1.2 * (reported[0] + reported[2]));
    }
}

#[test]
fn what_does_not_determine_them_is_refused() {
    let outer = CAMERA.shape(1.0);
    // A centre more than half of the way to the edge, and none.
    assert!(Concentric::new(outer, (outer.cx + 0.6 * outer.semi_axes().0, outer.cy)).is_none());
    assert!(Concentric::new(outer, (f32::NAN, outer.cy)).is_none());
    let family = CAMERA.family();
    let mut few = ConcentricAdjustment::new();
    assert!(few.finish(&family).is_none());
    let member = family.member(1.0, 0.0);
    few.next_circle();
    arc(1.0, 1.0, 100, || 0.0).iter().for_each(|&(x, y)| few.add(&member, &member.view(x, y)));
    // One circle tells nothing of s.
    assert!(few.finish(&family).is_none());
}
