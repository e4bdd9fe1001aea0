//! The methods on pictures of one's own: no truth, so each is compared with eq. (7).

use anyhow::{Context, Result};
use concentric::{Camera, Compensation, Settings, Target, TargetSpec};

use super::{
    board::{
        methods::{KINDS, NAMES, Trial},
        scene::Stage,
    },
    one_circle::candidates,
};
use crate::{
    detect,
    layout::Layout,
    measure::{distance, px},
    picture::Picture,
    table::{BOLD, Table, paint},
};

/// A target that is found twice is not farther from itself than this, px.
const NEAR: f64 = 2.0;

/// Views of a board: the camera is calibrated from them, then every method is there.
///
/// # Errors
/// Pictures on which too few coded markers are read, or from which no camera can be calibrated.
pub fn board(pictures: Vec<Picture>, layout: &Layout) -> Result<String> {
    let stages: Vec<_> = pictures.into_iter().map(|picture| Stage::photo(picture, layout)).collect();
    let trial = Trial::new(&stages, 0.0)?;
    let mut methods = Table::new(&["RMS", "largest", "method"]);
    for ((name, _), spread) in NAMES.iter().zip(trial.left) {
        methods.row(vec![mpx(spread.rms), mpx(spread.largest), (*name).to_owned()]);
    }
    let header = ["focal length", "sigma", "principal point", "", "reprojection", "calibrated from"];
    let mut cameras = Table::new(&header);
    for ((name, _), figures) in KINDS.iter().zip(trial.cameras) {
        let [x, y] = figures.principal_point;
        let numbers = [figures.focal_length, figures.sigma, x, y];
        let mut row = numbers.map(|number| format!("{number:.3}")).to_vec();
        row.extend([format!("{:.4}", figures.reprojection), (*name).to_owned()]);
        cameras.row(row);
    }
    let title = format!(
        "{} targets in {} views: centres less those by eq. (7), one coordinate, mpx",
        trial.targets,
        stages.len()
    );
    Ok(format!("{}\n{methods}\n{}\n{cameras}", paint(BOLD, &title), paint(BOLD, "Cameras, px")))
}

fn mpx(px: f64) -> String {
    format!("{:.2}", 1000.0 * px)
}

/// The targets of a picture, with what there is without a board.
///
/// # Errors
/// A picture that the library refuses.
pub fn single(picture: &Picture, spec: TargetSpec, camera: Option<Camera>) -> Result<String> {
    let targets = detect::run(picture, Settings::new(spec))?.targets;
    let known = match camera {
        Some(camera) => {
            let settings = Settings::new(spec).camera(camera).compensation(Compensation::Known);
            Some((camera, detect::run(picture, settings)?.targets))
        }
        None => None,
    };
    let mut header = vec!["#", "x", "y", "outer ellipse", "inner ellipse", "exact form"];
    if known.is_some() {
        header.extend(["one circle", "or", "two circles, camera"]);
    }
    let mut table = Table::new(&header);
    for (number, target) in (1..).zip(&targets) {
        let reference = px(target.eq7);
        let off = |place: [f64; 2]| format!("{:.4}", distance(place, reference));
        let ends = target.circles.first().zip(target.circles.last());
        let (outer, inner) = ends.context("a target has circles")?;
        let mut row = vec![number.to_string()];
        row.extend(reference.map(|axis| format!("{axis:.4}")));
        row.extend([outer.ellipse.centre, inner.ellipse.centre, target.exact].map(|place| off(px(place))));
        if let Some((camera, all)) = &known {
            let same = all.iter().find(|other| distance(px(other.eq7), reference) < NEAR);
            row.extend(
                with_camera(same, camera)
                    .map_or_else(|| vec![String::new(); 3], |places| places.map(off).to_vec()),
            );
        }
        table.row(row);
    }
    let title = format!(
        "{}: {} targets; eq. (7), and how far other centres are from there, px",
        picture.name,
        targets.len()
    );
    Ok(format!("{}\n{table}", paint(BOLD, &title)))
}

/// The two centres that the outer ellipse leaves, and that from both circles.
fn with_camera(target: Option<&Target>, camera: &Camera) -> Option<[[f64; 2]; 3]> {
    let target = target?;
    let [first, second] = candidates(&target.circles.first()?.ellipse, camera)?;
    Some([first.centre, second.centre, px(target.centre)])
}
