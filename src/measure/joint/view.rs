//! A stored crossing as the model has it.

use super::arrow::{Place, Sums};
use super::exact;
use super::scene::{Scene, Seen, Track};
use crate::appearance::Saddle;
use crate::edge::normal_fixed;
use crate::fit::Passage;
use crate::fixed::{BEND, GREY, LEAST_LIGHT, MOST_LIGHT, ONE, PX, fixed, scale};
use crate::measure::Origin;
use crate::scan::{Axis, Crossing, NEAR};

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

/// Farthest that is told from each other, standard deviations of the blur with the unit of lengths.
const AWAY: f32 = 16.0 * PX as f32;

/// A crossing, its edge and the model.
pub(super) struct View<'s> {
    scene: &'s Scene<'s>,
    track: &'s Track<'s>,
    crossing: &'s Crossing,
    axis: Axis,
    /// The middle between its inner samples about the origin, px / 2, along and across the axis.
    middle: (i32, i32),
    /// In the undistorted plane, where a lens distorts the image.
    exact: Option<exact::Place>,
    passage: Passage,
    /// Half the curvature, 1/px, positive where the edge bends away from light.
    bend: i32,
    /// Standard deviations of the blur beyond the edge as a power series of the distance on the axis, px.
    series: [i32; 4],
    /// 1 where the axis leads towards light, else -1.
    sign: i32,
    /// Light at the middle; and its change along the axis, 1/px, with 64 times its unit.
    light: i32,
    slope: i32,
}

/// What the near samples tell.
pub(super) struct Samples {
    pub sums: Sums,
    /// Those that count, and their residuals.
    pub own: [bool; NEAR],
    residuals: [i32; NEAR],
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
    /// Level beyond that of the model.
    pub residual: i32,
    pub place: Place,
}

impl Samples {
    /// Differences of the residuals of the two outermost samples on either side: in them whatever changes the light over more than a
    /// pixel cancels, and so does an edge that is off.
    #[inline]
    pub fn differences(&self) -> impl Iterator<Item = i32> {
        let [a, b, .., c, d] = self.own;
        let [first, second, .., third, fourth] = self.residuals;
        [(a && b, first - second), (c && d, fourth - third)]
            .into_iter()
            .filter_map(|(both, difference)| both.then_some(difference))
    }
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
        let exact =
            if origin.lens().is_some() { Some(exact::Place::new(axis, middle, origin)?) } else { None };
        let passage = match &exact {
            Some(exact) => exact.passage(track.own.outline)?,
            None => {
                let line = track.own.line(axis);
                line.passage(line.about_centre(middle))?
            }
        };
        let (cosine, change) = (passage.cosines.0, passage.change.0);
        let near = scale(passage.at.abs(), cosine.abs()) <= MAX_DISTANCE;
        let wide =
            track.own.saddle.is_some() || 4 * MIN_HALF_CHORD.1 * cosine.abs() >= MIN_HALF_CHORD.0 * change;
        if rising != ((cosine > 0) == track.dark_inside) || !near || !wide {
            return None;
        }
        let light = ONE + ((slope.0 * middle.0 + slope.1 * middle.1 + (1 << 6)) >> 7);
        let bend = if track.dark_inside { passage.bend } else { -passage.bend };
        let cosine = cosine.abs();
        let square = scale(cosine, cosine);
        let second = (scale(bend, ONE - square) * scene.sharpness) >> 13;
        let third = -((scale(bend, cosine) * second) >> 15);
        // In 1/16 of the unit of the others, because it is small.
        let cube = || (((second * bend) >> 12) * bend + BEND / 2) >> 16;
        let fourth = if track.own.tight { 0 } else { scale(cube(), 5 * square - ONE) };
        let series = [scale(cosine, scene.sharpness), second, third, fourth];
        Some(Self {
            scene,
            track,
            crossing,
            axis,
            middle,
            exact,
            bend,
            series,
            passage,
            sign: if rising { 1 } else { -1 },
            light: light.clamp(LEAST_LIGHT, MOST_LIGHT),
            slope: slope.0,
        })
    }

    /// How far the place `at` is beyond the edge towards light, standard deviations of the blur: that from the circle that fits the
    /// edge where the axis passes it, its series to the fourth order.
    #[inline]
    fn beyond(&self, at: i32) -> i32 {
        let [first, second, third, fourth] = self.series;
        let h = self.sign * (at - self.passage.at);
        let third = third + ((h * fourth + (1 << 15)) >> 16);
        let second = second + ((h * third) >> 12);
        (h * (first + ((h * second) >> 15)) + (1 << 12)) >> 13
    }

    /// Which of the near samples are nearer to this edge than to its other side, on the steeper axis.
    #[inline]
    pub fn owns(&self) -> [bool; NEAR] {
        self.passage.owns(FIRST)
    }

    /// The near samples; `None` if none of them counts here.
    #[inline]
    pub fn samples(&self) -> Option<Samples> {
        let scene = self.scene;
        let mut own = self.owns();
        // Standard deviations of the blur: where the level of one half is, and so many beyond the edge.
        let (mut leads, mut beyond) = ([scene.lead(self.bend); NEAR], [0; NEAR]);
        for i in 0..NEAR {
            if !self.track.own.tight {
                beyond[i] = self.beyond(near_place(i));
            } else if own[i] {
                match self.deviations(&self.track.own, near_place(i)) {
                    Some(here) => (beyond[i], leads[i]) = here,
                    None => own[i] = false,
                }
            }
        }
        let (mut lightness, mut by_blur, mut by_place) = ([0; NEAR], [0; NEAR], [0; NEAR]);
        for i in 0..NEAR {
            (lightness[i], by_place[i]) = normal_fixed(beyond[i] + leads[i]);
            by_blur[i] = (by_place[i] * (leads[i] - beyond[i])) >> 12;
        }
        if scene.overlapping {
            self.add_next(&mut own, &beyond, (&mut lightness, &mut by_blur));
        }
        let (mut n, mut misfit, mut residuals) = (0, 0, [0; NEAR]);
        for i in 0..NEAR {
            let light = self.light + ((self.slope * (2 * i as i32 - 5) + (1 << 6)) >> 7);
            let level = scale(scene.mixed(lightness[i]), light);
            if own[i] && scene.is_told(level) {
                residuals[i] = i32::from(self.crossing.near[i]) * GREY - level;
                misfit = misfit.max(residuals[i].abs());
                n += 1;
            } else {
                own[i] = false;
                (lightness[i], by_blur[i], by_place[i]) = (0, 0, 0);
            }
        }
        let excess = residuals[1] + residuals[NEAR - 2];
        let sums = [&lightness, &by_blur, &by_place, &residuals];
        (n > 0).then(|| Samples { sums: Sums::new(n, sums), own, residuals, misfit, excess })
    }

    /// How far the place `at` on the axis is beyond an outline's edge towards light, and where the level of one half is there,
    /// standard deviations of the blur. `None` far away.
    fn deviations(&self, seen: &Seen<'_>, at: i32) -> Option<(i32, i32)> {
        if let Some(saddle) = &seen.saddle {
            return Some(self.beyond_tight(saddle, seen, at));
        }
        let (depth, bend) = match &self.exact {
            Some(exact) => exact.distance(seen.outline, at),
            None => {
                let line = seen.line(self.axis);
                let (along, across) = line.about_centre(self.middle);
                line.distance((along + at, across))?
            }
        };
        let (depth, bend) = if seen.outline.inside < 0.0 { (depth, bend) } else { (-depth, -bend) };
        Some((self.scene.deviations(depth), self.scene.lead(bend)))
    }

    /// The same where the edge bends as tightly as the blur is wide.
    #[inline(never)]
    fn beyond_tight(&self, saddle: &Saddle, seen: &Seen<'_>, at: i32) -> (i32, i32) {
        let (place, areas) = match &self.exact {
            Some(exact) => exact.beside_centre(seen.outline, at),
            None => {
                let (along, across) = seen.line(self.axis).about_centre(self.middle);
                let (along, across) = ((along + at) as f32 / PX as f32, across as f32 / PX as f32);
                (if self.axis == Axis::Row { (along, across) } else { (across, along) }, 1.0)
            }
        };
        let blur = self.scene.model().blur;
        let (beyond, lead) = saddle.beyond(place, blur * blur * areas);
        let inside = -seen.outline.inside * PX as f32;
        (fixed((inside * beyond).clamp(-AWAY, AWAY), 1), fixed((inside * lead).clamp(-AWAY, AWAY), 1))
    }

    /// Adds what the edges beside this one give to its samples: light of the dark area beyond, and dark of the light area beyond.
    /// Samples that are nearer to one of these are not its `own`.
    fn add_next(
        &self,
        own: &mut [bool; NEAR],
        beyond: &[i32; NEAR],
        (lightness, by_blur): (&mut [i32; NEAR], &mut [i32; NEAR]),
    ) {
        for (next, side) in self.track.beside.iter().zip([1, -1]) {
            let Some(next) = next else { continue };
            // From the sample nearest to that edge.
            for step in 0..NEAR {
                let i = if side == self.sign { NEAR - 1 - step } else { step };
                if !own[i] {
                    continue;
                }
                let Some((z, lead)) = self.deviations(next, near_place(i)).filter(|(z, _)| side * z <= OVER)
                else {
                    break;
                };
                let (share, density) = normal_fixed(z + lead);
                lightness[i] += if side > 0 { share - ONE } else { share };
                lightness[i] = lightness[i].clamp(-ONE / 8, ONE + ONE / 8);
                by_blur[i] += (density * (lead - z)) >> 12;
                own[i] = z.abs() > beyond[i].abs();
            }
        }
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

    /// The middle between its inner samples.
    pub fn place(&self) -> Place {
        self.place_at(0)
    }

    /// The place `at`, px / 2 from that on the axis.
    #[inline]
    fn place_at(&self, at: i32) -> Place {
        let (along, across) = (self.scene.place(self.middle.0 + at), self.scene.place(self.middle.1));
        if self.axis == Axis::Row { Place { x: along, y: across } } else { Place { x: across, y: along } }
    }

    /// Calls `told` with the far stretches before and after the near samples, where they tell the levels. Gives whether one is
    /// clipped.
    #[inline]
    pub fn far(&self, mut told: impl FnMut(Far)) -> bool {
        let scene = self.scene;
        let mut clipped = false;
        for (side, stretch) in [-1, 1].into_iter().zip(self.crossing.far()) {
            let (log, sum) = stretch.sum();
            let level = (i32::from(sum) * GREY) >> log;
            if !scene.is_told(level) {
                clipped = true;
                continue;
            }
            let bright = side == self.sign;
            let tail = self.tail(side, bright, log);
            if tail >= TAIL || !self.is_clear(side, bright, log) {
                continue;
            }
            let mixed = scene.mixed(if bright { ONE - tail } else { tail });
            // Its middle, px / 2.
            let at = side * (6 + (1 << log));
            let light = (self.light + ((self.slope * at) >> 7)).clamp(LEAST_LIGHT, MOST_LIGHT);
            let residual = level - scale(mixed, light);
            told(Far { log, bright, residual, place: self.place_at(at) });
        }
        clipped
    }

    /// Share that a far stretch has of the edge.
    #[inline]
    fn tail(&self, side: i32, bright: bool, log: u32) -> i32 {
        let scene = self.scene;
        let z = if self.track.own.tight {
            let Some((z, lead)) = self.deviations(&self.track.own, side * FAR) else { return 0 };
            z + lead
        } else {
            self.beyond(side * FAR) + scene.lead(self.bend)
        };
        let z = if bright { -z } else { z };
        if z <= -OVER {
            return 0;
        }
        mean_tail(z, self.series[0] >> 1, log)
    }

    /// Whether a far stretch is clear of the other edges, and of the other side of this one.
    #[inline]
    fn is_clear(&self, side: i32, bright: bool, log: u32) -> bool {
        // In px / 4.
        let first = 2 * self.middle.0 + side * 14;
        let last = first + side * (4 << log) - 4 * side;
        let inwards = bright != self.track.dark_inside;
        self.track.is_clear(self.axis, inwards, (first, last), 2 * self.middle.1)
    }
}

/// Place of a near sample on the axis, px from the middle.
fn near_place(i: usize) -> i32 {
    FIRST + i as i32 * PX
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
