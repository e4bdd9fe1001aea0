//! The part of the page on the board: figures 7 and 8, and the methods.

use super::{mpx, table};
use crate::{
    measure::distance,
    paper::{
        board::{Board, USUAL, level::Spread, methods::Needs, scene},
        printed::{DEVIATION, TARGETS, VIEWS},
    },
};

const HEAD: &str = "
The paper prints one figure for this: all deviations between the compared method (eq. (3) on the inner ellipses, with a camera
calibrated by Zhang's method from their centres) and eq. (7) are below 0.01 px. Radii, numbers and frame are the paper's; pitch
(22 mm), distance (about 500 mm), the eight poses and the camera's lens (that of section 4.1, without distortion; two radial
terms are calibrated) are ours. Which target is which follows from the five coded markers.
";

const DEVIATIONS: &str = "
Both methods share the inner ellipse's centre and with it most of the noise: C1 - C2 = -eps2 - k2 (B2 - B1), k2 = 1/3. So a
small deviation does not say that the centres are as good; what they are off the true ones is beside it. RMS of one coordinate,
largest of all coordinates, in mpx:
";

const METHODS: &str = "
What each method needs beside the picture, and what it leaves of the true centres of these eight views: RMS of one coordinate
and largest of all, in mpx.
";

const CALIBRATED: &str = "
The camera calibrated from each kind of centre. Error of the focal length with its reported standard deviation, distance of the
principal points, RMS distance of the measured places from the projected ones; all in px.
";

/// Figures 7 and 8.
pub fn deviations(board: &Board) -> String {
    let all = TARGETS * VIEWS;
    let rows = board.levels.iter().map(|level| {
        let mut row = vec![format!("{:.0}", level.noise), format!("{} of {all}", level.found)];
        row.push(level.wrong.to_string());
        row.push(format!("{} of {}", level.coded, 5 * VIEWS));
        row.extend(pair(level.deviation));
        row.push(if level.deviation.largest < DEVIATION { "yes" } else { "no" }.to_owned());
        row.extend([level.eq7, level.eq3, level.pooled].into_iter().flat_map(pair));
        row
    });
    let header = [
        "noise",
        "found and identified",
        "wrongly",
        "markers read",
        "C1 - C2",
        "largest",
        "all below 10 mpx",
        "true error, eq. (7)",
        "largest",
        "eq. (3)",
        "largest",
        "pooled",
        "largest",
    ];
    let table = table(&header, &rows.collect::<Vec<_>>());
    format!("\n## Figures 7 and 8: the board\n{HEAD}{DEVIATIONS}\n{table}\n{}", implied(board))
}

fn implied(board: &Board) -> String {
    let Some(level) = board.implied() else {
        return format!("At no noise are all deviations below the {DEVIATION} px that the paper prints.\n");
    };
    let [noise, largest, rms] =
        [level.noise, 1000.0 * level.eq7.largest, level.eq7.rms / level.deviation.rms];
    format!(
        "The noise up to which all deviations are below the {DEVIATION} px that the paper prints is {noise:.0} grey levels, of a \
         contrast of 190. Eq. (7) is then {:.2} mpx off the true centres, {rms:.1} times the deviation, and {largest:.1} mpx at \
         worst. Figure 8 is drawn for that noise.\n",
        1000.0 * level.eq7.rms
    )
}

fn pair(spread: Spread) -> [String; 2] {
    [mpx(spread.rms), mpx(spread.largest)]
}

/// Every method, and the cameras.
pub fn methods(board: &Board) -> String {
    let mark = |needed: bool| if needed { "yes" } else { "" }.to_owned();
    let rows = board.methods.iter().map(|method| {
        let Needs { camera, pose, radius, ratio, views, other } = method.needs;
        let mut row = vec![method.name.to_owned()];
        row.extend([camera, pose, radius, ratio, views].map(mark));
        row.push(other.to_owned());
        row.extend(method.left.into_iter().flat_map(pair));
        row
    });
    let noise = format!("noise {USUAL:.0}");
    let header = [
        "method", "camera", "pose", "radius", "ratio", "views", "other", "no noise", "largest", &noise,
        "largest",
    ];
    let methods = table(&header, &rows.collect::<Vec<_>>());
    let truth = scene::camera();
    let rows = board.calibrated.iter().map(|calibrated| {
        let mut row = vec![calibrated.name.to_owned()];
        for figures in calibrated.cameras {
            row.push(format!("{:+.3} (sigma {:.3})", figures.focal_length - truth.f, figures.sigma));
            let off = distance(figures.principal_point, [truth.cx, truth.cy]);
            row.extend([off, figures.reprojection].map(|px| format!("{px:.4}")));
        }
        row
    });
    let noisy = |what: &str| format!("{noise}: {what}");
    let second = [noisy("focal length"), noisy("principal point"), noisy("reprojection")];
    let mut header = vec!["centres", "no noise: focal length", "principal point", "reprojection"];
    header.extend(second.iter().map(String::as_str));
    let cameras = table(&header, &rows.collect::<Vec<_>>());
    format!("\n## Methods\n{METHODS}\n{methods}{CALIBRATED}\n{cameras}")
}
