//! A pinhole camera with lens distortion, and planes seen through it.

use anyhow::{Result, ensure};
use glam::{DMat2, DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Lens distortion in normalised coordinates (px from the principal point, divided by f): Brown 1971,
/// "Close-range camera calibration", radial terms `k1 r^2 + k2 r^4` and tangential terms `p1`, `p2`, in
/// OpenCV's order of names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distortion {
    /// Radial, second order.
    pub k1: f64,
    /// Radial, fourth order.
    pub k2: f64,
    /// Tangential, along y.
    pub p1: f64,
    /// Tangential, along x.
    pub p2: f64,
}

impl Distortion {
    /// The distorted place of `n`, and its derivative by `n`.
    fn apply(&self, n: DVec2) -> (DVec2, DMat2) {
        let Self { k1, k2, p1, p2 } = *self;
        let (x, y, r2) = (n.x, n.y, n.length_squared());
        let radial = 1.0 + r2 * (k1 + r2 * k2);
        let slope = 2.0 * (k1 + 2.0 * k2 * r2);
        let place = n * radial
            + DVec2::new(
                2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            );
        let xx = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
        let xy = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
        let yy = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
        (place, DMat2::from_cols(DVec2::new(xx, xy), DVec2::new(xy, yy)))
    }

    /// The place that distortion moves to `distorted` (Newton's method).
    fn undo(&self, distorted: DVec2) -> DVec2 {
        let mut n = distorted;
        for _ in 0..50 {
            let (place, slope) = self.apply(n);
            let step = slope.inverse() * (place - distorted);
            n -= step;
            if step.length_squared() < 1e-32 {
                break;
            }
        }
        n
    }
}

/// A pinhole camera. Pixel centres at integer coordinates, x right, y down; camera axes likewise, z forward.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Frame width, px.
    pub width: u32,
    /// Frame height, px.
    pub height: u32,
    /// Focal length, px.
    pub f: f64,
    /// Principal point, column, px.
    pub cx: f64,
    /// Principal point, row, px.
    pub cy: f64,
    /// Lens distortion.
    pub distortion: Distortion,
}

impl Camera {
    /// Largest width and height, px.
    pub const LARGEST: u32 = 8192;

    /// A camera without distortion whose principal point is `(width / 2, height / 2)`; `f` in px.
    pub fn new(width: u32, height: u32, f: f64) -> Self {
        let (cx, cy) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
        Self { width, height, f, cx, cy, distortion: Distortion::default() }
    }

    /// The camera of Huo et al. 2013, section 4.1: 12 mm lens, 4.65 um pixels, 1280 x 1024.
    pub fn paper() -> Self {
        Self::new(1280, 1024, 12.0 / 0.00465)
    }

    /// # Errors
    /// When the frame is empty or too large, a number is not finite, or the distortion folds inside the
    /// frame.
    pub fn validate(&self) -> Result<()> {
        let sizes = 1..=Self::LARGEST;
        ensure!(
            sizes.contains(&self.width) && sizes.contains(&self.height),
            "frame of {} x {} px: each side must be 1 to {}",
            self.width,
            self.height,
            Self::LARGEST
        );
        ensure!(self.f.is_finite() && self.f >= 1.0, "focal length {} px: must be at least 1", self.f);
        ensure!(
            self.cx.is_finite() && self.cy.is_finite(),
            "principal point ({}, {}): must be finite",
            self.cx,
            self.cy
        );
        let d = self.distortion;
        ensure!([d.k1, d.k2, d.p1, d.p2].iter().all(|k| k.is_finite()), "distortion {d:?} is not finite");
        ensure!(
            !self.folds(),
            "distortion k1 {} k2 {} p1 {} p2 {} folds the image inside the frame: it must be smaller for this \
             focal length and frame size",
            d.k1,
            d.k2,
            d.p1,
            d.p2
        );
        Ok(())
    }

    /// Whether a ray from the principal axis turns back before it has left the frame.
    fn folds(&self) -> bool {
        let corner = |x: f64, y: f64| DVec2::new(x - self.cx, y - self.cy).length() / self.f;
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        let reach = corner(0.0, 0.0).max(corner(w, 0.0)).max(corner(0.0, h)).max(corner(w, h));
        (0..64).any(|i| {
            let direction = DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 64.0);
            for step in 1..=4000 {
                let (place, slope) = self.distortion.apply(direction * (reach * f64::from(step) / 400.0));
                if slope.determinant() <= 0.0 {
                    return true;
                }
                if place.length() > reach {
                    return false;
                }
            }
            true
        })
    }

    /// The ray through the pixel `(x, y)`: a point at depth 1.
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        let distorted = DVec2::new(x - self.cx, y - self.cy) / self.f;
        self.distortion.undo(distorted).extend(1.0)
    }

    fn principal_point(&self) -> DVec2 {
        DVec2::new(self.cx, self.cy)
    }
}

/// Where a plane lies before the camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Column at which the plane's origin appears, px.
    pub x: f64,
    /// Row at which the plane's origin appears, px.
    pub y: f64,
    /// Distance of the plane's origin from the camera's centre along that ray, mm.
    pub distance: f64,
    /// Angle between the plane's normal and the optical axis, degrees, below 90.
    pub tilt: f64,
    /// Direction of the axis about which the plane is tilted, from +x towards +y, degrees. With a positive
    /// tilt the side of the plane at `azimuth + 90` is the farther one.
    pub azimuth: f64,
}

impl Pose {
    /// The plane through `camera`.
    pub fn view(&self, camera: &Camera) -> View {
        let axis = DVec2::from_angle(self.azimuth.to_radians()).extend(0.0);
        let turn = DMat3::from_axis_angle(axis, self.tilt.to_radians());
        View {
            camera: *camera,
            origin: camera.ray(self.x, self.y).normalize() * self.distance,
            e1: turn.x_axis,
            e2: turn.y_axis,
        }
    }
}

/// The image of one circle without lens distortion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ellipse {
    /// Ellipse centre, column, px.
    pub x: f64,
    /// Ellipse centre, row, px.
    pub y: f64,
    /// Semi-major axis, px.
    pub a: f64,
    /// Semi-minor axis, px.
    pub b: f64,
    /// Direction of the major axis from +x towards +y, radians, in (-pi/2, pi/2].
    pub theta: f64,
}

/// A plane seen through a camera: maps plane coordinates (mm) to the image (px).
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    origin: DVec3,
    e1: DVec3,
    e2: DVec3,
}

impl View {
    /// The plane parallel to the sensor on which 1 mm is 1 px (before distortion), its origin seen at `(x,
    /// y)`.
    pub fn flat(camera: &Camera, x: f64, y: f64) -> Self {
        Self { camera: *camera, origin: camera.ray(x, y) * camera.f, e1: DVec3::X, e2: DVec3::Y }
    }

    /// The point `p` (mm) in camera coordinates, mm.
    pub fn point(&self, p: DVec2) -> DVec3 {
        self.origin + self.e1 * p.x + self.e2 * p.y
    }

    /// Whether the camera looks at the front of the plane.
    pub fn faces_camera(&self) -> bool {
        self.e1.cross(self.e2).dot(self.origin) > 0.0
    }

    /// Smallest depth within `radius` mm of `centre`, mm.
    pub fn least_depth(&self, centre: DVec2, radius: f64) -> f64 {
        self.point(centre).z - radius * DVec2::new(self.e1.z, self.e2.z).length()
    }

    /// Where `p` (mm) appears (px), and the derivative of that by `p` (px/mm).
    pub fn at(&self, p: DVec2) -> (DVec2, DMat2) {
        let point = self.point(p);
        let n = point.truncate() / point.z;
        let column = |e: DVec3| (e.truncate() - n * e.z) / point.z;
        let (place, slope) = self.camera.distortion.apply(n);
        let f = self.camera.f;
        (
            self.camera.principal_point() + place * f,
            slope * DMat2::from_cols(column(self.e1), column(self.e2)) * f,
        )
    }

    /// The point of the plane (mm) that appears at `place` (px).
    pub fn plane(&self, place: DVec2) -> DVec2 {
        let ray = self.camera.ray(place.x, place.y);
        // origin + x e1 + y e2 = depth ray.
        (DMat3::from_cols(self.e1, self.e2, -ray).inverse() * -self.origin).truncate()
    }

    /// Where `p` (mm) would appear without lens distortion, px.
    pub fn undistorted(&self, p: DVec2) -> DVec2 {
        let point = self.point(p);
        self.camera.principal_point() + point.truncate() * (self.camera.f / point.z)
    }

    /// The image of the circle of `radius` mm about `centre` (mm), without lens distortion.
    ///
    /// With e the unit vector towards a point of the circle, that point appears at `c + r M e / (1 + r p.e)`,
    /// where c is the image of the centre, M a 2 x 2 matrix and p the relative change of depth per mm. In `q
    /// = M^-1 (x - c)` this is `|q|^2 = r^2 (1 - p.q)^2`, a conic about c, so nothing cancels far from the
    /// image's origin.
    pub fn ellipse(&self, centre: DVec2, radius: f64) -> Ellipse {
        let point = self.point(centre);
        let n = point.truncate() / point.z;
        let p = DVec2::new(self.e1.z, self.e2.z) / point.z;
        let column = |e: DVec3| (e.truncate() - n * e.z) * (self.camera.f / point.z);
        let m = DMat2::from_cols(column(self.e1), column(self.e2));

        let r2 = radius * radius;
        let scale = 1.0 - r2 * p.length_squared();
        let middle = self.undistorted(centre) - m * p * (r2 / scale);
        let u = m.col(0) * radius;
        let v = m.col(1) * radius;
        let w = m * p * (r2 / scale.sqrt());
        let entry = |i: usize, j: usize| (u[i] * u[j] + v[i] * v[j] + w[i] * w[j]) / scale;
        let (xx, xy, yy) = (entry(0, 0), entry(0, 1), entry(1, 1));

        let half_sum = (xx + yy) / 2.0;
        let half_difference = ((xx - yy) / 2.0).hypot(xy);
        let major = half_sum + half_difference;
        let minor = (xx * yy - xy * xy) / major;
        Ellipse {
            x: middle.x,
            y: middle.y,
            a: major.sqrt(),
            b: minor.sqrt(),
            // Adding 0 turns -0 into 0, whose angle is +pi.
            theta: (2.0 * xy + 0.0).atan2(xx - yy) / 2.0,
        }
    }
}
