//! The page in short.

use super::{equations::EXACT, mpx, number, table};
use crate::paper::{
    board::USUAL,
    equations::SCENES,
    printed::{DEVIATION, TARGETS, VIEWS},
    report::Report,
};

/// What is printed, and what came out.
pub fn table_of(report: &Report) -> String {
    let [first, second] = &report.tables;
    let same = first.rows.iter().filter(|(row, _)| row.rounded() == row.printed).count();
    let shares: Vec<_> = second.rows.iter().map(|(row, _)| number(row.printed) / row.eq7).collect();
    let worst = report.equations;
    let worst = worst.centre.max(worst.ellipse).max(worst.eccentricity);
    let mut rows = vec![
        [
            format!("(1) to (3) against the projection of conics, {SCENES} random scenes"),
            "exact".to_owned(),
            format!("{worst:.0e} px, goal {EXACT:.0e} px"),
        ],
        [
            "table 1".to_owned(),
            format!("{} values", first.rows.len()),
            format!("{same} of {} to the last digit", first.rows.len()),
        ],
        [
            "table 2".to_owned(),
            format!("{} values", second.rows.len()),
            format!(
                "printed / ours: {}",
                shares.iter().map(|share| format!("{share:.2}")).collect::<Vec<_>>().join(", ")
            ),
        ],
    ];
    if let Some(row) = report.lens.iter().max_by(|a, b| a.neglected.total_cmp(&b.neglected)) {
        rows.push([
            format!("(8), k1 {}, semi-major axis {:.0} px", row.lens.radial[0], row.radius),
            "both ellipse centres are moved alike".to_owned(),
            format!(
                "that neglects {} mpx; eq. (7) leaves {} mpx all the same",
                mpx(row.neglected),
                mpx(row.eq7)
            ),
        ]);
    }
    let [.., (_, _, eq7), (_, _, exact)] = report.single.centres;
    rows.push([
        "figure 6, one target, 120 mm at 1 m".to_owned(),
        "good accordance".to_owned(),
        format!("eq. (7) {} mpx off the true centre, the exact form {} mpx", mpx(eq7), mpx(exact)),
    ]);
    rows.extend(board(report));
    let rows: Vec<_> = rows.into_iter().map(Vec::from).collect();
    table(&["what", "printed", "here"], &rows)
}

fn board(report: &Report) -> Vec<[String; 3]> {
    let mut rows = Vec::new();
    if let Some(level) = report.board.implied() {
        rows.push([
            "figure 8, targets found and identified".to_owned(),
            format!("{TARGETS} in {VIEWS} views"),
            format!("{} of {}, {} of them wrongly", level.found, TARGETS * VIEWS, level.wrong),
        ]);
        rows.push([
            "figure 8, eq. (3) less eq. (7)".to_owned(),
            format!("below {DEVIATION} px"),
            format!(
                "up to noise {:.0} at most {} mpx; the centres are then {} mpx off (RMS of one coordinate), at worst {} mpx",
                level.noise,
                mpx(level.deviation.largest),
                mpx(level.eq7.rms),
                mpx(level.eq7.largest)
            ),
        ]);
    }
    if let Some(level) = report.board.levels.iter().find(|level| level.noise == USUAL) {
        rows.push([
            format!("the same board, noise {USUAL:.0}: correction shared by a view's targets"),
            String::new(),
            format!(
                "{} mpx off (RMS of one coordinate), eq. (7) {} mpx",
                mpx(level.pooled.rms),
                mpx(level.eq7.rms)
            ),
        ]);
    }
    rows
}
