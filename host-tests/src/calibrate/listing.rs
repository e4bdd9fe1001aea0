//! The calibration for people.

use std::fmt::Write;

use super::{Calibration, CalibrationError, Fitted, Intrinsics, input::Seen};
use crate::table::{BOLD, FAINT, Table, paint};

/// Largest angle between two normals below which more tilt is advised, degrees.
const FLAT: f64 = 20.0;
/// Variance factor above which the covariances of the points are doubtful.
const WORSE: f64 = 4.0;

/// Camera, views, and what to know about them.
pub fn text(found: &Calibration) -> String {
    let [width, height] = found.size;
    let mut text = format!(
        "{}\n",
        paint(
            BOLD,
            &format!(
                "camera of {width} x {height} px from {} points in {} views: RMS {:.4} px",
                found.kept(),
                found.views.len(),
                found.rms
            )
        )
    );
    let mut parameters = Table::new(&["parameter", "value", "sigma", ""]);
    let values = found.intrinsics.to_array().into_iter().zip(found.sigma.to_array());
    for ((value, sigma), name) in values.zip(Intrinsics::NAMES) {
        let (unit, digits) = if name.starts_with(['f', 'c']) { ("px", 3) } else { ("", 6) };
        let sigma = if sigma > 0.0 { format!("{sigma:.digits$}") } else { "fixed".to_owned() };
        parameters.row(vec![name.to_owned(), format!("{value:.digits$}"), sigma, unit.to_owned()]);
    }
    let _ = write!(text, "{parameters}\n{}", views(&found.views));
    for note in notes(found) {
        let _ = writeln!(text, "  {}", paint(FAINT, &note));
    }
    text
}

fn views(views: &[Fitted]) -> Table {
    let mut table = Table::new(&["points", "left out", "rms px", "tilt", "distance mm", "view"]);
    for view in views {
        // The board's z axis is its normal, either way.
        let z = view.pose.rotation().column(2).z.abs().min(1.0);
        table.row(vec![
            (view.residuals.len() - view.rejected()).to_string(),
            view.rejected().to_string(),
            format!("{:.4}", view.rms),
            format!("{:.1}", z.acos().to_degrees()),
            format!("{:.1}", view.pose.tvec.norm()),
            view.name.clone(),
        ]);
    }
    table
}

fn notes(found: &Calibration) -> Vec<String> {
    let factor = found.variance_factor;
    let mut notes = vec![format!(
        "residuals are {:.2} times as large as the reported covariances say{}",
        factor.sqrt(),
        if factor > 1.0 { "; standard deviations are enlarged by that" } else { "" }
    )];
    if factor > WORSE {
        notes.push(
            "that much is not noise: is the layout exact, the board flat, the lens of this model?".to_owned(),
        );
    }
    if found.rejected() > 0 {
        notes.push(format!(
            "{} points contradict the others and were left out in {} passes",
            found.rejected(),
            found.passes
        ));
    }
    if found.angle < FLAT {
        notes.push(format!(
            "the board's normals differ by at most {:.1} degrees; more tilt in different directions makes the camera surer",
            found.angle
        ));
    }
    notes
}

/// What was not matched, in a line for each view where something was not.
pub fn matches(seen: &[Seen], frames_left_out: usize) -> String {
    let mut text = String::new();
    for Seen { view, correspondence: found } in seen {
        let counts = [
            (found.missing.len(), "targets not seen"),
            (found.unmatched.len(), "that are not on the layout"),
            (found.ambiguous.len(), "ambiguous"),
            (found.foreign.len(), "ids not on the layout"),
            (found.duplicates.len(), "ids seen twice"),
            (found.contradicting.len(), "ids in a wrong place"),
        ];
        let told: Vec<_> =
            counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        if !told.is_empty() {
            let _ = writeln!(text, "  {}", paint(FAINT, &format!("{}: {}", view.name, told.join(", "))));
        }
    }
    if frames_left_out > 0 {
        let note = format!("{frames_left_out} frames were left out: too few coded targets in them");
        let _ = writeln!(text, "  {}", paint(FAINT, &note));
    }
    text
}

/// What to say of an error, with the views that were left out before.
pub fn refusal(error: &CalibrationError, left_out: usize) -> String {
    if left_out == 0 { error.to_string() } else { format!("{error} ({left_out} views were left out before)") }
}
