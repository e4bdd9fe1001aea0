//! The levels of a target from the flat areas beside its edges: one look at each crossing, and more error than
//! [`Levels::refined`] has.

use super::{Edges, Levels};
use crate::fit::{Factor, dot};
use crate::math;
use crate::scan::{Axis, Crossing, Pool};

/// Where a far stretch begins and where the outermost near sample has its middle, px / 2 from the middle of the crossing.
const BESIDE: i32 = 6;
const OUTERMOST: i32 = 5;
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

/// Sums over light areas, each as often as it has pixels: of 1, of places, px / 2, of levels, and of their products.
#[derive(Default)]
struct Bright {
    pixels: u32,
    place: (i32, i32),
    square: (i64, i64, i64),
    level: u32,
    place_level: (i64, i64),
    /// Squares of the mean levels.
    squares: u64,
    areas: u16,
    clipped: u16,
}

impl Bright {
    #[inline(always)]
    fn add(&mut self, (x, y): (i32, i32), (log, sum): (u32, u32)) {
        let level = sum as i32;
        self.pixels += 1 << log;
        self.place.0 += x << log;
        self.place.1 += y << log;
        self.square.0 += i64::from((x * x) << log);
        self.square.1 += i64::from((x * y) << log);
        self.square.2 += i64::from((y * y) << log);
        self.level += sum;
        self.place_level.0 += i64::from(x * level);
        self.place_level.1 += i64::from(y * level);
        self.squares += u64::from((sum * sum) >> log);
        self.areas += 1;
        self.clipped += u16::from(sum >= (256 - END) << log);
    }
}

impl Levels {
    /// Those of a target that nothing disturbs; `None` where nothing is flat, or too much of it clipped.
    #[inline(never)]
    pub fn of_flat(edges: &Edges<'_>, pool: &Pool<'_>) -> Option<Self> {
        let (mut dark, mut bright) = (Dark::default(), Bright::default());
        for edge in edges.edges {
            for crossing in pool.iter(edge.crossings) {
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
        let pixels = sums.pixels as f32;
        let (x, y) = (0.5 * sums.place.0 as f32, 0.5 * sums.place.1 as f32);
        let (xx, xy, yy) = sums.square;
        let [xx, xy, yy] = [xx, xy, yy].map(|sum| 0.25 * sum as f32);
        let (x_level, y_level) = sums.place_level;
        let right = [sums.level as f32, 0.5 * x_level as f32, 0.5 * y_level as f32];
        let factor = Factor::new(&[[pixels, 0.0, 0.0], [x, xx, 0.0], [y, xy, yy]])?;
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
