//! The simulator against closed forms and independent formulas.

use concentric_host::render::{
    Artwork, Camera, Coverage, Distortion, Ellipse, Mark, Outline, Photometry, Pose, Scene, Shading, Style,
    Target, Tone, View,
};
use glam::DVec2;
use std::f64::consts::PI;

/// Sum, centroid and second central moments of a coverage.
struct Moments {
    area: f64,
    centre: DVec2,
    xx: f64,
    yy: f64,
}

fn moments(coverage: &Coverage) -> Moments {
    let (mut area, mut sum) = (0.0, DVec2::ZERO);
    coverage.for_each(|x, y, c| {
        area += c;
        sum += c * DVec2::new(x as f64, y as f64);
    });
    let centre = sum / area;
    let (mut xx, mut yy) = (0.0, 0.0);
    coverage.for_each(|x, y, c| {
        xx += c * (x as f64 - centre.x).powi(2) / area;
        yy += c * (y as f64 - centre.y).powi(2) / area;
    });
    Moments { area, centre, xx, yy }
}

/// Radius mm, tilt and azimuth in degrees, phase px.
const POSES: [(f64, f64, f64, [f64; 2]); 5] = [
    (24.0, 0.0, 0.0, [0.0, 0.0]),
    (60.0, 45.0, 0.0, [0.37, -0.21]),
    (10.0, 72.0, 33.0, [0.5, 0.5]),
    (3.0, 30.0, 200.0, [-300.1, 200.7]),
    (40.0, 60.0, 117.0, [200.3, -100.8]),
];

fn seen(radius: f64, tilt: f64, azimuth: f64, phase: [f64; 2]) -> (View, Ellipse) {
    let scene = Scene::single(radius, tilt, azimuth, phase);
    let view = scene.targets[0].view(&scene.camera);
    (view, view.ellipse(DVec2::ZERO, radius))
}

#[test]
fn area_and_centroid_are_those_of_the_ellipse() {
    for (radius, tilt, azimuth, phase) in POSES {
        let (view, ellipse) = seen(radius, tilt, azimuth, phase);
        let circle = Outline::circle(DVec2::ZERO, radius);
        for sigma in [0.0, 0.1, 0.6, 0.8, 3.0] {
            let found = moments(&Coverage::new(&circle, &view, sigma).unwrap());
            let area = PI * ellipse.a * ellipse.b;
            assert!((found.area / area - 1.0).abs() < 1e-6, "area {} of {area}, sigma {sigma}", found.area);
            let error = found.centre.distance(DVec2::new(ellipse.x, ellipse.y));
            // A sharper image is not band-limited: its pixels' centroid is not the figure's, however exact
            // they are.
            assert!(
                error < 1e-5 || sigma < 0.5,
                "centroid off by {error} px, radius {radius} tilt {tilt} sigma {sigma}"
            );
        }
    }
    let (view, ellipse) = seen(60.0, 45.0, 0.0, [0.0, 0.0]);
    let eccentricity = view.undistorted(DVec2::ZERO).distance(DVec2::new(ellipse.x, ellipse.y));
    assert!(eccentricity > 7.0, "the test cannot tell true centre and ellipse centre: {eccentricity} px");
}

#[test]
fn blur_adds_its_variance() {
    for (radius, tilt, azimuth, phase) in POSES {
        let (view, e) = seen(radius, tilt, azimuth, phase);
        for sigma in [0.8_f64, 2.0] {
            let found = moments(&Coverage::new(&Outline::circle(DVec2::ZERO, radius), &view, sigma).unwrap());
            let (sin, cos) = e.theta.sin_cos();
            let added = sigma * sigma + 1.0 / 12.0;
            let xx = ((e.a * cos).powi(2) + (e.b * sin).powi(2)) / 4.0 + added;
            let yy = ((e.a * sin).powi(2) + (e.b * cos).powi(2)) / 4.0 + added;
            assert!(
                (found.xx - xx).abs() < 1e-4 && (found.yy - yy).abs() < 1e-4,
                "{} {xx}, {} {yy}",
                found.xx,
                found.yy
            );
        }
    }
}

/// Mean over the pixel at (x, y) of `value`, by Simpson's rule in both directions.
fn pixel_mean(x: f64, y: f64, value: impl Fn(f64, f64) -> f64) -> f64 {
    let n = 60;
    let weight = |i: usize| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    let offset = |i: usize| i as f64 / n as f64 - 0.5;
    let row = |j| (0..=n).map(|i| weight(i) * value(x + offset(i), y + offset(j))).sum::<f64>();
    (0..=n).map(|j| weight(j) * row(j)).sum::<f64>() / (9.0 * (n * n) as f64)
}

#[test]
fn blurred_straight_edge_is_an_erf() {
    let camera = Camera::new(101, 101, 1000.0);
    let view = View::flat(&camera, 50.3, 49.8);
    for (angle, sigma) in [(0.0_f64, 0.4), (0.0, 0.8), (0.5, 0.8), (0.5, 0.3), (2.2, 1.5), (-1.1, 4.0)] {
        // A square whose one side runs through the view's origin; the others are far away.
        let square = Outline::rectangle(DVec2::new(400.0, 0.0), 400.0, 400.0).placed(DVec2::ZERO, angle, 1.0);
        let coverage = Coverage::new(&square, &view, sigma).unwrap();
        let normal = DVec2::from_angle(angle);
        let mut worst = 0.0_f64;
        coverage.for_each(|x, y, found| {
            if !(45..55).contains(&x) || !(45..55).contains(&y) {
                return;
            }
            let expected = pixel_mean(x as f64, y as f64, |x, y| {
                let distance = normal.dot(DVec2::new(x - 50.3, y - 49.8));
                0.5 + 0.5 * libm::erf(distance / sigma / 2_f64.sqrt())
            });
            worst = worst.max((found - expected).abs());
        });
        assert!(worst < 1e-6, "{worst} at angle {angle} sigma {sigma}");
    }
}

/// Area of the ellipse in the pixel at (x, y), by the midpoint rule over chords.
fn pixel_area(e: &Ellipse, x: f64, y: f64) -> f64 {
    let (sin, cos) = e.theta.sin_cos();
    let xx = (cos / e.a).powi(2) + (sin / e.b).powi(2);
    let yy = (sin / e.a).powi(2) + (cos / e.b).powi(2);
    let xy = sin * cos * (1.0 / (e.a * e.a) - 1.0 / (e.b * e.b));
    let n = 4000;
    let chord = |i: u32| {
        let v = y - 0.5 + (f64::from(i) + 0.5) / f64::from(n) - e.y;
        let root = (xy * v).powi(2) - xx * (yy * v * v - 1.0);
        let half = root.max(0.0).sqrt() / xx;
        let middle = e.x - xy * v / xx;
        ((middle + half).min(x + 0.5) - (middle - half).max(x - 0.5)).max(0.0)
    };
    (0..n).map(chord).sum::<f64>() / f64::from(n)
}

#[test]
fn sharp_pixels_are_those_of_the_ellipse() {
    let (view, e) = seen(6.0, 50.0, 70.0, [0.2, 0.4]);
    let circle = Outline::circle(DVec2::ZERO, 6.0);
    let sharp = Coverage::new(&circle, &view, 0.0).unwrap();
    sharp.for_each(|x, y, found| {
        let expected = pixel_area(&e, x as f64, y as f64);
        assert!((found - expected).abs() < 1e-5, "({x}, {y}): {found} {expected}");
    });
    // Quadrature and polygon are two programs; they meet where the blur ends.
    let blurred = Coverage::new(&circle, &view, 0.02).unwrap();
    assert_eq!((blurred.x0, blurred.y0, blurred.width), (sharp.x0, sharp.y0, sharp.width));
    let worst = sharp.values.iter().zip(&blurred.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 0.01, "{worst}");
}

/// Eqs. (1) of Huo et al. 2013: the point (x, y) of the plane seen by a camera at (0, -d sin a, d cos a),
/// optical axis at angle w from the normal, focal length c.
fn paper_projection([c, d, w, a]: [f64; 4], p: DVec2) -> DVec2 {
    let depth = d * (w - a).cos() + p.y * w.sin();
    DVec2::new(c * p.x, c * (p.y * w.cos() - d * (w - a).sin())) / depth
}

/// The paper's pose in terms of ours, turned by `azimuth` degrees about the optical axis.
fn paper_pose([c, d, w, a]: [f64; 4], azimuth: f64, x_p: f64) -> (Target, Camera) {
    let camera = Camera { f: c, ..Camera::paper() };
    let place = DVec2::from_angle(azimuth.to_radians()).rotate(paper_projection([c, d, w, a], DVec2::ZERO));
    let pose =
        Pose { x: camera.cx + place.x, y: camera.cy + place.y, distance: d, tilt: w.to_degrees(), azimuth };
    let at = DVec2::from_angle(azimuth.to_radians()).rotate(DVec2::new(x_p, 0.0));
    (Target { artwork: Artwork::annulus(60.0, 30.0), pose, at: at.into() }, camera)
}

#[test]
fn true_centres_are_those_of_an_independent_projection() {
    for (w, a, azimuth) in [(0.8_f64, 0.8_f64, 0.0_f64), (0.8, 0.5, 40.0), (1.2, 1.0, -130.0)] {
        let scene = [2500.0, 700.0, w, a];
        let turn = DVec2::from_angle(azimuth.to_radians());
        let back = DVec2::from_angle(-azimuth.to_radians());
        let (target, camera) = paper_pose(scene, azimuth, 0.0);
        let board = Scene::board(5, 4, 20.0, &Artwork::annulus(8.0, 4.0), target.pose);
        let board = Scene { camera, ..board };
        for (target, truth) in board.targets.iter().zip(&board.truth(0).targets) {
            let on_plane = back.rotate(target.at.into());
            let expected = turn.rotate(paper_projection(scene, on_plane)) + DVec2::new(camera.cx, camera.cy);
            assert!(expected.distance(DVec2::new(truth.x, truth.y)) < 1e-9, "{expected} {truth:?}");
        }
    }
}

/// Eq. (3) of Huo et al. 2013 with the v row put right (cos alpha).
fn eccentricity([c, d, w, a]: [f64; 4], x_p: f64, r: f64) -> DVec2 {
    let l = d * (w - a).cos();
    let divisor = (l / r).powi(2) - w.sin().powi(2);
    DVec2::new(c * x_p / l * w.sin().powi(2), -c * d / l * w.sin() * a.cos()) / divisor
}

#[test]
fn eccentricity_is_eq_3() {
    for (w, a) in [(45.0_f64, 45.0_f64), (45.0, 30.0), (45.0, 0.0), (30.0, 45.0), (60.0, 30.0), (60.0, 75.0)]
    {
        let (w, a) = (w.to_radians(), a.to_radians());
        for x_p in [0.0, 50.0, -80.0] {
            let scene = [12.0 / 0.00465, 800.0, w, a];
            let (target, camera) = paper_pose(scene, 0.0, x_p);
            let view = target.view(&camera);
            for r in [60.0, 30.0, 5.0] {
                let e = view.ellipse(target.centre(), r);
                let found = DVec2::new(e.x, e.y) - view.undistorted(target.centre());
                let expected = eccentricity(scene, x_p, r);
                assert!(found.distance(expected) < 1e-9, "{found} {expected}");
                if x_p == 0.0 && r == 60.0 && a == 0.0 {
                    let misprint = expected * w.cos() / a.cos();
                    assert!(
                        found.distance(misprint) > 8.0,
                        "the test cannot tell cos(alpha) from cos(omega)"
                    );
                }
            }
        }
    }
    let (_, e) = seen(60.0, 45.0, 0.0, [0.0, 0.0]);
    assert!((DVec2::new(e.x, e.y).distance(DVec2::new(640.0, 512.0)) - 7.279).abs() < 5e-4);
}

/// A camera with every kind of distortion.
fn bent() -> Camera {
    Camera {
        distortion: Distortion { k1: -0.3, k2: 0.1, p1: 0.002, p2: -0.001 },
        ..Camera::new(1280, 1024, 1000.0)
    }
}

#[test]
fn distortion_is_browns() {
    let camera = bent();
    let Distortion { k1, k2, p1, p2 } = camera.distortion;
    let pose = Pose { x: 1000.0, y: 200.0, distance: 500.0, tilt: 40.0, azimuth: 70.0 };
    let view = pose.view(&camera);
    assert!(view.at(DVec2::ZERO).0.distance(DVec2::new(1000.0, 200.0)) < 1e-9);
    let distort = |p: DVec2| {
        let n = (view.undistorted(p) - DVec2::new(640.0, 512.0)) / 1000.0;
        let r2 = n.x * n.x + n.y * n.y;
        let radial = 1.0 + k1 * r2 + k2 * r2 * r2;
        let x = n.x * radial + 2.0 * p1 * n.x * n.y + p2 * (r2 + 2.0 * n.x * n.x);
        let y = n.y * radial + p1 * (r2 + 2.0 * n.y * n.y) + 2.0 * p2 * n.x * n.y;
        DVec2::new(640.0 + 1000.0 * x, 512.0 + 1000.0 * y)
    };
    let (p, h) = (DVec2::new(20.0, -30.0), 1e-3);
    let slope = view.at(p).1;
    for (axis, found) in [(DVec2::X, slope.x_axis), (DVec2::Y, slope.y_axis)] {
        let expected = (distort(p + axis * h) - distort(p - axis * h)) / (2.0 * h);
        assert!(found.distance(expected) < 1e-6, "{found} {expected}");
    }
    let rim: Vec<DVec2> =
        (0..40_000).map(|i| distort(DVec2::from_angle(f64::from(i) * PI / 20_000.0) * 40.0)).collect();
    let (mut area, mut sum) = (0.0, DVec2::ZERO);
    for (p, q) in rim.iter().zip(rim.iter().cycle().skip(1)).map(|(p, q)| (*p - rim[0], *q - rim[0])) {
        area += p.perp_dot(q) / 2.0;
        sum += (p + q) * p.perp_dot(q) / 6.0;
    }
    for sigma in [0.0, 0.8] {
        let found = moments(&Coverage::new(&Outline::circle(DVec2::ZERO, 40.0), &view, sigma).unwrap());
        assert!((found.area / area - 1.0).abs() < 1e-6, "{} {area}", found.area);
        assert!(sigma == 0.0 || found.centre.distance(rim[0] + sum / area) < 1e-5);
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let mut scene = Scene::many(6, 320, 240, true, 7).unwrap();
    scene.texture = Some(concentric_host::render::Texture { amplitude: 0.3, scale: 20.0, seed: 3 });
    let frame = scene.render(1);
    assert_eq!(frame.pixels, scene.render(1).pixels);
    assert_ne!(frame.pixels, scene.render(2).pixels);
    let hash = |bytes: &[u8]| {
        bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x100_0000_01b3))
    };
    assert_eq!(hash(&frame.pixels), GOLDEN, "bytes of a seed changed: {:#x}", hash(&frame.pixels));
}

/// FNV-1a hash of a rendered frame; changes only with the simulator's own meaning.
const GOLDEN: u64 = 0xa496_eb41_f46e_1665;

#[test]
fn levels_follow_the_chain() {
    let mut scene = Scene::empty(Camera::new(400, 300, 1000.0));
    let light = Shading { fraction: 0.4, span: 400.0, direction: 90.0, x: 0.0, y: 100.0 };
    scene.photometry = Photometry {
        white: 200.0,
        shading: Some(light),
        gamma: 2.0,
        gain: 1.1,
        noise: 3.0,
        ..Photometry::default()
    };
    let levels = scene.levels();
    let expected = |y: f64| 1.1 * 255.0 * (200.0 * (1.0 + 0.001 * (y - 100.0)) / 255.0).powi(2);
    for (x, y) in [(0, 0), (399, 100), (200, 299)] {
        assert!((levels.values[y * 400 + x] - expected(y as f64)).abs() < 1e-9);
    }
    scene.photometry = Photometry { white: 100.3, noise: 3.0, ..Photometry::default() };
    let pixels = scene.render(5).pixels;
    let count = pixels.len() as f64;
    let mean = pixels.iter().map(|p| f64::from(*p)).sum::<f64>() / count;
    let variance = pixels.iter().map(|p| (f64::from(*p) - mean).powi(2)).sum::<f64>() / count;
    assert!((mean - 100.3).abs() < 0.05 && (variance - 9.0 - 1.0 / 12.0).abs() < 0.15, "{mean} {variance}");
    scene.photometry = Photometry { gain: 2.0, white: 200.0, ..Photometry::default() };
    assert!(scene.render(5).pixels.iter().all(|p| *p == 255));
}

#[test]
fn drawings_have_the_area_of_their_ellipses() {
    let dark_area = |artwork: Artwork, paper: Tone| {
        let mut scene = Scene::single(24.0, 40.0, 20.0, [0.3, 0.1]);
        scene.photometry = Photometry { black: 0.0, white: 1.0, ..Photometry::default() };
        (scene.targets[0].artwork, scene.paper) = (artwork, paper);
        let ellipses: Vec<f64> =
            scene.truth(0).targets[0].circles.iter().map(|c| c.ellipse.a * c.ellipse.b * PI).collect();
        (scene.levels().values.iter().map(|v| 1.0 - v).sum::<f64>(), ellipses)
    };
    let ring = Artwork::annulus(24.0, 12.0);
    let (ring_area, e) = dark_area(ring.clone(), Tone::Light);
    assert!((ring_area - (e[0] - e[1])).abs() < 1e-3, "{ring_area} {e:?}");
    let lines_of_2_mm = Artwork { style: Style::Lines(2.0), ..ring.clone() };
    assert_eq!(lines_of_2_mm.outlines(), [25.0, 23.0, 13.0, 11.0]);
    let (lines, e) = dark_area(lines_of_2_mm, Tone::Light);
    assert!(e.len() == 4 && (lines - (e[0] - e[1] + e[2] - e[3])).abs() < 1e-3, "{lines} {e:?}");
    let (light, _) = dark_area(Artwork { ink: Tone::Light, ..ring.clone() }, Tone::Dark);
    assert!((light - (1280.0 * 1024.0 - ring_area)).abs() < 1e-3);
    for mark in [Mark::Plus, Mark::Dot, Mark::Digits("48".into())] {
        let (marked, e) = dark_area(Artwork { mark: Some(mark.clone()), ..ring.clone() }, Tone::Light);
        let added = marked - ring_area;
        assert!(added > 0.03 * e[1] && added < 0.3 * e[1], "{mark:?} {added} {e:?}");
    }
}

#[test]
fn a_crowd_keeps_its_distances() {
    for (width, height) in [(640, 480), (1280, 1024)] {
        for seed in 0..3 {
            let scene = Scene::many(60, width, height, true, seed).unwrap();
            assert_eq!((scene.targets.len(), scene.decoys.len()), (60, 60));
            let truth = scene.truth(0);
            let targets = truth.targets.iter().map(|t| (DVec2::new(t.x, t.y), t.circles[0].ellipse.a));
            let decoys = scene.decoys.iter().map(|d| (DVec2::new(d.x, d.y), d.size));
            let all: Vec<_> = targets.chain(decoys).collect();
            for (i, (p, r)) in all.iter().enumerate() {
                assert!(all[..i].iter().all(|(q, s)| p.distance(*q) > r + s + 5.5), "{i} of seed {seed}");
            }
            for target in &truth.targets {
                let [outer, inner] = [target.circles[0].ellipse, target.circles[1].ellipse];
                assert!(target.complete && inner.b > 4.4 && outer.b - inner.b > 4.4, "{target:?}");
                assert!((10.5..61.0).contains(&outer.a), "{outer:?}");
            }
        }
    }
    let error = Scene::many(500, 320, 240, false, 1).unwrap_err().to_string();
    assert!(error.contains("500 targets do not fit in 320 x 240 px"), "{error}");
}

#[test]
fn impossible_scenes_are_refused() {
    let refused = |change: &dyn Fn(&mut Scene), message: &str| {
        let mut scene = Scene::single(24.0, 40.0, 0.0, [0.0, 0.0]);
        scene.validate().unwrap();
        change(&mut scene);
        let error = format!("{:#}", scene.validate().unwrap_err());
        assert!(error.contains(message), "{error}");
    };
    refused(&|s| s.targets[0].pose.distance = 30.0, "reaches behind the camera");
    refused(&|s| s.targets[0].pose.tilt = 90.0, "between -90 and 90");
    refused(&|s| s.targets[0].artwork.radii = vec![12.0, 24.0], "must fall");
    refused(&|s| s.targets[0].artwork.style = Style::Lines(13.0), "touch");
    refused(&|s| s.targets[0].artwork.mark = Some(Mark::Digits("a".into())), "1 to 4 decimal digits");
    refused(&|s| s.camera.distortion.k1 = -20.0, "folds");
    refused(&|s| s.camera.width = 0, "each side must be 1 to 8192");
    refused(&|s| s.photometry.blur = -1.0, "0.02 to 50");
    refused(&|s| s.photometry.black = 230.0, "black must be below white");
}
