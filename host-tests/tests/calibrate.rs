//! Calibration from points whose truth is known.

mod common;

use common::boards::{Draw, SIZE, WIDE, board, tilted};
use concentric_host::calibrate::{
    CalibrationError, Intrinsics, Options, Placed, Point, Pose, View, calibrate,
};
use nalgebra::{Matrix2, Vector2, Vector3};

/// Radius of the circles, mm.
const RADIUS: f64 = 12.0;

fn frontal(draw: &mut Draw) -> Pose {
    let rvec = Vector3::z() * draw.between(-3.0, 3.0);
    Pose { rvec, ..tilted(draw) }
}

/// A view of `objects` with noise of a random covariance times `noise` squared; ellipse centres of circles of `radius`.
fn view(draw: &mut Draw, objects: &[[f64; 3]], pose: &Pose, radius: f64, noise: f64) -> View {
    let camera = Intrinsics::from_array(WIDE);
    let placed = Placed::new(pose, Vector3::z());
    let point = |&object: &[f64; 3]| {
        let exact = placed.seen_centre(&camera, &object.into(), radius);
        let root = Matrix2::new(
            draw.between(0.002, 0.02),
            0.0,
            draw.between(-0.01, 0.01),
            draw.between(0.002, 0.02),
        );
        let image = exact + root * Vector2::new(draw.normal(), draw.normal()) * noise;
        let covariance = root * root.transpose();
        let covariance = [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]];
        Point { object, image: image.into(), covariance, radius }
    };
    View { name: "view".into(), size: SIZE, points: objects.iter().map(point).collect() }
}

fn views(seed: u64, count: usize, noise: f64) -> Vec<View> {
    let mut draw = Draw::new(seed);
    (0..count)
        .map(|_| {
            let pose = tilted(&mut draw);
            view(&mut draw, &board(), &pose, 0.0, noise)
        })
        .collect()
}

fn errors(found: &Intrinsics) -> [f64; 9] {
    let found = found.to_array();
    std::array::from_fn(|i| found[i] - WIDE[i])
}

#[test]
fn exact_points_give_the_exact_camera() {
    for seed in 0..10 {
        let found = calibrate(&views(seed, 4, 0.0), &Options::default()).unwrap();
        for (error, name) in errors(&found.intrinsics).into_iter().zip(Intrinsics::NAMES) {
            assert!(error.abs() < 1e-6, "{seed}: {name} {error}");
        }
        assert!(found.rms < 1e-8 && found.rejected() == 0, "{seed}: {}", found.rms);
    }
}

/// Mean of `e' C^-1 e` of the nine parameters over random boards, and the largest error of one in its standard deviation.
fn consistency(change: impl Fn(&mut View)) -> (f64, f64) {
    const BOARDS: u64 = 60;
    let (mut sum, mut largest) = (0.0, 0f64);
    for seed in 0..BOARDS {
        let mut views = views(100 + seed, 6, 1.0);
        views.iter_mut().for_each(&change);
        let found = calibrate(&views, &Options::default()).unwrap();
        let error = nalgebra::DVector::from_row_slice(&errors(&found.intrinsics));
        sum += error.dot(&found.covariance.clone().cholesky().unwrap().solve(&error)) / BOARDS as f64;
        for (error, sigma) in error.iter().zip(found.sigma.to_array()) {
            largest = largest.max(error.abs() / sigma);
        }
    }
    (sum, largest)
}

#[test]
fn errors_are_as_large_as_reported() {
    let all = |mean: f64| (mean - 9.0).abs() < 3.0 * (2.0 * 9.0 / 60f64).sqrt();
    let (mean, largest) = consistency(|_| {});
    assert!(all(mean) && largest < 4.5, "{mean} {largest}");
    // Points that are worse than they say enlarge the standard deviations.
    let (mean, _) =
        consistency(|view| view.points.iter_mut().for_each(|p| p.covariance = p.covariance.map(|c| c / 9.0)));
    assert!(all(mean), "{mean}");
    // An error of 0.02 px that depends on the place is noticed.
    let (mean, _) =
        consistency(|view| view.points.iter_mut().for_each(|p| p.image[0] += 2e-5 * (p.image[0] - 640.0)));
    assert!(!all(mean), "{mean}");
}

#[test]
fn ellipse_centres_need_the_radius() {
    let mut draw = Draw::new(5);
    let mut views: Vec<_> = (0..6)
        .map(|_| {
            let pose = tilted(&mut draw);
            view(&mut draw, &board(), &pose, RADIUS, 1.0)
        })
        .collect();
    let worst = |views: &[View]| {
        let found = calibrate(views, &Options::default()).unwrap();
        let sigma = found.sigma.to_array();
        errors(&found.intrinsics).iter().zip(sigma).map(|(e, s)| e.abs() / s).fold(0.0, f64::max)
    };
    let corrected = worst(&views);
    views.iter_mut().flat_map(|view| &mut view.points).for_each(|point| point.radius = 0.0);
    assert!(corrected < 3.5 && worst(&views) > 5.0, "{corrected} {}", worst(&views));
}

#[test]
fn wrong_points_are_left_out() {
    let mut views = views(7, 6, 1.0);
    let clean = calibrate(&views, &Options::default()).unwrap();
    let wrong = [(0, 5, 40.0), (0, 6, -300.0), (1, 11, 0.5), (3, 60, 7.0), (4, 0, -2.0), (4, 1, 2.0)];
    for (view, point, shift) in wrong {
        views[view].points[point].image[1] += shift;
    }
    let found = calibrate(&views, &Options::default()).unwrap();
    assert_eq!(found.rejected(), wrong.len());
    assert!(wrong.iter().all(|&(view, point, _)| !found.views[view].residuals[point].kept));
    assert!((1..=5).contains(&found.passes), "{}", found.passes);
    let difference = found.intrinsics.fx - clean.intrinsics.fx;
    assert!(difference.abs() < clean.sigma.fx, "{difference} {}", clean.sigma.fx);
    let all = calibrate(&views, &Options { passes: 0, ..Options::default() });
    assert!(!all.is_ok_and(|all| (all.intrinsics.fx - WIDE[0]).abs() < 3.0 * clean.sigma.fx));
}

#[test]
fn fixed_parameters_stay() {
    let options = Options { same_focal: true, radial: 1, tangential: false, ..Options::default() };
    let mut views = views(3, 6, 0.0);
    // A lens without the terms that are left out.
    let camera =
        Intrinsics { fy: WIDE[0], k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0, ..Intrinsics::from_array(WIDE) };
    let mut draw = Draw::new(3);
    for view in &mut views {
        let placed = Placed::new(&tilted(&mut draw), Vector3::z());
        for point in &mut view.points {
            point.image = camera.project(&placed.point(&point.object.into())).into();
        }
    }
    let found = calibrate(&views, &options).unwrap();
    for (found, truth) in found.intrinsics.to_array().into_iter().zip(camera.to_array()) {
        assert!((found - truth).abs() < 1e-6, "{found} {truth}");
    }
    let sigma = found.sigma;
    assert_eq!([sigma.k2, sigma.p1, sigma.p2, sigma.k3], [0.0; 4]);
    assert!(sigma.fx == sigma.fy && sigma.fx > 0.0);
}

#[test]
fn points_in_space() {
    let objects: Vec<[f64; 3]> =
        board().into_iter().enumerate().map(|(i, [x, y, _])| [x, y, (i % 4) as f64 * 30.0]).collect();
    let mut draw = Draw::new(11);
    let mut views: Vec<_> = (0..4)
        .map(|_| {
            let pose = frontal(&mut draw);
            view(&mut draw, &objects, &pose, 0.0, 1.0)
        })
        .collect();
    let found = calibrate(&views, &Options::default()).unwrap();
    for (error, sigma) in errors(&found.intrinsics).into_iter().zip(found.sigma.to_array()) {
        assert!(error.abs() < 3.5 * sigma, "{error} {sigma}");
    }
    views[0].points[0].radius = RADIUS;
    assert_eq!(calibrate(&views, &Options::default()).map(|found| found.rms), Err(CalibrationError::NoPlane));
}

#[test]
fn what_is_missing_is_said() {
    let good = views(1, 5, 1.0);
    let refused = |views: &[View], parts: &[&str]| {
        let message = calibrate(views, &Options::default()).map(|found| found.rms).unwrap_err().to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    };
    refused(&[], &["0 views", "4 or more"]);
    refused(&good[..3], &["3 views;", "4 or more", "tilted"]);
    let changed = |change: fn(&mut View)| {
        let mut views = good.clone();
        views[2].name = "third".into();
        change(&mut views[2]);
        views
    };
    refused(&changed(|view| view.size = [640, 480]), &["third is 640 x 480 px", "1280 x 960"]);
    refused(&changed(|view| view.points.truncate(3)), &["third: 3 points", "4 or more"]);
    refused(&changed(|view| view.points[9].image[0] = f64::NAN), &["third: point 9"]);
    refused(&changed(|view| view.points[8].covariance = [0.0; 3]), &["third: point 8", "positive definite"]);
    refused(&changed(|view| view.points.truncate(9)), &["third", "on a line"]);
    refused(
        &changed(|view| view.points.iter_mut().step_by(2).for_each(|point| point.image[1] += 0.5)),
        &["63 of 315 points contradict", "in third"],
    );
    let mut draw = Draw::new(9);
    for noise in [0.0, 1.0, 10.0] {
        let frontal: Vec<_> = (0..8)
            .map(|_| {
                let pose = frontal(&mut draw);
                view(&mut draw, &board(), &pose, 0.0, noise)
            })
            .collect();
        refused(&frontal, &["do not tell", "normals differ by at most", "tilted"]);
    }
    let mut scrambled = good;
    scrambled
        .iter_mut()
        .for_each(|view| (0..31).for_each(|i| view.points[i].object[0] += (i % 5) as f64 * 20.0));
    refused(&scrambled, &["layout"]);
}
