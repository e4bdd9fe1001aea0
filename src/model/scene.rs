use crate::centre::Real;

/// A plane with a circle before the camera, in the axes of figure 2 of the paper.
///
/// The circle's plane is z = 0, z towards the camera's side. The camera's centre O' is in the plane x = 0, at the distance d
/// from the origin O; z makes the angle alpha with the line O O' and the angle omega with the optical axis, which is at
/// right angles to x. The circle's centre is at (x_p, 0). Then the point (x, y) of the plane appears, with
/// l = d cos(omega - alpha), from the principal point at
///
/// ```text
/// u = c x / (l + y sin omega)      v = c (y cos omega - d sin(omega - alpha)) / (l + y sin omega)
/// ```
///
/// Every circle before every camera can be written so: [`Plane`](super::Plane) does it.
///
/// Image coordinates are in the unit of the focal length c, for square pixels in px. Lengths on the target (d, x_p, radii)
/// share any one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scene<T> {
    /// c.
    focal_length: T,
    /// x_p.
    x: T,
    /// d cos(omega - alpha), the depth of the circle's centre.
    l: T,
    /// d sin(omega - alpha).
    side: T,
    /// d cos(alpha), the distance of the camera from the plane.
    height: T,
    /// Of omega.
    sin: T,
    /// Of omega.
    cos: T,
}

impl<T: Real> Scene<T> {
    /// `focal_length` c, `x` x_p, `distance` d, `tilt` omega and `direction` alpha in radians.
    ///
    /// `None` unless the circle's centre lies before the camera, which sees the plane's upper side: c > 0,
    /// d cos(omega - alpha) > 0, d cos(alpha) > 0.
    pub fn new(focal_length: T, x: T, distance: T, tilt: T, direction: T) -> Option<Self> {
        let (sin, cos) = tilt.sin_cos();
        let (side, l) = (tilt - direction).sin_cos();
        let (_, height) = direction.sin_cos();
        let scene = Self {
            focal_length,
            x,
            l: distance * l,
            side: distance * side,
            height: distance * height,
            sin,
            cos,
        };
        scene.checked()
    }

    /// From the circle's centre in camera axes and the tilt, both turned about the optical axis so that the plane's steepest
    /// line is upright.
    pub(super) fn upright(focal_length: T, [x, y, z]: [T; 3], (sin, cos): (T, T)) -> Option<Self> {
        let scene = Self { focal_length, x, l: z, side: -y, height: z * cos - y * sin, sin, cos };
        scene.checked()
    }

    /// Also refuses NaN.
    fn checked(self) -> Option<Self> {
        let zero = T::from(0.0);
        (self.focal_length > zero && self.l > zero && self.height > zero).then_some(self)
    }

    /// kappa = (sin(omega) / l)^2.
    fn kappa(&self) -> T {
        let slope = self.sin / self.l;
        slope * slope
    }

    /// Eq. (1): the true centre C.
    pub fn centre(&self) -> (T, T) {
        let Self { focal_length: c, x, l, side, .. } = *self;
        (c * x / l, -c * side / l)
    }

    /// Eq. (2): the ellipse centre B of the circle with this radius. Exact.
    ///
    /// `None` unless the whole circle is before the camera: radius sin(omega) < l.
    pub fn ellipse_centre(&self, radius: T) -> Option<(T, T)> {
        let Self { focal_length: c, x, l, side, sin, cos, .. } = *self;
        let square = radius * radius;
        let below = l * l - square * sin * sin;
        (below > T::from(0.0)).then(|| (c * x * l / below, -c * (side * l + square * sin * cos) / below))
    }

    /// Eq. (3): the eccentricity B - C. Exact.
    ///
    /// The row for v is not readable in every copy of the paper, and a sign or an angle differs in what quotes it. From (1)
    /// and (2) it is
    ///
    /// ```text
    /// -c (d / l) sin(omega) cos(alpha) / ((l / r)^2 - sin(omega)^2)
    /// ```
    ///
    /// with a minus, because the ellipse centre lies on the near side of the true one, and with cos(alpha), because
    /// l cos(omega) + d sin(omega - alpha) sin(omega) = d cos(alpha).
    ///
    /// `None` unless radius sin(omega) < l.
    pub fn eccentricity(&self, radius: T) -> Option<(T, T)> {
        let Self { focal_length: c, x, l, height, sin, .. } = *self;
        let square = radius * radius;
        // 1 / ((l / r)^2 - sin^2), without dividing by a radius of 0.
        let below = l * l - square * sin * sin;
        let factor = square / below;
        (below > T::from(0.0)).then(|| (c * (x / l) * sin * sin * factor, -c * (height / l) * sin * factor))
    }

    /// Eq. (4): K_u and K_v, in the unit of the focal length over that of the squared radius.
    ///
    /// The paper prints cos(omega) in K_v; it must be cos(alpha), as in (3). They are the same only where the optical axis
    /// goes through O (alpha = omega), as in all of the paper's simulations; elsewhere the printed one is pixels off. Eq. (7)
    /// does not contain K, so the misprint does not touch it.
    pub fn coefficients(&self) -> (T, T) {
        let Self { focal_length: c, x, l, height, sin, .. } = *self;
        let cube = l * l * l;
        (c * x * sin * sin / cube, -c * height * sin / cube)
    }

    /// Eqs. (5) and (6): the eccentricity K r^2, which neglects sin(omega)^2 beside (l / r)^2.
    ///
    /// Too small by the share kappa r^2, with kappa = (sin(omega) / l)^2.
    pub fn approximation(&self, radius: T) -> (T, T) {
        let (u, v) = self.coefficients();
        let square = radius * radius;
        (u * square, v * square)
    }

    /// What eq. (7) leaves: its centre minus the true one,
    /// -K kappa r1^2 r2^2 / ((1 - kappa r1^2)(1 - kappa r2^2)), with K of (4) and kappa = (sin(omega) / l)^2. Exact.
    ///
    /// Not in the paper. It follows from B(r) = C + K r^2 / (1 - kappa r^2), which is (3).
    pub fn residual(&self, outer: T, inner: T) -> (T, T) {
        let one = T::from(1.0);
        let kappa = self.kappa();
        let (a, b) = (outer * outer, inner * inner);
        let factor = -(kappa * a * b) / ((one - kappa * a) * (one - kappa * b));
        let (u, v) = self.coefficients();
        (u * factor, v * factor)
    }
}
