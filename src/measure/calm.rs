//! A target that nothing disturbs, circle by circle in one pass over its crossings.

use super::distances::Distances;
use super::ellipse::{Fitted, FittedList, Source, judge};
use super::origin::Origin;
use super::sectors::{SectorLight, Sectors};
use super::{Light, check_contrast};
use crate::edge::{Blur, Edges, Levels, Lines, Point, Survey};
use crate::fit::{Adjusted, Adjustment, FIELD, Frame, TERMS};
use crate::fixed::{ONE, fixed, sector};
use crate::scan::Pool;
use crate::settings::limits;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Variance of the edge points in units of what the noise explains, and beyond that, px^2: more is disturbed.
const EXPLAINED: f32 = 2.0;
const UNEXPLAINED: f32 = 0.015 * 0.015;

/// An edge after the pass.
struct Track {
    fitted: Fitted,
    /// Its step, and how much further that goes for a shift of 1 px, see [`Survey::shift`].
    step: [f32; TERMS],
    further: [[f32; TERMS]; 3],
    /// Variance of the light beside it.
    light: f32,
}

/// The ellipses of all edges into `fitted`, with the levels and the noise of a sample. `None` where anything disturbs the target.
#[inline(never)]
pub(super) fn calm(
    target: (&Edges<'_>, &Lines),
    pool: &Pool<'_>,
    origin: &Origin,
    (before, blur): (&Levels, &Blur),
    fitted: &mut FittedList,
) -> Option<(Levels, f32)> {
    let edges = target.0.edges;
    let mut survey = Survey::new(target, before, blur)?;
    let mut tracks = Vec::<Track, MAX_CIRCLES>::new();
    let mut noise = f32::INFINITY;
    for k in 0..edges.len() {
        let (track, own) = track(&mut survey, (edges, k), pool, blur)?;
        tracks.push(track).ok()?;
        noise = noise.min(own);
    }
    let levels = survey.levels()?;
    check_contrast(levels.contrast()).ok()?;
    if levels.noise > limits::DISTURBED * noise * levels.contrast() {
        return None;
    }
    let source = Source { edges, pool, origin, noise, calm: noise, blur: blur.sigma };
    for (track, edge) in tracks.iter().zip(edges) {
        let shift = survey.shift(&levels, edge)?;
        let step = core::array::from_fn(|i| {
            let further = track.further.iter().zip(shift).map(|(further, shift)| shift * further[i]);
            further.fold(track.step[i], |sum, more| sum + more)
        });
        let Adjusted { points, rms, .. } = track.fitted.adjusted;
        let shape = Frame::new(&edge.shape)?.moved(&edge.shape, &step)?;
        let adjusted = Adjusted { shape, ..track.fitted.adjusted };
        judge(&adjusted, 0, false, source.edge_variance()).ok()?;
        let adjusted = adjusted.with_variance(source.excess(points, rms, track.light));
        fitted.push(Fitted { adjusted, ..track.fitted }).ok()?;
    }
    Some((levels, noise))
}

/// What the edge points of edge `k` tell.
struct Points {
    adjustment: Adjustment,
    /// Sums of the terms, and of the second of them times the place.
    terms: [i32; TERMS],
    bent: (i32, i32),
    light: SectorLight,
    seen: Sectors,
    distances: Distances,
}

impl Points {
    #[inline]
    fn add(&mut self, point: &Point) {
        let (u, v) = point.view.place;
        let sector = sector((u, v));
        self.light.add(sector, point.excess.clamp(-128, 127) as i8);
        self.seen.mark(sector);
        self.distances.add(point.view.distance);
        let terms = self.adjustment.add(&point.view);
        for (sum, term) in self.terms.iter_mut().zip(terms) {
            *sum += term;
        }
        let [_, bent, ..] = terms;
        self.bent.0 += (bent * u) >> 7;
        self.bent.1 += (bent * v) >> 7;
    }

    /// The sums of the terms times 1, u and v: near the ellipse u^2 + v^2 is 1.
    fn fields(&self) -> [[i32; TERMS]; 3] {
        let [p, q, all, u, v] = self.terms.map(|sum| sum * FIELD);
        let (bent_u, bent_v) = self.bent;
        let (uu, uv, vv) = ((all + p) / 2, q / 2, (all - p) / 2);
        [[p, q, all, u, v], [u - bent_v, bent_u, u, uu, uv], [bent_u - v, bent_v, v, uv, vv]]
    }
}

/// Edge `k` with the noise of its samples.
#[inline(never)]
fn track(
    survey: &mut Survey<'_>,
    (edges, k): (&[crate::edge::Edge], usize),
    pool: &Pool<'_>,
    blur: &Blur,
) -> Option<(Track, f32)> {
    let edge = edges.get(k)?;
    let (_, minor) = edge.axes;
    let mut points = Points {
        adjustment: Adjustment::new(edge.shape)?,
        terms: [0; TERMS],
        bent: (0, 0),
        light: SectorLight::new(minor),
        seen: Sectors::NONE,
        distances: Distances::default(),
    };
    let tolerance = fixed(limits::MISFIT + limits::MISFIT_SIGMAS * blur.noise, ONE);
    let noise = survey.pass(k, pool, |point| {
        if point.misfit <= tolerance {
            points.add(point);
        }
    })?;
    let (even, light) = points.light.judged((noise, noise));
    let whole = points.seen.without_ends(minor);
    let (adjusted, step, further) = points.adjustment.finish_with(&points.fields())?;
    let explained = Light::edge_variance(1.0, noise, blur.sigma);
    let undisturbed = even == Sectors::ALL
        && whole == Sectors::ALL
        && points.distances.are_near(&adjusted, &step, edge.axes)
        && adjusted.rms * adjusted.rms <= EXPLAINED * explained + UNEXPLAINED;
    if !undisturbed {
        return None;
    }
    let (dark_inside, partial, cut) = (edge.dark_inside, edge.partial, edge.cut);
    let fitted =
        Fitted { adjusted, edge: k, dark_inside, partial, cut, gap: 0, ratio: 1.0, measured_ratio: 1.0 };
    Some((Track { fitted, step, further, light }, noise))
}

#[cfg(test)]
mod tests;
