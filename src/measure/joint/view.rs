//! A stored crossing as the model has it.

use super::exact;
use super::part::Residuals;
use super::samples::{Far, Samples, Stretch};
use super::scene::{self, Beside, Scene, Seen, Track};
use super::series::Series;
use crate::appearance::Saddle;
use crate::edge::{normal_fixed, normal_near};
use crate::fit::Passage;
use crate::fixed::{GREY, ONE, PX, fixed, scale};
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
const OVER: i32 = (scene::OVER * PX as f32) as i32;

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
    exact: Option<&'s exact::Place>,
    passage: Passage,
    /// Where the level of one half is, standard deviations of the blur towards light.
    lead: i32,
    /// How far the near samples and the nearest pixels of the far stretches are beyond that, by the circle that fits the edge where
    /// the axis passes it; and how that changes with the distance, 1/px.
    beyond: [i32; NEAR + 2],
    sharpness: i32,
    /// 1 where the axis leads towards light, else -1.
    sign: i32,
    /// Light at the middle; dark and the contrast there, grey levels with [`ONE`] and 64 times their unit.
    light: i32,
    dark: i32,
    contrast: i32,
}

impl<'s> View<'s> {
    /// `None` where the crossing is none of the outline's. `room` is for what a lens makes of it.
    #[inline]
    pub fn new(
        scene: &'s Scene<'s>,
        track: &'s Track<'s>,
        crossing: &'s Crossing,
        origin: &Origin,
        room: &'s mut Option<exact::Place>,
    ) -> Option<Self> {
        let (axis, rising, place) = (crossing.axis(), crossing.is_rising(), crossing.middle(origin.pixel));
        // Along and across the axis.
        let middle = if axis == Axis::Row { place } else { (place.1, place.0) };
        let passage = if origin.lens().is_some() {
            let (exact, passage) = exact::Place::with_passage(axis, middle, origin, track.own.outline)?;
            *room = Some(exact);
            passage
        } else {
            track.own.line(axis).passage(middle)?
        };
        let (cosine, change) = (passage.cosines.0, passage.change.0);
        let near = scale(passage.at.abs(), cosine.abs()) <= MAX_DISTANCE;
        let wide =
            track.own.saddle.is_some() || 4 * MIN_HALF_CHORD.1 * cosine.abs() >= MIN_HALF_CHORD.0 * change;
        if rising != ((cosine > 0) == track.dark_inside) || !near || !wide {
            return None;
        }
        let bend = if track.dark_inside { passage.bend } else { -passage.bend };
        let light = scene.light(place);
        let (lead, sign) = (scene.lead(bend), if rising { 1 } else { -1 });
        let series = Series::new(scene.sharpness, (cosine.abs(), bend), track.own.tight);
        Some(Self {
            scene,
            track,
            crossing,
            axis,
            middle,
            exact: room.as_ref(),
            lead,
            beyond: series.beyond(-sign * passage.at, sign, lead),
            sharpness: series.first >> 1,
            passage,
            sign,
            light,
            dark: scene.dark * light,
            contrast: (scene.contrast * light) >> 8,
        })
    }

    /// Which of the near samples are nearer to this edge than to its other side, on the steeper axis.
    #[inline]
    pub fn owns(&self) -> [bool; NEAR] {
        self.passage.owns(FIRST)
    }

    /// The near samples, into a place that holds those of another crossing; perhaps none of them counts here.
    #[inline]
    pub fn samples(&self, samples: &mut Samples) {
        samples.own = self.owns();
        if self.track.own.tight || self.scene.overlapping {
            self.model_all(samples);
        } else {
            self.model(samples);
        }
        self.compare(samples);
        samples.n = NEAR as i32;
        if !self.scene.all_told || samples.own != [true; NEAR] {
            self.leave_out(samples);
        }
        samples.residuals = Residuals::new(samples);
    }

    /// The near samples in the model, where one series is good for all and only this edge has a part in them.
    #[inline]
    fn model(&self, samples: &mut Samples) {
        let [_, near @ .., _] = self.beyond;
        for i in 0..NEAR {
            let (share, density) = normal_near(near[i]);
            samples.lightness[i] = share;
            samples.by_place[i] = density;
            samples.by_blur[i] = (density * (2 * self.lead - near[i])) >> 12;
        }
    }

    /// The same for all.
    #[inline(never)]
    fn model_all(&self, samples: &mut Samples) {
        if self.track.own.tight {
            self.model_tight(samples);
        } else {
            self.model(samples);
        }
        if self.scene.overlapping {
            self.add_next(samples);
        }
    }

    /// The same where the edge bends too much for a series.
    #[inline(never)]
    fn model_tight(&self, samples: &mut Samples) {
        for i in 0..NEAR {
            let here = if samples.own[i] { self.own_deviations(i) } else { None };
            samples.own[i] = here.is_some();
            let (beyond, lead) = here.unwrap_or((0, self.lead));
            let (share, density) = normal_fixed(beyond + lead);
            samples.lightness[i] = share;
            samples.by_place[i] = density;
            samples.by_blur[i] = (density * (lead - beyond)) >> 12;
        }
    }

    /// What they are beyond that.
    #[inline]
    fn compare(&self, samples: &mut Samples) {
        let rise = self.scene.rise(self.axis);
        let mut dark = self.dark + ONE / 2 - ((5 * rise.dark) >> 1);
        let mut contrast = self.contrast + (1 << 5) - ((5 * rise.contrast) >> 1);
        for i in 0..NEAR {
            let level = (dark + (contrast >> 6) * samples.lightness[i]) >> 14;
            samples.single[i] = i32::from(self.crossing.near[i]) * GREY - level;
            dark += rise.dark;
            contrast += rise.contrast;
        }
    }

    /// Takes out the samples that are not this edge's own, and those that the ends of the scale cut off.
    #[inline(never)]
    fn leave_out(&self, samples: &mut Samples) {
        samples.n = 0;
        for i in 0..NEAR {
            let level = i32::from(self.crossing.near[i]) * GREY - samples.single[i];
            if samples.own[i] && (self.scene.all_told || self.scene.is_told(level)) {
                samples.n += 1;
            } else {
                samples.own[i] = false;
                samples.lightness[i] = 0;
                samples.by_blur[i] = 0;
                samples.by_place[i] = 0;
                samples.single[i] = 0;
            }
        }
    }

    /// How far the place `at` on the axis is beyond an outline's edge towards light, and where the level of one half is there,
    /// standard deviations of the blur. `None` far away.
    fn deviations(&self, seen: &Seen<'_>, at: i32) -> Option<(i32, i32)> {
        if let Some(saddle) = &seen.saddle {
            return Some(self.beyond_tight(saddle, seen, at));
        }
        let (depth, bend) = match self.exact {
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

    /// The same of a near sample and its own edge.
    #[inline]
    fn own_deviations(&self, i: usize) -> Option<(i32, i32)> {
        if self.track.own.tight {
            self.deviations(&self.track.own, near_place(i))
        } else {
            Some((self.beyond.get(i + 1)? - self.lead, self.lead))
        }
    }

    /// The same where the edge bends as tightly as the blur is wide.
    #[inline(never)]
    fn beyond_tight(&self, saddle: &Saddle, seen: &Seen<'_>, at: i32) -> (i32, i32) {
        let (place, areas) = match self.exact {
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
    fn add_next(&self, samples: &mut Samples) {
        let Samples { own, lightness, by_blur, .. } = samples;
        for (next, side) in self.track.beside.iter().zip([1, -1]) {
            let Some(Beside { seen, over }) = next else { continue };
            // From the sample nearest to that edge.
            for step in 0..NEAR {
                let i = if side == self.sign { NEAR - 1 - step } else { step };
                let at = near_place(i);
                // On the axis it is no less than it is away from its own edge.
                if side * self.sign * (at - self.passage.at) <= *over {
                    break;
                }
                if !own[i] {
                    continue;
                }
                let Some((z, lead)) = self.deviations(seen, at).filter(|(z, _)| side * z <= OVER) else {
                    break;
                };
                let (share, density) = normal_fixed(z + lead);
                let light = lightness[i] + if side > 0 { share - ONE } else { share };
                lightness[i] = light.clamp(-ONE / 8, ONE + ONE / 8);
                by_blur[i] += (density * (lead - z)) >> 12;
                own[i] = self.own_deviations(i).is_some_and(|(own, _)| z.abs() > own.abs());
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

    /// The middle between its inner samples, px / 2 about the origin.
    pub fn place(&self) -> (i32, i32) {
        self.place_at(0)
    }

    /// The place `at`, px / 2 from that on the axis.
    #[inline]
    fn place_at(&self, at: i32) -> (i32, i32) {
        let (along, across) = (self.middle.0 + at, self.middle.1);
        if self.axis == Axis::Row { (along, across) } else { (across, along) }
    }

    /// The far stretch before (-1) or after (1) the near samples.
    #[inline(always)]
    pub fn far(&self, side: i32) -> Stretch {
        let scene = self.scene;
        let [before, after] = self.crossing.far();
        let (log, sum) = if side < 0 { before } else { after }.sum();
        let level = (i32::from(sum) * GREY) >> log;
        if !scene.is_told(level) {
            return Stretch::Clipped;
        }
        let bright = side == self.sign;
        let tail = self.tail(side, bright, log);
        if tail >= TAIL || !self.is_clear(side, bright, log) {
            return Stretch::Mixed;
        }
        // Its middle, px / 2.
        let at = side * (6 + (1 << log));
        let rise = scene.rise(self.axis);
        let dark = self.dark + ONE / 2 + ((rise.dark * at) >> 1);
        let contrast = (self.contrast + ((rise.contrast * at) >> 1) + (1 << 5)) >> 6;
        let lightness = if bright { ONE - tail } else { tail };
        let residual = level - ((dark + contrast * lightness) >> 14);
        Stretch::Clear(Far { log, bright, residual, place: self.place_at(at) })
    }

    /// Share that a far stretch has of the edge.
    #[inline(always)]
    fn tail(&self, side: i32, bright: bool, log: u32) -> i32 {
        let z = if self.track.own.tight {
            let Some((z, lead)) = self.deviations(&self.track.own, side * FAR) else { return 0 };
            z + lead
        } else {
            let [before, .., after] = self.beyond;
            if side < 0 { before } else { after }
        };
        let z = if bright { -z } else { z };
        if z <= -OVER {
            return 0;
        }
        mean_tail(z, self.sharpness, log)
    }

    /// Whether a far stretch is clear of the other edges, and of the other side of this one.
    #[inline(always)]
    fn is_clear(&self, side: i32, bright: bool, log: u32) -> bool {
        let inwards = bright != self.track.dark_inside;
        if FAR + (PX << log) - PX + self.passage.at.abs() <= self.track.free(inwards) {
            return true;
        }
        // In px / 4.
        let first = 2 * self.middle.0 + side * 14;
        let last = first + side * (4 << log) - 4 * side;
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
