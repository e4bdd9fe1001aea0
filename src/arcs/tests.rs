extern crate std;

use super::gauge::{Gauge, root, square};
use super::pieces::{Pieces, Unit};
use super::points::{Point, Points};
use super::step::{Free, Normals};
use crate::fit::{Adjustment, Shape};
use crate::scan::{Axis, Crossing, Pool, Stretch};
use core::f32::consts::TAU;
use std::vec::Vec;

struct Random(u32);

impl Random {
    fn within(&mut self, least: f32, most: f32) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        least + (most - least) * (self.0 >> 8) as f32 / (1u32 << 24) as f32
    }
}

/// An ellipse with these semi-axes and direction.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    a: f32,
    b: f32,
    theta: f32,
    centre: (f32, f32),
}

impl Drawn {
    fn any(random: &mut Random) -> Self {
        let b = 2.5 * libm::powf(160.0, random.within(0.0, 1.0));
        let a = b * random.within(1.0, 6.0);
        let theta = random.within(0.0, 3.1);
        Self { a, b, theta, centre: (random.within(-40.0, 40.0), random.within(-40.0, 40.0)) }
    }

    fn shape(&self) -> Shape {
        let (s, c) = libm::sincosf(self.theta);
        let (p, q) = (0.25 * self.a * self.a, 0.25 * self.b * self.b);
        let (xx, yy) = (p * c * c + q * s * s, p * s * s + q * c * c);
        Shape::from_moments(self.centre.0, self.centre.1, xx, (p - q) * s * c, yy).unwrap()
    }

    /// The place at the angle `t`, `out` px outside.
    fn place(&self, t: f32, out: f32) -> (f32, f32) {
        let ((sin, cos), (s, c)) = (libm::sincosf(t), libm::sincosf(self.theta));
        let (nx, ny) = (cos / self.a, sin / self.b);
        let k = out / libm::hypotf(nx, ny);
        let (u, v) = (self.a * cos + k * nx, self.b * sin + k * ny);
        (self.centre.0 + u * c - v * s, self.centre.1 + u * s + v * c)
    }
}

/// The point at a place, with light on the far side of a row.
fn point((x, y): (f32, f32)) -> Point {
    let levels = [0, 0, 0, 200, 200, 200];
    let crossing = Crossing::new(Axis::Row, (0, 0), levels, [Stretch::of(&[0], 0); 2]);
    let grid = |x: f32| libm::roundf(256.0 * x) as i32;
    let mut point = Point::new(&crossing, (0, 0));
    (point.x, point.y) = (grid(x), grid(y));
    point
}

/// Squared distance to first order, px^2.
fn square_distance(shape: &Shape, (x, y): (f32, f32)) -> f32 {
    let ((gx, gy), (dx, dy)) = shape.gradient(x, y);
    let excess = dx * gx + dy * gy - 1.0;
    0.25 * excess * excess / (gx * gx + gy * gy)
}

#[test]
fn distances_are_those_of_floats() {
    let mut random = Random(1);
    for _ in 0..20_000 {
        let drawn = Drawn::any(&mut random);
        let shape = drawn.shape();
        let gauge = Gauge::new(&shape).unwrap();
        let place = drawn.place(random.within(0.0, TAU), random.within(-4.0, 4.0).max(-0.6 * drawn.b));
        let exact = libm::sqrtf(square_distance(&shape, place));
        let look = gauge.look(&point(place));
        let Some(found) = look.and_then(|look| gauge.square_distance(&look)) else {
            assert!(exact > 2.5, "{drawn:?} {place:?}: {exact}");
            continue;
        };
        let found = libm::sqrtf(found as f32 / square(1.0) as f32);
        assert!(
            (found - exact).abs() < 0.05 + 0.03 * exact + drawn.a / 4000.0,
            "{drawn:?} {place:?}: {found} for {exact}"
        );
    }
    // Teeth: another ellipse is told from it.
    let gauge = Gauge::new(&Drawn { a: 20.3, b: 20.3, theta: 0.0, centre: (0.0, 0.0) }.shape()).unwrap();
    let look = gauge.look(&point((20.0, 0.0))).unwrap();
    assert!(gauge.square_distance(&look).unwrap() > square(0.25));
}

#[test]
fn light_is_on_the_side_where_it_is() {
    let gauge = Gauge::new(&Drawn { a: 20.0, b: 12.0, theta: 0.3, centre: (3.0, -5.0) }.shape()).unwrap();
    assert!(gauge.look(&point((23.0, -5.0))).unwrap().dark_inside);
    assert!(!gauge.look(&point((-17.0, -5.0))).unwrap().dark_inside);
}

#[test]
fn radii_are_those_of_floats() {
    let mut random = Random(2);
    for _ in 0..5000 {
        let drawn = Drawn::any(&mut random);
        let shape = drawn.shape();
        let gauge = Gauge::around(&shape).unwrap();
        let (t, factor) = (random.within(0.0, TAU), random.within(0.3, 10.0));
        let (x, y) = drawn.place(t, 0.0);
        let place = (shape.cx + factor * (x - shape.cx), shape.cy + factor * (y - shape.cy));
        let (radius, change) = gauge.radius(&gauge.look(&point(place)).unwrap()).unwrap();
        let ((gx, gy), _) = shape.gradient(x, y);
        let unit = Gauge::UNIT as f32;
        assert!(
            (radius as f32 / unit - factor).abs() < 0.004 * factor + 0.002,
            "{drawn:?} {factor}: {radius}"
        );
        let (change, per_px) = (change as f32 / 16.0, unit * libm::hypotf(gx, gy));
        assert!((change - per_px).abs() < 0.5 + 0.06 * per_px, "{drawn:?} {factor}: {change} for {per_px}");
    }
}

#[test]
fn a_turn_has_thirty_two_sectors_alike() {
    let gauge = Gauge::new(&Drawn { a: 100.0, b: 100.0, theta: 0.0, centre: (0.0, 0.0) }.shape()).unwrap();
    let sector = |turn: f32| {
        let (sin, cos) = libm::sincosf(turn / 32.0 * core::f32::consts::TAU);
        gauge.look(&point((100.0 * cos, 100.0 * sin))).unwrap().sector()
    };
    let mut all = 0u32;
    for i in 0..32 {
        let middle = sector(i as f32 + 0.5);
        assert_eq!(all & middle, 0, "{i}");
        all |= middle;
        assert_eq!([0.05, 0.95].map(|share| sector(i as f32 + share)), [middle; 2], "{i}");
    }
    assert_eq!(all, u32::MAX);
}

#[test]
fn roots_are_rounded_down() {
    for x in (0..70_000).chain([(1 << 30) - 1, 1 << 30, i32::MAX as u32]) {
        assert_eq!(root(x), x.isqrt());
    }
}

/// An arc as short as any that is taken, from a displaced start.
#[test]
fn steps_are_those_of_floats() {
    let mut random = Random(3);
    for _ in 0..2000 {
        let drawn = Drawn { b: 8.0, a: random.within(8.0, 40.0), ..Drawn::any(&mut random) };
        let first = random.within(0.0, TAU);
        let places: Vec<_> =
            (0..60).map(|i| drawn.place(first + 0.03 * i as f32, random.within(-0.05, 0.05))).collect();
        let start = Drawn { a: 1.01 * drawn.a, b: 0.99 * drawn.b, ..drawn }.shape();
        let gauge = Gauge::new(&start).unwrap();
        let (mut normals, mut adjustment) = (Normals::default(), Adjustment::new(start).unwrap());
        for place in &places {
            let point = point(*place);
            normals.add(&gauge.look(&point).unwrap());
            adjustment.add_point((point.x as f32 / 256.0, point.y as f32 / 256.0));
        }
        let (Some(found), Some(exact)) = (normals.step(&start, Free::All), adjustment.finish()) else {
            continue;
        };
        // Where the arc is, they are the same ellipse.
        for place in places.iter().step_by(10) {
            let between =
                found.distance(place.0, place.1).unwrap() - exact.shape.distance(place.0, place.1).unwrap();
            assert!(between.abs() < 0.08, "{drawn:?} {first}: {between}");
        }
    }
}

#[test]
fn a_similar_step_keeps_the_form() {
    let drawn = Drawn { a: 30.0, b: 20.0, theta: 0.4, centre: (2.0, -3.0) };
    let start = Drawn { a: 29.4, b: 19.6, centre: (2.5, -2.6), ..drawn }.shape();
    let mut shape = start;
    for _ in 0..3 {
        let gauge = Gauge::new(&shape).unwrap();
        let mut normals = Normals::default();
        (0..100).for_each(|i| normals.add(&gauge.look(&point(drawn.place(0.03 * i as f32, 0.0))).unwrap()));
        shape = normals.step(&shape, Free::Similar).unwrap();
    }
    let (a, b) = shape.semi_axes();
    assert!((a / b - 1.5).abs() < 1e-3 && (a - 30.0).abs() < 0.05, "{a} {b}");
    assert!((shape.cx - 2.0).abs() < 0.05 && (shape.cy + 3.0).abs() < 0.05, "{shape:?}");
}

#[test]
fn points_come_in_the_order_of_the_outline() {
    let drawn = Drawn { a: 30.0, b: 20.0, theta: 0.4, centre: (2.0, -3.0) };
    // Every seventh of fifty.
    let mut points =
        Points { points: (0..50).map(|i| point(drawn.place(0.125 * (i * 7 % 50) as f32, 0.0))).collect() };
    let unit = Unit::of(&points.points);
    points.sort(unit.shift);
    let step =
        |pair: &[Point]| libm::hypotf((pair[1].x - pair[0].x) as f32, (pair[1].y - pair[0].y) as f32) / 256.0;
    // One step leads back to where the first one left the start.
    let long = points.points.windows(2).filter(|pair| step(pair) > 5.0).count();
    assert!(long <= 1, "{long}");
}

/// An ellipse turns to one side everywhere, a wave to both.
#[test]
fn turns_tell_an_arc_from_a_wave() {
    let turns = |place: &dyn Fn(f32) -> (f32, f32)| {
        let points: Vec<_> = (0..56).map(|i| point(place(i as f32 / 56.0))).collect();
        let unit = Unit::of(&points);
        Pieces::new(&points, &unit).turns(&unit)
    };
    let drawn = Drawn { a: 30.0, b: 8.0, theta: 0.4, centre: (2.0, -3.0) };
    let ellipse = turns(&|share| drawn.place(TAU * share, 0.15 * libm::sinf(400.0 * share)));
    let wave = turns(&|share| (60.0 * share, 8.0 * libm::sinf(12.0 * share)));
    for (start, length) in [(0, 10), (3, 7), (14, 5)] {
        assert!(!ellipse.are_both(start, length), "{start} {length}");
    }
    assert!(wave.are_both(1, 10) && wave.are_both(2, 10));
}

/// Nothing is taken from a pool that has nothing.
#[test]
fn an_empty_list_has_no_arcs() {
    let pool = Pool::new(&mut []);
    let points = Points::few(crate::scan::CrossingList::EMPTY, &pool, (0, 0));
    assert!(super::free(points).is_none());
}
