extern crate std;
use super::*;
use crate::target::Covariance;
use std::format;

const WIDE: Distortion = Distortion { k1: -0.3, k2: 0.12, p1: 1e-3, p2: -2e-3, k3: -0.02 };

fn camera() -> Camera {
    Camera::new(1000.0, 990.0, 640.3, 511.7).and_then(|camera| camera.distortion(WIDE)).unwrap()
}

fn position(x: f64, y: f64) -> Position {
    Position { x: (x * 65536.0).round() as i32, y: (y * 65536.0).round() as i32 }
}

fn px(place: Position) -> (f64, f64) {
    (f64::from(place.x) / 65536.0, f64::from(place.y) / 65536.0)
}

/// The model as it stands in OpenCV's documentation, in f64.
fn oracle((u, v): (f64, f64)) -> (f64, f64) {
    let Camera { fx, fy, cx, cy, .. } = camera();
    let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(f64::from);
    let [k1, k2, p1, p2, k3] = [WIDE.k1, WIDE.k2, WIDE.p1, WIDE.p2, WIDE.k3].map(f64::from);
    let (x, y) = ((u - cx) / fx, (v - cy) / fy);
    let r2 = x * x + y * y;
    let radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    let xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
    let yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
    (fx * xd + cx, fy * yd + cy)
}

#[test]
fn distorts_as_opencv_and_back() {
    let camera = camera();
    for (x, y) in [(640.3, 511.7), (700.25, 100.5), (1300.0, 1000.0), (-20.0, 30.0), (1400.125, 400.0)] {
        let there = px(camera.distort(position(x, y)).unwrap());
        let (u, v) = oracle((x, y));
        assert!((there.0 - u).hypot(there.1 - v) < 5e-5, "({x}, {y}): {there:?} for {:?}", (u, v));
        let back = px(camera.undistort(position(u, v)).unwrap());
        assert!((back.0 - x).hypot(back.1 - y) < 7e-5, "({x}, {y}): {back:?}");
    }
}

#[test]
fn differences_keep_their_digits() {
    let camera = camera();
    for (x, y) in [(640.0, 512.0), (200.0, 100.0), (1270.0, 1000.0)] {
        let origin = position(x, y);
        let local = Local::new(&camera, origin).unwrap();
        let (ux, uy) = px(camera.undistort(origin).unwrap());
        let zero = oracle((ux, uy));
        for (dx, dy) in [(0.01, 0.0), (3.0, -2.0), (60.0, 80.0), (-150.0, 130.0)] {
            let there = local.distort((dx, dy));
            let (u, v) = oracle((ux + f64::from(dx), uy + f64::from(dy)));
            let size = dx.hypot(dy);
            let error = (f64::from(there.0) - u + zero.0).hypot(f64::from(there.1) - v + zero.1);
            assert!(error < 4e-7 * f64::from(size) + 1e-8, "({x}, {y}) + ({dx}, {dy}): {error:e}");
            let back = local.undistort(there).unwrap();
            let error = (back.0 - dx).hypot(back.1 - dy);
            assert!(error < 4e-7 * size, "({x}, {y}) + ({dx}, {dy}): {error:e} back");
        }
    }
}

#[test]
fn covariance_goes_with_the_places() {
    let local = Local::new(&camera(), position(1200.0, 900.0)).unwrap();
    let (offset, h) = ((20.0, -10.0), 0.5);
    let column = |(x, y): (f32, f32)| {
        let (a, b) =
            (local.distort((offset.0 + x, offset.1 + y)), local.distort((offset.0 - x, offset.1 - y)));
        ((a.0 - b.0) / (2.0 * h), (a.1 - b.1) / (2.0 * h))
    };
    let ((xx, yx), (xy, yy)) = (column((h, 0.0)), column((0.0, h)));
    let unit = Covariance { xx: 1.0, xy: 0.2, yy: 0.5 };
    let there = local.distort_covariance(offset, &unit);
    let expected = unit.mapped([[xx, xy], [yx, yy]]);
    let back = local.undistort_covariance(offset, &there);
    for (found, wanted) in [(there, expected), (back, unit)] {
        for (f, w) in [(found.xx, wanted.xx), (found.xy, wanted.xy), (found.yy, wanted.yy)] {
            assert!((f - w).abs() < 1e-3, "{found:?} for {wanted:?}");
        }
    }
    assert!((there.xx - unit.xx).abs() > 0.1, "the map matters here");
}

#[test]
fn a_fold_is_seen() {
    let barrel = Distortion { k1: -0.3, ..Distortion::default() };
    let camera = Camera::new(600.0, 600.0, 640.0, 512.0).and_then(|c| c.distortion(barrel)).unwrap();
    // x (1 - 0.3 x^2) is largest at x = 1.054 with 0.703: 422 px.
    assert!(camera.undistort(position(640.0 + 412.0, 512.0)).is_some());
    assert!(camera.undistort(position(640.0 + 425.0, 512.0)).is_none());
    assert!(camera.distort(position(640.0 + 600.0, 512.0)).is_some());
    assert!(camera.distort(position(640.0 + 660.0, 512.0)).is_none());
    assert!(!camera.covers(1280, 1024) && !camera.covers(4096, 16384));
    let longer = Camera::new(1200.0, 1200.0, 640.0, 512.0).and_then(|c| c.distortion(barrel)).unwrap();
    assert!(longer.covers(1280, 1024));
    let strong = Distortion { p1: 0.9, ..Distortion::default() };
    let tangential = Camera::new(600.0, 600.0, 640.0, 512.0).and_then(|c| c.distortion(strong)).unwrap();
    assert!(!tangential.covers(1280, 1024));
}

#[test]
fn bad_parameters_are_named_with_their_range() {
    const _: () = assert!(Camera::new(800.0, 800.0, 320.0, 240.0).is_ok());
    let error = |result: Result<Camera, CameraError>| format!("{}", result.unwrap_err());
    assert_eq!(error(Camera::new(0.0, 1.0, 0.0, 0.0)), "camera: fx = 0 px is outside 1..=1000000");
    assert_eq!(error(Camera::new(9.0, f32::NAN, 0.0, 0.0)), "camera: fy = NaN px is outside 1..=1000000");
    assert_eq!(error(Camera::new(9.0, 9.0, 0.0, 4e4)), "camera: cy = 40000 px is outside -32767..=32767");
    let bad = Distortion { p2: f32::INFINITY, ..WIDE };
    assert_eq!(error(camera().distortion(bad)), "camera: p2 = inf is outside -1000..=1000");
}
