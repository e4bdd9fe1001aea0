//! The calibration beside OpenCV's, on the same points.
//!
//! The points are those of rendered boards through detector and correspondence. `golden/calibration/points.json` is written
//! anew with CONCENTRIC_BLESS=1, after which `opencv.py` beside it must be run once.

mod common;

use std::path::{Path, PathBuf};

use common::boards::Draw;
use concentric_host::{
    calibrate::{
        Calibration, Intrinsics, Options, Point, View, calibrate,
        input::{Measuring, Seen},
    },
    layout::{CodeName, Layout, LayoutTarget},
    picture::Picture,
    render::{Camera, Distortion, Pose},
};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

const BOARDS: u64 = 20;
const VIEWS: u32 = 5;

/// Boards of 7 x 5 targets and what their views show.
#[derive(Serialize, Deserialize)]
struct Points {
    /// Places of the targets, mm.
    layout: Vec<[f64; 3]>,
    boards: Vec<Board>,
}

#[derive(Serialize, Deserialize)]
struct Board {
    width: u32,
    height: u32,
    /// By [`Intrinsics::NAMES`].
    truth: [f64; 9],
    views: Vec<Shown>,
}

#[derive(Serialize, Deserialize)]
struct Shown {
    /// Numbers of the targets on the layout.
    target: Vec<usize>,
    image: Vec<[f64; 2]>,
    covariance: Vec<[f64; 3]>,
}

#[derive(Deserialize)]
struct OpenCv {
    opencv: String,
    answers: Vec<Answer>,
}

#[derive(Deserialize)]
struct Answer {
    rms: f64,
    parameters: [f64; 9],
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/calibration").join(name)
}

fn layout() -> Layout {
    let coded = [(8, 32), (12, 123), (18, 336), (22, 366), (25, 515)];
    let target = |index: usize| {
        let id = coded.iter().find(|(at, _)| *at == index).map(|(_, id)| *id);
        let position = [(index % 7) as f64 * 30.0 - 90.0, (index / 7) as f64 * 30.0 - 60.0, 0.0];
        LayoutTarget { id, position, radii: vec![6.0, 3.0] }
    };
    Layout { code: Some(CodeName::Five), targets: (0..35).map(target).collect(), ..Layout::default() }
}

/// Renders and measures a board before a random camera.
fn measure(seed: u64) -> Board {
    let mut draw = Draw::new(seed);
    let mut camera = Camera::new(960, 720, draw.between(1000.0, 1400.0));
    (camera.cx, camera.cy) = (draw.between(460.0, 500.0), draw.between(340.0, 380.0));
    let mut term = |size: f64| draw.between(-size, size);
    camera.distortion =
        Distortion { k1: -0.15 + term(0.1), k2: term(0.05), p1: term(0.001), p2: term(0.001) };
    let measuring = Measuring::new(layout()).unwrap();
    let mut view = |index: u32| {
        let pose = Pose {
            x: draw.between(400.0, 560.0),
            y: draw.between(310.0, 410.0),
            distance: camera.f * draw.between(0.3, 0.45),
            tilt: draw.between(15.0, 55.0),
            azimuth: f64::from(index) * 72.0 + draw.between(0.0, 60.0),
        };
        let mut scene = layout().scene(camera, pose).unwrap();
        // Views are of very different quality, as by hand in changing light.
        scene.photometry.noise = 8f64.powf(draw.between(0.0, 1.0));
        let frame = scene.render(seed * 100 + u64::from(index));
        let picture = Picture::new("view", frame.width, frame.height, frame.pixels).unwrap();
        let Seen { view, correspondence } = measuring.picture(&picture).unwrap();
        let points = view.points;
        let digits = |value: f64, per_unit: f64| (value * per_unit).round() / per_unit;
        Shown {
            target: correspondence.pairs.iter().map(|pair| pair.target).collect(),
            image: points.iter().map(|point| point.image.map(|value| digits(value, 1e5))).collect(),
            covariance: points.iter().map(|point| point.covariance.map(|value| digits(value, 1e8))).collect(),
        }
    };
    let views = (0..VIEWS).map(&mut view).collect();
    let Distortion { k1, k2, p1, p2 } = camera.distortion;
    let truth = [camera.f, camera.f, camera.cx, camera.cy, k1, k2, p1, p2, 0.0];
    Board { width: camera.width, height: camera.height, truth, views }
}

impl Board {
    fn calibrate(&self, layout: &[[f64; 3]], options: &Options) -> Calibration {
        let view = |shown: &Shown| {
            let measured = shown.image.iter().zip(&shown.covariance);
            let point = |(&target, (&image, &covariance)): (&usize, _)| Point {
                object: layout[target],
                image,
                covariance,
                radius: 0.0,
            };
            let points = shown.target.iter().zip(measured).map(point).collect();
            View { name: "view".into(), size: [self.width, self.height], points }
        };
        calibrate(&self.views.iter().map(view).collect::<Vec<_>>(), options).unwrap()
    }
}

fn read<T: for<'a> Deserialize<'a>>(name: &str) -> T {
    let text = std::fs::read_to_string(path(name)).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn focal_length_is_not_worse_than_that_of_opencv() {
    if std::env::var_os("CONCENTRIC_BLESS").is_some() {
        let layout = layout().targets.iter().map(|target| target.position).collect();
        let points = Points { layout, boards: (0..BOARDS).map(measure).collect() };
        std::fs::write(path("points.json"), serde_json::to_string(&points).unwrap() + "\n").unwrap();
        return;
    }
    let Points { layout, boards } = read("points.json");
    let OpenCv { opencv, answers } = read("opencv.json");
    assert_eq!(boards.len(), answers.len(), "opencv.py has not been run after the points were made");
    let (mut ours, mut theirs, mut better) = (0.0, 0.0, 0);
    let (mut chi_square, mut largest) = (0.0, 0f64);
    for (board, answer) in boards.iter().zip(&answers) {
        // The same model and the same sum of squares have the same minimum.
        let alike = board.calibrate(&layout, &Options { weighted: false, passes: 0, ..Options::default() });
        let names = Intrinsics::NAMES.iter().zip(alike.intrinsics.to_array()).zip(answer.parameters);
        for (((name, value), other), sigma) in names.zip(alike.sigma.to_array()) {
            assert!((value - other).abs() < 0.01 * sigma, "{name}: {value}, OpenCV {opencv} {other}");
        }
        // OpenCV takes the points in single precision.
        assert!((alike.rms - answer.rms).abs() < 1e-5, "{} {}", alike.rms, answer.rms);

        let found = board.calibrate(&layout, &Options::default());
        let off = |parameters: [f64; 9]| (parameters[0] - board.truth[0]).abs();
        let errors = [off(found.intrinsics.to_array()), off(answer.parameters)];
        ours += errors[0].powi(2) / BOARDS as f64;
        theirs += errors[1].powi(2) / BOARDS as f64;
        better += u32::from(errors[0] <= errors[1]);
        let truth = DVector::from_row_slice(&board.truth);
        let error = DVector::from_row_slice(&found.intrinsics.to_array()) - truth;
        for (error, sigma) in error.iter().zip(found.sigma.to_array()) {
            largest = largest.max(error.abs() / sigma);
        }
        chi_square += error.dot(&found.covariance.cholesky().unwrap().solve(&error)) / BOARDS as f64;
    }
    println!(
        "errors of nine parameters: chi square {chi_square:.2}, largest {largest:.2} standard deviations"
    );
    let spread = (2.0 * 9.0 / BOARDS as f64).sqrt();
    assert!((chi_square - 9.0).abs() < 3.0 * spread && largest < 3.0, "{chi_square} {largest}");
    println!(
        "RMS error of fx: {:.4} px, OpenCV {opencv} {:.4} px, not worse on {better}",
        ours.sqrt(),
        theirs.sqrt()
    );
    assert!(ours <= theirs, "RMS error of fx: {} px, OpenCV {opencv} {} px", ours.sqrt(), theirs.sqrt());
}
