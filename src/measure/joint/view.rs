//! A stored crossing as the model has it.

use super::arrow::{Sums, Told};
use super::passage::{Axes, Passage, distance, dot};
use super::scene::{Next, Scene};
use crate::appearance::Outline;
use crate::edge::{mean_tail, normal};
use crate::math;
use crate::measure::Origin;
use crate::scan::{Axis, Crossing, NEAR};

/// Farthest that a crossing may lie from its outline's ellipse, px.
const MAX_DISTANCE: f32 = 2.0;
/// Least distance on the axis from an edge to the middle between it and the other side of its own circle, px.
const MIN_HALF_CHORD: f32 = 2.5;
/// Places of the near samples on the axis from their middle, px, ...
const PLACES: [f32; NEAR] = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5];
/// ... and of the pixels of the far stretches nearest to it.
const FAR: f32 = 3.5;
/// Lightness that a stretch may have from its own edge to tell the levels, ...
const TAIL: f32 = 0.08;
/// ... which is over beyond this, ...
const OVER: f32 = 3.5;
/// ... and least distance of any other edge, standard deviations of the blur.
const CLEAR: f32 = 2.5;

/// A crossing, its edge and the model.
pub(super) struct View<'s> {
    scene: &'s Scene,
    outline: &'s Outline,
    next: Next,
    crossing: &'s Crossing,
    /// The middle between its inner samples about the origin, px: in the image and in the undistorted plane.
    seen: (f32, f32),
    middle: (f32, f32),
    axes: Axes,
    passage: Passage,
    curvature: f32,
    /// 1 where light is outside the edge, else -1.
    lightward: f32,
    /// 1 where the axis leads towards light, else -1.
    sign: f32,
    /// Light at the middle and its change along the axis, relative and 1/px.
    light: f32,
    slope: f32,
}

/// The near samples.
pub(super) struct Samples {
    /// 1 for those that count, else 0.
    pub own: [f32; NEAR],
    lightness: [f32; NEAR],
    /// Change of that with the logarithm of the blur, ...
    by_blur: [f32; NEAR],
    /// ... and with the place of the edge towards dark, in standard deviations of the blur.
    by_place: [f32; NEAR],
    /// Levels beyond those of the model.
    pub residuals: [f32; NEAR],
}

impl Samples {
    /// Largest residual.
    pub fn misfit(&self) -> f32 {
        self.residuals.iter().zip(self.own).fold(0.0, |most, (residual, own)| most.max(own * residual.abs()))
    }

    /// What light there is too much beside the edge.
    pub fn excess(&self) -> f32 {
        let ([_, a, _, _, d, _], [_, of_a, _, _, of_d, _]) = (self.residuals, self.own);
        0.5 * (of_a * a + of_d * d)
    }

    #[inline]
    pub fn sums(&self) -> Sums {
        let mut sums = Sums::default();
        for i in 0..NEAR {
            let own = self.own[i];
            let (l, b, p, r) = (self.lightness[i], self.by_blur[i], self.by_place[i], self.residuals[i]);
            let (wl, wb, wp, wr) = (own * l, own * b, own * p, own * r);
            sums.n += own;
            sums.l += wl;
            sums.ll += wl * l;
            sums.b += wb;
            sums.lb += wb * l;
            sums.bb += wb * b;
            sums.p += wp;
            sums.lp += wp * l;
            sums.bp += wp * b;
            sums.pp += wp * p;
            sums.r += wr;
            sums.lr += wr * l;
            sums.br += wr * b;
            sums.pr += wr * p;
            sums.rr += wr * r;
        }
        sums
    }
}

/// A far stretch that is clear of edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Far {
    pub pixels: f32,
    pub level: f32,
    pub lightness: f32,
    /// Its middle about the origin, px.
    pub place: (f32, f32),
}

impl<'s> View<'s> {
    /// `None` where the crossing is none of outline `k`'s.
    #[inline]
    pub fn new(scene: &'s Scene, k: usize, crossing: &'s Crossing, origin: &Origin) -> Option<Self> {
        let (outline, next) = (scene.outline(Some(k))?, *scene.next.get(k)?);
        let x = (i32::from(crossing.x) - i32::from(origin.pixel.0)) as f32;
        let y = (i32::from(crossing.y()) - i32::from(origin.pixel.1)) as f32;
        let row = crossing.axis() == Axis::Row;
        let seen = if row { (x - 0.5, y) } else { (x, y - 0.5) };
        let middle = origin.place(seen)?;
        let [xx, xy, yx, yy] = origin.slope(middle);
        let (column, other) = ((xx, yx), (xy, yy));
        let axes =
            if row { Axes { along: column, across: other } } else { Axes { along: other, across: column } };
        let passage = Passage::new(&outline.shape, middle, &axes)?;
        let [_, n0, n1, n2, n3, _] = crossing.near.map(u16::from);
        let (rising, dark_inside) = (n2 + n3 > n0 + n1, outline.inside < 0.0);
        let near = passage.at.abs() * passage.cosine <= MAX_DISTANCE;
        let wide = passage.gradient.0.abs() >= MIN_HALF_CHORD * passage.change.0;
        if rising != ((passage.gradient.0 > 0.0) == dark_inside) || !near || !wide {
            return None;
        }
        let model = &scene.model;
        Some(Self {
            scene,
            outline,
            next,
            crossing,
            seen,
            middle,
            axes,
            curvature: -outline.inside * passage.curvature(outline, &axes),
            passage,
            lightward: -outline.inside,
            sign: if rising { 1.0 } else { -1.0 },
            light: 1.0 + model.gx * seen.0 + model.gy * seen.1,
            slope: if row { model.gx } else { model.gy },
        })
    }

    /// The undistorted place `at` px from the middle on the axis.
    fn place(&self, at: f32) -> (f32, f32) {
        (self.middle.0 + at * self.axes.along.0, self.middle.1 + at * self.axes.along.1)
    }

    /// Distance towards light of the place `at`, and half the curvature there, positive where the edge bends away from light.
    #[inline]
    fn depth(&self, at: f32) -> (f32, f32) {
        if self.scene.tight {
            self.depth_of_ellipse(at)
        } else {
            (self.depth_of_circle(at), 0.5 * self.curvature)
        }
    }

    /// The same by itself.
    fn depth_of_ellipse(&self, at: f32) -> (f32, f32) {
        let (distance, curvature) = distance(self.outline, self.place(at), &self.axes);
        (self.lightward * distance, 0.5 * self.lightward * curvature)
    }

    /// The distance from the circle that fits the edge where the axis passes it: its series to the third order.
    #[inline]
    fn depth_of_circle(&self, at: f32) -> f32 {
        let h = self.sign * (at - self.passage.at);
        let bend = 0.5 * self.curvature;
        let q = h * (self.passage.cosine + bend * h);
        q * (1.0 - bend * q * (1.0 - 2.0 * bend * q))
    }

    /// The near samples; `None` if none of them counts here.
    #[inline]
    pub fn samples(&self) -> Option<Samples> {
        let blur = self.scene.model.blur;
        let inverse = 1.0 / blur;
        let mut depths = [0.0; NEAR];
        let mut leads = [0.5 * self.curvature * blur; NEAR];
        for i in 0..NEAR {
            depths[i] = self.depth_of_circle(PLACES[i]);
        }
        if self.scene.tight {
            for i in 0..NEAR {
                let (depth, bend) = self.depth_of_ellipse(PLACES[i]);
                (depths[i], leads[i]) = (depth, bend * blur);
            }
        }
        let (mut own, mut lightness, mut by_blur) = ([0.0; NEAR], [0.0; NEAR], [0.0; NEAR]);
        let mut by_place = [0.0; NEAR];
        for i in 0..NEAR {
            let z = depths[i] * inverse;
            (lightness[i], by_place[i]) = normal(z + leads[i]);
            by_blur[i] = by_place[i] * (leads[i] - z);
        }
        for i in 0..NEAR {
            own[i] = self.passage.owns(PLACES[i] - self.passage.at);
        }
        if self.scene.overlapping {
            self.add_next(&depths, &mut own, &mut lightness, &mut by_blur);
        }
        let model = &self.scene.model;
        let contrast = model.contrast();
        let mut residuals = self.crossing.near.map(f32::from);
        let (least, most) = self.scene.ends;
        let mut any = 0.0;
        for i in 0..NEAR {
            let level = (model.dark + contrast * lightness[i]) * (self.light + self.slope * PLACES[i]);
            let told = level > least && level < most;
            own[i] = if told { own[i] } else { 0.0 };
            any += own[i];
            residuals[i] -= level;
        }
        (any > 0.0).then_some(Samples { own, lightness, by_blur, by_place, residuals })
    }

    /// Adds what the edges beside this one give to its samples: light of the dark area beyond, and dark of the light area
    /// beyond. What is nearer to them is theirs.
    fn add_next(
        &self,
        depths: &[f32; NEAR],
        own: &mut [f32; NEAR],
        lightness: &mut [f32; NEAR],
        by_blur: &mut [f32; NEAR],
    ) {
        let blur = self.scene.model.blur;
        for (next, beyond) in self.next.near.into_iter().zip([-1.0, 0.0]) {
            let Some(next) = self.scene.outline(next) else { continue };
            for i in 0..NEAR {
                let (outwards, curvature) = distance(next, self.place(PLACES[i]), &self.axes);
                let depth = -next.inside * outwards;
                let (z, lead) = (depth / blur, -0.5 * next.inside * curvature * blur);
                let (share, density) = normal(z + lead);
                lightness[i] += share + beyond;
                by_blur[i] += density * (lead - z);
                if depth.abs() <= depths[i].abs() {
                    own[i] = 0.0;
                }
            }
        }
    }

    /// Where the axis passes the edge, in the frame where that is the unit circle.
    pub fn direction(&self) -> (f32, f32) {
        self.outline.frame.vector(self.passage.from_centre.0, self.passage.from_centre.1)
    }

    fn is_told(&self, level: f32) -> bool {
        level > self.scene.ends.0 && level < self.scene.ends.1
    }

    /// What `samples` tell.
    #[inline]
    pub fn told(&self, samples: &Samples) -> Told {
        let model = &self.scene.model;
        let (u, v) = self.direction();
        let unit = 1.0 / self.scene.size;
        Told {
            terms: [u * u - v * v, 2.0 * u * v, 1.0, u, v],
            reach: -0.5 / self.passage.norm,
            by_place: self.outline.inside * model.contrast() * self.light / model.blur,
            light: self.light,
            place: (self.seen.0 * unit, self.seen.1 * unit),
            sums: samples.sums(),
        }
    }

    /// The far stretches before and after the near samples, where they tell the levels; and whether one is clipped.
    pub fn far(&self) -> ([Option<Far>; 2], bool) {
        let [before, after] = self.crossing.far().map(|stretch| stretch.mean());
        let clipped = !self.is_told(before.1) || !self.is_told(after.1);
        ([self.stretch(-1.0, before), self.stretch(1.0, after)], clipped)
    }

    fn stretch(&self, side: f32, (pixels, level): (f32, f32)) -> Option<Far> {
        let blur = self.scene.model.blur;
        let (first, last) = (side * FAR, side * (FAR + pixels - 1.0));
        let bright = side == self.sign;
        if !self.is_told(level) {
            return None;
        }
        let (depth, bend) = self.depth(first);
        let z = depth / blur + bend * blur;
        let z = if bright { -z } else { z };
        let tail = if z > -OVER { mean_tail(z, self.passage.cosine / blur, pixels) } else { 0.0 };
        // Outwards only the next edge can be near, and that at the end; inwards the next edge or the other side of this one.
        let inwards = bright == (self.lightward < 0.0);
        let clear = match self.scene.outline(self.next.far[usize::from(inwards)]) {
            Some(next) => {
                let nearest =
                    if inwards { self.nearest(next).max(first.min(last)).min(first.max(last)) } else { last };
                distance(next, self.place(nearest), &self.axes).0.abs()
            }
            None if inwards => self.depth(last).0.abs(),
            None if self.scene.ringed => return None,
            None => f32::INFINITY,
        };
        let middle = 0.5 * (first + last);
        let place = match self.crossing.axis() {
            Axis::Row => (self.seen.0 + middle, self.seen.1),
            Axis::Column => (self.seen.0, self.seen.1 + middle),
        };
        let told = tail < TAIL && clear > CLEAR * blur;
        told.then_some(Far { pixels, level, lightness: if bright { 1.0 - tail } else { tail }, place })
    }

    /// Where the axis comes nearest to the centre of an outline, in the measure of its ellipse.
    fn nearest(&self, outline: &Outline) -> f32 {
        let (slope, _) = outline.shape.gradient(self.middle.0, self.middle.1);
        -dot(slope, self.axes.along) / outline.shape.square(self.axes.along.0, self.axes.along.1)
    }
}

impl Far {
    /// Room for its error beyond `limit` grey levels: `noise` is that of a pixel.
    pub fn limit(&self, limit: f32, noise: f32) -> f32 {
        limit + 4.0 * noise / math::sqrt(self.pixels)
    }
}
