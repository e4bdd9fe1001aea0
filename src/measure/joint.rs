//! Circles of which only arcs are seen: their ellipses together, as those of concentric circles.
//!
//! An arc by itself leaves its ellipse unsure across the gap, the more the less is seen. What the circles share
//! ([`Concentric`]) takes most of that away.

use super::combine::{combine, measured_perspective};
use super::ellipse::{EXPLAINED, Fitted, FittedList, NEAR, PASSES, Source, even_sectors, list};
use super::sectors::{SectorSums, Sectors};
use crate::fit::{Concentric, ConcentricAdjustment, ConcentricStep, Member, Spread};
use crate::settings::{Settings, limits};
use crate::target::{Covariance, MAX_CIRCLES};
use heapless::Vec;

/// Circles that were fitted together.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub circles: FittedList,
    /// Of the true centre, px^2.
    pub covariance: Covariance,
}

/// Which points of a circle are used.
#[derive(Clone, Copy, Debug)]
struct Gate {
    size: f32,
    sectors: u128,
    even: Sectors,
}

/// What the points of a pass tell.
struct Pass {
    step: ConcentricStep,
    /// By circle: sectors in which there are points of the edge.
    near: Vec<Sectors, MAX_CIRCLES>,
    farthest: f32,
    sigma: f32,
}

/// Fits the `circles`, which are those of one target, together. `None` if they contradict that.
#[inline(never)]
pub(super) fn joint(circles: &FittedList, source: &Source<'_, '_>, settings: &Settings) -> Option<Joint> {
    let outer = circles.first()?.adjusted.shape;
    let start = combine(circles, measured_perspective(circles)?)?;
    let mut family =
        Concentric::new(outer, (start.x, start.y)).or(Concentric::new(outer, (outer.cx, outer.cy)))?;
    let mut ratios: Vec<f32, MAX_CIRCLES> = circles.iter().map(|circle| circle.ratio).collect();
    let mut gates = Vec::<Gate, MAX_CIRCLES>::new();
    for circle in circles {
        let even =
            even_sectors(&circle.adjusted.shape, source.crossings(circle.edge), source.origin, source.noise)?;
        let _ = gates.push(Gate { size: 0.0, sectors: even.0, even });
    }
    let mut limit = f32::INFINITY;
    let free = settings.spec.ratios().is_empty();
    let mut last = None;
    for _ in 0..PASSES {
        let Pass { step, near, farthest, sigma } = pass(&family, circles, source, (&ratios, &gates, limit))?;
        let next = limits::OUTLIER * sigma;
        let mut settled = farthest <= next;
        family = step.family;
        for ((gate, near), (ratio, change)) in
            gates.iter_mut().zip(near).zip(ratios.iter_mut().zip(&step.sizes))
        {
            let sectors = near.without_ends();
            settled &= gate.sectors & !sectors == 0;
            gate.sectors = sectors;
            gate.size += change;
            // Where the ratio is not given, the size tells it.
            if free {
                *ratio = crate::math::sqrt(*ratio * *ratio + gate.size);
                gate.size = 0.0;
            }
        }
        limit = next;
        last = Some(step);
        if settled {
            break;
        }
    }
    let step = last?;
    let factor = excess(&family, circles, source, (&ratios, &gates, limit), step.rms)?;
    let mut fitted = FittedList::new();
    for ((circle, gate), &ratio) in circles.iter().zip(&gates).zip(&ratios) {
        let mut circle = Fitted { ratio, ..*circle };
        circle.adjusted.shape = family.member(ratio, gate.size).shape()?;
        circle.adjusted.covariance = step.covariance(ratio).scaled(factor);
        let _ = fitted.push(circle);
    }
    Some(Joint { circles: list(fitted.into_iter()), covariance: step.covariance(0.0).scaled(factor) })
}

type Gates<'a> = (&'a [f32], &'a [Gate], f32);

fn pass(
    family: &Concentric,
    circles: &FittedList,
    source: &Source<'_, '_>,
    (ratios, gates, limit): Gates<'_>,
) -> Option<Pass> {
    let mut adjustment = ConcentricAdjustment::new();
    let mut all = Vec::new();
    let mut spread = Spread::default();
    let mut farthest = 0.0f32;
    for ((circle, gate), &ratio) in circles.iter().zip(gates).zip(ratios) {
        let member = family.member(ratio, gate.size);
        let none = Sectors::new(member.shape()?.semi_axes().1);
        let mut near = none;
        adjustment.next_circle();
        for (x, y) in source.points(circle.edge) {
            let view = member.view(x, y);
            let distance = view.distance().abs();
            if distance > limit.max(NEAR) {
                continue;
            }
            let sector = none.sector(view.u, view.v) & gate.even.0;
            near.0 |= sector;
            if distance <= limit && gate.sectors & sector != 0 {
                adjustment.add(&member, &view);
                farthest = farthest.max(distance);
                spread.add(distance * distance);
            }
        }
        let _ = all.push(near);
    }
    let step = adjustment.finish(family)?;
    Some(Pass { step, near: all, farthest, sigma: spread.sigma() })
}

/// Largest factor on the covariance because the residuals of a circle are not independent.
fn excess(
    family: &Concentric,
    circles: &FittedList,
    source: &Source<'_, '_>,
    (ratios, gates, limit): Gates<'_>,
    rms: f32,
) -> Option<f32> {
    if rms <= EXPLAINED * source.noise {
        return Some(1.0);
    }
    let mut factor = 1.0f32;
    for ((circle, gate), &ratio) in circles.iter().zip(gates).zip(ratios) {
        let member: Member = family.member(ratio, gate.size);
        let sectors = Sectors::new(member.shape()?.semi_axes().1);
        let mut sums = SectorSums::new(circle.adjusted.points);
        for (x, y) in source.points(circle.edge) {
            let view = member.view(x, y);
            let distance = view.distance();
            if distance.abs() <= limit && gate.sectors & sectors.sector(view.u, view.v) != 0 {
                sums.add(view.u, view.v, distance);
            }
        }
        factor = factor.max(sums.excess());
    }
    Some(factor)
}
