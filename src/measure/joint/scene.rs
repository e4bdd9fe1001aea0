//! A model, prepared for the crossings of its outlines.

use crate::appearance::{Model, Outline, Saddle};
use crate::fit::{Border, Line};
use crate::fixed::{GREY, LEAST_LIGHT, MOST_LIGHT, ONE, PX, fixed};
use crate::scan::Axis;

/// Standard deviations of the blur beyond which an edge is over, ...
const BAND: f32 = 3.0;
/// ... between two edges, below which they merge, ...
const MERGED: f32 = 4.5;
/// ... and that a far stretch must be away from it to tell the levels.
const CLEAR: f32 = 2.5;
/// Standard deviations of the blur beyond which an edge has no part in a sample.
pub(super) const OVER: f32 = 3.5;
/// How far the near samples and the far stretches of a crossing reach from an edge, px, with room for its place.
const NEAR: f32 = 3.0;
const FAR: f32 = 19.5;
/// Farther than any stretch, px.
const FREE: f32 = 1e3;
/// How far beyond the target, px, and how many times its size the unit of places is.
const UNIT: (f32, f32) = (16.0, 2.0);
/// Room of levels to the ends of the scale, where these need not be looked for, grey levels.
const ROOM: f32 = 2.0;

/// How the levels change along an axis, for 1 px, where light is one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rise {
    /// Grey levels with [`ONE`] times their unit.
    pub dark: i32,
    /// Grey levels with 64 times their unit.
    pub contrast: i32,
}

/// What all crossings share.
pub(super) struct Scene<'m> {
    model: &'m Model,
    /// Edges have a part in the samples of others; and so large a one that these tell of their places.
    pub overlapping: bool,
    pub merging: bool,
    /// Around the target there may be the segments of a code: what is far outside of it tells nothing.
    ringed: bool,
    /// Unit of places, px.
    pub unit: f32,
    /// Grey levels.
    pub dark: i32,
    pub bright: i32,
    pub contrast: i32,
    /// Slopes of the light along x and y, 1/px, with 64 times its unit, and what they make of the levels.
    slopes: (i32, i32),
    rises: [Rise; 2],
    blur: i32,
    /// Its reciprocal, with half the unit of shares.
    pub sharpness: i32,
    /// Reciprocal of the unit of places, and the farthest place, px / 2.
    by_unit: i32,
    farthest: i32,
    /// Grey levels beyond which noise reaches the ends of the scale, so that the mean is no longer the level.
    ends: (i32, i32),
    /// They are nowhere near the target.
    pub all_told: bool,
}

impl<'m> Scene<'m> {
    pub fn new(model: &'m Model, size: f32, noise: f32, ringed: bool) -> Self {
        let outlines = &model.outlines;
        let any =
            |reach: f32| (1..outlines.len()).any(|k| within(model, k, k.checked_sub(1), reach).is_some());
        let (overlapping, merging) = (any(NEAR + BAND * model.blur), any(MERGED * model.blur));
        let unit = UNIT.0 + UNIT.1 * size;
        let grey = |level: f32| fixed(level.clamp(0.0, 500.0), GREY);
        let (dark, bright) = (grey(model.dark), grey(model.bright));
        let slope = |slope: f32| fixed(slope.clamp(-0.06, 0.06), ONE << 6);
        let slopes = (slope(model.gx), slope(model.gy));
        let rise = |slope: i32| Rise { dark: (dark * slope) >> 6, contrast: ((bright - dark) * slope) >> 14 };
        let (darkest, brightest) = (noise, 255.0 - noise);
        // How much the light changes from the origin to the farthest samples.
        let uneven = (model.gx.abs() + model.gy.abs()) * unit;
        let all_told =
            model.dark * (1.0 - uneven) > darkest + ROOM && model.bright * (1.0 + uneven) < brightest - ROOM;
        Self {
            model,
            overlapping,
            merging,
            ringed,
            unit,
            dark,
            bright,
            contrast: bright - dark,
            slopes,
            rises: [rise(slopes.0), rise(slopes.1)],
            blur: fixed(model.blur, PX),
            sharpness: fixed(1.0 / model.blur, ONE / 2),
            by_unit: fixed(1.0 / unit, 1 << 27),
            farthest: (2.0 * unit) as i32,
            ends: (fixed(darkest, GREY), fixed(brightest, GREY)),
            all_told,
        }
    }

    pub fn model(&self) -> &Model {
        self.model
    }

    pub fn outline(&self, k: Option<usize>) -> Option<&Outline> {
        self.model.outlines.get(k?)
    }

    #[inline]
    pub fn rise(&self, axis: Axis) -> &Rise {
        of(&self.rises, axis)
    }

    /// Standard deviations of the blur in a length, px.
    #[inline]
    pub fn deviations(&self, length: i32) -> i32 {
        (length * self.sharpness + ONE / 4) >> 13
    }

    /// How far blur moves the level of one half where half the curvature is `bend`, standard deviations of the blur.
    #[inline]
    pub fn lead(&self, bend: i32) -> i32 {
        (bend * self.blur + (1 << 15)) >> 16
    }

    #[inline]
    pub fn is_told(&self, level: i32) -> bool {
        level > self.ends.0 && level < self.ends.1
    }

    /// Light at a place about the origin, px / 2.
    #[inline]
    pub fn light(&self, (x, y): (i32, i32)) -> i32 {
        let light = ONE + ((self.slopes.0 * x + self.slopes.1 * y + (1 << 6)) >> 7);
        light.clamp(LEAST_LIGHT, MOST_LIGHT)
    }

    /// A sum of coordinates, or of multiples of them, in the unit of places, from px / 2.
    #[inline]
    pub fn place_sum(&self, sum: i32) -> i64 {
        (i64::from(sum) * i64::from(self.by_unit)) >> 14
    }

    /// A coordinate in the unit of places, from px / 2.
    #[inline]
    pub fn place(&self, at: i32) -> i32 {
        (at.max(-self.farthest).min(self.farthest) * self.by_unit) >> 14
    }

    /// Whether it bends too much for a series, and for far stretches beside it to tell the levels.
    fn is_tight(&self, outline: &Outline) -> bool {
        Saddle::is_tight(outline, self.model.blur)
    }

    fn seen<'o>(&self, outline: &'o Outline) -> Option<Seen<'o>> {
        let blur = self.model.blur;
        let saddle = if Saddle::is_tightest(outline, blur) { Saddle::new(outline, blur) } else { None };
        Some(Seen {
            outline,
            lines: Line::both(&outline.shape, &outline.frame, outline.minor)?,
            tight: self.is_tight(outline),
            saddle,
        })
    }

    /// Outline `k` as crossings see it. `None` if there is no such ellipse.
    pub fn track(&self, k: usize) -> Option<Track<'_>> {
        let outline = self.outline(Some(k))?;
        let dark_inside = outline.inside < 0.0;
        let band = BAND * self.model.blur;
        let next = |next: Option<usize>, reach: f32| within(self.model, k, next, reach + band);
        let (outer, inner) = (k.checked_sub(1), Some(k + 1));
        let far = [next(outer, FAR), next(inner, FAR)].map(|next| self.outline(next));
        let clear = CLEAR * self.model.blur;
        let room = [
            match far[0] {
                Some(outer) if self.is_tight(outer) => Room::None,
                Some(outer) => Room::Within(Border::both(&outer.shape, -clear)),
                None if self.ringed => Room::None,
                None => Room::All,
            },
            match far[1] {
                Some(inner) if self.is_tight(inner) => Room::None,
                Some(inner) => Room::Around(Border::both(&inner.shape, clear)),
                None if self.is_tight(outline) => Room::None,
                None => Room::Within(Border::both(&outline.shape, -clear)),
            },
        ];
        let free = |room: &Room, next: Option<&Outline>| match (room, next) {
            (Room::All, _) => FREE,
            (Room::None, _) | (_, None) => 0.0,
            (_, Some(next)) => gap(outline, next) - clear,
        };
        let free = [free(&room[0], far[0]), free(&room[1], far[1])];
        let beside = |k: Option<usize>| {
            let Some(next) = self.outline(next(k, NEAR)) else { return Some(None) };
            let over = fixed(gap(outline, next) - OVER * self.model.blur, PX);
            Some(Some(Beside { seen: self.seen(next)?, over }))
        };
        let (outside, inside) = (beside(outer)?, beside(inner)?);
        Some(Track {
            own: self.seen(outline)?,
            beside: if dark_inside { [outside, inside] } else { [inside, outside] },
            dark_inside,
            room,
            free: free.map(|length| fixed(length, PX)),
        })
    }
}

/// How near two outlines of concentric circles come to each other, px.
fn gap(outline: &Outline, next: &Outline) -> f32 {
    let (a, b) = (&outline.shape, &next.shape);
    (next.minor - outline.minor).abs() - ((a.cx - b.cx).abs() + (a.cy - b.cy).abs())
}

/// The outline `next` to `k`, if the other side of the area between them is nearer than `reach` px.
fn within(model: &Model, k: usize, next: Option<usize>, reach: f32) -> Option<usize> {
    let (outline, other) = (model.outlines.get(k)?, model.outlines.get(next?)?);
    // Between similar ellipses the gap is narrowest on the minor axis.
    let gap = (other.minor - outline.minor).abs();
    next.filter(|_| other.inside != outline.inside && gap < reach)
}

/// Where a far stretch tells the levels.
enum Room {
    /// Nowhere, and anywhere.
    None,
    All,
    /// Inside of this border, and outside of it, for rows and for columns.
    Within(Option<[Border; 2]>),
    Around(Option<[Border; 2]>),
}

/// An outline, and its ellipse as rows and as columns see it.
pub(super) struct Seen<'m> {
    pub outline: &'m Outline,
    lines: [Line; 2],
    /// It bends too much for a series.
    pub tight: bool,
    /// Where it bends too much for its distance to tell the level.
    pub saddle: Option<Saddle>,
}

impl Seen<'_> {
    #[inline]
    pub fn line(&self, axis: Axis) -> &Line {
        of(&self.lines, axis)
    }
}

/// What is for rows and for columns: by an index, so that its address is chosen once and not each of its fields.
#[inline]
fn of<T>(both: &[T; 2], axis: Axis) -> &T {
    &both[usize::from(axis == Axis::Column)]
}

/// An outline that has a part in the samples of the one beside it: only in those that are farther than `over` from that, px.
pub(super) struct Beside<'m> {
    pub seen: Seen<'m>,
    pub over: i32,
}

/// An outline as crossings see it.
pub(super) struct Track<'m> {
    pub own: Seen<'m>,
    /// The outlines beside it that have a part in its samples: on the light side and on the dark side.
    pub beside: [Option<Beside<'m>>; 2],
    pub dark_inside: bool,
    /// Outside and inside.
    room: [Room; 2],
    /// How far beyond the edge, px on the axis, all is clear of the other edges.
    free: [i32; 2],
}

impl Track<'_> {
    /// How far outside or inside of the edge, px on the axis, all is clear of other edges; there may be more.
    #[inline]
    pub fn free(&self, inwards: bool) -> i32 {
        let [outside, inside] = self.free;
        if inwards { inside } else { outside }
    }

    /// Whether a stretch on an axis, from `first` to `last`, px / 4, outside or inside of the outline, is clear of all edges.
    #[inline]
    pub fn is_clear(&self, axis: Axis, inwards: bool, (first, last): (i32, i32), across: i32) -> bool {
        let [outside, inside] = &self.room;
        match if inwards { inside } else { outside } {
            Room::None | Room::Within(None) | Room::Around(None) => false,
            Room::All => true,
            Room::Within(Some(border)) => of(border, axis).contains(last, across),
            Room::Around(Some(border)) => !of(border, axis).meets((first, last), across),
        }
    }
}
