//! A sheet as PDF: the page's content is in millimetres, x right, y down, under one transformation to points.

use glam::DVec2;
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str};

use super::{LINE_WIDTH, Shape, Sheet, Tint};

/// Points in a millimetre.
pub const POINT: f64 = 72.0 / 25.4;
/// Curves of a whole circle. A cubic curve of an eighth of a circle leaves it by 4e-6 of the radius.
const CURVES: f64 = 8.0;
const FONT: Name<'static> = Name(b"F1");
/// Width of a character of the font, in its size: Helvetica's digits have 0.556, and so has its text about.
const CHARACTER: f64 = 0.53;

/// The bytes of the file.
pub fn bytes(sheet: &Sheet) -> Vec<u8> {
    let [catalog, tree, page_id, font, content_id] = [1, 2, 3, 4, 5].map(Ref::new);
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(tree);
    pdf.pages(tree).kids([page_id]).count(1);
    let DVec2 { x: width, y: height } = sheet.size * POINT;
    let mut page = pdf.page(page_id);
    page.media_box(Rect::new(0.0, 0.0, width as f32, height as f32));
    page.parent(tree);
    page.contents(content_id);
    page.resources().fonts().pair(FONT, font);
    page.finish();
    pdf.type1_font(font).base_font(Name(b"Helvetica"));

    let mut content = Content::new();
    let unit = POINT as f32;
    content.transform([unit, 0.0, 0.0, -unit, 0.0, height as f32]);
    content.set_line_width(LINE_WIDTH as f32);
    for shape in &sheet.shapes {
        draw(&mut content, shape);
    }
    pdf.stream(content_id, &content.finish());
    pdf.finish()
}

fn fill(content: &mut Content, tint: Tint) {
    content.set_fill_gray(if tint == Tint::Black { 0.0 } else { 1.0 });
}

/// Goes on along a circle from `start` by `sweep`, radians.
fn arc(content: &mut Content, at: DVec2, radius: f64, [start, sweep]: [f64; 2]) {
    let curves = (sweep.abs() / std::f64::consts::TAU * CURVES).ceil().max(1.0);
    let step = sweep / curves;
    let pull = 4.0 / 3.0 * (step / 4.0).tan() * radius;
    for k in 0..curves as u32 {
        let [a, b] = [f64::from(k), f64::from(k) + 1.0].map(|k| DVec2::from_angle(start + k * step));
        let [p, q, r] =
            [a * radius + a.perp() * pull, b * radius - b.perp() * pull, b * radius].map(|place| at + place);
        content.cubic_to(p.x as f32, p.y as f32, q.x as f32, q.y as f32, r.x as f32, r.y as f32);
    }
}

fn draw(content: &mut Content, shape: &Shape) {
    match shape {
        Shape::Rectangle { from, to, tint } => {
            fill(content, *tint);
            let size = *to - *from;
            content.rect(from.x as f32, from.y as f32, size.x as f32, size.y as f32).fill_nonzero();
        }
        Shape::Disc { at, radius, tint } => {
            fill(content, *tint);
            content.move_to((at.x + radius) as f32, at.y as f32);
            arc(content, *at, *radius, [0.0, std::f64::consts::TAU]);
            content.close_path().fill_nonzero();
        }
        Shape::Segment { at, radii: [inner, outer], arc: [start, sweep], tint } => {
            fill(content, *tint);
            let first = *at + DVec2::from_angle(*start) * *outer;
            content.move_to(first.x as f32, first.y as f32);
            arc(content, *at, *outer, [*start, *sweep]);
            let turn = *at + DVec2::from_angle(start + sweep) * *inner;
            content.line_to(turn.x as f32, turn.y as f32);
            arc(content, *at, *inner, [start + sweep, -sweep]);
            content.close_path().fill_nonzero();
        }
        Shape::Line { from, to } => {
            content.move_to(from.x as f32, from.y as f32).line_to(to.x as f32, to.y as f32).stroke();
        }
        Shape::Text { at, size, text, tint } => {
            fill(content, *tint);
            let left = at.x - CHARACTER * size * text.len() as f64 / 2.0;
            content.begin_text().set_font(FONT, *size as f32);
            // Upright, as y runs down.
            content.set_text_matrix([1.0, 0.0, 0.0, -1.0, left as f32, at.y as f32]);
            content.show(Str(text.as_bytes())).end_text();
        }
    }
}
