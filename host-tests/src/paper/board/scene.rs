//! The board and the places from which it is seen. The paper gives the radii, the numbers and the frame; the rest is ours.

use anyhow::{Result, ensure};
use indicatif::ProgressBar;
use rayon::prelude::*;

use crate::{
    layout::Layout,
    paper::printed::{TARGETS, VIEWS},
    picture::Picture,
    render::{Camera, Levels, Photometry, Pose},
    sheet::Plan,
};

/// A view of a board: a picture, or what a noise makes one of.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Name for messages.
    pub name: String,
    /// The board.
    pub layout: Layout,
    /// Width and height, px.
    pub size: [usize; 2],
    /// The truth, of a rendered view.
    pub truth: Option<Truth>,
    source: Source,
}

/// What a rendered view really shows.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The camera.
    pub camera: Camera,
    /// True centres by the layout's order, px.
    pub centres: Vec<[f64; 2]>,
}

#[derive(Clone, Debug)]
enum Source {
    /// Before the camera's noise.
    Rendered {
        levels: Levels,
        photometry: Photometry,
    },
    Photo(Picture),
}

impl Stage {
    /// A photograph of the board.
    pub fn photo(picture: Picture, layout: &Layout) -> Self {
        Self {
            name: picture.name.clone(),
            layout: layout.clone(),
            size: [picture.width, picture.height],
            truth: None,
            source: Source::Photo(picture),
        }
    }

    fn rendered(layout: &Layout, number: usize, pose: Pose) -> Result<Self> {
        let camera = camera();
        let scene = layout.scene(camera, pose)?;
        let truth = scene.truth(0).targets;
        ensure!(truth.iter().all(|target| target.complete), "a target does not lie inside the frame");
        let levels = scene.levels();
        Ok(Self {
            name: format!("view {number}"),
            layout: layout.clone(),
            size: [levels.width, levels.height],
            truth: Some(Truth { camera, centres: truth.iter().map(|target| [target.x, target.y]).collect() }),
            source: Source::Rendered { levels, photometry: scene.photometry },
        })
    }

    /// The picture; that of a rendered view with a noise, grey levels.
    ///
    /// # Errors
    /// None that a caller can cause.
    pub fn picture(&self, noise: f64, seed: u64) -> Result<Picture> {
        match &self.source {
            Source::Rendered { levels, photometry } => {
                let pixels = Photometry { noise, ..*photometry }.digitise(&levels.values, seed);
                Picture::new(self.name.clone(), levels.width, levels.height, pixels)
            }
            Source::Photo(picture) => Ok(picture.clone()),
        }
    }

    /// True centre of a target of the layout, px.
    pub fn centre(&self, index: usize) -> Option<[f64; 2]> {
        self.truth.as_ref()?.centres.get(index).copied()
    }
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
    let layout = Plan::board().layout()?;
    let plain = layout.targets.iter().filter(|target| target.id.is_none()).count();
    ensure!(plain == TARGETS, "{plain} targets on the board, {TARGETS} wanted");
    let stage = |(number, pose): (usize, &Pose)| {
        let stage = Stage::rendered(&layout, number + 1, *pose);
        progress.inc(1);
        stage
    };
    poses().par_iter().enumerate().map(stage).collect()
}
