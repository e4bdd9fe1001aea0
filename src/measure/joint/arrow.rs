//! Normal equations of all ellipses and of what they share: an arrow of 5 x 5 blocks, summed up in integers.
//!
//! In the units of the sums, a unit of an outline's terms moves its edge by half its semi-major axis, the light's slopes are those
//! over [`Scene::unit`] with 256 grey levels, and the logarithm of the blur changes levels by the contrast.

use super::fixed::{GREY, ONE, scale, wide};
use super::scene::Scene;
use super::view::{Far, View};
use crate::appearance::{Model, OWN, SHARED, Spread, Step};
use crate::fit::{CENTRE_TERMS, Factor, Matrix};
use crate::list::list;
use crate::target::MAX_CIRCLES;
use heapless::Vec;

/// Grey levels of one in the units of the sums.
const LEVELS: f32 = 256.0;
/// What is one in the sums: of products of terms, of those of what is shared, and of these with residuals.
const OWN_ONE: f32 = ONE as f32;
const SHARED_ONE: f32 = (ONE / 4) as f32;
const RIGHT_ONE: f32 = ONE as f32 * ONE as f32 * GREY as f32;
const SQUARE_ONE: f32 = (GREY * GREY) as f32;

/// Most that a crossing may weigh, for the room of its products.
const MOST: i32 = ONE * 3 / 2;

/// A place in units of [`Scene::unit`].
#[derive(Clone, Copy, Debug)]
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
    /// Adds samples.
    #[inline]
    pub fn add<const N: usize>(&mut self, l: &[i32; N], b: &[i32; N], p: &[i32; N], r: &[i32; N]) {
        let total = |a: &[i32; N]| a.iter().sum::<i32>();
        let product = |a: &[i32; N], b: &[i32; N]| a.iter().zip(b).map(|(a, b)| a * b).sum::<i32>();
        self.l += total(l);
        self.ll += product(l, l);
        self.b += total(b);
        self.lb += product(b, l);
        self.bb += product(b, b);
        self.p += total(p);
        self.lp += product(p, l);
        self.bp += product(p, b);
        self.pp += product(p, p);
        self.r += total(r);
        self.lr += product(r, l);
        self.br += product(r, b);
        self.pr += product(r, p);
        self.rr += product(r, r);
    }
}

/// The model where a crossing is.
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
        let mixed = scale(dark, self.dark) + scale(bright, self.bright);
        [
            scale(dark, self.light),
            scale(bright, self.light),
            scale(mixed, self.place.x),
            scale(mixed, self.place.y),
        ]
    }

    /// The same of a quantity with more bits.
    #[inline]
    fn with_levels_wide(&self, sum: i32, with_lightness: i32) -> [i64; 4] {
        let (dark, bright) = (sum - with_lightness, with_lightness);
        let mixed = wide(dark, self.dark, 14) + wide(bright, self.bright, 14);
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        [
            product(dark, self.light),
            product(bright, self.light),
            product(mixed, self.place.x),
            product(mixed, self.place.y),
        ]
    }
}

/// An outline's part.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Block {
    m: Matrix<OWN, i32>,
    right: [i64; OWN],
    /// Rows: the conic's terms; columns: what is shared.
    cross: [[i32; SHARED]; OWN],
    /// Of the crossings: squared products of the residuals with the change by the place of the edge, and squares of that.
    residuals: i64,
    squares: i64,
    /// Inverse variances of the edge points, and their number.
    information: i64,
    pub points: u16,
}

impl Block {
    #[inline]
    fn add(&mut self, view: &View<'_>, here: &Here, sums: &Sums) {
        let (u, v) = view.direction();
        let terms = [scale(u, u) - scale(v, v), 2 * scale(u, v), ONE, u, v];
        let unit = scale(view.reach(), here.light).min(MOST);
        let (pp, lp) = (sums.pp >> 14, sums.lp >> 14);
        let square = scale(scale(unit, unit), pp);
        let right = wide(sums.pr, unit, 14);
        let [dark, bright, x, y] = here.with_levels(scale(sums.p, unit), scale(lp, unit));
        let blur = scale(scale(sums.bp >> 14, unit), here.light);
        let shared = [dark, bright, x, y, blur];
        for i in 0..OWN {
            let weighted = scale(square, terms[i]);
            for j in 0..=i {
                self.m[i][j] += scale(weighted, terms[j]);
            }
            self.right[i] += i64::from(right) * i64::from(terms[i]);
            for j in 0..SHARED {
                self.cross[i][j] += scale(terms[i], shared[j]);
            }
        }
        let residual = i64::from(sums.pr >> 8);
        self.residuals += residual * residual;
        self.squares += i64::from(pp);
        self.information += i64::from(scale(scale(here.light, here.light), pp));
        self.points = self.points.saturating_add(1);
    }
}

/// All of them.
#[derive(Clone, Debug)]
pub(super) struct Arrow {
    blocks: Vec<Block, MAX_CIRCLES>,
    shared: Matrix<SHARED, i64>,
    right: [i64; SHARED],
    /// Squared residuals of the samples, and their number.
    squares: i64,
    samples: i32,
}

impl Arrow {
    pub fn new(model: &Model) -> Self {
        let blocks = list(model.outlines.iter().map(|_| Block::default()));
        Self { blocks, shared: [[0; SHARED]; SHARED], right: [0; SHARED], squares: 0, samples: 0 }
    }

    /// Adds a crossing of outline `k`.
    #[inline]
    pub fn add(&mut self, k: usize, view: &View<'_>, s: &Sums, scene: &Scene<'_>) {
        let here = Here { light: view.light(), place: view.place(), dark: scene.dark, bright: scene.bright };
        if let Some(block) = self.blocks.get_mut(k) {
            block.add(view, &here, s);
        }
        // A quarter of the unit, which leaves room for all samples.
        let (n, l, ll) = (s.n << 12, s.l >> 2, s.ll >> 16);
        let (b, lb, bb) = (s.b >> 2, s.lb >> 16, s.bb >> 16);
        let (light, Place { x, y }) = (here.light, here.place);
        let [dark_dark, dark_bright, dark_x, dark_y] = here.with_levels(n - l, l - ll);
        let [_, bright_bright, bright_x, bright_y] = here.with_levels(l, ll);
        let mixed = |dark: i32, bright: i32| scale(dark, here.dark) + scale(bright, here.bright);
        let (mixed_x, mixed_y) = (mixed(dark_x, bright_x), mixed(dark_y, bright_y));
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
                self.shared[i][j] += i64::from(rows[i][j]);
            }
        }
        let [dark, bright, by_x, by_y] = here.with_levels_wide(s.r << 14, s.lr);
        let blur = i64::from(s.br) * i64::from(light);
        for (right, sum) in self.right.iter_mut().zip([dark, bright, by_x, by_y, blur]) {
            *right += sum;
        }
        self.squares += i64::from(s.rr);
        self.samples += s.n;
    }

    /// Adds a far stretch. What little it has of the other level counts for its residual only.
    pub fn add_far(&mut self, far: &Far) {
        let pixels = 1 << far.log;
        let (light, x, y) = (far.light, scale(far.mixed, far.place.x), scale(far.mixed, far.place.y));
        let square = |a: i32, b: i32| i64::from((scale(a, b) >> 2) * pixels);
        let residual = far.residual * pixels;
        let product = |a: i32| i64::from(a) * i64::from(residual << 11) << 3;
        let [[dark, ..], [_, bright, ..], [x_dark, x_bright, xx, ..], [y_dark, y_bright, yx, yy, _], _] =
            &mut self.shared;
        let [right_dark, right_bright, right_x, right_y, _] = &mut self.right;
        let (level, x_level, y_level, right) = if far.bright {
            (bright, x_bright, y_bright, right_bright)
        } else {
            (dark, x_dark, y_dark, right_dark)
        };
        *level += square(light, light);
        *x_level += square(x, light);
        *y_level += square(y, light);
        *xx += square(x, x);
        *yx += square(y, x);
        *yy += square(y, y);
        *right += product(light);
        *right_x += product(x);
        *right_y += product(y);
        self.squares += i64::from(far.residual * far.residual) << far.log;
        self.samples += 1;
    }

    /// `None` where the crossings do not determine the unknowns.
    pub fn solve(&self, scene: &Scene<'_>, size: f32) -> Option<Solved> {
        let model = scene.model();
        let contrast = model.contrast();
        let slope = LEVELS * scene.unit / size;
        // Derivatives by what is shared, in the units of the sums.
        let units = [1.0, 1.0, slope, slope, contrast];
        let mut rest = [[0.0; SHARED]; SHARED];
        for (i, weight) in model.prior().into_iter().enumerate() {
            for j in 0..=i {
                rest[i][j] = units[i] * units[j] / SHARED_ONE * self.shared[i][j] as f32;
            }
            rest[i][i] += weight;
        }
        let all_right: [f32; SHARED] = core::array::from_fn(|i| units[i] / RIGHT_ONE * self.right[i] as f32);
        let mut right = all_right;
        let mut parts = Vec::<Part, MAX_CIRCLES>::new();
        for (block, outline) in self.blocks.iter().zip(&model.outlines) {
            let (a, _) = outline.shape.semi_axes();
            let by_place = outline.inside * contrast / model.blur;
            let unit = -0.5 * a * by_place;
            let by_unit = unit * unit / OWN_ONE;
            let factor = Factor::new(&block.m.map(|row| row.map(|entry| by_unit * entry as f32)))?;
            let own_right = block.right.map(|sum| unit / RIGHT_ONE * sum as f32);
            let own = factor.solve(own_right);
            let crosses: [[f32; OWN]; SHARED] = core::array::from_fn(|j| {
                core::array::from_fn(|i| unit / OWN_ONE * units[j] * block.cross[i][j] as f32)
            });
            let by_shared = crosses.map(|cross| factor.solve(cross));
            for i in 0..SHARED {
                right[i] -= dot(&crosses[i], &own);
                for j in 0..=i {
                    rest[i][j] -= dot(&crosses[i], &by_shared[j]);
                }
            }
            // As if every crossing told as much of its place as they do on average.
            let squares = (block.squares as f32).max(1.0) / f32::from(block.points);
            let scatter = block.residuals as f32 * (ONE as f32 / (SQUARE_ONE * 4096.0 * 4096.0)) / squares;
            let information = by_place * by_place / OWN_ONE * block.information as f32;
            parts
                .push(Part {
                    factor,
                    by_shared,
                    own,
                    right: own_right,
                    scatter,
                    information,
                    points: block.points,
                })
                .ok()?;
        }
        let factor = Factor::new(&rest)?;
        let shared = factor.solve(right);
        let mut gain = dot(&shared, &all_right);
        for part in &mut parts {
            for j in 0..SHARED {
                for k in 0..OWN {
                    part.own[k] -= part.by_shared[j][k] * shared[j];
                }
            }
            let taken = dot(&part.own, &part.right);
            gain += taken;
            part.scatter = (part.scatter - taken).max(0.0);
        }
        let free = (self.samples - (OWN * self.blocks.len() + SHARED) as i32).max(1);
        let variance = (self.squares as f32 / SQUARE_ONE - gain).max(0.0) / free as f32;
        Some(Solved { parts, shared, variance, factor })
    }
}

fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// The solution for an outline.
struct Part {
    factor: Factor<OWN>,
    /// How its terms go with what is shared, negative.
    by_shared: [[f32; OWN]; SHARED],
    own: [f32; OWN],
    right: [f32; OWN],
    /// What moving each edge point by itself would take from the squares.
    scatter: f32,
    /// Inverse variances of the edge points for a unit variance of the samples, 1/px^2, and their number.
    information: f32,
    points: u16,
}

/// The solution.
pub(super) struct Solved {
    parts: Vec<Part, MAX_CIRCLES>,
    shared: [f32; SHARED],
    /// Variance of a sample after the step.
    pub variance: f32,
    factor: Factor<SHARED>,
}

impl Solved {
    pub fn step(&self) -> Step {
        Step { own: list(self.parts.iter().map(|part| part.own)), shared: self.shared }
    }

    /// Variance of a sample that the scatter of the edge points of outline `k` about its ellipse tells.
    pub fn scatter(&self, k: usize) -> Option<f32> {
        self.parts.get(k).map(|part| part.scatter / (f32::from(part.points) - OWN as f32).max(1.0))
    }

    /// Mean square distance of the edge points of outline `k` from its ellipse after the step, each with its weight, px^2.
    pub fn mean_square(&self, k: usize) -> Option<f32> {
        self.parts.get(k).map(|part| part.scatter / part.information)
    }

    /// Edge points of outline `k`.
    pub fn points(&self, k: usize) -> Option<u16> {
        self.parts.get(k).map(|part| part.points)
    }

    /// Covariances of outline `k` for a unit variance of the samples.
    pub fn spread(&self, k: usize) -> Option<Spread> {
        let part = self.parts.get(k)?;
        let mut spread = Spread { own: [[0.0; 4]; 4], shared: [[0.0; 4]; 4] };
        for (i, (term, scale)) in CENTRE_TERMS.into_iter().enumerate() {
            let own = part.factor.solve(core::array::from_fn(|i| if i == term { scale } else { 0.0 }));
            let moved = self.factor.solve(part.by_shared.map(|terms| scale * entry(&terms, term)));
            for (j, (other, scale)) in CENTRE_TERMS.into_iter().enumerate() {
                let shared = part
                    .by_shared
                    .iter()
                    .zip(moved)
                    .fold(0.0, |sum, (by, moved)| sum + entry(by, other) * moved);
                spread.own[i][j] = scale * entry(&own, other);
                spread.shared[i][j] = scale * shared;
            }
        }
        Some(spread)
    }
}

/// Entry `i` of an outline's own terms.
fn entry(terms: &[f32; OWN], i: usize) -> f32 {
    terms.get(i).copied().unwrap_or(0.0)
}
