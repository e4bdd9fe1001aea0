//! Whether anything lies in the gap of an open ring.

use super::points::Point;
use super::{Arc, expected_crossings};
use crate::fit::{Factor, Matrix, Spread};
use crate::scan::{Crossing, CrossingList, Pool};

/// Distance from both circles from which on a crossing is one of the ring's ends, px.
const CLEAR: f32 = 1.0;
/// Passes over the levels of the paper, and how far from it a level may be in the next, in standard deviations.
const PASSES: usize = 3;
const NEAREST: f32 = 1.5;
/// Share of the crossings of the ends that must agree: near the circles the levels are not those of the gap.
const MOST: f32 = 0.6;
/// Largest difference of the gap's level from the paper's, as a share of the contrast, with which it is paper, ...
const SAME: f32 = 0.05;
/// ... with room for this many standard deviations of the levels.
const SAME_SIGMAS: f32 = 3.0;

/// Whether a ring that is open between `circles`, the outer and the inner one with their crossings, shows paper in its gap: then
/// it is a letter C and no target with something over it. The ends of the ring are looked for in `rest`.
pub(crate) fn shows_paper(
    circles: [(&Arc, CrossingList); 2],
    rest: CrossingList,
    pool: &Pool<'_>,
    origin: (u16, u16),
) -> bool {
    let [(outer, _), (inner, _)] = circles;
    let half_seen = |(arc, list): &(&Arc, CrossingList)| {
        let (a, b) = arc.shape.semi_axes();
        f32::from(list.len()) > 0.5 * expected_crossings(a, b)
    };
    if !circles.iter().all(half_seen) {
        return false;
    }
    let scale = 1.0 / outer.shape.semi_axes().0;
    let place = |crossing: &Crossing| {
        let (x, y) = Point::new(crossing, origin).place();
        [1.0, (x - outer.shape.cx) * scale, (y - outer.shape.cy) * scale]
    };
    let crossings = || circles.iter().flat_map(|(_, list)| pool.iter(*list));
    let Some(paper) = Paper::of(crossings, place) else { return false };
    let limit = SAME * paper.contrast + SAME_SIGMAS * paper.sigma;
    let (mut agree, mut ends) = (0u16, 0u16);
    for crossing in pool.iter(rest) {
        let (x, y) = Point::new(crossing, origin).place();
        let beside = |arc: &Arc| arc.shape.distance(x, y).unwrap_or(f32::NEG_INFINITY);
        if beside(outer) < -CLEAR && beside(inner) > CLEAR {
            agree += u16::from(paper.excess(place(crossing), crossing).abs() < limit);
            ends += 1;
        }
    }
    ends > 0 && f32::from(agree) >= MOST * f32::from(ends)
}

/// Dark and light level beside a crossing.
fn levels(crossing: &Crossing) -> (f32, f32) {
    let [before, after] = crossing.far().map(|stretch| stretch.mean().1);
    if crossing.is_rising() { (before, after) } else { (after, before) }
}

/// The light side of a ring.
struct Paper {
    /// Plane of its levels.
    plane: [f32; 3],
    /// Mean difference from the dark side.
    contrast: f32,
    /// Standard deviation about the plane.
    sigma: f32,
}

impl Paper {
    /// The plane of most of the crossings: what lies over the target shows beside some of them.
    fn of<'c, I: Iterator<Item = &'c Crossing>>(
        crossings: impl Fn() -> I,
        place: impl Fn(&Crossing) -> [f32; 3],
    ) -> Option<Self> {
        let mut paper = Self { plane: [0.0; 3], contrast: 0.0, sigma: f32::INFINITY };
        for _ in 0..PASSES {
            let mut normals = Normals::default();
            for crossing in crossings() {
                let place = place(crossing);
                if paper.excess(place, crossing).abs() <= NEAREST * paper.sigma {
                    normals.add(place, levels(crossing));
                }
            }
            (paper.plane, paper.contrast) = normals.solve()?;
            let mut spread = Spread::default();
            for crossing in crossings() {
                let excess = paper.excess(place(crossing), crossing);
                spread.add(excess * excess);
            }
            paper.sigma = spread.sigma();
        }
        Some(paper)
    }

    /// Light level of a crossing above the plane.
    fn excess(&self, place: [f32; 3], crossing: &Crossing) -> f32 {
        levels(crossing).1 - place.iter().zip(self.plane).fold(0.0, |sum, (x, p)| sum + x * p)
    }
}

/// Normal equations of the plane of the light levels.
#[derive(Default)]
struct Normals {
    m: Matrix<3>,
    right: [f32; 3],
    dark: f32,
    light: f32,
    count: f32,
}

impl Normals {
    fn add(&mut self, terms: [f32; 3], (dark, light): (f32, f32)) {
        for (row, a) in self.m.iter_mut().zip(terms) {
            for (entry, b) in row.iter_mut().zip(terms) {
                *entry += a * b;
            }
        }
        for (right, term) in self.right.iter_mut().zip(terms) {
            *right += term * light;
        }
        self.dark += dark;
        self.light += light;
        self.count += 1.0;
    }

    /// The plane of the light levels, and the mean contrast.
    fn solve(&self) -> Option<([f32; 3], f32)> {
        let plane = Factor::new(&self.m)?.solve(self.right);
        Some((plane, (self.light - self.dark) / self.count))
    }
}
