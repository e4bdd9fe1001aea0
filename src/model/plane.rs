use super::Scene;
use crate::centre::Real;

/// A circle whose centre and plane are known in camera axes (x right, y down, z forward): its [`Scene`], and how that lies
/// in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plane<T> {
    scene: Scene<T>,
    /// Direction of v in the image; u is at right angles to it.
    v: (T, T),
}

impl<T: Real> Plane<T> {
    /// `centre` is the circle's centre before the camera, `normal` any vector at right angles to its plane, of any length.
    ///
    /// `focal_length` is that of a camera with square pixels and without distortion. For others take 1 and multiply what
    /// comes out by fx and fy.
    ///
    /// `None` where the centre is not before the camera, or the plane goes through the camera.
    pub fn new(focal_length: T, centre: [T; 3], normal: [T; 3]) -> Option<Self> {
        let (zero, one) = (T::from(0.0), T::from(1.0));
        let [x, y, z] = centre;
        let [nx, ny, nz] = normal;
        let towards = if nx * x + ny * y + nz * z > zero { -one } else { one };
        let steep = nx * nx + ny * ny;
        let length = towards * (steep + nz * nz).sqrt();
        let steep = steep.sqrt();
        // From the front any direction is as good.
        let v = if steep > zero { (towards * nx / steep, towards * ny / steep) } else { (zero, one) };
        // u = (v.1, -v.0).
        let turned = [v.1 * x - v.0 * y, v.0 * x + v.1 * y, z];
        let tilt = (towards * steep / length, -nz / length);
        Some(Self { scene: Scene::upright(focal_length, turned, tilt)?, v })
    }

    /// In the axes of figure 2.
    pub fn scene(&self) -> &Scene<T> {
        &self.scene
    }

    /// The true centre from the principal point, by eq. (1).
    pub fn centre(&self) -> (T, T) {
        self.in_image(self.scene.centre())
    }

    /// Ellipse centre minus true centre for a circle of this radius, by eq. (3). `None` as in [`Scene::eccentricity`].
    pub fn eccentricity(&self, radius: T) -> Option<(T, T)> {
        self.scene.eccentricity(radius).map(|shift| self.in_image(shift))
    }

    /// The true centre from a measured ellipse centre by eq. (3): the method with which the paper compares eq. (7).
    ///
    /// The ellipse must be one without lens distortion. An error of the radius, or of the pose, enters with its share of the
    /// eccentricity.
    pub fn correct(&self, ellipse_centre: (T, T), radius: T) -> Option<(T, T)> {
        let (x, y) = self.eccentricity(radius)?;
        Some((ellipse_centre.0 - x, ellipse_centre.1 - y))
    }

    fn in_image(&self, (u, v): (T, T)) -> (T, T) {
        (u * self.v.1 + v * self.v.0, v * self.v.1 - u * self.v.0)
    }
}
