//! What a target looks like on a picture: its ellipses, the marks of its centres, its error ellipse.

use concentric::{Ellipse, Target};

use super::canvas::{Canvas, Colour, Oval};
use crate::{
    measure::{axes, px},
    picture::Picture,
};

/// Behind marks and text.
pub const GROUND: Colour = [16, 19, 26];
/// Text.
pub const INK: Colour = [226, 231, 238];
/// Text of less weight.
pub const FAINT: Colour = [140, 150, 165];
/// Rejected candidates.
pub const REJECTED: Colour = [255, 150, 50];
/// Error ellipses.
pub const SIGMA: Colour = [255, 225, 90];

/// A place of interest of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// B1, the centre of the outermost ellipse.
    Outer,
    /// B2, the centre of the innermost ellipse.
    Inner,
    /// The centre by eq. (7).
    Eq7,
    /// C, the true centre as reported.
    Centre,
    /// Where the centre really is, known only of a rendered picture.
    Truth,
}

impl Mark {
    /// Colour of the mark, and of the ellipse whose centre it is.
    pub fn colour(self) -> Colour {
        match self {
            Mark::Outer => [64, 190, 255],
            Mark::Inner => [255, 105, 200],
            Mark::Eq7 => [190, 150, 255],
            Mark::Centre => [110, 255, 120],
            Mark::Truth => [255, 255, 255],
        }
    }

    /// Draws the mark, `size` px from its middle to its rim, on a dark rim of its own.
    pub fn draw(self, canvas: &mut Canvas, at: [f32; 2], size: f32) {
        self.strokes(canvas, at, size, ([0, 0, 0], 3.5));
        self.strokes(canvas, at, size, (self.colour(), 1.5));
    }

    fn strokes(self, canvas: &mut Canvas, [x, y]: [f32; 2], r: f32, (colour, width): (Colour, f32)) {
        match self {
            Mark::Outer => canvas.polygon(
                &[[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]],
                colour,
                width,
            ),
            Mark::Inner => canvas.polygon(&[[x - r, y], [x, y - r], [x + r, y], [x, y + r]], colour, width),
            Mark::Eq7 => {
                let (half, low) = (0.87 * r, 0.5 * r);
                canvas.polygon(&[[x, y - r], [x + half, y + low], [x - half, y + low]], colour, width);
            }
            Mark::Centre => {
                canvas.line(&[[x - r, y], [x + r, y]], colour, width);
                canvas.line(&[[x, y - r], [x, y + r]], colour, width);
            }
            Mark::Truth => canvas.oval(Oval { at: [x, y], a: r, b: r, theta: 0.0 }, colour, width),
        }
    }
}

/// A window on the image: `scale` canvas px to the image px, image place `corner` at the canvas' top-left corner,
/// where the image's own corner, half a pixel outside the first pixel's centre, is (0, 0).
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Canvas px to the image px.
    pub scale: f64,
    /// Image place at the canvas' corner, px from the image's corner.
    pub corner: [f64; 2],
}

impl View {
    /// A window of `size` canvas px round the image place `middle`, at least `reach` image px to every side of it.
    pub fn around(middle: [f64; 2], reach: f64, size: [f64; 2]) -> Self {
        let scale = size[0].min(size[1]) / (2.0 * reach);
        let corner = |axis: usize| middle[axis] + 0.5 - size[axis] / (2.0 * scale);
        Self { scale, corner: [corner(0), corner(1)] }
    }

    /// Canvas place of the image place `(x, y)`, px.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f32; 2] {
        let axis = |value: f64, corner: f64| ((value + 0.5 - corner) * self.scale) as f32;
        [axis(x, self.corner[0]), axis(y, self.corner[1])]
    }

    /// Paints the part of `picture` under the window, each grey level through `tone`; beyond the picture nothing.
    pub fn paint(&self, canvas: &mut Canvas, picture: &Picture, tone: impl Fn(u8) -> u8) {
        let [width, height] = canvas.size();
        let source = |place: usize, corner: f64, limit: usize| {
            let axis = (corner + (place as f64 + 0.5) / self.scale).floor();
            (axis >= 0.0 && axis < limit as f64).then_some(axis as usize)
        };
        let columns: Vec<_> = (0..width as usize).map(|x| source(x, self.corner[0], picture.width)).collect();
        for y in 0..height as usize {
            let Some(row) = source(y, self.corner[1], picture.height) else { continue };
            for (x, column) in columns.iter().enumerate() {
                if let Some(column) = column {
                    let level = tone(picture.pixels[row * picture.width + column]);
                    canvas.set(x, y, [level; 3]);
                }
            }
        }
    }

    /// Draws the ellipses of `target`'s circles.
    pub fn ellipses(&self, canvas: &mut Canvas, target: &Target, width: f32) {
        let last = target.circles.len().saturating_sub(1);
        for (index, circle) in target.circles.iter().enumerate() {
            let colour = if index == last { Mark::Inner.colour() } else { Mark::Outer.colour() };
            canvas.oval(self.oval(&circle.ellipse), colour, width);
        }
    }

    /// Draws the marks of `target`'s centres: those of the ellipses, eq. (7) if wanted, and C on top.
    pub fn centres(&self, canvas: &mut Canvas, target: &Target, size: f32, eq7: bool) {
        if let (Some(outer), Some(inner)) = (target.circles.first(), target.circles.last()) {
            Mark::Outer.draw(canvas, self.place(px(outer.ellipse.centre)), size);
            Mark::Inner.draw(canvas, self.place(px(inner.ellipse.centre)), size);
        }
        if eq7 {
            Mark::Eq7.draw(canvas, self.place(px(target.eq7)), size);
        }
        Mark::Centre.draw(canvas, self.place(px(target.centre)), size);
    }

    /// Draws the one-sigma ellipse of `target`'s centre, `factor` times as large as it is.
    pub fn sigma(&self, canvas: &mut Canvas, target: &Target, factor: f64) {
        let [a, b, theta] = axes(&target.covariance);
        let scale = self.scale * factor;
        let at = self.place(px(target.centre));
        canvas.oval(
            Oval { at, a: (a * scale) as f32, b: (b * scale) as f32, theta: theta as f32 },
            SIGMA,
            1.5,
        );
    }

    fn oval(&self, ellipse: &Ellipse) -> Oval {
        let scale = self.scale as f32;
        let at = self.place(px(ellipse.centre));
        Oval { at, a: ellipse.a * scale, b: ellipse.b * scale, theta: ellipse.theta }
    }
}

/// The nearest number of the series 1, 2, 5, 10, .. that is not above `value` (positive).
pub fn round_down(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    power * [5.0, 2.0].into_iter().find(|step| step * power <= value).unwrap_or(1.0)
}

/// By how many times, 1 or more of the series, an error ellipse of `sigma` canvas px is to be enlarged so that it reaches
/// about `wanted` px.
pub fn visible_factor(sigma: f64, wanted: f64) -> f64 {
    if sigma.is_finite() && sigma > 0.0 { round_down(wanted / sigma).max(1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series() {
        for (value, step) in [(0.0199, 0.01), (0.02, 0.02), (7.0, 5.0), (10.0, 10.0), (4999.0, 2000.0)] {
            assert!((round_down(value) - step).abs() < 1e-9 * step, "{value}: {}", round_down(value));
        }
    }

    #[test]
    fn a_pixels_centre_lands_on_the_middle_of_its_block() {
        let view = View { scale: 4.0, corner: [0.0, 0.0] };
        assert_eq!(view.place([0.0, 1.0]), [2.0, 6.0]);
        assert_eq!(View::around([7.25, 3.0], 0.5, [200.0, 100.0]).place([7.25, 3.5]), [100.0, 100.0]);
    }
}
