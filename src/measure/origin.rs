//! The integer pixel about which a target is measured, and the lens before it.

use crate::abilities::CAMERA;
use crate::camera::{Camera, Local};
use crate::fit::Shape;
use crate::fixed::{PX, fixed};
use crate::target::{Circle, Covariance, Position, Target};

/// Edge points have 1/256 px.
const GRID: i32 = 256;
/// Farthest that the fits take a point, px.
const FARTHEST: f32 = 4096.0;

/// Edge points go in through it, results go out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin {
    pub pixel: (u16, u16),
    lens: Option<Local>,
}

impl Origin {
    /// `None` where the camera's distortion folds the image.
    pub fn new(pixel: (u16, u16), camera: Option<&Camera>) -> Option<Self> {
        let place = Position::from_origin(i32::from(pixel.0), i32::from(pixel.1), 0.0, 0.0);
        let lens = match camera {
            Some(camera) => Some(Local::new(camera, place)?),
            None => None,
        };
        Some(Self { pixel, lens })
    }

    /// That of a target: its outer ellipse's centre.
    pub fn of(target: &Target, camera: Option<&Camera>) -> Option<Self> {
        let centre = target.circles.first()?.ellipse.centre;
        let pixel = |place: i32| u16::try_from(place / Position::SCALE).ok();
        Self::new((pixel(centre.x)?, pixel(centre.y)?), camera)
    }

    /// Where the undistorted image shows `position`, px.
    pub fn offset(&self, position: Position) -> Option<(f32, f32)> {
        let from = Position::from_origin(i32::from(self.pixel.0), i32::from(self.pixel.1), 0.0, 0.0);
        self.place(position.offset_from(from))
    }

    /// The ellipse of one of the target's circles.
    pub fn shape(&self, circle: &Circle) -> Option<Shape> {
        Shape::from_ellipse(&circle.ellipse, self.offset(circle.ellipse.centre)?)
    }

    pub fn lens(&self) -> Option<&Local> {
        self.lens.as_ref().filter(|_| CAMERA)
    }

    /// Edge point without distortion, [`PX`]. `None` where the lens folds the image or puts the point too far away.
    pub fn undistorted(&self, (x, y): (i32, i32)) -> Option<(i32, i32)> {
        const EACH: i32 = PX / GRID;
        if self.lens().is_none() {
            return Some((EACH * x, EACH * y));
        }
        let (x, y) = self.place((x as f32 / GRID as f32, y as f32 / GRID as f32))?;
        (x.abs() < FARTHEST && y.abs() < FARTHEST).then(|| (fixed(x, PX), fixed(y, PX)))
    }

    /// The place without distortion of what is seen `(x, y)` px from the origin.
    pub fn place(&self, seen: (f32, f32)) -> Option<(f32, f32)> {
        match self.lens() {
            Some(lens) => lens.undistort(seen),
            None => Some(seen),
        }
    }

    /// An ellipse in the image as it is without distortion, by the lens's derivative at its centre.
    pub fn undistorted_shape(&self, shape: &Shape) -> Option<Shape> {
        if self.lens().is_none() {
            return Some(*shape);
        }
        let (cx, cy) = self.place((shape.cx, shape.cy))?;
        let [xx, xy, yx, yy] = self.slope((cx, cy));
        let det = xx * yy - xy * yx;
        let (a, b, c, d) = (yy / det, -xy / det, -yx / det, xx / det);
        let Shape { axx, axy, ayy, .. } = *shape;
        Some(Shape {
            cx,
            cy,
            axx: a * (a * axx + c * axy) + c * (a * axy + c * ayy),
            axy: b * (a * axx + c * axy) + d * (a * axy + c * ayy),
            ayy: b * (b * axx + d * axy) + d * (b * axy + d * ayy),
        })
    }

    /// The inverse of [`place`](Self::place).
    pub fn seen(&self, place: (f32, f32)) -> (f32, f32) {
        self.lens().map_or(place, |lens| lens.distort(place))
    }

    /// Derivative (xx, xy, yx, yy) of the place by what is seen.
    pub fn slope(&self, place: (f32, f32)) -> [f32; 4] {
        self.lens().map_or([1.0, 0.0, 0.0, 1.0], |lens| lens.undistorted_slope(place))
    }

    /// Where the image shows `(x, y)`.
    #[inline(never)]
    pub fn position(&self, x: f32, y: f32) -> Position {
        let (x, y) = self.seen((x, y));
        Position::from_origin(i32::from(self.pixel.0), i32::from(self.pixel.1), x, y)
    }

    /// The covariance there.
    pub fn covariance(&self, place: (f32, f32), covariance: &Covariance) -> Covariance {
        self.lens().map_or(*covariance, |lens| lens.distort_covariance(place, covariance))
    }
}
