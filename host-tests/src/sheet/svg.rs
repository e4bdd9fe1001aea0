//! A sheet as SVG: one user unit is a millimetre.

use std::fmt::Write;

use glam::DVec2;

use super::{LINE_WIDTH, Shape, Sheet, Tint};

/// Lengths have this many decimals, mm.
const DECIMALS: usize = 4;

/// The text of the file.
pub fn text(sheet: &Sheet) -> String {
    let DVec2 { x: width, y: height } = sheet.size;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
         viewBox=\"0 0 {width} {height}\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for shape in &sheet.shapes {
        let _ = writeln!(text, "{}", element(shape));
    }
    text + "</svg>\n"
}

fn name(tint: Tint) -> &'static str {
    if tint == Tint::Black { "black" } else { "white" }
}

fn mm(length: f64) -> String {
    format!("{length:.DECIMALS$}")
}

fn pair(place: DVec2) -> String {
    format!("{} {}", mm(place.x), mm(place.y))
}

fn element(shape: &Shape) -> String {
    match shape {
        Shape::Rectangle { from, to, tint } => {
            let size = *to - *from;
            let [x, y, width, height] = [from.x, from.y, size.x, size.y].map(mm);
            format!(
                "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{}\"/>",
                name(*tint)
            )
        }
        Shape::Disc { at, radius, tint } => {
            let [x, y, radius] = [at.x, at.y, *radius].map(mm);
            format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{}\"/>", name(*tint))
        }
        Shape::Segment { at, radii: [inner, outer], arc: [start, sweep], tint } => {
            let point = |radius: f64, angle: f64| pair(*at + DVec2::from_angle(angle) * radius);
            let end = start + sweep;
            let large = u8::from(*sweep > std::f64::consts::PI);
            let (r, s) = (mm(*outer), mm(*inner));
            format!(
                "<path d=\"M {} A {r} {r} 0 {large} 1 {} L {} A {s} {s} 0 {large} 0 {} Z\" fill=\"{}\"/>",
                point(*outer, *start),
                point(*outer, end),
                point(*inner, end),
                point(*inner, *start),
                name(*tint)
            )
        }
        Shape::Line { from, to } => {
            let [x1, y1, x2, y2] = [from.x, from.y, to.x, to.y].map(mm);
            format!(
                "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke=\"black\" stroke-width=\"{LINE_WIDTH}\"/>"
            )
        }
        Shape::Text { at, size, text, tint } => {
            let [x, y] = [at.x, at.y].map(mm);
            let text = text.replace('&', "&amp;").replace('<', "&lt;");
            format!(
                "<text x=\"{x}\" y=\"{y}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"{size}\" \
                 text-anchor=\"middle\" fill=\"{}\">{text}</text>",
                name(*tint)
            )
        }
    }
}
