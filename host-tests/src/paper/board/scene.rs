//! The board and the places from which it is seen. The paper gives the radii, the numbers and the frame; the rest is ours.

use anyhow::{Context, Result, ensure};
use concentric::Code;
use indicatif::ProgressBar;
use rayon::prelude::*;

use crate::{
    layout::{CodeName, Layout, LayoutTarget},
    paper::printed::{TARGETS, VIEWS},
    render::{Camera, Levels, Photometry, Pose},
};

/// Radii of the targets, mm.
pub const RADII: [f64; 2] = [5.0, 2.5];
/// Columns and rows of the grid, and its pitch, mm.
const GRID: [u16; 2] = [9, 7];
const PITCH: f64 = 22.0;
/// Column and row of the coded markers.
const CODED: [[u16; 2]; 5] = [[1, 1], [7, 1], [4, 2], [1, 5], [7, 5]];

/// A view before the camera's noise.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The board.
    pub layout: Layout,
    /// The camera.
    pub camera: Camera,
    /// Grey levels without noise.
    pub levels: Levels,
    photometry: Photometry,
    /// True centres by the layout's order, px.
    pub truth: Vec<[f64; 2]>,
    /// Outer semi-major axes, px, likewise.
    pub sizes: Vec<f64>,
}

impl Stage {
    /// The picture with a noise, grey levels; rows of [`Levels::width`].
    pub fn picture(&self, noise: f64, seed: u64) -> Vec<u8> {
        Photometry { noise, ..self.photometry }.digitise(&self.levels.values, seed)
    }
}

/// 58 targets and five coded ones in a grid about the origin.
pub fn layout() -> Layout {
    let mut ids = Code::FIVE.into_iter();
    let place = |i: u16, count: u16| (f64::from(i) - f64::from(count - 1) / 2.0) * PITCH;
    let [columns, rows] = GRID;
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
    let target = |cell: [u16; 2]| LayoutTarget {
        id: CODED.contains(&cell).then(|| ids.next()).flatten(),
        position: [place(cell[0], columns), place(cell[1], rows), 0.0],
        radii: RADII.to_vec(),
    };
    Layout { code: Some(CodeName::Five), light: false, targets: cells.map(target).collect() }
}

/// The camera of section 4.1 with the frame of section 4.2.
pub fn camera() -> Camera {
    Camera::new(1280, 960, Camera::paper().f)
}

/// Eight places about half a metre away, up to 40 degrees from the normal.
fn poses() -> [Pose; VIEWS] {
    let pose =
        |x: f64, y: f64, distance: f64, tilt: f64, azimuth: f64| Pose { x, y, distance, tilt, azimuth };
    [
        pose(641.3, 478.2, 480.0, 8.0, 20.0),
        pose(633.7, 486.4, 490.0, 25.0, 0.0),
        pose(650.2, 470.9, 500.0, 30.0, 90.0),
        pose(628.5, 482.3, 490.0, 25.0, 180.0),
        pose(646.1, 475.6, 500.0, 30.0, 270.0),
        pose(637.8, 489.1, 510.0, 40.0, 45.0),
        pose(652.4, 473.7, 510.0, 40.0, 135.0),
        pose(630.9, 480.8, 500.0, 35.0, 315.0),
    ]
}

/// Renders the views.
///
/// # Errors
/// None that a caller can cause.
pub fn stages(progress: &ProgressBar) -> Result<Vec<Stage>> {
    let layout = layout();
    let plain = layout.targets.iter().filter(|target| target.id.is_none()).count();
    ensure!(plain == TARGETS, "{plain} targets on the board, {TARGETS} wanted");
    let stage = |pose: &Pose| {
        let camera = camera();
        let scene = layout.scene(camera, *pose)?;
        let truth = scene.truth(0).targets;
        ensure!(truth.iter().all(|target| target.complete), "a target does not lie inside the frame");
        let size = |target: &crate::render::TargetTruth| target.circles.first().map(|outer| outer.ellipse.a);
        let sizes = truth.iter().map(size).collect::<Option<_>>().context("a target without circles")?;
        let levels = scene.levels();
        progress.inc(1);
        let truth = truth.iter().map(|target| [target.x, target.y]).collect();
        Ok(Stage { layout: layout.clone(), camera, levels, photometry: scene.photometry, truth, sizes })
    };
    poses().par_iter().map(stage).collect()
}
