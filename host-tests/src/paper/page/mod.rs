//! The results as a page: printed values, ours, and the difference.

mod board;
mod short;

use super::{
    equations::{self, EXACT, SCENES},
    lens,
    report::{Report, Table},
    simulation::{NOISES, PICTURES, Seen, number, other_grid},
    single::{self, Single},
};
use crate::accuracy::markdown::table;

const HEAD: &str = "\
# The paper, reproduced

Huo et al. 2013, \"Eccentricity error identification and compensation for high-accuracy 3D optical measurement\", Meas. Sci.
Technol. 24, 075402: its equations, tables and figures, calculated with the library's own code. Written by `concentric
paper`. All errors in px.
";

const EQUATIONS: &str = "
| equation | what | here | deviation from print, and why |
| --- | --- | --- | --- |
| (1) | true centre, geometry known | `model::Scene::centre` | none |
| (2) | ellipse centre, geometry known | `model::Scene::ellipse_centre` | none |
| (3) | eccentricity | `model::Scene::eccentricity` | the row for v has a minus and cos(alpha): (2) less (1) gives both |
| (4)-(6) | the same to the order r^2 | `model::Scene::approximation` | cos(alpha), where cos(omega) is printed: the same only where the optical axis goes through O |
| (7) | true centre from two ellipse centres | `model::from_two`, `centre::weights` | none; contains no K, so the misprint in (4) does not touch it |
| (8) | the same with lens distortion | `model::Lens` | its assumption does not hold, its result does: see below |
";

const TABLE_1: &str = "
The radii are said to be 0 to 60 mm in steps of 5. A circle of radius 0 has no ellipse; what is printed are 13 equal steps
from 1 to 60 mm, of which the first is left out. The pixel pitch is not given; 4.65 um (12 mm are 2580.65 px) gives all
twelve values. *at the label*: what eq. (7) leaves at the radius that is printed.
";

const TABLE_2: &str = "
The angle printed as 4pi/5 would show the target's back; 4pi/15 is what follows 3pi/15. The printed errors have the size of
ours, and their peak at 60 degrees (the law is sin^3 cos), but not their digits. No factor explains all rows: four of them are
0.93 to 0.94 of ours, one is 1.43. *other grid*: the same law at 0.7 + 11.48 i degrees, times 0.92: of all equal steps with
a factor those that come nearest, within 7 % of every printed value. So angles and radius are likely to be off by such steps as
the radii of table 1 are; what they were is not known.
";

const LENS: &str = "
Eq. (8) assumes that the lens moves both ellipse centres alike, d(B1) = d(B2). It does not: *apart* is the length of
d(B1) - d(B2), *neglected* what of that eq. (8) leaves out. Yet eq. (7) on the distorted picture is good to far less, because
every shift of an outline's centre, by perspective or by the lens, is an even function of the radius: B'(r) = C' + K' r^2 +
O(r^4). That is all that eq. (7) needs. What it leaves grows with r^4. Exact outlines, no pictures.
";

/// Files of all figures.
pub const FIGURES: [&str; 5] = ["figure4.svg", "figure5.svg", "figure6.png", "figure7.png", "figure8.svg"];

/// The page; the figures with these files lie beside it.
pub fn page(report: &Report, shown: &[&str]) -> String {
    let [first, second] = &report.tables;
    let figure = |file: &str, caption: &str| match shown.contains(&file) {
        true => format!("\n![{caption}]({file})\n"),
        false => String::new(),
    };
    [
        HEAD.to_owned(),
        format!("\n## In short\n\n{}", short::table_of(report)),
        equations(report),
        format!("\n## Table 1 and figure 4: over the radius\n{TABLE_1}\n{}", table_1(first)),
        pictures(first),
        figure(first.plot, first.title),
        format!("\n## Table 2 and figure 5: over the angle\n{TABLE_2}\n{}", table_2(second)),
        pictures(second),
        figure(second.plot, second.title),
        format!("\n## Equation (8): lens distortion\n{LENS}\n{}", lens_table(&report.lens)),
        single(&report.single),
        figure("figure6.png", "Figure 6: the single target and its centres"),
        board::deviations(&report.board),
        figure("figure7.png", "Figure 7: the eight views, and what was identified on them"),
        figure("figure8.svg", "Figure 8: deviations C1 - C2 by view"),
        board::methods(&report.board),
    ]
    .concat()
}

/// A number with two significant digits, as the paper prints them.
fn short(value: f64) -> String {
    format!("{value:.1e}")
}

fn mpx(px: f64) -> String {
    format!("{:.2}", 1000.0 * px)
}

fn equations(report: &Report) -> String {
    let worst = report.equations;
    let row =
        |name: &str, off: f64| vec![name.to_owned(), format!("{off:.0e} px"), format!("< {EXACT:.0e} px")];
    let rows = [
        row("(1), true centre", worst.centre),
        row("(2), ellipse centre", worst.ellipse),
        row("(3), eccentricity", worst.eccentricity),
        vec![
            "(3) with the printed cos(omega)".to_owned(),
            format!("{:.0} px", worst.misprint),
            String::new(),
        ],
    ];
    format!(
        "\n## Equations\n{EQUATIONS}\nLargest difference from the projection of conics, {SCENES} random scenes:\n\n{}",
        table(&["equation", "off by", "goal"], &rows)
    )
}

/// The printed value, ours, and how the two differ in units of the last printed digit.
fn digits(printed: &str, rounded: &str) -> String {
    if printed == rounded { "0".to_owned() } else { format!("{:+.1e}", number(rounded) - number(printed)) }
}

fn table_1(table_1: &Table) -> String {
    let rows: Vec<_> = table_1
        .rows
        .iter()
        .map(|(row, _)| {
            let ours = row.rounded();
            vec![
                row.label.to_owned(),
                format!("{:.3}", row.radius),
                row.printed.to_owned(),
                ours.clone(),
                digits(row.printed, &ours),
                format!("{:.3e}", row.eq7),
                short(row.at_label),
                format!("{:.3}", row.outer),
            ]
        })
        .collect();
    let header = [
        "r1 printed, mm",
        "r1, mm",
        "printed",
        "ours",
        "difference",
        "ours, more digits",
        "at the label",
        "uncorrected",
    ];
    table(&header, &rows)
}

fn table_2(table_2: &Table) -> String {
    let rows: Vec<_> = (1..)
        .zip(&table_2.rows)
        .map(|(i, (row, _))| {
            let printed = number(row.printed);
            vec![
                row.label.to_owned(),
                format!("{:.0}", row.tilt.to_degrees()),
                row.printed.to_owned(),
                format!("{:.2e}", row.eq7),
                format!("{:+.1e}", row.eq7 - printed),
                format!("{:.2}", printed / row.eq7),
                other_grid(i).map_or(String::new(), short),
                format!("{:.3}", row.outer),
            ]
        })
        .collect();
    let header = [
        "omega printed",
        "omega, degrees",
        "printed",
        "ours",
        "difference",
        "printed / ours",
        "other grid",
        "uncorrected",
    ];
    table(&header, &rows)
}

/// What the detector finds on pictures of a table's rows.
fn pictures(of: &Table) -> String {
    let value = |found: u32, px: f64| if found > 0 { mpx(px) } else { "not found".to_owned() };
    let rows: Vec<_> = of
        .rows
        .iter()
        .map(|(row, [clean, noisy])| {
            let found = |seen: &Seen| format!("{} of {PICTURES}", seen.found);
            vec![
                row.label.to_owned(),
                mpx(row.eq7),
                mpx(row.outer),
                found(clean),
                value(clean.found, clean.eq7),
                value(clean.found, clean.outer),
                found(noisy),
                value(noisy.found, noisy.eq7),
                value(noisy.found, noisy.outer),
            ]
        })
        .collect();
    let [first, second] = NOISES.map(|noise| format!("noise {noise}: "));
    let head = |noise: &str, what: &str| format!("{noise}{what}");
    let header = [
        "row".to_owned(),
        "eq. (7), theory".to_owned(),
        "outer ellipse, theory".to_owned(),
        head(&first, "found"),
        head(&first, "eq. (7)"),
        head(&first, "outer ellipse"),
        head(&second, "found"),
        head(&second, "eq. (7)"),
        head(&second, "outer ellipse"),
    ];
    let header: Vec<_> = header.iter().map(String::as_str).collect();
    format!(
        "\nThe same from rendered pictures through the detector, {PICTURES} for each noise (grey levels of 190 between dark \
         and bright, blur 0.8 px, 8 bits). RMS distance from the true centre in mpx (1/1000 px):\n\n{}",
        table(&header, &rows)
    )
}

fn lens_table(rows: &[lens::Row]) -> String {
    let rows: Vec<_> = rows
        .iter()
        .map(|row| {
            let [k1, k2, k3] = row.lens.radial;
            let [p1, p2] = row.lens.decentring;
            let [b1, b2] = row.lens.affine;
            let components = if p1 == 0.0 {
                format!("k1 {k1}")
            } else {
                format!("k1 {k1}, k2 {k2}, k3 {k3}, p1 {p1}, p2 {p2}, b1 {b1}, b2 {b2}")
            };
            let mut cells = vec![components, format!("{:.0}", row.radius)];
            cells.extend([row.outer, row.apart, row.neglected, row.eq7, row.perspective].map(mpx));
            cells
        })
        .collect();
    let header = [
        "lens",
        "R, px",
        "outer ellipse",
        "apart",
        "neglected by (8)",
        "eq. (7), distorted",
        "eq. (7), no lens",
    ];
    let (f, x, y) = (lens::FOCAL_LENGTH, lens::PLACE.x, lens::PLACE.y);
    format!(
        "Tilt {:.0} degrees, f {f:.0} px, {x:.0} px right of and {:.0} px above the principal point. In mpx:\n\n{}",
        lens::TILT,
        -y,
        table(&header, &rows)
    )
}

fn single(single: &Single) -> String {
    let rows: Vec<_> = single
        .centres
        .iter()
        .map(|(name, [x, y], off)| {
            vec![(*name).to_owned(), format!("{x:.3}"), format!("{y:.3}"), format!("{off:.4}")]
        })
        .collect();
    let [a, b] = single.axes;
    let [x, y] = single.truth;
    format!(
        "\n## Figure 6: one picture of a single target\n\nRadii {:.0} and {:.0} mm, {:.0} mm away, at {:.0} degrees: an ellipse of \
         {a:.0} x {b:.0} px. The paper prints no figure for it but speaks of good accordance. The true centre is at \
         ({x:.3}, {y:.3}). Eq. (7) itself leaves {:.4} px here (by the law of the model, without a picture): above the 0.01 px \
         and 0.02 px that the paper takes as the accuracy of centres. The library expects {:.4} px of noise in one \
         coordinate.\n\n{}",
        single::RADIUS,
        single::RADIUS / 2.0,
        single::DISTANCE,
        single::TILT,
        single.residual,
        single.sigma,
        table(&["centre", "x", "y", "off the true centre"], &rows)
    )
}
