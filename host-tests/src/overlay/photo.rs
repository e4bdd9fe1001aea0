//! The whole photograph with every target, and the candidates that were rejected.

use concentric::{Reject, Rejected, Target};

use super::{
    canvas::{Area, Canvas, Colour, LINE, text_width},
    marks::{GROUND, INK, Mark, REJECTED, View},
};
use crate::{measure::px, picture::Picture};

/// Rejected candidates with a smaller box, px, are left out.
pub const SMALLEST_BOX: u16 = 8;
/// At most so many rejected candidates are drawn.
const MOST_BOXES: usize = 80;

/// Draws the photograph dimmed, `scale` times as large.
pub fn paint(canvas: &mut Canvas, picture: &Picture, view: &View) {
    view.paint(canvas, picture, |level| 16 + (u16::from(level) * 3 / 5) as u8);
}

/// The rejected candidates worth a box: first those that came far enough to be an ellipse, large ones before small ones.
pub fn worth_a_box(rejected: &[Rejected]) -> Vec<&Rejected> {
    let mut boxes: Vec<_> = rejected.iter().filter(|one| one.width.max(one.height) >= SMALLEST_BOX).collect();
    let early = |cause| matches!(cause, Reject::TooSmall | Reject::CutByFrame | Reject::NotElliptic);
    boxes.sort_by_key(|one| {
        (early(one.cause), std::cmp::Reverse(u32::from(one.width) * u32::from(one.height)))
    });
    boxes.truncate(MOST_BOXES);
    boxes
}

/// Draws the boxes of rejected candidates.
pub fn boxes(canvas: &mut Canvas, boxes: &[&Rejected], view: &View) {
    for candidate in boxes {
        canvas.frame(candidate_area(candidate, view), REJECTED);
    }
}

/// Draws every target; `factor` enlarges the error ellipses.
pub fn targets(canvas: &mut Canvas, targets: &[Target], view: &View, factor: f64) {
    for target in targets {
        view.ellipses(canvas, target, 1.5);
        view.sigma(canvas, target, factor);
        view.centres(canvas, target, 5.0, false);
    }
}

/// Places for text that do not cover each other or a target.
pub struct Labels {
    frame: Area,
    taken: Vec<Area>,
}

impl Labels {
    /// Labels inside a canvas of `size` px that keep off the outer ellipses of `targets`.
    pub fn new([width, height]: [f32; 2], targets: &[Target], view: &View) -> Self {
        let taken = targets.iter().map(|target| bounds(target, view)).collect();
        Self { frame: Area { x: 0.0, y: 0.0, width, height }, taken }
    }

    /// The first free one of the places for `text` around `area`.
    fn around(&self, area: Area, text: &str) -> Option<Area> {
        let Area { width, height, .. } = text_area(text);
        let (right, below) = (area.x + area.width + 3.0, area.y + area.height + 2.0);
        let (left, above) = (area.x - width - 3.0, area.y - height - 2.0);
        let middle = area.y + (area.height - height) / 2.0;
        let centred = area.x + (area.width - width) / 2.0;
        self.first_free(
            text,
            &[
                [right, middle],
                [centred, below],
                [centred, above],
                [left, middle],
                [right, above],
                [right, below],
                [area.x, above],
                [area.x, below],
            ],
        )
    }

    fn first_free(&self, text: &str, places: &[[f32; 2]]) -> Option<Area> {
        let place = |&[x, y]: &[f32; 2]| Area { x, y, ..text_area(text) };
        places
            .iter()
            .map(place)
            .find(|place| self.frame.holds(place) && !self.taken.iter().any(|other| other.meets(place)))
    }

    fn write(&mut self, canvas: &mut Canvas, place: Area, text: &str, colour: Colour) {
        canvas.fill(place, GROUND, 0.72);
        canvas.text([place.x + 3.0, place.y + 1.0], text, colour, false);
        self.taken.push(place);
    }

    /// Writes number and coordinates beside every target; where there is no room for both, the number.
    pub fn targets(&mut self, canvas: &mut Canvas, targets: &[Target], view: &View) {
        for (index, target) in targets.iter().enumerate() {
            let area = bounds(target, view);
            let [x, y] = px(target.centre);
            let number = name(target, index);
            for text in [format!("{number}: {x:.3}, {y:.3}"), number] {
                if let Some(place) = self.around(area, &text) {
                    self.write(canvas, place, &text, INK);
                    break;
                }
            }
        }
    }

    /// Writes the cause beside the box of every rejected candidate where there is room for it.
    pub fn rejected(&mut self, canvas: &mut Canvas, boxes: &[&Rejected], view: &View) {
        for candidate in boxes {
            let area = candidate_area(candidate, view);
            let text = candidate.cause.name().replace('_', " ");
            let corner = [[area.x + 2.0, area.y + 2.0]];
            let inside = self.first_free(&text, &corner).filter(|place| area.holds(place));
            if let Some(place) = inside.or_else(|| self.around(area, &text)) {
                self.write(canvas, place, &text, REJECTED);
            }
        }
    }
}

/// What a target is called: its number in the list, and its id where it carries one.
pub fn name(target: &Target, index: usize) -> String {
    let id = target.code.map_or_else(String::new, |code| format!(" id {}", code.id));
    format!("{}{id}", index + 1)
}

fn text_area(text: &str) -> Area {
    Area { x: 0.0, y: 0.0, width: text_width(text, false) + 6.0, height: LINE }
}

fn candidate_area(candidate: &Rejected, view: &View) -> Area {
    let (width, height) = (f64::from(candidate.width), f64::from(candidate.height));
    let [x, y] = px(candidate.centre);
    let [left, top] = view.place([x - width / 2.0, y - height / 2.0]);
    Area { x: left, y: top, width: (width * view.scale) as f32, height: (height * view.scale) as f32 }
}

fn bounds(target: &Target, view: &View) -> Area {
    let Some(outer) = target.circles.first() else {
        return Area { x: 0.0, y: 0.0, width: 0.0, height: 0.0 };
    };
    let (sin, cos) = outer.ellipse.theta.sin_cos();
    let (a, b) = (outer.ellipse.a, outer.ellipse.b);
    let scale = view.scale as f32;
    let (half_width, half_height) = ((a * cos).hypot(b * sin) * scale, (a * sin).hypot(b * cos) * scale);
    let [x, y] = view.place(px(outer.ellipse.centre));
    Area { x: x - half_width, y: y - half_height, width: 2.0 * half_width, height: 2.0 * half_height }
}

/// Draws where the centres really are.
pub fn truth(canvas: &mut Canvas, places: &[[f64; 2]], view: &View) {
    for place in places {
        Mark::Truth.draw(canvas, view.place(*place), 9.0);
    }
}
