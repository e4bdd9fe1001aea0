//! Lens distortion about a place, in differences, so that `f32` keeps all digits of them.
//!
//! Nothing here is inlined: heads without a camera link it too.

use super::{Camera, Distortion, divide};
use crate::target::{Covariance, Position};

/// Most Newton steps for a point; from the linear map three are enough over 200 px in a strongly distorted corner.
const STEPS: usize = 6;
/// A step below this, px, is the last: the next one would be its square.
const SETTLED: f32 = 1e-3;

/// The camera as seen from one place of the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Local {
    camera: Camera,
    /// The undistorted place, normalised.
    at: (f32, f32),
    /// Inverse of the distortion's derivative there.
    inverse: (f32, f32, f32),
}

impl Local {
    /// `None` where the distortion folds the image.
    #[inline(never)]
    pub fn new(camera: &Camera, place: Position) -> Option<Self> {
        let at = camera.distortion.undo(camera.within(place)?)?;
        let slope = camera.distortion.slope(at);
        let (xx, xy) = divide((1.0, 0.0), slope)?;
        let (_, yy) = divide((0.0, 1.0), slope)?;
        Some(Self { camera: *camera, at, inverse: (xx, xy, yy) })
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The place itself without distortion, from the principal point, undistorted px.
    pub fn off_axis(&self) -> (f32, f32) {
        (self.camera.fx * self.at.0, self.camera.fy * self.at.1)
    }

    /// How far from the place, px, the image shows what is `(dx, dy)` undistorted px from it.
    #[inline(never)]
    pub fn distort(&self, (dx, dy): (f32, f32)) -> (f32, f32) {
        let Camera { fx, fy, .. } = self.camera;
        let (x, y) = self.difference((dx / fx, dy / fy));
        (fx * x, fy * y)
    }

    /// The inverse of [`distort`](Self::distort); `None` where the distortion folds the image.
    #[inline(never)]
    pub fn undistort(&self, (dx, dy): (f32, f32)) -> Option<(f32, f32)> {
        let Camera { fx, fy, .. } = self.camera;
        let wanted = (dx / fx, dy / fy);
        let (xx, xy, yy) = self.inverse;
        let mut v = (xx * wanted.0 + xy * wanted.1, xy * wanted.0 + yy * wanted.1);
        for _ in 0..STEPS {
            let found = self.difference(v);
            let slope = self.camera.distortion.slope((self.at.0 + v.0, self.at.1 + v.1));
            let step = divide((wanted.0 - found.0, wanted.1 - found.1), slope)?;
            v = (v.0 + step.0, v.1 + step.1);
            if (fx * step.0).abs() + (fy * step.1).abs() < SETTLED {
                return Some((fx * v.0, fy * v.1));
            }
        }
        None
    }

    /// The covariance in the image of a place `(dx, dy)` undistorted px from here.
    pub fn distort_covariance(&self, offset: (f32, f32), covariance: &Covariance) -> Covariance {
        let (xx, xy, yy) = self.slope(offset);
        let Camera { fx, fy, .. } = self.camera;
        covariance.mapped([[xx, xy * fx / fy], [xy * fy / fx, yy]])
    }

    /// The inverse of [`distort_covariance`](Self::distort_covariance).
    pub fn undistort_covariance(&self, offset: (f32, f32), covariance: &Covariance) -> Covariance {
        let [xx, xy, yx, yy] = self.undistorted_slope(offset);
        covariance.mapped([[xx, xy], [yx, yy]])
    }

    /// Derivative (xx, xy, yx, yy) of the undistorted place, `offset` px from here, by the place in the image.
    pub fn undistorted_slope(&self, offset: (f32, f32)) -> [f32; 4] {
        let (xx, xy, yy) = self.slope(offset);
        let Camera { fx, fy, .. } = self.camera;
        let scale = 1.0 / (xx * yy - xy * xy);
        [yy * scale, -xy * scale * fx / fy, -xy * scale * fy / fx, xx * scale]
    }

    fn slope(&self, (dx, dy): (f32, f32)) -> (f32, f32, f32) {
        let Camera { fx, fy, .. } = self.camera;
        self.camera.distortion.slope((self.at.0 + dx / fx, self.at.1 + dy / fy))
    }

    /// Distorted place of `at + v` less that of `at`, normalised.
    fn difference(&self, (vx, vy): (f32, f32)) -> (f32, f32) {
        let Distortion { k1, k2, p1, p2, k3 } = self.camera.distortion;
        let (x, y) = self.at;
        let before = x * x + y * y;
        let more = 2.0 * (x * vx + y * vy) + vx * vx + vy * vy;
        let after = before + more;
        let growth =
            more * (k1 + k2 * (before + after) + k3 * (before * before + before * after + after * after));
        let scale = 1.0 + self.camera.distortion.radial(after);
        let cross = 2.0 * (x * vy + y * vx + vx * vy);
        (
            vx * scale + x * growth + p1 * cross + p2 * (more + 2.0 * vx * (2.0 * x + vx)),
            vy * scale + y * growth + p1 * (more + 2.0 * vy * (2.0 * y + vy)) + p2 * cross,
        )
    }
}
