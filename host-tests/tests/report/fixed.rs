//! Wire units: rounding, and the nearest value in range for everything out of it.

use concentric::report::{CircleEntry, Detail, Details, FullEntry, Report, TargetEntry};
use concentric::{Circle, Covariance, Ellipse, Flags, Position, Target};

fn entry(target: &Target, detail: Detail) -> TargetEntry {
    let mut report = Report::<1>::new(detail);
    report.push(target);
    report.targets()[0].clone()
}

fn full(target: &Target) -> FullEntry {
    match entry(target, Detail::Full).details {
        Details::Full(full) => full,
        other => panic!("{other:?}"),
    }
}

fn circle(circle: Circle) -> CircleEntry {
    let mut target = Target::default();
    target.circles.push(circle).unwrap();
    full(&target).circles[0]
}

fn with_covariance(xx: f32, xy: f32, yy: f32) -> TargetEntry {
    entry(&Target { covariance: Covariance { xx, xy, yy }, ..Target::default() }, Detail::Terse)
}

#[test]
fn sigma_is_in_65536ths_of_a_pixel() {
    let entry = with_covariance(0.005 * 0.005, 0.0, 0.25);
    assert_eq!((entry.sigma_x, entry.sigma_y), (328, 32768));
}

#[test]
fn sigma_of_a_pixel_or_more_or_unknown_is_the_largest() {
    for variance in [1.0, 1.7, 1e9, f32::MAX, f32::INFINITY, -1e-9, f32::NAN] {
        let entry = with_covariance(variance, 0.0, 0.9999);
        assert_eq!(entry.sigma_x, u16::MAX, "{variance}");
        assert!(entry.sigma_y < u16::MAX);
    }
}

#[test]
fn correlation_is_in_127ths() {
    assert_eq!(with_covariance(4e-4, -1e-4, 1e-4).correlation, -64);
    assert_eq!(with_covariance(1e-5, 1e-5, 1e-5).correlation, 127);
    assert_eq!(with_covariance(1e-5, 3e-5, 1e-5).correlation, 127);
    assert_eq!(with_covariance(1e-5, -3e-5, 1e-5).correlation, -127);
    assert_eq!(with_covariance(1e-30, 5e-31, 1e-30).correlation, 64);
    assert_eq!(with_covariance(0.0, 1.0, 1e-5).correlation, 0);
}

#[test]
fn positions_pass_unchanged() {
    let ends = Position { x: i32::MIN, y: i32::MAX };
    let target = Target { centre: ends, eq7: ends, exact: ends, ..Target::default() };
    let full = full(&target);
    assert_eq!((entry(&target, Detail::Terse).centre, full.eq7, full.exact), (ends, ends, ends));
    let of = circle(Circle { ellipse: Ellipse { centre: ends, ..Ellipse::default() }, ..Circle::default() });
    assert_eq!(of.centre, ends);
}

#[test]
fn a_circle_in_wire_units() {
    let ellipse = Ellipse { centre: Position { x: 1, y: 2 }, a: 41.5, b: 30.0, theta: -0.5 };
    let entry = circle(Circle {
        ellipse,
        rms: 0.03,
        points: 200,
        gap: 33.75,
        ratio: 0.5,
        measured_ratio: 0.25,
        ..Circle::default()
    });
    assert_eq!((entry.shape.a, entry.shape.b), (41 * 4096 + 2048, 30 * 4096));
    assert_eq!((entry.shape.theta, entry.shape.rms), (-5215, 1966));
    assert_eq!((entry.points, entry.gap, entry.ratio, entry.measured_ratio), (200, 540, 32768, 16384));
}

#[test]
fn a_circle_out_of_range_is_sent_as_the_nearest_in_range() {
    let of = |value: f32| {
        let ellipse = Ellipse { a: value, b: value, theta: value, ..Ellipse::default() };
        let entry = circle(Circle { ellipse, rms: value, gap: value, ratio: value, ..Circle::default() });
        (entry.shape.a, entry.shape.b, entry.shape.theta, entry.shape.rms, entry.gap, entry.ratio)
    };
    let most = i32::MAX as u32;
    assert_eq!(of(1e30), (most, most, i16::MAX, u16::MAX, u16::MAX, u16::MAX));
    assert_eq!(of(f32::INFINITY), (most, most, i16::MAX, u16::MAX, u16::MAX, u16::MAX));
    assert_eq!(of(-1e30), (0, 0, i16::MIN, 0, 0, 0));
    assert_eq!(of(f32::NAN), (0, 0, 0, u16::MAX, u16::MAX, u16::MAX));
}

#[test]
fn contrast_noise_and_blur_in_wire_units() {
    let of = |contrast, noise, blur| {
        let full = full(&Target { contrast, noise, blur, ..Target::default() });
        (full.contrast, full.noise, full.blur)
    };
    assert_eq!(of(190.03, 2.5, 0.8), (3040, 640, 205));
    assert_eq!(of(-3.0, -2.0, -1.0), (0, 0, 0));
    assert_eq!(of(5000.0, 300.0, 256.0), (u16::MAX, u16::MAX, u16::MAX));
}

#[test]
fn flags_and_the_shape_of_a_target_without_circles() {
    let target = Target { flags: Flags(0xA5A5), ..Target::default() };
    let normal = entry(&target, Detail::Normal);
    assert_eq!((normal.id, normal.flags), (0, target.flags));
    assert_eq!(normal.details, Details::Normal(Default::default()));
}
