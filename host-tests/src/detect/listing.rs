//! The table for people.

use concentric::Target;

use super::Outcome;
use crate::{
    measure::{axes, distance, px},
    picture::Picture,
    table::{BOLD, FAINT, Table, paint},
};

const HEADER: [&str; 13] = [
    "#",
    "x px",
    "y px",
    "sigma px",
    "eq7-C px",
    "B1-C px",
    "outer a x b px",
    "ratios",
    "contrast",
    "noise",
    "blur px",
    "rms px",
    "flags",
];

/// What was found in `picture`: a table of the targets, what was rejected and lost, the time.
pub fn text(picture: &Picture, outcome: &Outcome) -> String {
    let Picture { name, width, height, .. } = picture;
    let found = match outcome.targets.len() {
        0 => "no target".to_owned(),
        1 => "1 target".to_owned(),
        many => format!("{many} targets"),
    };
    let mut text = paint(BOLD, &format!("{name}: {found}")) + &format!(" ({width} x {height} px)\n");
    if !outcome.targets.is_empty() {
        let coded = outcome.targets.iter().any(|target| target.code.is_some());
        let header: Vec<_> = HEADER.into_iter().chain(coded.then_some("id")).collect();
        let mut table = Table::new(&header);
        for (index, target) in outcome.targets.iter().enumerate() {
            let id = || target.code.map_or_else(String::new, |code| code.id.to_string());
            table.row(cells(index + 1, target).into_iter().chain(coded.then(id)).collect());
        }
        text += &table.to_string();
    }
    if let Some(plane) = &outcome.plane {
        text += &format!(
            "one plane: {} targets share the correction, {} do not fit\n",
            plane.used, plane.left_out
        );
    }
    let unsearched = match outcome.summary.unsearched {
        0 => String::new(),
        count => format!("{count} not searched for arcs; "),
    };
    let account = format!(
        "rejected: {}; dropped: {}; {unsearched}{:.2} ms",
        list(outcome.summary.rejected.iter().map(|(cause, count)| (cause.name(), count))),
        lost(outcome),
        outcome.elapsed.as_secs_f64() * 1e3
    );
    text + &paint(FAINT, &account) + "\n"
}

fn cells(number: usize, target: &Target) -> Vec<String> {
    let centre = px(target.centre);
    let outer = target.circles.first().map(|circle| circle.ellipse).unwrap_or_default();
    vec![
        number.to_string(),
        format!("{:.4}", centre[0]),
        format!("{:.4}", centre[1]),
        format!("{:.4}", axes(&target.covariance)[0]),
        format!("{:.4}", distance(px(target.eq7), centre)),
        format!("{:.4}", distance(px(outer.centre), centre)),
        format!("{:.2} x {:.2}", outer.a, outer.b),
        ratios(target),
        format!("{:.0}", target.contrast),
        format!("{:.1}", target.noise),
        format!("{:.2}", target.blur),
        format!("{:.3}", target.residual()),
        target.flags.names().collect::<Vec<_>>().join(" "),
    ]
}

/// Measured radii of the inner circles over the outer one, outermost first.
fn ratios(target: &Target) -> String {
    let inner = target.circles.iter().skip(1).map(|circle| format!("{:.3}", circle.measured_ratio));
    inner.collect::<Vec<_>>().join(" ")
}

fn lost(outcome: &Outcome) -> String {
    let dropped = outcome.summary.dropped;
    list(
        [("runs", dropped.runs), ("outlines", dropped.outlines), ("crossings", dropped.crossings)]
            .into_iter(),
    )
}

fn list<'a>(counts: impl Iterator<Item = (&'a str, u32)>) -> String {
    let words: Vec<_> = counts
        .filter(|&(_, count)| count > 0)
        .map(|(name, count)| format!("{count} {}", name.replace('_', " ")))
        .collect();
    if words.is_empty() { "nothing".to_owned() } else { words.join(", ") }
}
