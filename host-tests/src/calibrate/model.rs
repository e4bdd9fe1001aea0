//! The camera's model and its derivatives.

use concentric::{Camera, CameraError, Distortion};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix3x6, Rotation3, SMatrix, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// Number of parameters of [`Intrinsics`].
pub const COUNT: usize = 9;

/// A camera in OpenCV's terms: [`concentric::Camera`] in `f64`. Also standard deviations of its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Focal length along x, px.
    pub fx: f64,
    /// Focal length along y, px.
    pub fy: f64,
    /// Principal point, column, px.
    pub cx: f64,
    /// Principal point, row, px.
    pub cy: f64,
    /// Radial, second order.
    pub k1: f64,
    /// Radial, fourth order.
    pub k2: f64,
    /// Tangential, along y.
    pub p1: f64,
    /// Tangential, along x.
    pub p2: f64,
    /// Radial, sixth order.
    pub k3: f64,
}

impl Intrinsics {
    /// Names of the parameters, in the order of [`to_array`](Self::to_array).
    pub const NAMES: [&str; COUNT] = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];

    /// A camera without distortion.
    pub fn pinhole(fx: f64, fy: f64, cx: f64, cy: f64) -> Self {
        Self { fx, fy, cx, cy, ..Self::default() }
    }

    /// The parameters: focal lengths, principal point, distortion in OpenCV's order.
    pub fn to_array(&self) -> [f64; COUNT] {
        let Self { fx, fy, cx, cy, k1, k2, p1, p2, k3 } = *self;
        [fx, fy, cx, cy, k1, k2, p1, p2, k3]
    }

    /// The inverse of [`to_array`](Self::to_array).
    pub fn from_array([fx, fy, cx, cy, k1, k2, p1, p2, k3]: [f64; COUNT]) -> Self {
        Self { fx, fy, cx, cy, k1, k2, p1, p2, k3 }
    }

    /// The same for the library.
    ///
    /// # Errors
    /// A parameter outside the library's range.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        let [fx, fy, cx, cy, k1, k2, p1, p2, k3] = self.to_array().map(|value| value as f32);
        Camera::new(fx, fy, cx, cy)?.distortion(Distortion { k1, k2, p1, p2, k3 })
    }

    /// Where the point `q` of camera axes appears, px.
    pub fn project(&self, q: &Vector3<f64>) -> Vector2<f64> {
        self.derive(q).place
    }

    /// The same with its derivatives.
    pub fn derive(&self, q: &Vector3<f64>) -> Projection {
        let Self { fx, fy, cx, cy, k1, k2, p1, p2, k3 } = *self;
        let (x, y) = (q.x / q.z, q.y / q.z);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let bend = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
        let cross = 2.0 * x * y;
        let (across, along) = (r2 + 2.0 * x * x, r2 + 2.0 * y * y);
        let xd = x * radial + p1 * cross + p2 * across;
        let yd = y * radial + p1 * along + p2 * cross;

        let off_diagonal = bend * x * y + 2.0 * (p1 * x + p2 * y);
        let slope = Matrix2::new(
            fx * (radial + bend * x * x + 2.0 * p1 * y + 6.0 * p2 * x),
            fx * off_diagonal,
            fy * off_diagonal,
            fy * (radial + bend * y * y + 6.0 * p1 * y + 2.0 * p2 * x),
        );
        let perspective = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / q.z;
        let (r4, r6) = (r2 * r2, r2 * r2 * r2);
        Projection {
            place: Vector2::new(fx * xd + cx, fy * yd + cy),
            by_point: slope * perspective,
            by_intrinsics: SMatrix::from_row_slice(&[
                xd,
                0.0,
                1.0,
                0.0,
                fx * x * r2,
                fx * x * r4,
                fx * cross,
                fx * across,
                fx * x * r6,
                0.0,
                yd,
                0.0,
                1.0,
                fy * y * r2,
                fy * y * r4,
                fy * along,
                fy * cross,
                fy * y * r6,
            ]),
        }
    }
}

/// A projected point.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// Where it appears, px.
    pub place: Vector2<f64>,
    /// Derivative of that by the point in camera axes.
    pub by_point: Matrix2x3<f64>,
    /// Derivative by the parameters in the order of [`Intrinsics::NAMES`].
    pub by_intrinsics: SMatrix<f64, 2, COUNT>,
}

/// Where an object stands before the camera, in OpenCV's terms: a point `x` of it is at `R x + tvec` in camera axes, with
/// `R` the rotation about `rvec` by its length in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation vector, radians.
    pub rvec: Vector3<f64>,
    /// Translation, mm.
    pub tvec: Vector3<f64>,
}

impl Pose {
    /// A pose of a rotation matrix.
    pub fn new(rotation: &Matrix3<f64>, tvec: Vector3<f64>) -> Self {
        Self { rvec: Rotation3::from_matrix_unchecked(*rotation).scaled_axis(), tvec }
    }

    /// The rotation matrix.
    pub fn rotation(&self) -> Matrix3<f64> {
        *Rotation3::from_scaled_axis(self.rvec).matrix()
    }

    /// Derivative of a small rotation on the object's side by `rvec` (right Jacobian of the exponential map).
    pub fn right_jacobian(&self) -> Matrix3<f64> {
        let cross = self.rvec.cross_matrix();
        let angle2 = self.rvec.norm_squared();
        if angle2 < 1e-8 {
            return Matrix3::identity() - cross / 2.0 + cross * cross / 6.0;
        }
        let angle = angle2.sqrt();
        Matrix3::identity() - cross * ((1.0 - angle.cos()) / angle2)
            + cross * cross * ((angle - angle.sin()) / (angle2 * angle))
    }
}

/// Directions of the points of an outline, radians.
const OUTLINE: [f64; 12] = {
    let mut directions = [0.0; 12];
    let mut index = 0;
    while index < 12 {
        directions[index] = index as f64 * (std::f64::consts::TAU / 12.0);
        index += 1;
    }
    directions
};

/// A pose with what its derivatives share.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    rotation: Matrix3<f64>,
    tvec: Vector3<f64>,
    turn: Matrix3<f64>,
    normal: Vector3<f64>,
}

impl Placed {
    /// `normal` (unit, in the object's axes) is that of the targets' planes.
    pub fn new(pose: &Pose, normal: Vector3<f64>) -> Self {
        Self { rotation: pose.rotation(), tvec: pose.tvec, turn: pose.right_jacobian(), normal }
    }

    /// `x` in camera axes.
    pub fn point(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * x + self.tvec
    }

    /// Where the centre of the ellipse as which `camera` sees a circle of `radius` about `x` appears, px; with radius 0, where
    /// `x` appears.
    ///
    /// Distortion bends the ellipse, and shifts the centre of what is fitted to it by more than it shifts the place of the
    /// centre. In the affine frame in which the ellipse is the unit circle the fit's centre moves by the first harmonic of
    /// the outline's distance from that circle.
    pub fn seen_centre(&self, camera: &Intrinsics, x: &Vector3<f64>, radius: f64) -> Vector2<f64> {
        if radius == 0.0 {
            return camera.project(&self.point(x));
        }
        let (centre, axes) = self.ellipse(x, radius);
        let circle = OUTLINE.map(|angle| Vector2::new(angle.cos(), angle.sin()));
        let outline = circle.map(|u| camera.project(&(centre + axes * u).push(1.0)));
        let share = 1.0 / circle.len() as f64;
        let middle = outline.iter().sum::<Vector2<f64>>() * share;
        let pairs = || outline.iter().zip(&circle);
        let frame = pairs().map(|(place, u)| place * u.transpose()).sum::<Matrix2<f64>>() * (2.0 * share);
        let Some(inverse) = frame.try_inverse() else { return middle };
        let shift: Vector2<f64> =
            pairs().map(|(place, u)| u * ((inverse * (place - middle)).dot(u) - 1.0)).sum();
        middle + frame * shift * (2.0 * share)
    }

    /// Centre and half axes (columns, conjugate to each other) of the image of a circle, in normalised coordinates without
    /// distortion: from its dual conic, of which [`ellipse_centre`](Self::ellipse_centre) is the last column.
    fn ellipse(&self, x: &Vector3<f64>, radius: f64) -> (Vector2<f64>, Matrix2<f64>) {
        let (point, normal) = (self.point(x), self.rotation * self.normal);
        let plane = Matrix3::identity() - normal * normal.transpose();
        let dual = plane * (radius * radius) - point * point.transpose();
        let dual = dual / dual[(2, 2)];
        let centre = dual.fixed_view::<2, 1>(0, 2).into_owned();
        let square = centre * centre.transpose() - dual.fixed_view::<2, 2>(0, 0);
        (centre, square.cholesky().map_or_else(Matrix2::zeros, |root| root.l()))
    }

    /// A point in camera axes that appears where the *ellipse centre* of a circle of `radius` about `x` would appear
    /// without distortion, and its derivative by the pose (`rvec`, `tvec`).
    ///
    /// The dual conic of the image of a circle about p (camera axes) with normal n is, in normalised coordinates,
    /// `r^2 (I - n n') - p p'`; its last column is the ellipse centre. With radius 0 this is p itself.
    pub fn ellipse_centre(&self, x: &Vector3<f64>, radius: f64) -> (Vector3<f64>, Matrix3x6<f64>) {
        let point = self.point(x);
        let mut point_by = Matrix3x6::zeros();
        let turned = |v: &Vector3<f64>| -self.rotation * v.cross_matrix() * self.turn;
        point_by.fixed_columns_mut::<3>(0).copy_from(&turned(x));
        point_by.fixed_columns_mut::<3>(3).copy_from(&Matrix3::identity());
        if radius == 0.0 {
            return (point, point_by);
        }
        let normal = self.rotation * self.normal;
        let normal_by = turned(&self.normal);
        let push = normal * normal.z - Vector3::z();
        let strength = radius * radius / point.z;
        let mut by = point_by - push * point_by.row(2) * (strength / point.z);
        let bend = normal * normal_by.row(2) + normal_by * normal.z;
        let mut rotated = by.fixed_columns_mut::<3>(0);
        rotated += bend * strength;
        (point + push * strength, by)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render;
    use glam::DVec2;

    fn intrinsics() -> Intrinsics {
        Intrinsics::from_array([900.0, 880.0, 640.0, 470.0, -0.3, 0.1, 0.002, -0.001, 0.05])
    }

    fn pose() -> Pose {
        Pose { rvec: Vector3::new(0.4, -0.7, 1.9), tvec: Vector3::new(30.0, -50.0, 700.0) }
    }

    #[test]
    fn derivatives_are_those_of_the_function() {
        let normal = Vector3::new(0.2, -0.1, 1.0).normalize();
        let x = Vector3::new(120.0, -80.0, 15.0);
        for radius in [0.0, 40.0] {
            let place = |camera: [f64; COUNT], pose: [f64; 6]| {
                let pose = Pose {
                    rvec: Vector3::from_row_slice(&pose[..3]),
                    tvec: Vector3::from_row_slice(&pose[3..]),
                };
                let (q, by) = Placed::new(&pose, normal).ellipse_centre(&x, radius);
                (Intrinsics::from_array(camera).derive(&q), by)
            };
            let camera = intrinsics().to_array();
            let Pose { rvec: r, tvec: t } = pose();
            let pose = [r.x, r.y, r.z, t.x, t.y, t.z];
            let (projection, by) = place(camera, pose);
            let check = |found: Vector2<f64>, step: f64, plus: Vector2<f64>, minus: Vector2<f64>| {
                let slope = (plus - minus) / (2.0 * step);
                assert!((found - slope).norm() < 1e-6 * (1.0 + slope.norm()), "{found} {slope}");
            };
            for i in 0..COUNT {
                let step = 1e-6 * (1.0 + camera[i].abs());
                let moved = |step: f64| {
                    let mut camera = camera;
                    camera[i] += step;
                    place(camera, pose).0.place
                };
                check(projection.by_intrinsics.column(i).into(), step, moved(step), moved(-step));
            }
            for i in 0..6 {
                let step = 1e-6 * (1.0 + pose[i].abs());
                let moved = |step: f64| {
                    let mut pose = pose;
                    pose[i] += step;
                    place(camera, pose).0.place
                };
                let slope = projection.by_point * by;
                check(slope.column(i).into(), step, moved(step), moved(-step));
            }
        }
    }

    #[test]
    fn ellipse_centres_are_those_of_the_simulator() {
        let camera = render::Camera::new(1280, 960, 1000.0);
        let pose = render::Pose { x: 900.0, y: 300.0, distance: 500.0, tilt: 50.0, azimuth: 25.0 };
        let view = pose.view(&camera);
        let at = |x: f64, y: f64| Vector3::from(view.point(DVec2::new(x, y)).to_array());
        let origin = at(0.0, 0.0);
        let (e1, e2) = (at(1.0, 0.0) - origin, at(0.0, 1.0) - origin);
        let pose = Pose::new(&Matrix3::from_columns(&[e1, e2, e1.cross(&e2)]), origin);
        let placed = Placed::new(&pose, Vector3::z());
        let intrinsics = Intrinsics::pinhole(camera.f, camera.f, camera.cx, camera.cy);
        for (x, y, radius) in [(0.0, 0.0, 60.0), (80.0, -40.0, 30.0)] {
            let truth = view.ellipse(DVec2::new(x, y), radius);
            let found = intrinsics.project(&placed.ellipse_centre(&Vector3::new(x, y, 0.0), radius).0);
            assert!((found - Vector2::new(truth.x, truth.y)).norm() < 1e-9, "{found} {truth:?}");
            let seen = placed.seen_centre(&intrinsics, &Vector3::new(x, y, 0.0), radius);
            assert!((found - seen).norm() < 1e-9, "{found} {seen}");
            let centre = intrinsics.project(&placed.point(&Vector3::new(x, y, 0.0)));
            assert!((found - centre).norm() > 0.5, "no eccentricity to speak of");
        }
    }
}
