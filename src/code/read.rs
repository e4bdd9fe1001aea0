//! The code of a target on the pixels.

use super::{Code, INNER, OUTER, QUIET, Reading};
use crate::detector::Image;
use crate::fit::{Frame, Shape};
use crate::math;
use crate::measure::Origin;
use crate::settings::Settings;
use crate::target::Target;
use heapless::Vec;

/// Places in a segment along the ring.
const PARTS: usize = 8;
/// Most places around the ring.
const PLACES: usize = PARTS * super::table::SEGMENTS as usize;
/// How far from the borders of segments and paper levels are taken, in standard deviations of the blur.
const REACH: f32 = 1.4;
/// The same in outer radii: at least, for what the print and the plane are off, and at most, as half of a ring's width is 0.2.
const MARGINS: (f32, f32) = (0.04, 0.14);
/// Margin up to which all but the first and the last part of a segment tell its bit; with wider ones half of them do.
const WIDE: f32 = 0.09;
/// Smallest contrast of the ring, as a share of the target's: that of segments of 2 px under a blur of 1.2 px.
const MIN_CONTRAST: f32 = 0.4;
/// Farthest that the ground in the ring may be from the ground around it, as a share of the target's contrast.
const MAX_GROUND: f32 = 0.3;
/// Least distance of a clear segment from the middle between ink and ground, as a share of half the ring's contrast.
const MIN_MARGIN: f32 = 0.5;
/// The same for each level in it.
const MIN_PLACE: f32 = 0.0;
/// Farthest that the paper on either side of a clear segment may be from the ground, as a share of the ring's contrast.
const MAX_UNCLEAN: f32 = 0.4;
/// What a segment that plainly is the other bit counts, where one that is not clear counts 1: dirt rarely has the shape of a segment.
const PLAINLY_WRONG: u32 = 2;

/// Reads the code of `target` in `image`, in which a [`Detector`](crate::Detector) with the same `settings` has found it, into
/// [`Target::code`]. `false`, and no code, if `settings` have no [`Code`], or if there is none to be read: one that
/// the image's border cuts, one of an id that is not in the settings, one with more segments that are not clear than can be
/// repaired. A target without a ring of segments has no code.
///
/// A segment is clear where every level in it is on its side of the middle between ink and ground, away from its borders, and
/// the paper inside and outside of it is clean. Only what is not clear is repaired; a segment that plainly is the other
/// bit counts as two that are not.
///
/// The ring is looked at where the plane of the target puts it, which follows from the outer ellipse and the true centre, and if
/// nothing is read there, about the innermost ellipse. The work is at most 112 places around the ring, seven levels of four
/// pixels at each, twice.
pub fn read(image: &Image<'_>, settings: &Settings, target: &mut Target) -> bool {
    let sign = if target.flags.contains(crate::Flags::LIGHT) { -1.0 } else { 1.0 };
    target.code = settings.code.and_then(|code| {
        let planes = [Plane::new(settings, target), Plane::inner(settings, target)];
        planes
            .into_iter()
            .flatten()
            .find_map(|plane| Ring::new(image, &plane, &code, sign)?.read(&plane, &code, target.contrast))
    });
    target.code.is_some()
}

/// The target's plane: places on it in outer radii from the true centre, turned by an angle that is not known.
///
/// The projective map of the plane that takes the outer circle to its ellipse and its centre to the true centre is, in the
/// frame where the ellipse is the unit circle, one of that circle to itself that moves its centre to `c`. With |c| < 1 that
/// is p -> (c + s p + c (p c) / (1 + s)) / (1 + p c), s = sqrt(1 - c^2), apart from turns of p: a motion of the hyperbolic plane in Klein's model.
struct Plane {
    origin: Origin,
    frame: Frame,
    ellipse: (f32, f32),
    c: (f32, f32),
    s: f32,
    /// How far from borders levels are taken, outer radii.
    margin: f32,
}

impl Plane {
    /// That of the outer circle and the true centre.
    fn new(settings: &Settings, target: &Target) -> Option<Self> {
        let origin = Origin::of(target, settings.known_camera())?;
        let shape = origin.shape(target.circles.first()?)?;
        Self::of(origin, &shape, origin.offset(target.centre)?, target.blur)
    }

    /// That of the innermost circle as if it had no eccentricity. A code near the outer circle of a small target moves that and the
    /// true centre with it; where it is so near, eccentricity is nothing.
    fn inner(settings: &Settings, target: &Target) -> Option<Self> {
        let origin = Origin::of(target, settings.known_camera())?;
        let (outer, inner) = (target.circles.first()?.ellipse, target.circles.last()?);
        let ratio = math::sqrt(inner.ellipse.a * inner.ellipse.b / (outer.a * outer.b));
        let shape = origin.shape(inner)?.grown(1.0 / ratio);
        Self::of(origin, &shape, (shape.cx, shape.cy), target.blur)
    }

    fn of(origin: Origin, shape: &Shape, centre: (f32, f32), blur: f32) -> Option<Self> {
        let frame = Frame::new(shape)?;
        let c = frame.vector(centre.0 - shape.cx, centre.1 - shape.cy);
        let square = 1.0 - c.0 * c.0 - c.1 * c.1;
        // The vanishing line must lie beyond the code.
        (square > 1.0 - 1.0 / (QUIET * QUIET)).then_some(Self {
            origin,
            frame,
            ellipse: (shape.cx, shape.cy),
            c,
            s: math::sqrt(square),
            margin: (REACH * blur / shape.semi_axes().1).clamp(MARGINS.0, MARGINS.1),
        })
    }

    /// Where the image shows the point at `radius` in the direction `(cos, sin)` on the plane, px from the origin.
    fn seen(&self, radius: f32, (cos, sin): (f32, f32)) -> (f32, f32) {
        let (u, v) = (radius * cos, radius * sin);
        let along = u * self.c.0 + v * self.c.1;
        let scale = 1.0 / (1.0 + along);
        let own = 1.0 + along / (1.0 + self.s);
        let (x, y) =
            self.frame.inverse(scale * (self.s * u + self.c.0 * own), scale * (self.s * v + self.c.1 * own));
        self.origin.seen((x + self.ellipse.0, y + self.ellipse.1))
    }

    /// Level of the image there, between the pixels; `None` outside the image.
    fn level(&self, image: &Image<'_>, radius: f32, direction: (f32, f32)) -> Option<f32> {
        let (x, y) = self.seen(radius, direction);
        let (x, y) = (x + f32::from(self.origin.pixel.0), y + f32::from(self.origin.pixel.1));
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (column, row) = (x as i32, y as i32);
        let (right, down) = (x - column as f32, y - row as f32);
        let pixel = |dx, dy| image.level(column + dx, row + dy).map(f32::from);
        let top = (1.0 - right) * pixel(0, 0)? + right * pixel(1, 0)?;
        let bottom = (1.0 - right) * pixel(0, 1)? + right * pixel(1, 1)?;
        Some((1.0 - down) * top + down * bottom)
    }

    /// Direction in the image from the true centre to the point of the outer circle in `direction`, radians.
    fn angle(&self, direction: (f32, f32)) -> f32 {
        let (from, to) = (self.seen(0.0, direction), self.seen(1.0, direction));
        math::atan2(to.1 - from.1, to.0 - from.0)
    }
}

/// What is seen at a place around the ring, grey levels: how much nearer to the ink than the ground around the whole target.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// Across the ring.
    ring: [f32; 3],
    /// On the paper inside and outside it.
    beside: [f32; 4],
}

/// The ring of segments and the ground on both sides of it, all around.
struct Ring {
    places: Vec<Place, PLACES>,
    /// Parts of a segment that tell its bit: the others are near its ends, where the blur mixes it with the next one.
    middle: core::ops::Range<usize>,
}

/// What a segment looks like.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// Mean in the ring, and the least and the most.
    ring: f32,
    least: f32,
    most: f32,
    /// Largest deviation of the paper on both sides.
    unclean: f32,
}

/// Mean levels of the segments.
#[derive(Clone, Copy, Debug)]
struct Tones {
    ground: f32,
    half: f32,
}

fn direction(place: usize, places: usize) -> (f32, f32) {
    let (sin, cos) = math::sincos(place as f32 * (core::f32::consts::TAU / places as f32));
    (cos, sin)
}

impl Ring {
    /// `None` if the image's border cuts it. `sign` is 1 for dark ink and -1 for light.
    fn new(image: &Image<'_>, plane: &Plane, code: &Code, sign: f32) -> Option<Self> {
        let count = PARTS * code.segments() as usize;
        let (paper, margin) = (1.0, plane.margin);
        let mut places = Vec::new();
        for k in 0..count {
            let at = |radius| Some(-sign * plane.level(image, radius, direction(k, count))?);
            let ring = [at(INNER + margin)?, at(0.5 * (INNER + OUTER))?, at(OUTER - margin)?];
            let beside = [at(paper + margin)?, at(INNER - margin)?, at(OUTER + margin)?, at(QUIET - margin)?];
            places.push(Place { ring, beside }).ok()?;
        }
        let wide = margin <= WIDE;
        let mut ring = Self { places, middle: if wide { 1..PARTS - 1 } else { 2..PARTS - 2 } };
        ring.remove_light();
        Some(ring)
    }

    /// Takes away the level of the ground, which changes by as much on one side of the target as it does the other way on the
    /// opposite side.
    fn remove_light(&mut self) {
        let count = self.places.len();
        let (mut mean, mut x, mut y) = (0.0, 0.0, 0.0);
        for (k, place) in self.places.iter().enumerate() {
            let (cos, sin) = direction(k, count);
            let level = place.beside.iter().sum::<f32>() / (4 * count) as f32;
            mean += level;
            x += 2.0 * level * cos;
            y += 2.0 * level * sin;
        }
        for (k, place) in self.places.iter_mut().enumerate() {
            let (cos, sin) = direction(k, count);
            let ground = mean + x * cos + y * sin;
            place.ring = place.ring.map(|level| level - ground);
            place.beside = place.beside.map(|level| level - ground);
        }
    }

    /// The segment that begins at the place `start`.
    fn segment(&self, start: usize) -> Segment {
        let mut segment = Segment { ring: 0.0, least: f32::INFINITY, most: f32::NEG_INFINITY, unclean: 0.0 };
        for part in self.middle.clone() {
            let Some(place) = self.places.get((start + part) % self.places.len().max(1)) else { continue };
            for level in place.ring {
                segment.ring += level / (place.ring.len() * self.middle.len()) as f32;
                segment.least = segment.least.min(level);
                segment.most = segment.most.max(level);
            }
            segment.unclean = place.beside.iter().fold(segment.unclean, |most, level| most.max(level.abs()));
        }
        segment
    }

    /// The place at which a segment begins: where segments differ most from the middle of all.
    fn phase(&self, segments: usize) -> usize {
        let all = || (0..PARTS * segments).map(|start| self.segment(start).ring);
        let mean = all().sum::<f32>() / (PARTS * segments) as f32;
        let clear = |start: usize| {
            (0..segments).map(|i| (self.segment(start + PARTS * i).ring - mean).abs()).sum::<f32>()
        };
        let mut best = (0, f32::NEG_INFINITY);
        for start in 0..PARTS {
            let clear = clear(start);
            if clear > best.1 {
                best = (start, clear);
            }
        }
        best.0
    }

    fn read(&self, plane: &Plane, code: &Code, contrast: f32) -> Option<Reading> {
        let segments = code.segments();
        let start = self.phase(segments as usize);
        let all = || (0..segments as usize).map(|i| self.segment(start + PARTS * i));
        let tones = Tones::new(all, contrast)?;
        let (mut word, mut unclear, mut margin) = (0, 0, 1.0f32);
        for segment in all() {
            let ink = segment.ring > tones.ground + tones.half;
            let clear = tones.margin(&segment);
            word = word << 1 | u16::from(ink);
            unclear = unclear << 1 | u16::from(clear.is_none());
            margin = margin.min(clear.unwrap_or(1.0));
        }
        let decoded = code.decode(word)?;
        let turned = |word| super::table::rotated(word, decoded.turn.into(), segments);
        let wrong = turned(word) ^ code.word(decoded.id)?;
        let plainly = (wrong & !turned(unclear)).count_ones();
        if unclear.count_ones() + PLAINLY_WRONG * plainly > code.repairs() {
            return None;
        }
        let first = direction(start + PARTS * usize::from(decoded.turn), self.places.len());
        let wrong = (unclear.count_ones() + plainly) as u8;
        Some(Reading { id: decoded.id, angle: plane.angle(first), wrong, margin })
    }
}

impl Tones {
    /// `None` if the segments have no two tones, or their ground is none.
    fn new<I: Iterator<Item = Segment>>(all: impl Fn() -> I, contrast: f32) -> Option<Self> {
        let (least, most) = all().fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), segment| {
            (least.min(segment.ring), most.max(segment.ring))
        });
        let middle = 0.5 * (least + most);
        let mean = |ink: bool| {
            let (sum, count) = all()
                .filter(|segment| (segment.ring > middle) == ink)
                .fold((0.0, 0.0), |(sum, count), segment| (sum + segment.ring, count + 1.0));
            sum / count
        };
        let (ground, ink) = (mean(false), mean(true));
        let tones = Self { ground, half: 0.5 * (ink - ground) };
        // Also refuses a ring without any difference.
        (2.0 * tones.half >= MIN_CONTRAST * contrast && ground.abs() <= MAX_GROUND * contrast)
            .then_some(tones)
    }

    /// How far a segment is from the middle between the tones, as a share of the way to them; `None` if it is not clear.
    fn margin(&self, segment: &Segment) -> Option<f32> {
        let share = |level: f32| (level - self.ground) / self.half - 1.0;
        let (mean, worst) = if share(segment.ring) > 0.0 {
            (share(segment.ring), share(segment.least))
        } else {
            (-share(segment.ring), -share(segment.most))
        };
        let clean = segment.unclean <= MAX_UNCLEAN * 2.0 * self.half;
        (mean >= MIN_MARGIN && worst >= MIN_PLACE && clean).then_some(mean)
    }
}
