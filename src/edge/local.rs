//! A crossing as seen from its edge, in the integers of [`fixed`](crate::fixed).

use super::MAX_GAP;
use super::profile::{Blurred, normal_fixed};
use super::trace::{Conic, Trace};
use crate::fixed::{ONE, PX, scale};
use crate::scan::{Axis, Crossing};

/// Farthest that a crossing may lie from its outline's ellipse, px.
const MAX_DISTANCE: i32 = 2 * PX;
/// Least distance on the axis from an edge to the middle between it and the other side of its own circle, px: 5/2.
const MIN_HALF_CHORD: (i32, i32) = (5, 2);

/// Places of the near samples on the axis, towards light from their middle, px.
pub(super) const NEAR: [i32; 4] = [-3 * PX / 2, -PX / 2, PX / 2, 3 * PX / 2];
/// The same of the pixels of the far stretches nearest to it.
pub(super) const FAR: i32 = 7 * PX / 2;

/// A crossing, and where its edge is. The axis is that of the crossing, from the middle between its inner samples towards light.
pub(super) struct Local {
    pub axis: Axis,
    /// 1 where the axis leads along the coordinate, else -1.
    pub sign: i32,
    /// The middle along and across the coordinate, about the origin, px / 2.
    pub middle: (i32, i32),
    /// Where the ellipse passes, px.
    pub at: i32,
    /// |cosine| of the angle between axis and normal.
    pub cosine: i32,
    /// Its reciprocal.
    pub by_cosine: i32,
    /// Half the curvature of the edge, 1/px, positive where it bends away from light.
    pub bend: i32,
    /// Distance to the next edges on the light and on the dark side, px, where they have a part in the samples.
    pub light_gap: Option<i32>,
    pub dark_gap: Option<i32>,
    /// The edge's conic at the middle.
    pub conic: Conic,
}

/// An edge and those next to it: on the light side and on the dark side, where they are near enough to have a part in the samples.
pub(super) struct Views<'l> {
    pub edge: &'l Trace,
    pub light: Option<&'l Trace>,
    pub dark: Option<&'l Trace>,
    pub dark_inside: bool,
    pub origin: (u16, u16),
}

impl Views<'_> {
    /// `None` if the other axis is the better one here, or the crossing does not belong to this edge.
    pub fn local(&self, crossing: &Crossing) -> Option<Local> {
        self.local_inline(crossing)
    }

    /// The same for the one pass in which most crossings are looked at.
    #[inline(always)]
    pub fn local_inline(&self, crossing: &Crossing) -> Option<Local> {
        let (rising, axis, place) = (crossing.is_rising(), crossing.axis(), crossing.middle(self.origin));
        let look = self.edge.look(axis, place)?;
        let (outwards, across) = look.cosines;
        let cosine = outwards.abs();
        if cosine < across.abs()
            || rising != ((outwards > 0) == self.dark_inside)
            || look.distance.abs() > MAX_DISTANCE
            || 4 * MIN_HALF_CHORD.1 * cosine < MIN_HALF_CHORD.0 * look.change
        {
            return None;
        }
        let by_cosine = (1 << 28) / cosine.max(1);
        let along = |length: i32| (length * (by_cosine >> 1)) >> 13;
        let gap = |next: Option<&Trace>| {
            let there = next?.distance(place)?;
            Some(along((there - look.distance).abs())).filter(|&gap| gap < (MAX_GAP * PX as f32) as i32)
        };
        Some(Local {
            axis,
            sign: if rising { 1 } else { -1 },
            middle: if axis == Axis::Row { place } else { (place.1, place.0) },
            // Along the axis, light lies outside or inside of the edge.
            at: along(if self.dark_inside { -look.distance } else { look.distance }),
            cosine,
            by_cosine,
            bend: if self.dark_inside { look.bend } else { -look.bend },
            light_gap: gap(self.light),
            dark_gap: gap(self.dark),
            conic: look.conic,
        })
    }
}

impl Local {
    /// The near samples in order of growing lightness.
    pub fn near(&self, crossing: &Crossing) -> [i32; 4] {
        let [_, a, b, c, d, _] = crossing.near.map(i32::from);
        if self.sign > 0 { [a, b, c, d] } else { [d, c, b, a] }
    }

    /// This edge under a blur.
    pub fn blurred(&self, blur: &super::place::Sharpness) -> Blurred {
        let across = ONE - scale(self.cosine, self.cosine);
        Blurred {
            k: scale(self.cosine, blur.sharpness),
            second: (scale(self.bend, across) * blur.sharpness) >> 13,
            lead: (self.bend * blur.blur + (1 << 15)) >> 16,
        }
    }

    /// Whether no other edge has a part in the samples.
    #[inline]
    pub fn is_alone(&self) -> bool {
        self.light_gap.is_none() && self.dark_gap.is_none()
    }

    /// What the neighbouring edges add to the lightness `h` px from this edge.
    pub fn neighbours(&self, h: i32, edge: &Blurred) -> i32 {
        let light = self.light_gap.map_or(0, |gap| normal_fixed(edge.straight(h - gap)).0);
        let dark = self.dark_gap.map_or(0, |gap| normal_fixed(-edge.straight(h + gap)).0);
        dark - light
    }
}
