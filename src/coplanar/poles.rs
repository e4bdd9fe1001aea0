//! The poles of a vanishing line in the circles of one target.

use crate::camera::{Camera, Local};
use crate::math;
use crate::settings::limits;
use crate::target::{Circle, Covariance, MAX_CIRCLES, Position, Target};
use heapless::Vec;

/// Least standard deviation in units of the ellipse: what rounding leaves in a picture without noise.
const LEAST: f32 = 5e-7;

/// A matrix ((a, b), (c, d)).
type Square = [[f32; 2]; 2];

/// What a target's poles tell of the line, and the centre they give. Undistorted px about the outer ellipse's centre.
pub(super) struct Poles {
    /// Normal matrix and right-hand side of the line's change.
    pub m: Square,
    pub right: [f32; 2],
    /// Sum of squared distances of the poles from their mean, in units of their variance.
    pub squares: f32,
    /// Number of residuals in it that are free.
    pub free: f32,
    /// Their weighted mean, its covariance and its derivative by the line.
    mean: (f32, f32),
    covariance: Covariance,
    slope: Square,
    lens: Option<Local>,
}

/// The pole in one circle, its derivative by the line, and its weight.
struct Pole {
    place: (f32, f32),
    slope: Square,
    weight: Covariance,
}

impl Poles {
    /// `line` is about `origin`. `None` for a target with less than two circles, or one that the line passes through.
    pub fn new(target: &Target, camera: Option<&Camera>, origin: Position, line: (f32, f32)) -> Option<Self> {
        let outer = target.circles.first()?.ellipse.centre;
        let (lens, at) = match camera {
            Some(camera) => (Some(Local::new(camera, outer)?), camera.undistort(outer)?),
            None => (None, outer),
        };
        let at = at.offset_from(origin);
        let mut poles = Vec::<Pole, MAX_CIRCLES>::new();
        for circle in &target.circles {
            let offset = circle.ellipse.centre.offset_from(outer);
            poles.push(pole(circle, lens.as_ref(), offset, at, line)?).ok()?;
        }
        let free = 2.0 * poles.len().checked_sub(1).filter(|&more| more > 0)? as f32;
        let (mut weight, mut place, mut slope) = (Covariance::default(), (0.0, 0.0), [[0.0; 2]; 2]);
        for pole in &poles {
            let Covariance { xx, xy, yy } = pole.weight;
            weight = Covariance { xx: weight.xx + xx, xy: weight.xy + xy, yy: weight.yy + yy };
            let (x, y) = times(&pole.weight, pole.place);
            place = (place.0 + x, place.1 + y);
            slope = sum(&slope, 1.0, &product(&pole.weight, &pole.slope));
        }
        let covariance = inverse(&weight)?;
        let mean = times(&covariance, place);
        let slope = product(&covariance, &slope);
        let mut all =
            Self { m: [[0.0; 2]; 2], right: [0.0; 2], squares: 0.0, free, mean, covariance, slope, lens };
        poles.iter().for_each(|pole| all.add(pole));
        Some(all)
    }

    fn add(&mut self, pole: &Pole) {
        let (dx, dy) = (pole.place.0 - self.mean.0, pole.place.1 - self.mean.1);
        let slope = sum(&pole.slope, -1.0, &self.slope);
        let weighted = product(&pole.weight, &slope);
        let (wx, wy) = times(&pole.weight, (dx, dy));
        for i in 0..2 {
            for j in 0..2 {
                self.m[i][j] += slope[0][i] * weighted[0][j] + slope[1][i] * weighted[1][j];
            }
            self.right[i] -= slope[0][i] * wx + slope[1][i] * wy;
        }
        self.squares += dx * wx + dy * wy;
    }

    /// Mean squared distance of the poles over the largest that fits.
    pub fn excess(&self, misfit: f32) -> f32 {
        2.0 * self.squares / (self.free * misfit * limits::PLANE_SIGMAS * limits::PLANE_SIGMAS)
    }

    /// Whether the poles fall together.
    pub fn fit(&self, misfit: f32) -> bool {
        self.excess(misfit) <= 1.0
    }

    /// Puts the mean of the poles in the place of the target's centre. `line` is the covariance of the vanishing line; that of
    /// the poles themselves grows with the `misfit`.
    pub fn correct(&self, target: &mut Target, line: &Covariance, misfit: f32) {
        let Some(outer) = target.circles.first() else { return };
        let Covariance { xx, xy, yy } = line.mapped(self.slope);
        let own = self.covariance;
        let covariance =
            Covariance { xx: xx + misfit * own.xx, xy: xy + misfit * own.xy, yy: yy + misfit * own.yy };
        let (mean, covariance) = match &self.lens {
            Some(lens) => (lens.distort(self.mean), lens.distort_covariance(self.mean, &covariance)),
            None => (self.mean, covariance),
        };
        target.centre = outer.ellipse.centre.moved(mean);
        target.covariance = covariance;
    }
}

/// The pole in `circle`, whose centre is `offset` px from the outer one in the image; `at` is that one's place about the
/// line's origin.
fn pole(
    circle: &Circle,
    lens: Option<&Local>,
    offset: (f32, f32),
    at: (f32, f32),
    line: (f32, f32),
) -> Option<Pole> {
    let (offset, covariance) = match lens {
        Some(lens) => {
            let place = lens.undistort(offset)?;
            (place, lens.undistort_covariance(place, &circle.covariance))
        }
        None => (offset, circle.covariance),
    };
    let (x, y) = (at.0 + offset.0, at.1 + offset.1);
    let depth = 1.0 + line.0 * x + line.1 * y;
    if !(depth > 0.0) {
        return None;
    }
    let (lx, ly) = (line.0 / depth, line.1 / depth);
    // A^-1.
    let (a, b) = (circle.ellipse.a, circle.ellipse.b);
    let (s, c) = math::sincos(circle.ellipse.theta);
    let (a, b) = (a * a, b * b);
    let shape = Covariance { xx: a * c * c + b * s * s, xy: (a - b) * s * c, yy: a * s * s + b * c * c };
    let (px, py) = times(&shape, (lx, ly));
    let by_line = [[(lx * x - 1.0) / depth, lx * y / depth], [ly * x / depth, (ly * y - 1.0) / depth]];
    let least = LEAST * LEAST * a;
    let Covariance { xx, xy, yy } = covariance;
    Some(Pole {
        place: (offset.0 - px, offset.1 - py),
        slope: product(&shape, &by_line),
        weight: inverse(&Covariance { xx: xx + least, xy, yy: yy + least })?,
    })
}

/// a + k b.
fn sum(a: &Square, k: f32, b: &Square) -> Square {
    let entry = |i: usize, j: usize| a[i][j] + k * b[i][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

fn times(m: &Covariance, (x, y): (f32, f32)) -> (f32, f32) {
    (m.xx * x + m.xy * y, m.xy * x + m.yy * y)
}

fn product(m: &Covariance, [[a, b], [c, d]]: &Square) -> Square {
    [[m.xx * a + m.xy * c, m.xx * b + m.xy * d], [m.xy * a + m.yy * c, m.xy * b + m.yy * d]]
}

/// `None` unless positive definite.
fn inverse(m: &Covariance) -> Option<Covariance> {
    let det = m.xx * m.yy - m.xy * m.xy;
    (m.xx > 0.0 && det > 0.0).then(|| Covariance { xx: m.yy / det, xy: -m.xy / det, yy: m.xx / det })
}
