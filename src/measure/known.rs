//! Centre and normal with a known camera: Gauss-Newton over the true centre and the vanishing line of the target's plane.
//!
//! Each circle tells its ellipse's centre, which the line puts beside the true centre, and its ellipse's stretch, which says
//! on which planes it can be the image of a circle ([`crate::centre::Sight`]). Seen from the front the stretch says nothing
//! of the plane's direction any more; then the centres alone are left, as without a camera.

use super::combine::{Centre, swing};
use super::ellipse::{Fitted, FittedList};
use crate::camera::Local;
use crate::centre::{Misfit, Sight};
use crate::fit::{Factor, Frame, Matrix, Shape};
use crate::math;
use crate::settings::limits;
use crate::target::Covariance;

/// Most Gauss-Newton steps.
const STEPS: usize = 8;
/// A step of the centre below this, px, is the last.
const SETTLED: f32 = 1e-4;
/// Least standard deviation in units of the ellipse: what rounding leaves in a picture without noise.
const LEAST: f32 = 5e-7;

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
/// its covariance.
pub(super) fn known(circles: &FittedList, lens: &Local) -> Option<Known> {
    let view = View::new(circles, lens)?;
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
    /// Vanishing line about that, 1/px.
    line: (f32, f32),
    covariance: Covariance,
    swing: f32,
    /// Sum of squared residuals in units of their variance.
    squares: f32,
}

impl<'c> View<'c> {
    fn new(circles: &'c FittedList, lens: &Local) -> Option<Self> {
        let (fx, fy) = lens.camera().focal_lengths();
        let aspect = fx / fy;
        let (x, y) = lens.from_principal_point();
        let outer = circles.first()?.adjusted.shape;
        Some(Self { circles, outer, at: (x, aspect * y), focal_length: fx, aspect })
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
    fn solve(&self, line: (f32, f32)) -> Option<Solution> {
        let mut x = [0.0, 0.0, line.0, line.1];
        for step in 1..=STEPS {
            let mut normal = Normal::default();
            for circle in self.circles {
                normal.add(&self.observe(circle)?, swing(circle), &x)?;
            }
            let factor = Factor::new(&normal.m)?;
            let change = factor.solve(normal.right);
            for (x, change) in x.iter_mut().zip(change) {
                *x += change;
            }
            let [cx, cy, lx, ly] = x;
            if change[0].abs() + change[1].abs() < SETTLED || step == STEPS {
                let gain = change.iter().zip(normal.right).fold(0.0, |sum, (c, r)| sum + c * r);
                let [xx, xy, ..] = factor.solve([1.0, 0.0, 0.0, 0.0]);
                let [_, yy, ..] = factor.solve([0.0, 1.0, 0.0, 0.0]);
                let [swing_x, ..] = factor.solve(normal.push_x);
                let [_, swing_y, ..] = factor.solve(normal.push_y);
                return Some(Solution {
                    centre: (cx, cy),
                    line: (lx, ly),
                    covariance: Covariance { xx, xy, yy },
                    swing: 0.5 * (swing_x + swing_y),
                    squares: (normal.squares - gain).max(0.0),
                });
            }
        }
        None
    }

    /// The best centre with a given line; covariance and swing are those of `like`, which fits better.
    fn at_line(&self, line: (f32, f32), like: &Solution) -> Option<Solution> {
        let mut normal = Normal::default();
        let (cx, cy) = like.centre;
        for circle in self.circles {
            normal.add(&self.observe(circle)?, swing(circle), &[cx, cy, line.0, line.1])?;
        }
        let [[xx, ..], [yx, yy, ..], ..] = normal.m;
        let [x, y, ..] = normal.right;
        let [dx, dy] = Factor::new(&[[xx, 0.0], [yx, yy]])?.solve([x, y]);
        let squares = (normal.squares - dx * x - dy * y).max(like.squares);
        Some(Solution { centre: (cx + dx, cy + dy), line, squares, ..*like })
    }

    /// Back to the pixels as they are.
    fn centre(&self, solution: &Solution, inflation: f32) -> Centre {
        let Solution { centre, covariance, swing, .. } = *solution;
        let row = 1.0 / self.aspect;
        Centre {
            x: self.outer.cx + centre.0,
            y: self.outer.cy + row * centre.1,
            covariance: Covariance {
                xx: inflation * covariance.xx,
                xy: inflation * row * covariance.xy,
                yy: inflation * row * row * covariance.yy,
            },
            swing,
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
            swing: each * sum.swing,
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
    swing: f32,
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
        self.swing += weight * one.swing;
    }
}

/// Normal equations for changes of (centre x, y, line x, y).
#[derive(Default)]
struct Normal {
    m: Matrix<4>,
    right: [f32; 4],
    /// Right-hand sides for a light that moves the outer ellipse by 1 px along x and y.
    push_x: [f32; 4],
    push_y: [f32; 4],
    squares: f32,
}

impl Normal {
    /// Adds a circle as seen from the estimate `x`. `None` where the line passes through it.
    fn add(&mut self, circle: &Observed, swing: f32, &[cx, cy, lx, ly]: &[f32; 4]) -> Option<()> {
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
        let (u, v) = frame.vector(cx - px, cy - py);
        let residual = [stretch.0, stretch.1, u + s.0, v + s.1];
        let columns = [
            [0.0, 0.0, frame.l0, 0.0],
            [0.0, 0.0, frame.l1, frame.l2],
            [re * by_x.0 - im * by_x.1, im * by_x.0 + re * by_x.1, by_x.0, by_x.1],
            [re * by_y.0 - im * by_y.1, im * by_y.0 + re * by_y.1, by_y.0, by_y.1],
        ];
        let dot = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b);
        let [along_x, along_y, ..] = columns;
        for i in 0..4 {
            let weighted = weights.solve(columns[i]);
            for j in 0..=i {
                self.m[i][j] += dot(&weighted, &columns[j]);
            }
            self.right[i] -= dot(&weighted, &residual);
            self.push_x[i] += swing * dot(&weighted, &along_x);
            self.push_y[i] += swing * dot(&weighted, &along_y);
        }
        self.squares += dot(&weights.solve(residual), &residual);
        Some(())
    }
}

#[cfg(test)]
mod tests;
