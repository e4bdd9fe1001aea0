//! A stored crossing as the model has it.

use super::arrow::{Place, Sums};
use super::exact;
use super::fixed::{GREY, ONE, PX, scale};
use super::line::Passage;
use super::scene::{Scene, Track};
use crate::edge::normal_fixed;
use crate::measure::Origin;
use crate::scan::{Axis, Crossing, NEAR, Stretch};

/// Farthest that a crossing may lie from its outline's ellipse, px.
const MAX_DISTANCE: i32 = 2 * PX;
/// Least distance on the axis from an edge to the middle between it and the other side of its own circle, px, times the change of
/// the cosine for 1 px.
const MIN_HALF_CHORD: (i32, i32) = (5, 2);
/// Place of the first near sample on the axis from their middle, px, ...
const FIRST: i32 = -5 * PX / 2;
/// ... and of the pixels of the far stretches nearest to it.
const FAR: i32 = 7 * PX / 2;
/// Share that a stretch may have of its own edge to tell the levels, ...
const TAIL: i32 = ONE * 2 / 25;
/// ... which is over beyond this, standard deviations of the blur.
const OVER: i32 = 7 * PX / 2;

/// A crossing, its edge and the model.
pub(super) struct View<'s> {
    scene: &'s Scene<'s>,
    track: &'s Track<'s>,
    crossing: &'s Crossing,
    axis: Axis,
    /// The middle between its inner samples about the origin, px / 2, along and across the axis.
    middle: (i32, i32),
    /// In the undistorted plane, where something needs it.
    exact: Option<exact::Place>,
    passage: Passage,
    /// Half the curvature, 1/px, positive where the edge bends away from light.
    bend: i32,
    /// 1 where the axis leads towards light, else -1.
    sign: i32,
    /// Light at the middle; and its change along the axis, 1/px, with 64 times its unit.
    light: i32,
    slope: i32,
}

/// What the near samples tell.
pub(super) struct Samples {
    pub sums: Sums,
    /// Largest residual.
    pub misfit: i32,
    /// Twice what light there is too much beside the edge.
    pub excess: i32,
}

/// A far stretch that is clear of edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Far {
    /// Binary logarithm of its number of pixels.
    pub log: u32,
    /// On the light side.
    pub bright: bool,
    /// Level of the model without the plane of light, and what the stretch has beyond it.
    pub mixed: i32,
    pub residual: i32,
    pub light: i32,
    pub place: Place,
}

impl<'s> View<'s> {
    /// `None` where the crossing is none of the outline's.
    #[inline]
    pub fn new(
        scene: &'s Scene<'s>,
        track: &'s Track<'s>,
        crossing: &'s Crossing,
        origin: &Origin,
    ) -> Option<Self> {
        let x = i32::from(crossing.x) - i32::from(origin.pixel.0);
        let y = i32::from(crossing.y()) - i32::from(origin.pixel.1);
        let axis = crossing.axis();
        let row = axis == Axis::Row;
        let [_, n0, n1, n2, n3, _] = crossing.near.map(u16::from);
        let rising = n2 + n3 > n0 + n1;
        let (middle, slope) = if row {
            ((2 * x - 1, 2 * y), scene.slopes)
        } else {
            ((2 * y - 1, 2 * x), (scene.slopes.1, scene.slopes.0))
        };
        let needs = scene.tight || origin.lens().is_some();
        let exact = if needs { Some(exact::Place::new(axis, middle, origin)?) } else { None };
        let passage = match &exact {
            Some(exact) if origin.lens().is_some() => exact.passage(track.outline)?,
            _ => {
                let line = track.line(axis);
                line.passage(line.from_centre(middle))?
            }
        };
        let (cosine, change) = (passage.cosines.0, passage.change.0);
        let near = scale(passage.at.abs(), cosine.abs()) <= MAX_DISTANCE;
        let wide = 4 * MIN_HALF_CHORD.1 * cosine.abs() >= MIN_HALF_CHORD.0 * change;
        if rising != ((cosine > 0) == track.dark_inside) || !near || !wide {
            return None;
        }
        let light = ONE + ((slope.0 * middle.0 + slope.1 * middle.1) >> 7);
        Some(Self {
            scene,
            track,
            crossing,
            axis,
            middle,
            exact,
            bend: if track.dark_inside { passage.bend } else { -passage.bend },
            passage,
            sign: if rising { 1 } else { -1 },
            light: light.clamp(ONE / 4, ONE * 3 / 2),
            slope: slope.0,
        })
    }

    /// Distance towards light of the place `at`, and half the curvature there, positive where the edge bends away from light.
    #[inline]
    fn depth(&self, at: i32) -> (i32, i32) {
        match &self.exact {
            Some(exact) if self.scene.tight => exact.depth(self.track.outline, at),
            _ => (self.depth_of_circle(at), self.bend),
        }
    }

    /// The distance from the circle that fits the edge where the axis passes it: its series to the third order.
    #[inline]
    fn depth_of_circle(&self, at: i32) -> i32 {
        let h = self.sign * (at - self.passage.at);
        let q = scale(h, self.passage.cosines.0.abs() + ((self.bend * h) >> 14));
        let bent = (self.bend * q) >> 14;
        scale(q, ONE - scale(bent, ONE - 2 * bent))
    }

    /// Light at the place `at`, px / 2 from the middle on the axis.
    #[inline]
    fn light_at(&self, at: i32) -> i32 {
        (self.light + ((self.slope * at) >> 7)).clamp(ONE / 4, ONE * 3 / 2)
    }

    /// The near samples; `None` if none of them counts here.
    #[inline]
    pub fn samples(&self) -> Option<Samples> {
        let owns: [bool; NEAR] = self.passage.owns(FIRST);
        let mut samples = Samples { sums: Sums::default(), misfit: 0, excess: 0 };
        for i in 0..NEAR {
            if owns[i] {
                self.add_sample(i, &mut samples);
            }
        }
        (samples.sums.n > 0).then_some(samples)
    }

    #[inline]
    fn add_sample(&self, i: usize, samples: &mut Samples) {
        let scene = self.scene;
        let at = FIRST + i as i32 * PX;
        let (depth, bend) = self.depth(at);
        let (z, lead) = (scene.deviations(depth), scene.lead(bend));
        let (mut lightness, by_place) = normal_fixed(z + lead);
        let mut by_blur = (by_place * (lead - z)) >> 12;
        if let Some(exact) = &self.exact
            && scene.overlapping
        {
            // Light of the dark area beyond the edges beside this one, and dark of the light area beyond. What is nearer to them
            // is theirs.
            for (next, beyond) in self.track.near.into_iter().zip([-ONE, 0]) {
                let Some(next) = scene.outline(next) else { continue };
                let (other, bend) = exact.depth(next, at);
                if other.abs() <= depth.abs() {
                    return;
                }
                let (z, lead) = (scene.deviations(other), scene.lead(bend));
                let (share, density) = normal_fixed(z + lead);
                lightness += share + beyond;
                by_blur += (density * (lead - z)) >> 12;
            }
            lightness = lightness.clamp(-ONE / 8, ONE + ONE / 8);
        }
        let level = scale(scene.mixed(lightness), self.light_at(2 * i as i32 - 5));
        if !scene.is_told(level) {
            return;
        }
        let residual = i32::from(self.crossing.near[i]) * GREY - level;
        samples.misfit = samples.misfit.max(residual.abs());
        if i == 1 || i == NEAR - 2 {
            samples.excess += residual;
        }
        samples.sums.add(lightness, by_blur, by_place, residual);
    }

    /// Where the axis passes the edge, in the frame where that is the unit circle.
    pub fn direction(&self) -> (i32, i32) {
        self.passage.direction
    }

    pub fn reach(&self) -> i32 {
        self.passage.reach
    }

    pub fn light(&self) -> i32 {
        self.light
    }

    /// The place `at`, px / 2 from the middle on the axis.
    pub fn place(&self, at: i32) -> Place {
        let unit = |place: i32| self.scene.place(place);
        let (along, across) = (unit(self.middle.0 + at), unit(self.middle.1));
        if self.axis == Axis::Row { Place { x: along, y: across } } else { Place { x: across, y: along } }
    }

    /// The far stretches before and after the near samples, where they tell the levels; and whether one is clipped.
    pub fn far(&self) -> ([Option<Far>; 2], bool) {
        let [before, after] = self.crossing.far();
        let level = |stretch: Stretch| {
            let (log, sum) = stretch.sum();
            (log, (i32::from(sum) * GREY) >> log)
        };
        let (before, after) = (level(before), level(after));
        let told = |level: i32| self.scene.is_told(level);
        let far =
            |side, stretch: (u32, i32)| if told(stretch.1) { self.stretch(side, stretch) } else { None };
        ([far(-1, before), far(1, after)], !told(before.1) || !told(after.1))
    }

    fn stretch(&self, side: i32, (log, level): (u32, i32)) -> Option<Far> {
        let scene = self.scene;
        let bright = side == self.sign;
        let (depth, bend) = self.depth(side * FAR);
        let z = scene.deviations(depth) + scene.lead(bend);
        let z = if bright { -z } else { z };
        let along = scene.deviations(self.passage.cosines.0.abs()) >> 2;
        let tail = if z > -OVER { mean_tail(z, along, log) } else { 0 };
        // Outwards only the next edge can be near, and that at the end; inwards the next edge or the other side of this one.
        let inwards = bright != self.track.dark_inside;
        // In px / 4.
        let last = 2 * self.middle.0 + side * (14 + 4 * ((1 << log) - 1));
        let first = 2 * self.middle.0 + side * 14;
        if tail >= TAIL || !self.track.is_clear(self.axis, inwards, (first, last), 2 * self.middle.1) {
            return None;
        }
        let mixed = scene.mixed(if bright { ONE - tail } else { tail });
        // Its middle, px / 2.
        let at = side * (7 + (1 << log) - 1);
        let light = self.light_at(at);
        let residual = level - scale(mixed, light);
        Some(Far { log, bright, mixed, residual, light, place: self.place(at) })
    }
}

/// Mean share of the step over a stretch of pixels, the first of which is at `z` standard deviations, below 0, and which lead away
/// from the edge by `k` each.
fn mean_tail(z: i32, k: i32, log: u32) -> i32 {
    if log == 0 {
        return normal_fixed(z).0;
    }
    // The integral of the tail from the border of the first pixel.
    let z = z + (k >> 1);
    let (share, density) = normal_fixed(z);
    (((density + ((z * share) >> 12)) << 12) / k.max(1)) >> log
}
