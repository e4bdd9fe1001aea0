//! Whether the kernels of this processor give what they must, on every class of row: against models that look at one pixel
//! after the other. Compiled for tests only, of the desktop and of firmware.

use super::kernel::portable::Portable;
use super::kernel::{Best, Bytes, Line, MOST, ONES, TOP, WORDS, extremes_by};
use super::rows::{KEPT_ROWS, Rows};
use super::strips::{FLAGS, RESTLESS, STRIP, Strip, WINDOW, calm};

/// The pixels of a strip's row.
type Pixels = [u8; STRIP];

/// What was compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Agreement {
    /// Results that were compared with a model's.
    pub compared: u32,
    /// Results that differ.
    pub different: u32,
}

impl Agreement {
    fn see(&mut self, agrees: bool) {
        self.compared += 1;
        self.different += u32::from(!agrees);
    }
}

/// A comparison. `flawed`, the kernels are given other pixels than the models, which must be noticed.
pub type Comparison = fn(flawed: bool) -> Agreement;

/// All comparisons, with their names.
pub const ALL: [(&str, Comparison); 8] = [
    ("bytes", bytes::<Best>),
    ("bytes, portable", bytes::<Portable>),
    ("dark pixels", dark::<Best>),
    ("dark pixels, portable", dark::<Portable>),
    ("extremes", extremes::<Best>),
    ("extremes, portable", extremes::<Portable>),
    ("calm strips", calm_strips),
    ("copied rows", copied_rows),
];

/// Numbers without an order.
struct Random(u32);

impl Random {
    fn next(&mut self, most: u32) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) % (most + 1)
    }
}

/// Rows of every kind, for every grey level: flat, noisy, all noise, with one edge, with many.
fn every_row(mut see: impl FnMut(Pixels)) {
    let mut random = Random(1);
    for level in 0..=u8::MAX {
        see([level; STRIP]);
        see([0; STRIP].map(|_: u8| level.saturating_add(random.next(8) as u8)));
        see([0; STRIP].map(|_: u8| random.next(255) as u8));
        let (edge, other) = (random.next(31) as usize, random.next(255) as u8);
        see(core::array::from_fn(|x| if x < edge { level } else { other }));
        see(core::array::from_fn(|x| if x % 2 == 0 { level } else { 255 - level }));
    }
}

fn line(pixels: &Pixels, flawed: bool) -> Line {
    let mut pixels = *pixels;
    if flawed {
        pixels[13] ^= 0x80;
    }
    bytemuck::cast(pixels)
}

/// Every pair of half levels, in every place of a word.
fn bytes<B: Bytes>(flawed: bool) -> Agreement {
    let mut found = Agreement::default();
    let word = |byte: u32| byte | ((byte * 5) & 0x7f) << 8 | (byte ^ 0x7f) << 16 | ((byte * 3) & 0x7f) << 24;
    let by_byte = |a: u32, b: u32, rule: fn(u8, u8) -> u8| {
        let (a, b) = (a.to_le_bytes(), b.to_le_bytes());
        u32::from_le_bytes(core::array::from_fn(|k| rule(a[k], b[k])))
    };
    for (a, b) in (0..128).flat_map(|a| (0..128).map(move |b| (a, b))) {
        let (a, b) = (word(a), b * ONES);
        let given = a ^ if flawed { 1 << 16 } else { 0 };
        let mask = by_byte(a, b, |a, b| if a >= b { 0x7f } else { 0 });
        found.see(B::choose(given, b, MOST, 0) == mask);
        let chosen = by_byte(a, b, |a, b| if a >= b { 0x15 } else { 0x6a });
        found.see(B::choose(given, b, 0x15 * ONES, 0x6a * ONES) == chosen);
        found.see(B::sort(given, b) == [by_byte(a, b, u8::min), by_byte(a, b, u8::max)]);
        found.see(B::less(given, b) == by_byte(a, b, u8::saturating_sub));
    }
    found
}

fn dark<B: Bytes>(flawed: bool) -> Agreement {
    let (mut found, mut random, mut above) = (Agreement::default(), Random(2), [0; STRIP]);
    every_row(|pixels| {
        let half = pixels[13] / 2;
        // As most rows have it, beside a level, at either end.
        for thresholds in [
            core::array::from_fn(|_| random.next(127) as u8),
            [half; 4],
            [(half + 1).min(127); 4],
            [0, 127, 0, 127],
            [127, 0, 127, 0],
        ] {
            let model = |row: &Pixels| {
                let is_dark = |x: usize| row[x] / 2 < thresholds[x / 8];
                (0..STRIP).fold(0, |bits, x| bits | u32::from(is_dark(x)) << x)
            };
            let lines = [line(&above, false), line(&pixels, flawed)];
            let rows = [Some(&lines[0]), Some(&lines[1]), None, Some(&lines[0])];
            let found_dark = B::dark(rows, u32::from_le_bytes(thresholds));
            found.see(found_dark == [model(&above), model(&pixels), 0, model(&above)]);
        }
        above = pixels;
    });
    found
}

fn extremes<B: Bytes>(flawed: bool) -> Agreement {
    let (mut found, mut above) = (Agreement::default(), [0; STRIP]);
    every_row(|pixels| {
        let cell = |c: usize| {
            let samples = above[8 * c..][..4].iter().chain(&pixels[8 * c + 4..][..4]);
            samples.fold((u8::MAX, 0), |(low, high), &level| (level.min(low), level.max(high)))
        };
        let cells = [0, 1, 2, 3].map(cell);
        let model = [cells.map(|(low, _)| low / 2), cells.map(|(_, high)| high / 2)].map(u32::from_le_bytes);
        found.see(extremes_by::<B>(&line(&above, false), &line(&pixels, flawed)) == model);
        above = pixels;
    });
    found
}

/// Strips of a block, one of which is not calm.
const STRIPS: usize = 9;

fn calm_strips(flawed: bool) -> Agreement {
    let (mut found, mut random) = (Agreement::default(), Random(3));
    for round in 0..600 {
        let (width, level) = (1 + random.next(20), random.next(100));
        let sample = |random: &mut Random| 2 * (level + random.next(width - 1)) as u8 + random.next(1) as u8;
        let mut pixels = [[0; STRIP]; STRIPS];
        pixels.as_flattened_mut().iter_mut().for_each(|pixel| *pixel = sample(&mut random));
        let strip = |_| {
            let mut strip: Strip = core::array::from_fn(|_| random.next(u32::MAX - 1));
            strip[WINDOW] = TOP - level * ONES;
            // A few, more at the beginning than at the end.
            strip[FLAGS] = random.next(255) & if random.next(3) == 0 { !0 } else { !RESTLESS };
            strip
        };
        let strips: [Strip; STRIPS] = core::array::from_fn(strip);
        // A pixel that leaves the window by one level, at either end, or by as much as can be.
        let (at, x) = (random.next(STRIPS as u32) as usize, random.next(STRIP as u32 - 1) as usize);
        let outside = [2 * (level + width), (2 * level).saturating_sub(1), 255, 0][round % 4] as u8;
        if let Some(pixels) = pixels.get_mut(at).filter(|_| round % 8 < 6) {
            pixels[x] = outside;
        }
        let lines: [Line; STRIPS] = core::array::from_fn(|i| line(&pixels[i], flawed));
        for (count, first) in (0..=STRIPS).flat_map(|count| [(count, 0), (count, 1)]) {
            let [mut ours, mut expected] = [strips; 2];
            let within = |pixels: &Pixels| {
                let mut samples = (0..STRIP).filter(|x| x / 4 % 2 == first).map(|x| u32::from(pixels[x] / 2));
                samples.all(|level_here| (level..level + width).contains(&level_here))
            };
            let wanted = pixels[..count].iter().take_while(|pixels| within(pixels)).count();
            expected[..wanted].iter_mut().for_each(aged);
            let width = width * ONES;
            let calm = if first == 0 { calm::<0> } else { calm::<1> };
            // Where there are more lines than strips, and where there are as many.
            let lines = &lines[..if round % 2 == 0 { STRIPS } else { count }];
            found.see(calm(&mut ours[..count], lines, width) == wanted && ours == expected);
        }
    }
    found
}

/// A strip in which nothing has happened, a block later.
fn aged(strip: &mut Strip) {
    const ROOM: [usize; 2] = [0, 3];
    if strip[FLAGS] & RESTLESS != 0 {
        for first in ROOM {
            (strip[first], strip[first + 1]) = (strip[first + 1], strip[first + 2]);
        }
        strip[FLAGS] = strip[FLAGS] & !RESTLESS | (strip[FLAGS] << 1) & RESTLESS;
    }
}

/// Widths up to 9 strips, from every alignment in memory.
fn copied_rows(flawed: bool) -> Agreement {
    const WIDEST: usize = STRIPS * STRIP;
    let (mut found, mut random) = (Agreement::default(), Random(4));
    let mut kept = [0; KEPT_ROWS * STRIPS * WORDS];
    let mut memory = [[0u32; WORDS]; STRIPS + 1];
    let memory: &mut [u8] = bytemuck::cast_slice_mut(memory.as_flattened_mut());
    memory.iter_mut().for_each(|pixel| *pixel = random.next(255) as u8);
    for (width, offset) in (1..=WIDEST).flat_map(|width| (0..4).map(move |offset| (width, offset))) {
        let mut rows = Rows::new(&mut kept);
        rows.begin(width as u16, KEPT_ROWS as u16);
        for y in 0..3 {
            let row = &memory[offset + y..][..width];
            rows.push(row);
            let model = |x: usize| row[x.min(width - 1)] ^ u8::from(flawed && x == width / 2);
            let kept = rows.row(y as u16);
            found.see(
                kept.len() == width.next_multiple_of(STRIP) && (0..kept.len()).all(|x| kept[x] == model(x)),
            );
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_agree_with_their_models() {
        for (name, compare) in ALL {
            let found = compare(false);
            assert!(found.compared > 1000 && found.different == 0, "{name}: {found:?}");
        }
    }

    #[test]
    fn a_flaw_is_noticed() {
        for (name, compare) in ALL {
            let found = compare(true);
            assert!(found.different > found.compared / 20, "{name}: {found:?}");
        }
    }
}
