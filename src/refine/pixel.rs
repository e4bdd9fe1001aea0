//! The level that the model gives a pixel.

use crate::appearance::{Model, Saddle};
use crate::edge::normal;
use crate::fit::Frame;
use crate::list::list;
use crate::math;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Standard deviations of the blur beyond which an edge is over.
const BAND: f32 = 3.5;

/// Closest to the centre that a pixel has a direction from it.
const CENTRE: f32 = 1e-3;

/// Derivative of the undistorted place by the place in the image: (xx, xy, yx, yy).
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope(pub [f32; 4]);

impl Slope {
    /// A gradient in the undistorted plane as it is in the image.
    fn gradient(&self, (gx, gy): (f32, f32)) -> (f32, f32) {
        let Self([xx, xy, yx, yy]) = *self;
        (gx * xx + gy * yx, gx * xy + gy * yy)
    }

    /// How much larger an area is in the undistorted plane.
    fn det(&self) -> f32 {
        let Self([xx, xy, yx, yy]) = *self;
        xx * yy - xy * yx
    }

    /// Square of the length in the image of a short way in the undistorted plane.
    fn square(&self, (x, y): (f32, f32)) -> f32 {
        let Self([xx, xy, yx, yy]) = *self;
        let (x, y, det) = (yy * x - xy * y, xx * y - yx * x, self.det());
        (x * x + y * y) / (det * det)
    }
}

/// An edge as a pixel near to it sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// Which of the model's outlines.
    pub outline: usize,
    /// The nearest place in the frame where the outline is the unit circle.
    pub u: f32,
    pub v: f32,
    /// Change of lightness with the five terms of the conic, common factor of.
    pub change: f32,
}

/// A pixel as the model has it.
#[derive(Clone, Debug)]
pub(super) struct Expected {
    /// Lightness, 0 dark to 1 bright.
    pub lightness: f32,
    /// Change of that with the logarithm of the blur.
    pub by_blur: f32,
    /// Light relative to that at the origin.
    pub light: f32,
    /// The edges that have a part in it.
    pub edges: Vec<Near, MAX_CIRCLES>,
}

/// The outlines of a model that bend too much for distance and curvature to tell the level.
pub(super) type Tight = Vec<Option<Saddle>, MAX_CIRCLES>;

impl Model {
    pub(super) fn tight(&self) -> Tight {
        list(self.outlines.iter().map(|outline| Saddle::new(outline, self.blur)))
    }

    pub(super) fn level(&self, expected: &Expected) -> f32 {
        (self.dark + self.contrast() * expected.lightness) * expected.light
    }

    /// The pixel at `(x, y)`, where `lens` gives the derivative of the lens; `None` if it is farther than `reach` px from
    /// every edge.
    pub(super) fn at(
        &self,
        (x, y): (f32, f32),
        tight: &Tight,
        lens: impl Fn((f32, f32)) -> Slope,
        reach: f32,
    ) -> Option<Expected> {
        let outside = self.outlines.first().map_or(0.0, |outer| if outer.inside < 0.0 { 1.0 } else { 0.0 });
        let light = 1.0 + self.gx * x + self.gy * y;
        let mut expected = Expected { lightness: outside, by_blur: 0.0, light, edges: Vec::new() };
        let mut nearest = f32::INFINITY;
        for (k, outline) in self.outlines.iter().enumerate() {
            let (u, v) = outline.frame.vector(x - outline.shape.cx, y - outline.shape.cy);
            let radius = math::sqrt(u * u + v * v);
            // At least that far from the outline.
            let far = (radius - 1.0) * outline.minor;
            if far > reach {
                break;
            }
            if -far > reach {
                expected.lightness += outline.inside;
                continue;
            }
            let distance = self.add_edge(
                &mut expected,
                (k, tight.get(k).and_then(Option::as_ref)),
                (u, v, radius),
                &lens,
            );
            nearest = nearest.min(distance.abs());
        }
        (nearest <= reach).then_some(expected)
    }

    /// Adds an outline's share. Returns the distance from it, px, positive outside.
    fn add_edge(
        &self,
        expected: &mut Expected,
        (k, tight): (usize, Option<&Saddle>),
        (u, v, radius): (f32, f32, f32),
        lens: impl Fn((f32, f32)) -> Slope,
    ) -> f32 {
        let Some(outline) = self.outlines.get(k) else { return f32::INFINITY };
        let band = BAND * self.blur;
        let radius = radius.max(CENTRE);
        let Frame { l0, l1, l2 } = outline.frame;
        // The place on the outline in the same direction from the centre, and the conic's gradient there (half of it).
        let (u, v) = (u / radius, v / radius);
        let (px, py) = outline.frame.inverse(u, v);
        // Half way between both the lens has the derivative that takes the one to the other.
        let half = 0.5 * (radius + 1.0);
        let (cx, cy) = (outline.shape.cx, outline.shape.cy);
        let lens = lens((cx + half * px, cy + half * py));
        let (gx, gy) = lens.gradient((l0 * u, l1 * u + l2 * v));
        let slope = 1.0 / math::sqrt(gx * gx + gy * gy);
        let area = lens.det();
        let curvature = outline.det * area * area * slope * slope * slope;
        let along = (radius - 1.0) * slope;
        // That place is not the nearest one: the outline curves away between them.
        let depth = radius - 1.0;
        let aside = depth * depth * (lens.square((px, py)) - slope * slope).max(0.0);
        let distance = along + 0.5 * curvature * aside;
        if distance > band {
            return distance;
        }
        if distance < -band {
            expected.lightness += outline.inside;
            return distance;
        }
        let (z, lead) = match tight {
            Some(saddle) => saddle.beyond((radius * px, radius * py), self.blur * self.blur * area),
            None => (distance / self.blur, 0.5 * curvature * self.blur),
        };
        let (share, density) = normal(z + lead);
        expected.lightness += outline.inside * (1.0 - share);
        expected.by_blur += outline.inside * density * (z - lead);
        // A term of the conic moves the outline inwards by itself over the whole gradient.
        let change = -0.5 * outline.inside * density * slope / self.blur;
        let _ = expected.edges.push(Near { outline: k, u, v, change });
        distance
    }
}
