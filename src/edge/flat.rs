//! The levels of a target from the flat areas beside its edges: one look at each crossing, and more error than
//! [`Levels::refined`] has.

use super::{Edges, Levels};
use crate::fit::{Factor, dot};
use crate::math;
use crate::scan::{Axis, Crossing, Pool};

/// Where a far stretch begins, px / 2 from the middle of the crossing.
const BESIDE: i32 = 6;
/// Least room of a light area between two edges, px.
const ROOM: f32 = 14.0;
/// Least number of light areas.
const LEAST: u16 = 24;
/// Bits of places in units of the target, and most crossings that are looked at: the sums have 32 bits.
const PLACE: u32 = 7;
const MOST: usize = 2048;
/// How far beyond the target the samples reach, px.
const BEYOND: f32 = 16.0;
/// Least variance of a sample, grey levels: that of rounding.
const ROUNDING: f32 = 1.0 / 12.0;
/// Variance up to which that is so.
const MOST_ROUNDED: f32 = 0.5;
/// Levels from the end of the scale that noise clips, grey levels.
const END: u32 = 4;
/// One light area in so many may clip.
const CLIPPED_SHARE: u32 = 10;
/// Unit of the steps, 1/STEP grey levels.
const STEP: u32 = 4;

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
    /// Steps from the sample before an area to that, 1/[`STEP`] grey levels, and their squares.
    steps: i32,
    step_squares: u32,
}

impl Bright {
    #[inline(always)]
    fn add(&mut self, (x, y): (i32, i32), (log, sum): (u32, u32), before: u8) {
        let step = ((STEP * sum) >> log) as i32 - (STEP * u32::from(before)) as i32;
        self.steps += step;
        self.step_squares += step.unsigned_abs().pow(2);
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

    /// Variance of the steps, grey levels^2: whatever light there is, not less than that of a sample.
    fn step_variance(&self) -> f32 {
        let mean = |sum: f32| sum / f32::from(self.areas.max(1));
        let step = mean(self.steps as f32);
        (mean(self.step_squares as f32) - step * step) / (STEP * STEP) as f32
    }
}

impl Edges<'_> {
    /// How wide the light side of edge `k` is at least up to the next edge, px.
    fn light_room(&self, k: usize) -> f32 {
        let width = |k: usize| self.edges.get(k).map(|edge| edge.axes.1);
        let Some(edge) = self.edges.get(k) else { return 0.0 };
        if edge.dark_inside {
            k.checked_sub(1).and_then(width).map_or(f32::INFINITY, |outer| outer - edge.axes.1)
        } else {
            // The chord of an axis that is 45 degrees off the normal.
            width(k + 1).map_or(core::f32::consts::SQRT_2 * edge.axes.1, |inner| edge.axes.1 - inner)
        }
    }
}

impl Levels {
    /// Those of a target that nothing disturbs; `None` where nothing is flat, too much of it clipped, or not all of one level: then the
    /// levels vary by more than neighbouring samples do.
    #[inline(never)]
    pub fn of_flat(edges: &Edges<'_>, pool: &Pool<'_>) -> Option<Self> {
        let farthest = (2.0 * (edges.edges.first()?.axes.0 + BEYOND)) as u32;
        let less = (u32::BITS - farthest.leading_zeros()).saturating_sub(PLACE);
        let (mut dark, mut bright) = (Dark::default(), Bright { less, ..Bright::default() });
        // An odd one: a row leaves a crossing on either side.
        let crossings: usize = edges.edges.iter().map(|edge| usize::from(edge.crossings.len())).sum();
        let stride = (crossings / (MOST / 2)) | 1;
        for (k, edge) in edges.edges.iter().enumerate() {
            let tells_light = edges.light_room(k) >= ROOM;
            for crossing in pool.iter(edge.crossings).step_by(stride) {
                add(crossing, edges.origin, &mut dark, tells_light.then_some(&mut bright));
            }
        }
        let clips = CLIPPED_SHARE * u32::from(bright.clipped) > u32::from(bright.areas);
        if clips || bright.areas < LEAST || dark.pixels == 0 {
            return None;
        }
        Self::solve(&bright, dark.level as f32 / dark.pixels as f32)
    }

    fn solve(sums: &Bright, dark: f32) -> Option<Self> {
        let free = f32::from(sums.areas.checked_sub(3)?);
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
        if variance > sums.step_variance().max(MOST_ROUNDED) {
            return None;
        }
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

/// Adds what is beside a crossing on either side: the far stretch, or on the dark side, where that has one pixel and can be near the next
/// edge, of the two samples before it the one that no edge has a part in.
#[inline(always)]
fn add(crossing: &Crossing, origin: (u16, u16), dark: &mut Dark, bright: Option<&mut Bright>) {
    let [before, after] = crossing.far();
    let [first, second, .., fifth, sixth] = crossing.near;
    let rising = crossing.is_rising();
    let ((of_dark, darkest), (of_light, beside)) = if rising {
        ((before, first.min(second)), (after, sixth))
    } else {
        ((after, fifth.min(sixth)), (before, first))
    };
    let (log, sum) = of_dark.sum();
    dark.pixels += 1 << log;
    dark.level += if log > 0 { sum.into() } else { u32::from(darkest) };
    let (log, sum) = of_light.sum();
    if log > 0
        && let Some(bright) = bright
    {
        let away = BESIDE + (1 << log);
        let away = if rising { away } else { -away };
        let (x, y) = crossing.middle(origin);
        let place = if crossing.axis() == Axis::Row { (x + away, y) } else { (x, y + away) };
        bright.add(place, (log, sum.into()), beside);
    }
}
