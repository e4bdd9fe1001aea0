//! The levels of a target from the flat areas beside its edges: one look at each crossing, and more error than
//! [`Levels::refined`] has.

use super::{Edges, Levels};
use crate::fit::{Factor, dot};
use crate::math;
use crate::scan::{Axis, Crossing, Pool};

/// Where a far stretch begins and where the outermost near sample has its middle, px / 2 from the middle of the crossing.
const BESIDE: i32 = 6;
const OUTERMOST: i32 = 5;
/// Bits of places in units of the target, and most crossings that are looked at: the sums have 32 bits.
const PLACE: u32 = 7;
const MOST: usize = 2048;
/// How far beyond the target the samples reach, px.
const BEYOND: f32 = 16.0;
/// Least variance of a sample, grey levels: that of rounding.
const ROUNDING: f32 = 1.0 / 12.0;
/// Levels from the end of the scale that noise clips, grey levels.
const END: u32 = 4;
/// One light area in so many may clip.
const CLIPPED_SHARE: u32 = 10;

impl Crossing {
    /// Whether light follows dark along the axis.
    #[inline(always)]
    pub(super) fn is_rising(&self) -> bool {
        let [_, a, b, c, d, _] = self.near.map(i32::from);
        c + d > a + b
    }

    /// The middle between its inner samples about an origin, px / 2.
    #[inline(always)]
    pub(super) fn middle(&self, origin: (u16, u16)) -> (i32, i32) {
        let x = 2 * (i32::from(self.x) - i32::from(origin.0));
        let y = 2 * (i32::from(self.y()) - i32::from(origin.1));
        if self.axis() == Axis::Row { (x - 1, y) } else { (x, y - 1) }
    }
}

/// Number and sum of the pixels of dark areas.
#[derive(Default)]
struct Dark {
    pixels: u32,
    level: u32,
}

/// Sums over light areas, each as often as it has pixels: of 1, of places, of levels, and of their products.
#[derive(Default)]
struct Bright {
    /// Bits that a place has less than px / 2.
    less: u32,
    pixels: i32,
    place: (i32, i32),
    square: (i32, i32, i32),
    level: i32,
    place_level: (i32, i32),
    /// Squares of the mean levels.
    squares: u32,
    areas: u16,
    clipped: u16,
}

impl Bright {
    #[inline(always)]
    fn add(&mut self, (x, y): (i32, i32), (log, sum): (u32, u32)) {
        let (x, y) = (x >> self.less, y >> self.less);
        let level = sum as i32;
        self.pixels += 1 << log;
        self.place.0 += x << log;
        self.place.1 += y << log;
        self.square.0 += (x * x) << log;
        self.square.1 += (x * y) << log;
        self.square.2 += (y * y) << log;
        self.level += level;
        self.place_level.0 += x * level;
        self.place_level.1 += y * level;
        self.squares += (sum * sum) >> log;
        self.areas += 1;
        self.clipped += u16::from(sum >= (256 - END) << log);
    }
}

impl Levels {
    /// Those of a target that nothing disturbs; `None` where nothing is flat, or too much of it clipped.
    #[inline(never)]
    pub fn of_flat(edges: &Edges<'_>, pool: &Pool<'_>) -> Option<Self> {
        let farthest = (2.0 * (edges.edges.first()?.axes.0 + BEYOND)) as u32;
        let less = (u32::BITS - farthest.leading_zeros()).saturating_sub(PLACE);
        let (mut dark, mut bright) = (Dark::default(), Bright { less, ..Bright::default() });
        // An odd one: a row leaves a crossing on either side.
        let crossings: usize = edges.edges.iter().map(|edge| usize::from(edge.crossings.len())).sum();
        let stride = (crossings / (MOST / 2)) | 1;
        for edge in edges.edges {
            for crossing in pool.iter(edge.crossings).step_by(stride) {
                add(crossing, edges.origin, (&mut dark, &mut bright));
            }
        }
        if CLIPPED_SHARE * u32::from(bright.clipped) > u32::from(bright.areas) || dark.pixels == 0 {
            return None;
        }
        Self::solve(&bright, dark.level as f32 / dark.pixels as f32)
    }

    fn solve(sums: &Bright, dark: f32) -> Option<Self> {
        let free = f32::from(sums.areas.checked_sub(3).filter(|&free| free > 0)?);
        let Bright { less, pixels, place: (x, y), square: (xx, xy, yy), level, place_level, .. } = *sums;
        let unit = 0.5 * (1u32 << less) as f32;
        let place = |sum: i32| unit * sum as f32;
        let square = |sum: i32| unit * unit * sum as f32;
        let pixels = pixels as f32;
        let right = [level as f32, place(place_level.0), place(place_level.1)];
        let factor = Factor::new(&[
            [pixels, 0.0, 0.0],
            [place(x), square(xx), 0.0],
            [place(y), square(xy), square(yy)],
        ])?;
        let solution = factor.solve(right);
        let [bright, x_slope, y_slope] = solution;
        let variance = ((sums.squares as f32 - dot(&solution, &right)) / free).max(ROUNDING);
        let share = variance / (bright * bright);
        let (of_x, of_y) = (factor.solve([0.0, share, 0.0]), factor.solve([0.0, 0.0, share]));
        let noise = math::sqrt(variance);
        Some(Self {
            dark,
            bright,
            gx: x_slope / bright,
            gy: y_slope / bright,
            slopes: (of_x[1], of_x[2], of_y[2]),
            noise,
            spread: noise,
            pixels,
            clipped: false,
        })
    }
}

/// Adds what is beside a crossing on either side: the far stretch, or where that has one pixel and can be near the next edge, of the two
/// samples before it the one that no edge has a part in.
#[inline(always)]
fn add(crossing: &Crossing, origin: (u16, u16), (dark, bright): (&mut Dark, &mut Bright)) {
    let [before, after] = crossing.far();
    let [first, second, .., fifth, sixth] = crossing.near;
    let rising = crossing.is_rising();
    let ((of_dark, darkest), (of_light, lightest)) = if rising {
        ((before, first.min(second)), (after, fifth.max(sixth)))
    } else {
        ((after, fifth.min(sixth)), (before, first.max(second)))
    };
    let (log, sum) = of_dark.sum();
    dark.pixels += 1 << log;
    dark.level += if log > 0 { sum.into() } else { u32::from(darkest) };
    let (log, sum) = of_light.sum();
    let (away, sum) =
        if log > 0 { (BESIDE + (1 << log), sum.into()) } else { (OUTERMOST, u32::from(lightest)) };
    let away = if rising { away } else { -away };
    let (x, y) = crossing.middle(origin);
    bright.add(if crossing.axis() == Axis::Row { (x + away, y) } else { (x, y + away) }, (log, sum));
}
