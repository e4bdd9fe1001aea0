//! Fitted ellipses to a centre with its covariance: the forms of [`crate::centre`] applied.

use core::hint::black_box;

use super::ellipse::{Fitted, FittedList};
use crate::centre::{Significance, Weights, mean, perspective, weights};
use crate::fit::Adjusted;
use crate::list::rolled;
use crate::target::{Covariance, MAX_CIRCLES};
use heapless::Vec;

/// A centre with its covariance, about the origin, px.
#[derive(Clone, Copy, Debug)]
pub(super) struct Centre {
    pub x: f32,
    pub y: f32,
    pub covariance: Covariance,
    /// How far it moves when uneven light moves the outer ellipse by 1 px: edges of opposite polarity move apart.
    pub swing: f32,
}

impl Centre {
    pub fn of(circle: &Fitted) -> Self {
        let Adjusted { shape, covariance, .. } = circle.adjusted;
        Self { x: shape.cx, y: shape.cy, covariance, swing: swing(circle) }
    }

    /// Its covariance with that of the illumination plane, which moves the outer ellipse with the variance `plane`, px^2.
    pub fn total_covariance(&self, plane: f32) -> Covariance {
        let added = plane * self.swing * self.swing;
        let Covariance { xx, xy, yy } = self.covariance;
        Covariance { xx: xx + added, xy, yy: yy + added }
    }

    /// Where the line through this centre and the ellipse centres puts that of the circle with `ratio`: B = C + K g, with K
    /// by least squares.
    #[inline(never)]
    pub fn at(&self, ratio: f32, t: f32, circles: &FittedList) -> (f32, f32) {
        let g = |ratio: f32| ratio * ratio / (1.0 - t * ratio * ratio);
        let (mut kx, mut ky, mut norm) = (0.0, 0.0, 0.0);
        for circle in rolled(circles) {
            let weight = g(circle.ratio) / variance(circle);
            kx += weight * (circle.adjusted.shape.cx - self.x);
            ky += weight * (circle.adjusted.shape.cy - self.y);
            norm += weight * g(circle.ratio);
        }
        (self.x + g(ratio) * kx / norm, self.y + g(ratio) * ky / norm)
    }

    /// Mean square of the ellipse centres' distances from the line in units of their variance, where it is above 1: three
    /// or more circles show errors that the residuals of each alone do not.
    #[inline(never)]
    fn misfit(&self, circles: &FittedList, t: f32) -> f32 {
        let Some(free) = circles.len().checked_sub(2).filter(|&free| free > 0) else { return 1.0 };
        let squares = rolled(circles).fold(0.0, |sum, circle| {
            let (x, y) = self.at(circle.ratio, t, circles);
            let (dx, dy) = (circle.adjusted.shape.cx - x, circle.adjusted.shape.cy - y);
            sum + (dx * dx + dy * dy) / variance(circle)
        });
        (squares / free as f32).max(1.0)
    }

    fn scale(&mut self, factor: f32) {
        self.covariance.xx *= factor;
        self.covariance.xy *= factor;
        self.covariance.yy *= factor;
    }
}

/// The true centre from the ellipse centres; `t` is the perspective, 0 for eq. (7).
#[inline(never)]
pub(super) fn combine(circles: &FittedList, t: f32) -> Option<Centre> {
    let mut centre = sum(circles, &true_weights(circles, t)?)?;
    centre.scale(centre.misfit(circles, t));
    Some(centre)
}

/// The same, the centre with the share of the correction that is significant, and that share; `plane` as for
/// [`Centre::total_covariance`].
pub(super) fn significant(circles: &FittedList, t: f32, plane: f32) -> Option<(Centre, Centre, f32)> {
    let exact = true_weights(circles, t)?;
    let plain = mean(circles.iter().map(variance))?;
    let mut difference = plain.clone();
    for (difference, exact) in rolled(difference.iter_mut().zip(&exact)) {
        *difference = exact - *difference;
    }
    let mut to = sum(circles, &exact)?;
    let excess = to.misfit(circles, t);
    to.scale(excess);
    let total = |weights: &Weights<f32>| {
        let mut centre = sum(circles, weights)?;
        centre.scale(excess);
        let Covariance { xx, xy, yy } = centre.total_covariance(plane);
        Some((centre, (xx, xy, yy)))
    };
    let (from, mean) = total(&plain)?;
    let (_, correction) = total(&difference)?;
    let outer = Centre::of(circles.first()?).total_covariance(plane);
    let Significance { share, unsure } =
        Significance::new((to.x - from.x, to.y - from.y), correction, mean.0 + mean.2, outer.xx + outer.yy);
    let mut weights = plain;
    for (weight, difference) in rolled(weights.iter_mut().zip(&difference)) {
        *weight += share * difference;
    }
    let (mut centre, _) = total(&weights)?;
    centre.covariance.xx += unsure * correction.0;
    centre.covariance.xy += unsure * correction.1;
    centre.covariance.yy += unsure * correction.2;
    Some((to, centre, share))
}

#[inline(never)]
fn true_weights(circles: &FittedList, t: f32) -> Option<Weights<f32>> {
    let mut inputs = Vec::<(f32, f32), MAX_CIRCLES>::new();
    for circle in rolled(circles) {
        inputs.push((circle.ratio, variance(circle))).ok()?;
    }
    // A length that the compiler does not know: it would unroll all loops over up to eight circles.
    weights(black_box(&inputs), t)
}

/// The weighted sum of the ellipse centres about the outer one: a place where the weights sum to 1.
#[inline(never)]
fn sum(circles: &FittedList, weights: &Weights<f32>) -> Option<Centre> {
    let outer = circles.first()?.adjusted.shape;
    let mut centre = Centre { x: outer.cx, y: outer.cy, covariance: Covariance::default(), swing: 0.0 };
    for (weight, circle) in rolled(weights.iter().zip(circles)) {
        let Adjusted { shape, covariance, .. } = circle.adjusted;
        // Only differences of centres count, which keeps the digits of small ones.
        centre.x += weight * (shape.cx - outer.cx);
        centre.y += weight * (shape.cy - outer.cy);
        centre.swing += weight * swing(circle);
        let square = weight * weight;
        centre.covariance.xx += square * covariance.xx;
        centre.covariance.xy += square * covariance.xy;
        centre.covariance.yy += square * covariance.yy;
    }
    Some(centre)
}

/// Variance of a circle's ellipse centre, both coordinates together. A picture without noise has none, and the weights
/// need one.
fn variance(circle: &Fitted) -> f32 {
    circle.adjusted.covariance.xx + circle.adjusted.covariance.yy + 1e-12
}

/// How far uneven light moves an ellipse where it moves the outer one by 1 px.
pub(super) fn swing(circle: &Fitted) -> f32 {
    if circle.dark_inside { circle.ratio } else { -circle.ratio }
}

/// t of [`crate::centre::perspective`] from the outer and the innermost circle.
#[inline(never)]
pub(super) fn measured_perspective(circles: &FittedList) -> Option<f32> {
    let (outer, inner) = (circles.first()?.adjusted.shape, circles.last()?);
    let small = inner.adjusted.shape;
    Some(perspective(outer.square(small.cx - outer.cx, small.cy - outer.cy), inner.ratio))
}
