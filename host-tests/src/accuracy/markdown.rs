//! The study as a page.

use super::{
    goals::{Goal, goals},
    grid::SLICES,
    method::{MAIN, QUICK, REFINED},
    plots::Plot,
    run::Outcome,
    statistics::Figures,
    study::Study,
};

const HEADER: [&str; 21] = [
    "cell",
    "found",
    "frames",
    "bound",
    "none",
    "eq. (7)",
    "exact",
    "auto",
    "refined",
    "known",
    "quick",
    "exact / bound",
    "refined / bound",
    "quick / bound",
    "systematic",
    "bias",
    "drift",
    "error / sigma",
    "in 95 %",
    "refined error / sigma",
    "refined in 95 %",
];

const LEGEND: &str = "\
RMS errors of one coordinate in mpx (1/1000 px). *bound*: the Cramer-Rao bound of eq. (7) and the exact form, for the
contrast, light, noise, blur and shape of each frame; rounding to 8 bits counts as noise. *none*: the centre of the outer
ellipse; *auto*: the exact form as far as its correction is significant; *refined*: the exact form after the refinement on
the pixels; *known*: the centre where the camera is given; *quick*: the exact form with less effort. Ratios to the bound
have their 95 % confidence interval; in the range of the goals they, and *error / sigma*, are without what the noise of
these frames makes of any good estimate.
*systematic*: the part of the exact form's error that is the same for every noise. *bias*, *drift*: length of its mean error,
in the image and in directions of the light (or else of the tilt). *error / sigma*: its RMS error in units of the reported
standard deviation. *in 95 %*: share inside the reported 95 % ellipse. Cells in brackets are outside the range for which
the goals are set.
";

/// A table in Markdown.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
    let rule = vec!["---"; header.len()];
    let rows = rows.iter().map(|row| row.iter().map(String::as_str).collect());
    [header.to_vec(), rule].into_iter().chain(rows).map(line).collect()
}

/// The page; the plots lie beside it.
pub fn page(study: &Study, plots: &[Plot]) -> String {
    let mut page = format!(
        "# Accuracy\n\nRendered frames through the row interface of the library, {} frames a cell where nothing else is \
         said, against the least error that is possible.\n\n## Goals\n\n{}",
        study.frames,
        goal_table(&goals(study))
    );
    for plot in plots {
        page += &format!("\n![{}]({})\n", plot.title, plot.file);
    }
    page += &format!("\n## Cells\n\n{LEGEND}");
    for (slice, title) in SLICES {
        let rows: Vec<_> = study.slice(slice).map(row).collect();
        if !rows.is_empty() {
            page += &format!("\n### {title}\n\n{}", table(&HEADER, &rows));
        }
    }
    page
}

/// The goals as a table.
pub fn goal_table(goals: &[Goal]) -> String {
    let row = |goal: &Goal| {
        let reached = if goal.reached { "yes" } else { "no" };
        vec![goal.figure.clone(), goal.goal.clone(), goal.measured.clone(), reached.to_owned()]
    };
    table(&["figure", "goal", "measured", "reached"], &goals.iter().map(row).collect::<Vec<_>>())
}

/// A cell's line; without figures where the target was found in no frame.
pub fn row(outcome: &Outcome) -> Vec<String> {
    let label = outcome.cell.label();
    let label = if outcome.cell.in_range() { label } else { format!("({label})") };
    let frames = outcome.samples().count().to_string();
    let (Some(exact), Some(refined)) = (outcome.figures(MAIN), outcome.figures(REFINED)) else {
        return [vec![label, "0".to_owned(), frames], vec![String::new(); HEADER.len() - 3]].concat();
    };
    let mpx = |px: f64| format!("{:.2}", 1000.0 * px);
    let rms = |method: &str| outcome.figures(method).map_or(String::new(), |figures| mpx(figures.rms));
    let ratio = |figures: Figures| format!("{:.2} +- {:.2}", figures.ratio(), figures.ratio_spread());
    vec![
        label,
        exact.found.to_string(),
        frames,
        mpx(exact.bound),
        rms("none"),
        rms("eq7"),
        mpx(exact.rms),
        rms("auto"),
        mpx(refined.rms),
        rms("known"),
        rms(QUICK),
        ratio(exact),
        ratio(refined),
        outcome.figures(QUICK).map_or(String::new(), ratio),
        exact.systematic.map_or(String::new(), mpx),
        mpx(exact.bias),
        mpx(exact.drift),
        format!("{:.2}", exact.over_sigma.0),
        format!("{:.1}", 100.0 * exact.within),
        format!("{:.2}", refined.over_sigma.0),
        format!("{:.1}", 100.0 * refined.within),
    ]
}
