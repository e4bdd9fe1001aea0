//! Normal equations of all ellipses and of what they share: an arrow of 5 x 5 blocks, summed up in integers.
//!
//! In the units of the sums, a unit of an outline's terms moves its edge by half its semi-major axis, the light's slopes are those
//! over [`Scene::unit`] with 256 grey levels, and the logarithm of the blur changes levels by the contrast.

use super::scene::Scene;
use super::view::{Far, View};
use crate::appearance::{OWN, SHARED};
use crate::fit::Matrix;
use crate::fixed::{GREY, ONE, scale, unit, wide};
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Most that a crossing may weigh, for the room of its products.
const MOST: i32 = ONE * 3 / 2;

/// A place in units of [`Scene::unit`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    pub x: i32,
    pub y: i32,
}

/// Sums over the samples of a crossing, of products of: 1 (n), lightness (l), its changes with the logarithm of the blur (b) and
/// with the place of the edge (p), and the residual (r).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub n: i32,
    pub l: i32,
    pub ll: i32,
    pub b: i32,
    pub lb: i32,
    pub bb: i32,
    pub p: i32,
    pub lp: i32,
    pub bp: i32,
    pub pp: i32,
    pub r: i32,
    pub lr: i32,
    pub br: i32,
    pub pr: i32,
    pub rr: i32,
}

impl Sums {
    /// Of samples.
    #[inline]
    pub fn new<const N: usize>(n: i32, [l, b, p, r]: [&[i32; N]; 4]) -> Self {
        let total = |a: &[i32; N]| a.iter().sum();
        let product = |a: &[i32; N], b: &[i32; N]| a.iter().zip(b).map(|(a, b)| a * b).sum();
        Self {
            n,
            l: total(l),
            ll: product(l, l),
            b: total(b),
            lb: product(b, l),
            bb: product(b, b),
            p: total(p),
            lp: product(p, l),
            bp: product(p, b),
            pp: product(p, p),
            r: total(r),
            lr: product(r, l),
            br: product(r, b),
            pr: product(r, p),
            rr: product(r, r),
        }
    }
}

/// What the crossings of one part of an outline tell together: all but where exactly the edge is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    /// Number of crossings, and sums of what they see.
    crossings: i32,
    direction: (i32, i32),
    place: Place,
    light: i32,
    reach: i32,
    sums: Sums,
}

/// Parts of an outline.
pub(super) const PARTS: usize = 16;

impl Part {
    /// The sums with fewer bits, so that there is room for those of all crossings.
    #[inline]
    fn add(&mut self, view: &View<'_>, sums: &Sums) {
        self.crossings += 1;
        self.direction.0 += view.direction().0;
        self.direction.1 += view.direction().1;
        self.place.x += view.place().x;
        self.place.y += view.place().y;
        self.light += view.light();
        self.reach += view.reach();
        let own = &mut self.sums;
        own.n += sums.n << SUM_BITS;
        own.l += sums.l >> (14 - SUM_BITS);
        own.ll += sums.ll >> (28 - SUM_BITS);
        own.b += sums.b >> (14 - SUM_BITS);
        own.lb += sums.lb >> (28 - SUM_BITS);
        own.bb += sums.bb >> (28 - SUM_BITS);
        own.p += sums.p >> (14 - SUM_BITS);
        own.lp += sums.lp >> (28 - SUM_BITS);
        own.bp += sums.bp >> (28 - SUM_BITS);
        own.pp += sums.pp >> (28 - SUM_BITS);
    }
}

/// Bits of the sums of a part.
pub(super) const SUM_BITS: u32 = 12;
/// The same of those with residuals.
pub(super) const RIGHT_BITS: u32 = 10;

/// The model where the crossings of a part are, on average.
struct Here {
    light: i32,
    place: Place,
    dark: i32,
    bright: i32,
}

impl Here {
    /// Products of a quantity with the derivatives by dark, bright, and the light's slopes, from its sums with 1 and lightness.
    #[inline]
    fn with_levels(&self, sum: i32, with_lightness: i32) -> [i32; 4] {
        let (dark, bright) = (sum - with_lightness, with_lightness);
        let mixed = self.mixed(dark, bright);
        [
            scale(dark, self.light),
            scale(bright, self.light),
            scale(mixed, self.place.x),
            scale(mixed, self.place.y),
        ]
    }

    fn mixed(&self, dark: i32, bright: i32) -> i32 {
        scale(dark, self.dark) + scale(bright, self.bright)
    }
}

/// Derivatives of the conic by its terms at a place in the frame where it is the unit circle.
#[inline]
fn terms((u, v): (i32, i32)) -> [i32; OWN] {
    [scale(u, u) - scale(v, v), 2 * scale(u, v), ONE, u, v]
}

/// An outline's part.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Block {
    pub m: Matrix<OWN, i32>,
    pub right: [i64; OWN],
    /// Rows: the conic's terms; columns: what is shared.
    pub cross: [[i32; SHARED]; OWN],
    /// Of the crossings: squared products of the residuals with the change by the place of the edge, and squares of that.
    pub residuals: i64,
    pub squares: i32,
    /// Inverse variances of the edge points, and their number.
    pub information: i32,
    pub points: u16,
}

impl Block {
    #[inline]
    fn add(&mut self, view: &View<'_>, sums: &Sums) {
        let unit = scale(view.reach(), view.light()).min(MOST);
        let right = i64::from(wide(sums.pr, unit, 14));
        for (sum, term) in self.right.iter_mut().zip(terms(view.direction())) {
            *sum += right * i64::from(term);
        }
        let residual = sums.pr >> 8;
        self.residuals += i64::from(residual) * i64::from(residual);
        self.points = self.points.saturating_add(1);
    }

    /// The mean of a part's crossings, for as many as have a sum of `1 << log`.
    fn add_part(&mut self, part: &Part, here: &Here, log: u32) {
        let Sums { p, lp, bp, pp, .. } = part.sums;
        self.squares += pp;
        let [p, lp, bp, pp] = [p, lp, bp, pp].map(|sum| sum >> log);
        let terms = terms(part.direction);
        let unit = scale(part.reach, here.light).min(MOST);
        let square = scale(scale(unit, unit), pp);
        let [dark, bright, x, y] = here.with_levels(scale(p, unit), scale(lp, unit));
        let blur = scale(scale(bp, unit), here.light);
        let shared = [dark, bright, x, y, blur];
        for i in 0..OWN {
            for j in 0..=i {
                self.m[i][j] += scale(square, scale(terms[i], terms[j])) << log;
            }
            for j in 0..SHARED {
                self.cross[i][j] += scale(terms[i], shared[j]) << log;
            }
        }
        self.information += scale(scale(here.light, here.light), pp) << log;
    }
}

/// What the far stretches of one side tell: the sums over their pixels of the products of 1, the place, and the residual.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    n: i32,
    x: i32,
    y: i32,
    xx: i32,
    xy: i32,
    yy: i32,
    r: i64,
    rx: i64,
    ry: i64,
}

/// Bits of places in these.
const PLACE_BITS: u32 = 9;

impl Side {
    /// Equations of the level and of the light's slopes, which change the side's level by `level`, where the light has the slopes
    /// `(gx, gy)`.
    pub fn equations(&self, level: f32, (gx, gy): (f32, f32)) -> ([[f32; 3]; 3], [f32; 3]) {
        let one = (1 << PLACE_BITS) as f32;
        let [x, y, xx, xy, yy] = [self.x, self.y, self.xx, self.xy, self.yy].map(|sum| sum as f32 / one);
        let [rx, ry] = [self.rx, self.ry].map(|sum| sum as f32 / one);
        let (n, r) = (self.n as f32, self.r as f32);
        let (lx, ly) = (x + gx * xx + gy * xy, y + gx * xy + gy * yy);
        let square = n + gx * (x + lx) + gy * (y + ly);
        let level_square = level * level;
        let grey = 1.0 / GREY as f32;
        (
            [
                [square, 0.0, 0.0],
                [level * lx, level_square * xx, 0.0],
                [level * ly, level_square * xy, level_square * yy],
            ],
            [grey * (r + gx * rx + gy * ry), grey * level * rx, grey * level * ry],
        )
    }
}

/// All of them.
#[derive(Clone, Debug)]
pub(super) struct Arrow {
    /// Of the outlines so far.
    pub blocks: Vec<Block, MAX_CIRCLES>,
    pub shared: Matrix<SHARED, i64>,
    pub right: [i64; SHARED],
    /// Far stretches of the dark and of the light side.
    pub sides: [Side; 2],
    /// Squared residuals of the samples, and their number.
    pub squares: i64,
    pub samples: i32,
}

impl Arrow {
    pub fn new() -> Self {
        Self {
            blocks: Vec::new(),
            shared: [[0; SHARED]; SHARED],
            right: [0; SHARED],
            sides: [Side::default(); 2],
            squares: 0,
            samples: 0,
        }
    }

    pub fn clear(&mut self) {
        self.blocks.clear();
        self.shared = [[0; SHARED]; SHARED];
        self.right = [0; SHARED];
        self.sides = [Side::default(); 2];
        (self.squares, self.samples) = (0, 0);
    }

    /// The next outline's crossings follow.
    pub fn next(&mut self) {
        let _ = self.blocks.push(Block::default());
    }

    /// Adds a crossing that lies in `part`.
    #[inline]
    pub fn add(&mut self, part: &mut Part, view: &View<'_>, sums: &Sums, scene: &Scene<'_>) {
        part.add(view, sums);
        if let Some(block) = self.blocks.last_mut() {
            block.add(view, sums);
        }
        let (r, lr) = (sums.r << (RIGHT_BITS - 6), sums.lr >> (20 - RIGHT_BITS));
        let mixed = wide(r - lr, scene.dark, 14) + wide(lr, scene.bright, 14);
        let (light, Place { x, y }) = (view.light(), view.place());
        let products =
            [(r - lr, light), (lr, light), (mixed, x), (mixed, y), (sums.br >> (20 - RIGHT_BITS), light)];
        for (right, (a, b)) in self.right.iter_mut().zip(products) {
            *right += i64::from(a) * i64::from(b);
        }
        self.squares += i64::from(sums.rr);
        self.samples += sums.n;
    }

    /// Adds the parts of the outline.
    pub fn add_parts(&mut self, parts: &[Part; PARTS], scene: &Scene<'_>) {
        for part in parts.iter().filter(|part| part.crossings > 0) {
            self.add_part(part, scene);
        }
    }

    fn add_part(&mut self, part: &Part, scene: &Scene<'_>) {
        let count = part.crossings.max(1);
        let mean = |sum: i32| sum / count;
        let direction = unit((mean(part.direction.0), mean(part.direction.1)));
        let place = Place { x: mean(part.place.x), y: mean(part.place.y) };
        let here = Here { light: mean(part.light), place, dark: scene.dark, bright: scene.bright };
        let part = Part { direction, reach: mean(part.reach), ..*part };
        let log = i32::BITS - count.leading_zeros();
        if let Some(block) = self.blocks.last_mut() {
            block.add_part(&part, &here, log);
        }
        let Sums { n, l, ll, b, lb, bb, .. } = part.sums;
        let [n, l, ll, b, lb, bb] = [n, l, ll, b, lb, bb].map(|sum| sum >> log);
        let (light, Place { x, y }) = (here.light, here.place);
        let [dark_dark, dark_bright, dark_x, dark_y] = here.with_levels(n - l, l - ll);
        let [_, bright_bright, bright_x, bright_y] = here.with_levels(l, ll);
        let (mixed_x, mixed_y) = (here.mixed(dark_x, bright_x), here.mixed(dark_y, bright_y));
        let [blur_dark, blur_bright, blur_x, blur_y] = here.with_levels(scale(b, light), scale(lb, light));
        let rows = [
            [scale(light, dark_dark), 0, 0, 0, 0],
            [scale(light, dark_bright), scale(light, bright_bright), 0, 0, 0],
            [scale(light, dark_x), scale(light, bright_x), scale(x, mixed_x), 0, 0],
            [scale(light, dark_y), scale(light, bright_y), scale(y, mixed_x), scale(y, mixed_y), 0],
            [blur_dark, blur_bright, blur_x, blur_y, scale(scale(bb, light), light)],
        ];
        for i in 0..SHARED {
            for j in 0..=i {
                self.shared[i][j] += i64::from(rows[i][j]) << log;
            }
        }
    }

    /// Adds a far stretch. What little it has of the other level counts for its residual only.
    #[inline]
    pub fn add_far(&mut self, far: &Far) {
        let pixels = 1 << far.log;
        let [dark, bright] = &mut self.sides;
        let side = if far.bright { bright } else { dark };
        let (x, y) = (far.place.x >> (14 - PLACE_BITS), far.place.y >> (14 - PLACE_BITS));
        let (px, py, residual) = (pixels * x, pixels * y, pixels * far.residual);
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        side.n += pixels;
        side.x += px;
        side.y += py;
        side.xx += (px * x) >> PLACE_BITS;
        side.xy += (px * y) >> PLACE_BITS;
        side.yy += (py * y) >> PLACE_BITS;
        side.r += i64::from(residual);
        side.rx += product(residual, x);
        side.ry += product(residual, y);
        self.squares += product(residual, far.residual);
        self.samples += 1;
    }
}
