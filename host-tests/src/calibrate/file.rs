//! The camera as a file: JSON under OpenCV's names, readable by its `cv::FileStorage`, by Python and by `--camera`.

use anyhow::Result;
use serde::Serialize;

use super::{Calibration, Fitted, Intrinsics};

/// A matrix as OpenCV writes it.
#[derive(Serialize)]
struct Matrix {
    type_id: &'static str,
    rows: usize,
    cols: usize,
    dt: &'static str,
    data: Vec<f64>,
}

impl Matrix {
    fn new(rows: usize, cols: usize, data: Vec<f64>) -> Self {
        Self { type_id: "opencv-matrix", rows, cols, dt: "d", data }
    }
}

#[derive(Serialize)]
struct File<'a> {
    image_width: u32,
    image_height: u32,
    camera_matrix: Matrix,
    distortion_coefficients: Matrix,
    avg_reprojection_error: f64,
    per_view_reprojection_errors: Matrix,
    /// A row for each view: rotation vector and translation vector.
    extrinsic_parameters: Matrix,
    standard_deviations: Intrinsics,
    variance_factor: f64,
    points: usize,
    points_left_out: usize,
    views: Vec<View<'a>>,
}

#[derive(Serialize)]
struct View<'a> {
    name: &'a str,
    rvec: [f64; 3],
    tvec: [f64; 3],
    rms: f64,
    points: usize,
    points_left_out: usize,
}

impl<'a> From<&'a Fitted> for View<'a> {
    fn from(view: &'a Fitted) -> Self {
        Self {
            name: &view.name,
            rvec: view.pose.rvec.into(),
            tvec: view.pose.tvec.into(),
            rms: view.rms,
            points: view.residuals.len() - view.rejected(),
            points_left_out: view.rejected(),
        }
    }
}

/// The text of the file. Lengths in px, of `tvec` in mm; angles in radians; errors are RMS distances as OpenCV's.
///
/// # Errors
/// None that a caller can cause.
pub fn json(found: &Calibration) -> Result<String> {
    let Intrinsics { fx, fy, cx, cy, k1, k2, p1, p2, k3 } = found.intrinsics;
    let views = &found.views;
    let pose = |view: &Fitted| [view.pose.rvec, view.pose.tvec].map(<[f64; 3]>::from).concat();
    let file = File {
        image_width: found.size[0],
        image_height: found.size[1],
        camera_matrix: Matrix::new(3, 3, vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]),
        distortion_coefficients: Matrix::new(5, 1, vec![k1, k2, p1, p2, k3]),
        avg_reprojection_error: found.rms,
        per_view_reprojection_errors: Matrix::new(
            views.len(),
            1,
            views.iter().map(|view| view.rms).collect(),
        ),
        extrinsic_parameters: Matrix::new(views.len(), 6, views.iter().flat_map(pose).collect()),
        standard_deviations: found.sigma,
        variance_factor: found.variance_factor,
        points: found.kept(),
        points_left_out: found.rejected(),
        views: views.iter().map(View::from).collect(),
    };
    Ok(serde_json::to_string_pretty(&file)? + "\n")
}
