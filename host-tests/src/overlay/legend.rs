//! The explanation of the marks under the picture.

use anyhow::Result;

use super::{
    canvas::{Canvas, Colour, LINE, Oval, text_width},
    marks::{FAINT, GROUND, INK, Mark, REJECTED, SIGMA},
};

const MARGIN: f32 = 12.0;
const SIGN: f32 = 22.0;
const ROW: f32 = LINE + 4.0;

/// What stands before the words of an entry.
pub enum Sign {
    /// A centre.
    Mark(Mark),
    /// The outline of a circle.
    Ellipse(Colour),
    /// An error ellipse.
    Sigma,
    /// A rejected candidate.
    Box,
    /// Nothing.
    None,
}

/// Signs with their words, laid out in rows.
pub struct Legend {
    entries: Vec<(Sign, String)>,
}

impl Legend {
    /// A legend of `entries`.
    pub fn new(entries: Vec<(Sign, String)>) -> Self {
        Self { entries }
    }

    /// Draws the legend, `width` px wide and as high as it needs.
    ///
    /// # Errors
    /// No memory for it.
    pub fn draw(&self, width: usize) -> Result<Canvas> {
        let places = self.places(width as f32);
        let bottom = places.last().map_or(0.0, |[_, y]| y + ROW);
        let mut canvas = Canvas::new(width, (bottom + MARGIN) as usize, GROUND)?;
        for ((sign, words), [x, y]) in self.entries.iter().zip(places) {
            draw_sign(&mut canvas, sign, [x + SIGN / 2.0 - 3.0, y + LINE / 2.0]);
            let (indent, colour) = if matches!(sign, Sign::None) { (0.0, FAINT) } else { (SIGN, INK) };
            canvas.text([x + indent, y], words, colour, false);
        }
        Ok(canvas)
    }

    fn places(&self, width: f32) -> Vec<[f32; 2]> {
        let (mut x, mut y) = (MARGIN, MARGIN);
        let place = |(sign, words): &(Sign, String)| {
            let indent = if matches!(sign, Sign::None) { 0.0 } else { SIGN };
            let needed = indent + text_width(words, false);
            if x > MARGIN && x + needed > width - MARGIN {
                (x, y) = (MARGIN, y + ROW);
            }
            let here = [x, y];
            x += needed + 26.0;
            here
        };
        self.entries.iter().map(place).collect()
    }
}

fn draw_sign(canvas: &mut Canvas, sign: &Sign, [x, y]: [f32; 2]) {
    match sign {
        Sign::Mark(mark) => mark.draw(canvas, [x, y], 6.0),
        Sign::Ellipse(colour) => canvas.oval(Oval { at: [x, y], a: 8.0, b: 6.0, theta: -0.4 }, *colour, 1.5),
        Sign::Sigma => canvas.oval(Oval { at: [x, y], a: 8.0, b: 5.0, theta: 0.5 }, SIGMA, 1.5),
        Sign::Box => {
            let corners = [[x - 7.0, y - 6.0], [x + 7.0, y - 6.0], [x + 7.0, y + 6.0], [x - 7.0, y + 6.0]];
            canvas.polygon(&corners, REJECTED, 1.0);
        }
        Sign::None => {}
    }
}
