//! Anti-aliased lines, ellipses and text on an RGB picture; coordinates in its pixels, (0, 0) at its top-left corner.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, PixmapPaint, Rect, Stroke, Transform};

/// Red, green, blue.
pub type Colour = [u8; 3];

/// Height of a line of text, px.
pub const LINE: f32 = 18.0;
const FACE: RasterHeight = RasterHeight::Size16;

/// A rectangle: left, top, width, height, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Left edge.
    pub x: f32,
    /// Top edge.
    pub y: f32,
    /// Width.
    pub width: f32,
    /// Height.
    pub height: f32,
}

impl Area {
    /// Whether the two share any place.
    pub fn meets(&self, other: &Area) -> bool {
        self.x < other.x + other.width
            && other.x < self.x + self.width
            && self.y < other.y + other.height
            && other.y < self.y + self.height
    }

    /// Whether `other` is wholly inside.
    pub fn holds(&self, other: &Area) -> bool {
        other.x >= self.x
            && other.y >= self.y
            && other.x + other.width <= self.x + self.width
            && other.y + other.height <= self.y + self.height
    }
}

/// An ellipse to draw: semi-axes `a` (in direction `theta`, radians from +x towards +y) and `b`, px.
#[derive(Clone, Copy, Debug)]
pub struct Oval {
    /// Centre.
    pub at: [f32; 2],
    /// Semi-axis in direction `theta`.
    pub a: f32,
    /// The other semi-axis.
    pub b: f32,
    /// Direction of `a`.
    pub theta: f32,
}

/// A picture that is being drawn.
pub struct Canvas(Pixmap);

impl Canvas {
    /// A canvas filled with `ground`.
    ///
    /// # Errors
    /// A size of zero, or one too large for memory.
    pub fn new(width: usize, height: usize, ground: Colour) -> Result<Self> {
        let size = u32::try_from(width).ok().zip(u32::try_from(height).ok());
        let mut pixmap = size
            .and_then(|(width, height)| Pixmap::new(width, height))
            .with_context(|| format!("no memory for a picture of {width} x {height} px"))?;
        pixmap.fill(solid(ground, 1.0));
        Ok(Self(pixmap))
    }

    /// Sets one pixel; outside nothing happens.
    pub fn set(&mut self, x: usize, y: usize, [red, green, blue]: Colour) {
        let (width, height) = (self.0.width() as usize, self.0.height() as usize);
        if x < width && y < height {
            self.0.data_mut()[4 * (y * width + x)..][..4].copy_from_slice(&[red, green, blue, 255]);
        }
    }

    /// Lays `other` on this with its top-left corner at `(x, y)`; what reaches beyond is cut off.
    pub fn paste(&mut self, other: &Canvas, [x, y]: [f32; 2]) {
        let top = PixmapPaint::default();
        self.0.draw_pixmap(x as i32, y as i32, other.0.as_ref(), &top, Transform::identity(), None);
    }

    /// Width and height, px.
    pub fn size(&self) -> [f32; 2] {
        [self.0.width() as f32, self.0.height() as f32]
    }

    /// A filled rectangle with `opacity` 0 to 1.
    pub fn fill(&mut self, area: Area, colour: Colour, opacity: f32) {
        if let Some(rect) = Rect::from_xywh(area.x, area.y, area.width, area.height) {
            self.0.fill_rect(rect, &paint(colour, opacity), Transform::identity(), None);
        }
    }

    /// The outline of a rectangle, one px wide and on whole pixels so that it stays sharp.
    pub fn frame(&mut self, area: Area, colour: Colour) {
        let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(f32::round);
        if let Some(rect) = Rect::from_xywh(x + 0.5, y + 0.5, width - 1.0, height - 1.0) {
            self.stroke(&PathBuilder::from_rect(rect), colour, 1.0, Transform::identity());
        }
    }

    /// A line through `points`.
    pub fn line(&mut self, points: &[[f32; 2]], colour: Colour, width: f32) {
        if let Some(path) = through(points, false) {
            self.stroke(&path, colour, width, Transform::identity());
        }
    }

    /// A closed outline through `points`.
    pub fn polygon(&mut self, points: &[[f32; 2]], colour: Colour, width: f32) {
        if let Some(path) = through(points, true) {
            self.stroke(&path, colour, width, Transform::identity());
        }
    }

    /// The outline of an ellipse. Nothing is drawn where a number is not finite.
    pub fn oval(&mut self, oval: Oval, colour: Colour, width: f32) {
        let Oval { at: [x, y], a, b, theta } = oval;
        let path = Rect::from_ltrb(-a, -b, a, b).and_then(PathBuilder::from_oval);
        if let Some(path) = path.filter(|_| (x + y + theta).is_finite()) {
            self.stroke(
                &path,
                colour,
                width,
                Transform::from_rotate(theta.to_degrees()).post_translate(x, y),
            );
        }
    }

    /// A filled disc.
    pub fn disc(&mut self, [x, y]: [f32; 2], radius: f32, colour: Colour) {
        if let Some(path) = PathBuilder::from_circle(x, y, radius) {
            self.0.fill_path(&path, &paint(colour, 1.0), FillRule::Winding, Transform::identity(), None);
        }
    }

    /// One line of text with its top-left corner at `(x, y)`; characters that the face lacks become `?`.
    pub fn text(&mut self, [x, y]: [f32; 2], text: &str, colour: Colour, bold: bool) {
        let weight = weight(bold);
        let (left, top) = (x.round() as i64, y.round() as i64);
        for (index, letter) in text.chars().enumerate() {
            let Some(raster) = get_raster(letter, weight, FACE).or_else(|| get_raster('?', weight, FACE))
            else {
                continue;
            };
            let left = left + (index * raster.width()) as i64;
            for (dy, row) in raster.rows().enumerate() {
                for (dx, &cover) in row.iter().enumerate() {
                    self.blend(left + dx as i64, top + dy as i64, colour, cover);
                }
            }
        }
    }

    /// Writes the picture as a PNG file.
    ///
    /// # Errors
    /// A file that cannot be written; the message names it.
    pub fn save(&self, path: &Path) -> Result<()> {
        let (width, height) = (self.0.width(), self.0.height());
        let rgb: Vec<u8> =
            self.0.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        ensure!(!path.is_dir(), "{} is a directory; the picture needs a file name", path.display());
        image::save_buffer_with_format(
            path,
            &rgb,
            width,
            height,
            image::ColorType::Rgb8,
            image::ImageFormat::Png,
        )
        .with_context(|| format!("the picture {} cannot be written", path.display()))
    }

    fn blend(&mut self, x: i64, y: i64, colour: Colour, cover: u8) {
        let (width, height) = (i64::from(self.0.width()), i64::from(self.0.height()));
        if cover == 0 || !(0..width).contains(&x) || !(0..height).contains(&y) {
            return;
        }
        let pixel = &mut self.0.data_mut()[4 * (y * width + x) as usize..][..3];
        for (old, new) in pixel.iter_mut().zip(colour) {
            let sum = u32::from(*old) * u32::from(255 - cover) + u32::from(new) * u32::from(cover);
            *old = ((sum + 127) / 255) as u8;
        }
    }

    fn stroke(&mut self, path: &tiny_skia::Path, colour: Colour, width: f32, transform: Transform) {
        let stroke = Stroke { width, ..Stroke::default() };
        self.0.stroke_path(path, &paint(colour, 1.0), &stroke, transform, None);
    }
}

/// Width of a line of text, px.
pub fn text_width(text: &str, bold: bool) -> f32 {
    (text.chars().count() * get_raster_width(weight(bold), FACE)) as f32
}

fn weight(bold: bool) -> FontWeight {
    if bold { FontWeight::Bold } else { FontWeight::Regular }
}

fn solid([red, green, blue]: Colour, opacity: f32) -> Color {
    let alpha = (opacity.clamp(0.0, 1.0) * 255.0).round() as u8;
    Color::from_rgba8(red, green, blue, alpha)
}

fn paint(colour: Colour, opacity: f32) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(solid(colour, opacity));
    paint
}

fn through(points: &[[f32; 2]], closed: bool) -> Option<tiny_skia::Path> {
    let (first, rest) = points.split_first()?;
    let mut path = PathBuilder::new();
    path.move_to(first[0], first[1]);
    rest.iter().for_each(|point| path.line_to(point[0], point[1]));
    if closed {
        path.close();
    }
    path.finish()
}
