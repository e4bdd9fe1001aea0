//! A calibrated camera: focal length, principal point, lens distortion.
//!
//! Names and model are OpenCV's. With the ray `(X, Y, Z)` in camera axes (x right, y down, z forward), `x = X / Z`,
//! `y = Y / Z` and `r^2 = x^2 + y^2`:
//!
//! ```text
//! x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)      column = fx x' + cx
//! y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y      row    = fy y' + cy
//! ```
//!
//! (Brown 1971, "Close-range camera calibration", Photogramm. Eng. 37(8).) *Undistorted* px are `(fx x + cx, fy y + cy)`.

mod error;
mod local;

pub use error::CameraError;
pub(crate) use local::Local;

use crate::target::Position;

/// Lens distortion in OpenCV's terms, zero by default. Largest magnitude of each: [`Distortion::MAX`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Distortion {
    /// Radial, second order.
    pub k1: f32,
    /// Radial, fourth order.
    pub k2: f32,
    /// Tangential, along y.
    pub p1: f32,
    /// Tangential, along x.
    pub p2: f32,
    /// Radial, sixth order.
    pub k3: f32,
}

impl Distortion {
    /// Largest magnitude of a coefficient.
    pub const MAX: f32 = 1000.0;

    /// k1 r^2 + k2 r^4 + k3 r^6 at `t = r^2`.
    const fn radial(&self, t: f32) -> f32 {
        t * (self.k1 + t * (self.k2 + t * self.k3))
    }

    /// What it adds to the place `(x, y)`.
    fn shift(&self, (x, y): (f32, f32)) -> (f32, f32) {
        let square = x * x + y * y;
        let radial = self.radial(square);
        let cross = 2.0 * x * y;
        (
            x * radial + self.p1 * cross + self.p2 * (square + 2.0 * x * x),
            y * radial + self.p1 * (square + 2.0 * y * y) + self.p2 * cross,
        )
    }

    /// Derivative of the distorted place at `(x, y)`: `(xx, xy, yy)` of a symmetric matrix.
    #[inline(never)]
    fn slope(&self, (x, y): (f32, f32)) -> (f32, f32, f32) {
        let t = x * x + y * y;
        let along = 1.0 + self.radial(t);
        let bend = 2.0 * (self.k1 + t * (2.0 * self.k2 + t * 3.0 * self.k3));
        (
            along + bend * x * x + 2.0 * self.p1 * y + 6.0 * self.p2 * x,
            bend * x * y + 2.0 * self.p1 * x + 2.0 * self.p2 * y,
            along + bend * y * y + 6.0 * self.p1 * y + 2.0 * self.p2 * x,
        )
    }

    /// Square of the distorted radius up to which the radial terms grow with the radius, to 2 %: beyond it the lens would
    /// show the same place twice.
    const fn limit(&self) -> f32 {
        let mut t = 0.0;
        let mut next = 0.002;
        // Up to 89 degrees from the axis; larger ones have no pinhole image.
        while next < 3000.0
            && 1.0 + next * (3.0 * self.k1 + next * (5.0 * self.k2 + next * 7.0 * self.k3)) > 0.0
        {
            t = next;
            next *= 1.01;
        }
        let growth = 1.0 + self.radial(t);
        t * growth * growth
    }

    /// The place that distortion moves to `distorted` (Newton's method). `None` if there is none.
    #[inline(never)]
    fn undo(&self, (x, y): (f32, f32)) -> Option<(f32, f32)> {
        let mut at = (x, y);
        for _ in 0..20 {
            let (sx, sy) = self.shift(at);
            let step = divide((x - at.0 - sx, y - at.1 - sy), self.slope(at))?;
            at = (at.0 + step.0, at.1 + step.1);
            if step.0 * step.0 + step.1 * step.1 < 1e-13 * (1.0 + at.0 * at.0 + at.1 * at.1) {
                return Some(at);
            }
        }
        None
    }
}

/// The solution of the symmetric system `(xx, xy, yy)`; `None` where the image is folded.
fn divide((x, y): (f32, f32), (xx, xy, yy): (f32, f32, f32)) -> Option<(f32, f32)> {
    let det = xx * yy - xy * xy;
    (det > 0.0 && xx > 0.0).then(|| ((yy * x - xy * y) / det, (xx * y - xy * x) / det))
}

/// A calibrated camera. Lengths in px, in the [image coordinates](crate::target#image-coordinates).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Camera {
    fx: f32,
    fy: f32,
    cx: f32,
    cy: f32,
    distortion: Distortion,
    /// [`Distortion::limit`].
    limit: f32,
}

impl Camera {
    /// Shortest focal length, px.
    pub const MIN_FOCAL: f32 = 1.0;
    /// Longest focal length, px.
    pub const MAX_FOCAL: f32 = 1e6;
    /// Farthest principal point from the top-left pixel in x and y, px.
    pub const MAX_CENTRE: f32 = 32767.0;

    /// A camera without lens distortion: focal lengths and principal point, px.
    ///
    /// # Errors
    /// [`CameraError`] for a focal length outside 1..=1e6 px, or a principal point outside +-32767 px.
    pub const fn new(fx: f32, fy: f32, cx: f32, cy: f32) -> Result<Self, CameraError> {
        let mut i = 0;
        let values = [("fx", fx), ("fy", fy), ("cx", cx), ("cy", cy)];
        while i < values.len() {
            let (name, value) = values[i];
            let (min, max) = if i < 2 {
                (Self::MIN_FOCAL, Self::MAX_FOCAL)
            } else {
                (-Self::MAX_CENTRE, Self::MAX_CENTRE)
            };
            // Written so that NaN fails too.
            if !(value >= min && value <= max) {
                return Err(CameraError { name, value, min, max });
            }
            i += 1;
        }
        let distortion = Distortion { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 };
        Ok(Self { fx, fy, cx, cy, distortion, limit: distortion.limit() })
    }

    /// The same with lens distortion.
    ///
    /// A frame whose corners lie beyond where the radial terms stop growing with the radius is refused when it begins.
    ///
    /// # Errors
    /// [`CameraError`] for a coefficient outside +-[`Distortion::MAX`].
    pub const fn distortion(mut self, distortion: Distortion) -> Result<Self, CameraError> {
        let Distortion { k1, k2, p1, p2, k3 } = distortion;
        let values = [("k1", k1), ("k2", k2), ("p1", p1), ("p2", p2), ("k3", k3)];
        let mut i = 0;
        while i < values.len() {
            let (name, value) = values[i];
            if !(value >= -Distortion::MAX && value <= Distortion::MAX) {
                return Err(CameraError { name, value, min: -Distortion::MAX, max: Distortion::MAX });
            }
            i += 1;
        }
        self.distortion = distortion;
        self.limit = distortion.limit();
        Ok(self)
    }

    /// `(fx, fy)`, px.
    pub const fn focal_lengths(&self) -> (f32, f32) {
        (self.fx, self.fy)
    }

    /// `(cx, cy)`, px.
    pub const fn principal_point(&self) -> (f32, f32) {
        (self.cx, self.cy)
    }

    /// Where the image shows what a lens without distortion would show at `place`. `None` where the distortion folds the
    /// image.
    ///
    /// Wrong by at most 1e-5 px plus 3e-7 of the shift.
    pub fn distort(&self, place: Position) -> Option<Position> {
        let at = self.normalised(place);
        let (xx, xy, yy) = self.distortion.slope(at);
        // A folded image has a mirrored neighbourhood.
        let shift = self.distortion.shift(at);
        let (x, y) = (at.0 + shift.0, at.1 + shift.1);
        let whole = xx > 0.0 && xx * yy - xy * xy > 0.0 && x * x + y * y <= self.limit;
        whole.then(|| self.moved(place, shift))
    }

    /// Where a lens without distortion would show what the image shows at `place`: the inverse of
    /// [`distort`](Self::distort), with its errors.
    #[inline(never)]
    pub fn undistort(&self, place: Position) -> Option<Position> {
        let (x, y) = self.distortion.undo(self.within(place)?)?;
        let shift = self.distortion.shift((x, y));
        Some(self.moved(place, (-shift.0, -shift.1)))
    }

    /// Whether the image is not folded anywhere in a frame of this size.
    pub(crate) fn covers(&self, width: u16, height: u16) -> bool {
        let (right, bottom) = (i32::from(width) - 1, i32::from(height) - 1);
        [(0, 0), (right, 0), (0, bottom), (right, bottom)]
            .into_iter()
            .all(|(x, y)| self.undistort(Position::from_origin(x, y, 0.0, 0.0)).is_some())
    }

    /// `place` without the camera's own scale: what distortion is a function of.
    fn normalised(&self, place: Position) -> (f32, f32) {
        let (x, y) = place.to_px();
        ((x - self.cx) / self.fx, (y - self.cy) / self.fy)
    }

    /// The same for a place in the image; `None` where that is folded.
    fn within(&self, place: Position) -> Option<(f32, f32)> {
        let (x, y) = self.normalised(place);
        (x * x + y * y <= self.limit).then_some((x, y))
    }

    /// `place` after a shift in the scale of [`normalised`](Self::normalised), so that only the shift is rounded to `f32`.
    fn moved(&self, place: Position, (x, y): (f32, f32)) -> Position {
        place.moved((self.fx * x, self.fy * y))
    }
}

#[cfg(test)]
mod tests;
