//! The ellipses of concentric circles, fitted together.
//!
//! In the frame where the outer ellipse is the unit circle and the circles' centre appears at s, the circle with `ratio` times
//! the outer radius is the conic
//!
//! |q|^2 - 1 + g (1 - s . q)^2 = w with g = (1 - ratio^2) / (1 - |s|^2) and w = 0:
//!
//! conics of concentric circles are those of the pencil that one of them and the line at infinity, taken twice, span (Kim,
//! Gurdjos, Kweon 2005, "Geometric and algebraic constraints of projected concentric circles", IEEE Trans. Pattern Anal. 27),
//! and the image of that line is the polar of s. w leaves each inner circle its own size: light, response and print displace
//! its edge all around by the same, which must not move the centre where only an arc is seen. Two circles have eight unknowns
//! in this way, instead of ten: where two fifths of both are hidden, that makes the centre twice as sure.

use super::shape::{Frame, Shape};
use super::solve::{Factor, Matrix, add_scaled, dot};
use crate::list::list;
use crate::math;
use crate::target::{Covariance, MAX_CIRCLES};
use heapless::Vec;

#[cfg(test)]
mod tests;

/// Unknowns that the circles share: the terms of the outer conic as in [`Adjustment`](super::Adjustment), and s.
const SHARED: usize = 7;
/// Farthest that the centre may appear from that of the outer ellipse, in its frame.
const FARTHEST: f32 = 0.5;

/// Concentric circles as they are seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Concentric {
    pub outer: Shape,
    frame: Frame,
    s: (f32, f32),
}

impl Concentric {
    /// With the circles' centre at `(x, y)` px. `None` if `outer` is no ellipse or the centre is not in the middle of it.
    pub fn new(outer: Shape, (x, y): (f32, f32)) -> Option<Self> {
        let frame = Frame::new(&outer)?;
        let s = frame.vector(x - outer.cx, y - outer.cy);
        // Also refuses NaN.
        (s.0 * s.0 + s.1 * s.1 < FARTHEST * FARTHEST).then_some(Self { outer, frame, s })
    }

    /// The circle with this ratio and w.
    pub fn member(&self, ratio: f32, size: f32) -> Member {
        let (sx, sy) = self.s;
        let ss = sx * sx + sy * sy;
        let left = 1.0 / (1.0 - ss);
        let g = (1.0 - ratio * ratio) * left;
        let part = g / (1.0 + g * ss);
        Member { family: *self, g, left, middle: (part * sx, part * sy), size }
    }

    /// Covariance, px^2, of the centre of the ellipse of a circle, from the one of the unknowns.
    ///
    /// In first order it lies at 1 - ratio^2 of the way to the true centre, which has the ratio 0.
    fn covariance(&self, factor: &Factor<SHARED>, variance: f32, ratio: f32) -> Covariance {
        let part = 1.0 - ratio * ratio;
        let (x, y) = (0.5 * part * self.s.0, 0.5 * part * self.s.1);
        let rows = [[-x, -y, -x, -0.5, 0.0, part, 0.0], [y, -x, -y, 0.0, -0.5, 0.0, part]];
        let [u, v] = rows.map(|row| factor.solve(row.map(|entry| variance * entry)));
        self.frame.point_covariance(dot(&u, &rows[0]), dot(&u, &rows[1]), dot(&v, &rows[1]))
    }
}

/// One of the circles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member {
    family: Concentric,
    g: f32,
    /// 1 / (1 - |s|^2).
    left: f32,
    /// Centre of its ellipse, in the frame.
    middle: (f32, f32),
    size: f32,
}

/// A point as one of the circles sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MemberView {
    /// From the centre of the circle's ellipse, in the frame of the outer one.
    pub u: f32,
    pub v: f32,
    /// In that frame.
    place: (f32, f32),
    /// Half of the conic's gradient there.
    gradient: (f32, f32),
    residual: f32,
    /// 1 / squared gradient of the conic in the image, px^2.
    weight: f32,
}

impl MemberView {
    /// Signed distance from the ellipse, px, to first order; positive outside.
    pub fn distance(&self) -> f32 {
        math::sqrt(self.weight) * self.residual
    }
}

impl Member {
    /// The point `(x, y)` px as this circle sees it.
    pub fn view(&self, x: f32, y: f32) -> MemberView {
        let Concentric { outer, frame, s } = self.family;
        let (u, v) = frame.vector(x - outer.cx, y - outer.cy);
        let depth = 1.0 - s.0 * u - s.1 * v;
        let (gu, gv) = (u - self.g * depth * s.0, v - self.g * depth * s.1);
        let (gx, gy) = (frame.l0 * gu, frame.l1 * gu + frame.l2 * gv);
        MemberView {
            u: u - self.middle.0,
            v: v - self.middle.1,
            place: (u, v),
            gradient: (gu, gv),
            residual: u * u + v * v - 1.0 + self.g * depth * depth - self.size,
            weight: 0.25 / (gx * gx + gy * gy),
        }
    }

    /// Change of the conic at a point with the shared unknowns.
    fn terms(&self, view: &MemberView) -> [f32; SHARED] {
        let ((u, v), (gu, gv), s) = (view.place, view.gradient, self.family.s);
        let depth = 1.0 - s.0 * u - s.1 * v;
        let by_s = |s: f32, place: f32| 2.0 * self.g * depth * (depth * self.left * s - place);
        [u * gu - v * gv, v * gu + u * gv, u * gu + v * gv, gu, gv, by_s(s.0, u), by_s(s.1, v)]
    }

    /// Its ellipse. `None` if there is none.
    pub fn shape(&self) -> Option<Shape> {
        let Concentric { outer, frame: Frame { l0, l1, l2 }, s: (sx, sy) } = self.family;
        let ss = sx * sx + sy * sy;
        // Minus the conic's value in its middle.
        let level = 1.0 + self.size - self.g / (1.0 + self.g * ss);
        if !(level > 0.0) {
            return None;
        }
        let scale = 1.0 / level;
        let (uu, uv, vv) =
            (scale * (1.0 + self.g * sx * sx), scale * self.g * sx * sy, scale * (1.0 + self.g * sy * sy));
        let (dx, dy) = self.family.frame.inverse(self.middle.0, self.middle.1);
        Some(Shape {
            cx: outer.cx + dx,
            cy: outer.cy + dy,
            axx: l0 * l0 * uu,
            axy: l0 * (l1 * uu + l2 * uv),
            ayy: l1 * l1 * uu + 2.0 * l1 * l2 * uv + l2 * l2 * vv,
        })
    }
}

/// What the points of one circle say.
#[derive(Clone, Copy, Debug)]
struct Own {
    /// Its own unknown with the shared ones, and by itself; 0 for the outer circle, which has none.
    cross: [f32; SHARED],
    square: f32,
    right: f32,
}

/// Normal equations of a step, point by point.
#[derive(Clone, Debug)]
pub(crate) struct ConcentricAdjustment {
    m: Matrix<SHARED>,
    right: [f32; SHARED],
    squares: f32,
    points: u16,
    own: Vec<Own, MAX_CIRCLES>,
}

/// What they give.
#[derive(Clone, Debug)]
pub(crate) struct ConcentricStep {
    pub family: Concentric,
    /// Change of w of each circle, in the order of the circles.
    pub sizes: Vec<f32, MAX_CIRCLES>,
    /// RMS distance of the points, px.
    pub rms: f32,
    /// Variance of a point, px^2.
    variance: f32,
    before: Concentric,
    factor: Factor<SHARED>,
}

impl ConcentricAdjustment {
    pub fn new() -> Self {
        Self { m: [[0.0; SHARED]; SHARED], right: [0.0; SHARED], squares: 0.0, points: 0, own: Vec::new() }
    }

    /// The points that follow are of the next circle, inwards.
    pub fn next_circle(&mut self) {
        let _ = self.own.push(Own { cross: [0.0; SHARED], square: 0.0, right: 0.0 });
    }

    /// Adds a point of the newest circle.
    pub fn add(&mut self, member: &Member, view: &MemberView) {
        let terms = member.terms(view);
        let is_outer = self.own.len() <= 1;
        let Some(own) = self.own.last_mut() else { return };
        for (i, (row, &term)) in self.m.iter_mut().zip(&terms).enumerate() {
            let row = row.get_mut(..=i).unwrap_or_default();
            add_scaled(row, view.weight * term, &terms);
        }
        add_scaled(&mut self.right, -view.residual, &terms.map(|term| view.weight * term));
        if !is_outer {
            add_scaled(&mut own.cross, -view.weight, &terms);
        }
        if !is_outer {
            own.square += view.weight;
            own.right += view.weight * view.residual;
        }
        self.squares += view.weight * view.residual * view.residual;
        self.points = self.points.saturating_add(1);
    }

    /// The step from `family`, for which the points were added. `None` if they do not determine it.
    pub fn finish(&self, family: &Concentric) -> Option<ConcentricStep> {
        let (mut m, mut right, mut gain) = (self.m, self.right, 0.0);
        let inner = || self.own.iter().skip(1).filter(|own| own.square > 0.0);
        for own in inner() {
            for (row, cross) in m.iter_mut().zip(&own.cross) {
                add_scaled(row, -(cross / own.square), &own.cross);
            }
            let shares = own.cross.map(|cross| cross / own.square);
            add_scaled(&mut right, -own.right, &shares);
            gain += own.right * own.right / own.square;
        }
        let factor = Factor::new(&m)?;
        let step = factor.solve(right);
        gain += dot(&step, &right);
        let squares = (self.squares - gain).max(0.0);
        let unknowns = (SHARED + inner().count()) as u16;
        let free = self.points.checked_sub(unknowns).filter(|&free| free > 0)?;
        let sizes = self.own.iter().map(|own| {
            let shared = dot(&own.cross, &step);
            if own.square > 0.0 { (own.right - shared) / own.square } else { 0.0 }
        });
        Some(ConcentricStep {
            family: family.moved(&step)?,
            sizes: list(sizes),
            rms: math::sqrt(squares / f32::from(self.points)),
            variance: squares / f32::from(free),
            before: *family,
            factor,
        })
    }
}

impl ConcentricStep {
    /// Covariance, px^2, of the ellipse centre of the circle with `ratio`; 0 is the true centre.
    pub fn covariance(&self, ratio: f32) -> Covariance {
        self.before.covariance(&self.factor, self.variance, ratio)
    }
}

impl Concentric {
    fn moved(&self, step: &[f32; SHARED]) -> Option<Self> {
        let &[a, b, c, d, e, su, sv] = step;
        // The new frame's place of s, in the old one.
        let (u, v) = self.s;
        let x = u + su - 0.5 * ((a + c) * u + b * v + d);
        let y = v + sv - 0.5 * (b * u + (c - a) * v + e);
        let (dx, dy) = self.frame.inverse(x, y);
        let outer = self.frame.moved(&self.outer, &[a, b, c, d, e])?;
        Self::new(outer, (self.outer.cx + dx, self.outer.cy + dy))
    }
}
