//! What the crossings of one part of an outline tell together, in sums of 32 bits.

use super::samples::{Far, Samples};
use super::scene::Scene;
use super::view::View;
use crate::appearance::OWN;
use crate::fixed::{ONE, scale, unit};
use crate::scan::NEAR;

/// Most that a crossing may weigh, for the room of its products.
pub(super) const MOST: i32 = ONE * 3 / 2;

/// Sums over the samples of a crossing, of products of: 1 (n), lightness (l), its changes with the logarithm of the blur (b) and
/// with the place of the edge (p).
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
}

/// The same of products of these with the residual (r).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Residuals {
    pub n: i32,
    pub r: i32,
    pub lr: i32,
    pub br: i32,
    pub pr: i32,
    pub rr: i32,
}

/// The sum over samples, and that of products.
#[inline]
fn total(a: &[i32; NEAR]) -> i32 {
    a.iter().sum()
}

#[inline]
fn product(a: &[i32; NEAR], b: &[i32; NEAR]) -> i32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Sums {
    /// Adds those of a crossing with fewer bits, so that there is room for those of [`FULL`] crossings.
    #[inline]
    fn add(&mut self, &Samples { n, lightness: ref l, by_blur: ref b, by_place: ref p, .. }: &Samples) {
        self.n += n << SUM_BITS;
        self.l += total(l) >> (14 - SUM_BITS);
        self.ll += product(l, l) >> (28 - SUM_BITS);
        self.b += total(b) >> (14 - SUM_BITS);
        self.lb += product(l, b) >> (28 - SUM_BITS);
        self.bb += product(b, b) >> (28 - SUM_BITS);
        self.p += total(p) >> (14 - SUM_BITS);
        self.lp += product(l, p) >> (28 - SUM_BITS);
        self.bp += product(b, p) >> (28 - SUM_BITS);
        self.pp += product(p, p) >> (28 - SUM_BITS);
    }

    pub fn map(&self, of: impl Fn(i32) -> i32) -> Self {
        let Self { n, l, ll, b, lb, bb, p, lp, bp, pp } = *self;
        let [n, l, ll, b, lb] = [n, l, ll, b, lb].map(&of);
        let [bb, p, lp, bp, pp] = [bb, p, lp, bp, pp].map(&of);
        Self { n, l, ll, b, lb, bb, p, lp, bp, pp }
    }
}

impl Residuals {
    /// Of a crossing.
    #[inline]
    pub fn new(samples: &Samples) -> Self {
        let Samples { n, lightness, by_blur, by_place, single, .. } = samples;
        Self {
            n: *n,
            r: total(single),
            lr: product(lightness, single),
            br: product(by_blur, single),
            pr: product(by_place, single),
            rr: product(single, single),
        }
    }

    /// Adds those of a crossing with fewer bits.
    #[inline]
    fn take(&mut self, of: &Self) {
        self.n += of.n;
        self.r += of.r << (RIGHT_BITS - 6);
        self.lr += of.lr >> (20 - RIGHT_BITS);
        self.br += of.br >> (20 - RIGHT_BITS);
        self.rr += (of.rr + (1 << (SQUARE_BITS - 1))) >> SQUARE_BITS;
    }
}

/// The far stretches of a part on one side: their number, and sums over their pixels of 1, the place, and the residual.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stretches {
    pub count: i32,
    pub n: i32,
    pub x: i32,
    pub y: i32,
    pub r: i32,
}

/// What the crossings of one part of an outline tell together.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    /// Number of crossings, and sums of what they see; places in px / 2.
    pub crossings: i32,
    pub direction: (i32, i32),
    pub place: (i32, i32),
    pub reach: i32,
    /// All but `pr`.
    pub residuals: Residuals,
    pub sums: Sums,
    /// Of the conic's terms with the residuals, each where its edge is.
    pub right: [i32; OWN],
    /// Of the light's slopes with the residuals.
    pub slopes: (i32, i32),
    /// Squared products of the residuals with the change by the place of the edge.
    pub scatter: i32,
    /// Dark and bright.
    pub sides: [Stretches; 2],
}

/// Parts of an outline.
pub(super) const PARTS: usize = 16;
/// Crossings for which a part has room.
pub(super) const FULL: i32 = 128;
/// Largest product of residuals with the change by the place, in the unit of its squares.
const MOST_RESIDUAL: i32 = 1 << 15;

impl Part {
    /// Adds a crossing.
    #[inline]
    pub fn add(&mut self, view: &View<'_>, samples: &Samples, scene: &Scene<'_>) {
        let (u, v) = view.direction();
        let (x, y) = view.place();
        self.crossings += 1;
        self.direction = (self.direction.0 + u, self.direction.1 + v);
        self.place = (self.place.0 + x, self.place.1 + y);
        self.reach += view.reach();
        let of = &samples.residuals;
        self.residuals.take(of);
        self.sums.add(samples);
        let light = of.lr >> 14;
        let mixed = (of.r - light) * scene.dark + light * scene.bright;
        let mixed = (mixed + (1 << (19 - SLOPE_BITS))) >> (20 - SLOPE_BITS);
        self.slopes = (self.slopes.0 + mixed * x, self.slopes.1 + mixed * y);
        let pull = (of.pr + (1 << 11)) >> 12;
        let residual = pull.clamp(-MOST_RESIDUAL, MOST_RESIDUAL - 1);
        self.scatter += (residual * residual + (1 << 7)) >> 8;
        let pull = scale(pull, scale(view.reach(), view.light()).min(MOST));
        for (sum, term) in self.right.iter_mut().zip(terms((u, v))) {
            *sum += (pull * term) >> (22 - OWN_BITS);
        }
    }

    /// Adds a far stretch. What little it has of the other level counts for its residual only.
    #[inline]
    pub fn add_far(&mut self, far: &Far) {
        let [dark, bright] = &mut self.sides;
        let side = if far.bright { bright } else { dark };
        side.count += 1;
        side.n += 1 << far.log;
        side.x += far.place.0 << far.log;
        side.y += far.place.1 << far.log;
        side.r += far.residual << far.log;
        self.residuals.rr += ((far.residual * far.residual) << far.log) >> SQUARE_BITS;
    }

    /// The model where the crossings are, on average.
    pub fn here(&self, scene: &Scene<'_>, mean: impl Fn(i32) -> i32) -> Here {
        let place = (mean(self.place.0), mean(self.place.1));
        let light = scene.light(place);
        Here {
            light,
            place: (scene.place(place.0), scene.place(place.1)),
            dark: scene.dark,
            bright: scene.bright,
            terms: terms(unit((mean(self.direction.0), mean(self.direction.1)))),
            unit: scale(mean(self.reach), light).min(MOST),
            crossings: self.crossings,
        }
    }
}

/// Bits of the sums of a part.
pub(super) const SUM_BITS: u32 = 12;
/// The same of those with residuals, ...
pub(super) const RIGHT_BITS: u32 = 10;
/// ... with residuals and the conic's terms, ...
pub(super) const OWN_BITS: u32 = 13;
/// ... with residuals and places, ...
pub(super) const SLOPE_BITS: u32 = 2;
/// ... and of squared products of residuals.
pub(super) const RESIDUAL_BITS: u32 = 8;
/// Bits by which the squared residuals of a part are fewer.
pub(super) const SQUARE_BITS: u32 = 6;

/// The model where the crossings of a part are, on average.
pub(super) struct Here {
    pub light: i32,
    pub place: (i32, i32),
    pub dark: i32,
    pub bright: i32,
    pub terms: [i32; OWN],
    /// What a unit of the terms moves.
    pub unit: i32,
    pub crossings: i32,
}

/// The mean of so many.
pub(super) fn mean_of(count: i32) -> impl Fn(i32) -> i32 {
    let count = count.max(1);
    let inverse = ((1 << 16) + count / 2) / count;
    move |sum| (sum * inverse) >> 16
}

impl Here {
    /// Products of a quantity with the derivatives by dark, bright, and the light's slopes, from its sums with 1 and lightness.
    #[inline]
    pub fn with_levels(&self, sum: i32, with_lightness: i32) -> [i32; 4] {
        let (dark, bright) = (sum - with_lightness, with_lightness);
        let mixed = self.mixed(dark, bright);
        [
            scale(dark, self.light),
            scale(bright, self.light),
            scale(mixed, self.place.0),
            scale(mixed, self.place.1),
        ]
    }

    pub fn mixed(&self, dark: i32, bright: i32) -> i32 {
        (dark * self.dark + bright * self.bright + ONE / 2) >> 14
    }

    /// A product for all crossings.
    #[inline]
    pub fn all(&self, a: i32, b: i32) -> i32 {
        scale(a, b) * self.crossings
    }
}

/// Derivatives of the conic by its terms at a place in the frame where it is the unit circle.
#[inline]
fn terms((u, v): (i32, i32)) -> [i32; OWN] {
    [(u * u - v * v) >> 14, (u * v) >> 13, ONE, u, v]
}
