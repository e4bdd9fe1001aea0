//! Centre and normal with a known camera: Gauss-Newton over the true centre and the vanishing line of the target's plane.
//!
//! Each circle tells its ellipse's centre, which the line puts beside the true centre, and its ellipse's stretch, which says
//! on which planes it can be the image of a circle ([`crate::centre::Sight`]). Seen from the front the stretch says nothing
//! of the plane's direction any more; then the centres alone are left, as without a camera. How far the light's slope, which
//! is known only so well, moves the circles is estimated along with the rest.

use super::combine::{Centre, swing};
use super::ellipse::{Fitted, FittedList};
use crate::camera::Local;
use crate::centre::{Misfit, Sight};
use crate::fit::{Factor, Frame, Matrix, Shape, dot};
use crate::math;
use crate::settings::limits;
use crate::target::Covariance;

/// Most Gauss-Newton steps.
const STEPS: usize = 8;
/// A step of the centre below this, px, is the last.
const SETTLED: f32 = 1e-4;
/// Least standard deviation in units of the ellipse: what rounding leaves in a picture without noise.
const LEAST: f32 = 5e-7;
/// Least variance of the light's shift, px^2.
const LEAST_SHIFT: f32 = 1e-10;

/// What a known camera tells of a target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// True centre, undistorted px about the origin.
    pub centre: Centre,
    /// Unit normal of its plane, towards the camera, in camera axes.
    pub normal: [f32; 3],
}

/// The centre with the camera that `lens` sees the origin with. `None` where the ellipses contradict the camera.
///
/// The two planes that an ellipse leaves are both tried, and the one between them, which is the limit of both where the
/// stretch is lost in noise. The result is their mean, weighted by how well each fits, with the distances between them in
/// its covariance. The illumination plane moves the outer ellipse with the variance `plane`, px^2.
#[inline(never)]
pub(super) fn known(circles: &FittedList, lens: &Local, plane: f32) -> Option<Known> {
    let view = View::new(circles, lens, plane)?;
    let outer = view.observe(circles.first()?)?;
    let [a, b] = outer.sight.sections().map(|section| section.line);
    let (first, second) = (view.solve(a), view.solve(b));
    let best = match (first, second) {
        (Some(a), Some(b)) if a.squares <= b.squares => a,
        (_, Some(b)) => b,
        (a, None) => a?,
    };
    let free = 4.0 * (circles.len() as f32 - 1.0);
    let excess = best.squares / free;
    // Also refuses NaN.
    if !(excess <= limits::CAMERA_MISFIT) {
        return None;
    }
    let between = view.at_line((0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1)), &best);
    let mean = best.mean(&[first, second, between]);
    let inflation = (excess / limits::CAMERA_INFLATION).max(1.0);
    let (nx, ny, nz) = outer.sight.normal(best.line);
    Some(Known { centre: view.centre(&mean, inflation), normal: [nx, ny, nz] })
}

/// The circles as a camera with square pixels sees them: rows stretched to the scale of columns.
struct View<'c> {
    circles: &'c FittedList,
    outer: Shape,
    /// The origin from the principal point, px.
    at: (f32, f32),
    focal_length: f32,
    /// fx / fy.
    aspect: f32,
    /// 1 / variance of the light's shift, 1/px^2.
    steadiness: f32,
}

/// A circle about the outer ellipse's centre.
struct Observed {
    sight: Sight<f32>,
    frame: Frame,
    /// Its ellipse's centre.
    place: (f32, f32),
    weights: Factor<4>,
}

/// A plane that fits.
#[derive(Clone, Copy)]
struct Solution {
    /// True centre about the outer ellipse's centre, px.
    centre: (f32, f32),
    covariance: Covariance,
    /// How far the light moves the outer ellipse, px.
    shift: (f32, f32),
    /// Vanishing line about the outer ellipse's centre, 1/px.
    line: (f32, f32),
    /// Sum of squared residuals in units of their variance.
    squares: f32,
}

impl<'c> View<'c> {
    fn new(circles: &'c FittedList, lens: &Local, plane: f32) -> Option<Self> {
        let (fx, fy) = lens.camera().focal_lengths();
        let aspect = fx / fy;
        let (x, y) = lens.off_axis();
        let outer = circles.first()?.adjusted.shape;
        Some(Self {
            circles,
            outer,
            at: (x, aspect * y),
            focal_length: fx,
            aspect,
            steadiness: 1.0 / (plane + LEAST_SHIFT),
        })
    }

    fn observe(&self, circle: &Fitted) -> Option<Observed> {
        let shape = circle.adjusted.shape;
        let Frame { l0, l1, l2 } = Frame::new(&shape)?;
        let frame = Frame { l0, l1: l1 / self.aspect, l2: l2 / self.aspect };
        let at = (self.at.0 + shape.cx, self.at.1 + self.aspect * shape.cy);
        let mut covariance = circle.adjusted.frame_covariance;
        for k in 0..4 {
            covariance[k][k] += LEAST * LEAST;
        }
        Some(Observed {
            sight: Sight::new((frame.l0, frame.l1, frame.l2), at, self.focal_length),
            frame,
            place: (shape.cx - self.outer.cx, self.aspect * (shape.cy - self.outer.cy)),
            weights: Factor::new(&covariance)?,
        })
    }

    /// The plane that fits best near the one with the vanishing line `line`.
    fn solve(&self, (lx, ly): (f32, f32)) -> Option<Solution> {
        let mut x = [0.0, 0.0, 0.0, 0.0, lx, ly];
        for step in 1..=STEPS {
            let normal = self.normal(&x)?;
            let factor = Factor::new(&normal.m)?;
            let change = factor.solve(normal.right);
            for (x, change) in x.iter_mut().zip(change) {
                *x += change;
            }
            if change[0].abs() + change[1].abs() < SETTLED || step == STEPS {
                let [cx, cy, tx, ty, lx, ly] = x;
                let [xx, xy, ..] = factor.solve([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                let [_, yy, ..] = factor.solve([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
                return Some(Solution {
                    centre: (cx, cy),
                    covariance: Covariance { xx, xy, yy },
                    shift: (tx, ty),
                    line: (lx, ly),
                    squares: (normal.squares - dot(&change, &normal.right)).max(0.0),
                });
            }
        }
        None
    }

    /// The best centre with a given line, from `like`, which fits better; the covariance is that of `like`.
    fn at_line(&self, line: (f32, f32), like: &Solution) -> Option<Solution> {
        let ((cx, cy), (tx, ty)) = (like.centre, like.shift);
        let Normal { m: [a, b, c, d, ..], right, squares } =
            self.normal(&[cx, cy, tx, ty, line.0, line.1])?;
        let [r0, r1, r2, r3, ..] = right;
        let right = [r0, r1, r2, r3];
        let rows = [a, b, c, d].map(|[x, y, z, w, ..]| [x, y, z, w]);
        let change = Factor::new(&rows)?.solve(right);
        let squares = (squares - dot(&change, &right)).max(like.squares);
        Some(Solution { centre: (cx + change[0], cy + change[1]), line, squares, ..*like })
    }

    /// The normal equations at the estimate `x`.
    fn normal(&self, x: &[f32; 6]) -> Option<Normal> {
        let mut normal = Normal::default();
        for circle in self.circles {
            normal.add(&self.observe(circle)?, swing(circle), x)?;
        }
        for k in 2..4 {
            normal.m[k][k] += self.steadiness;
            normal.right[k] -= self.steadiness * x[k];
            normal.squares += self.steadiness * x[k] * x[k];
        }
        Some(normal)
    }

    /// Back to the pixels as they are.
    fn centre(&self, solution: &Solution, inflation: f32) -> Centre {
        let Solution { centre, covariance, .. } = *solution;
        let row = 1.0 / self.aspect;
        Centre {
            x: self.outer.cx + centre.0,
            y: self.outer.cy + row * centre.1,
            covariance: Covariance {
                xx: inflation * covariance.xx,
                xy: inflation * row * covariance.xy,
                yy: inflation * row * row * covariance.yy,
            },
            // The light is in the covariance.
            swing: 0.0,
        }
    }
}

impl Solution {
    /// Mean of `all`, each with its likelihood against this one's.
    fn mean(&self, all: &[Option<Self>]) -> Self {
        let mut sum = Moments::default();
        for one in all.iter().flatten() {
            sum.add(math::exp(0.5 * (self.squares - one.squares)), one, self.centre);
        }
        let each = 1.0 / sum.weight;
        let (x, y) = (each * sum.x, each * sum.y);
        Self {
            centre: (self.centre.0 + x, self.centre.1 + y),
            covariance: Covariance {
                xx: each * sum.xx - x * x,
                xy: each * sum.xy - x * y,
                yy: each * sum.yy - y * y,
            },
            ..*self
        }
    }
}

/// Weighted sums of solutions about a place.
#[derive(Default)]
struct Moments {
    weight: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
}

impl Moments {
    fn add(&mut self, weight: f32, one: &Solution, about: (f32, f32)) {
        let (dx, dy) = (one.centre.0 - about.0, one.centre.1 - about.1);
        self.weight += weight;
        self.x += weight * dx;
        self.y += weight * dy;
        self.xx += weight * (dx * dx + one.covariance.xx);
        self.xy += weight * (dx * dy + one.covariance.xy);
        self.yy += weight * (dy * dy + one.covariance.yy);
    }
}

/// Normal equations for changes of (centre x, y, light's shift x, y, line x, y).
#[derive(Default)]
struct Normal {
    m: Matrix<6>,
    right: [f32; 6],
    squares: f32,
}

impl Normal {
    /// Adds a circle, which the light moves by `swing`, as seen from the estimate. `None` where the line passes through it.
    fn add(&mut self, circle: &Observed, swing: f32, &[cx, cy, tx, ty, lx, ly]: &[f32; 6]) -> Option<()> {
        let Observed { sight, frame, place: (px, py), weights } = circle;
        // The line about this ellipse's centre, and how that changes with the line.
        let depth = 1.0 + lx * px + ly * py;
        if !(depth > 0.0) {
            return None;
        }
        let (x, y) = (lx / depth, ly / depth);
        let s = sight.in_frame((x, y));
        let by_x = sight.in_frame(((1.0 - x * px) / depth, -y * px / depth));
        let by_y = sight.in_frame((-x * py / depth, (1.0 - y * py) / depth));
        let Misfit { stretch, slope: (re, im) } = sight.misfit(s);
        let (u, v) = frame.vector(cx - px + swing * tx, cy - py + swing * ty);
        let residual = [stretch.0, stretch.1, u + s.0, v + s.1];
        let Frame { l0, l1, l2 } = *frame;
        let columns = [
            [0.0, 0.0, l0, 0.0],
            [0.0, 0.0, l1, l2],
            [0.0, 0.0, swing * l0, 0.0],
            [0.0, 0.0, swing * l1, swing * l2],
            [re * by_x.0 - im * by_x.1, im * by_x.0 + re * by_x.1, by_x.0, by_x.1],
            [re * by_y.0 - im * by_y.1, im * by_y.0 + re * by_y.1, by_y.0, by_y.1],
        ];
        for i in 0..6 {
            let weighted = weights.solve(columns[i]);
            for j in 0..=i {
                self.m[i][j] += dot(&weighted, &columns[j]);
            }
            self.right[i] -= dot(&weighted, &residual);
        }
        self.squares += dot(&weights.solve(residual), &residual);
        Some(())
    }
}

#[cfg(test)]
mod tests;
