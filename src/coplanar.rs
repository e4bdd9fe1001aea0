//! Targets on one plane: the correction shared by all of them.
//!
//! The true centre of a circle is the pole of its plane's vanishing line in the circle's image. One circle tells nothing
//! of that line; two concentric ones tell it badly, because their centres differ by little; but the line is the same for all
//! targets of a plane, whatever their sizes. It is fitted to the poles of all their circles, which must fall together in each
//! target; then each target's centre is the mean of its poles. Needs no calibration. With many targets what is left is about
//! 0.43 of the noise of a target by itself (ratio 0.5).
//!
//! For the ellipse (x - B)' A (x - B) = 1 and the line l.x + 1 = 0 the pole is B - A^-1 l / (1 + l.B).

mod poles;

use core::fmt;

use crate::camera::Camera;
use crate::fit::{Factor, Matrix};
use crate::settings::limits;
use crate::target::{Covariance, Position, Target};
use poles::Poles;

/// Gauss-Newton steps of each part of the fit.
const STEPS: usize = 10;
/// Largest change of the plane's depth over the targets in a step: half of what would put one of them on the line.
const MAX_CHANGE: f32 = 0.5;

/// The line at infinity of a plane, as a camera without distortion shows it: the places p with
/// `x (p.x - origin.x) + y (p.y - origin.y) + 1 = 0`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VanishingLine {
    /// Amid the targets, undistorted px where a camera was given.
    pub origin: Position,
    /// Along x, 1/px; 0 for a plane seen from the front.
    pub x: f32,
    /// Along y, 1/px.
    pub y: f32,
    /// Covariance of (x, y), 1/px^2.
    pub covariance: Covariance,
}

impl VanishingLine {
    /// Unit normal of the plane, towards the camera, in camera axes: x right, y down, z forward.
    pub fn normal(&self, camera: &Camera) -> [f32; 3] {
        let ((fx, fy), (cx, cy)) = (camera.focal_lengths(), camera.principal_point());
        let (ox, oy) = self.origin.to_px();
        let (x, y) = (self.x * fx, self.y * fy);
        let z = 1.0 + self.x * (cx - ox) + self.y * (cy - oy);
        let length = crate::math::sqrt(x * x + y * y + z * z);
        [x, y, z].map(|axis| -axis / length)
    }
}

/// What [`pool`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plane {
    /// Its vanishing line.
    pub line: VanishingLine,
    /// Targets on it, whose centres were replaced.
    pub used: usize,
    /// Targets that do not fit, left as they were.
    pub left_out: usize,
    /// Mean squared distance of the poles in units of their variance, at least 1; the covariances contain it.
    pub misfit: f32,
    camera: Option<Camera>,
}

impl Plane {
    /// Whether `target` is on the plane: its circles agree within 5 standard deviations.
    pub fn holds(&self, target: &Target) -> bool {
        self.poles(target).is_some()
    }

    fn poles(&self, target: &Target) -> Option<Poles> {
        let VanishingLine { origin, x, y, .. } = self.line;
        Poles::new(target, self.camera.as_ref(), origin, (x, y)).filter(|poles| poles.fit(self.misfit))
    }
}

/// Finds the plane on which the `targets` of a frame lie and replaces the centres and covariances of those on it.
///
/// `camera` is the one in the settings with which they were found, if there was one. A covariance is that of its target by
/// itself; centres of one plane are correlated by what they share of the line's covariance. Order and number of the targets
/// do not change, and `eq7` and `exact` stay those of each target alone.
///
/// Source of pole and polar: Hartley and Zisserman 2004, "Multiple View Geometry in Computer Vision", section 2.8.1; the
/// estimate is weighted least squares. Work: about 32 passes over the circles.
///
/// # Errors
/// [`PoolError`]; the targets are then unchanged.
pub fn pool(targets: &mut [Target], camera: Option<&Camera>) -> Result<Plane, PoolError> {
    let given = targets.len();
    if given < 2 {
        return Err(PoolError::TooFew { given });
    }
    if !apart(targets) {
        return Err(PoolError::OnePlace { given });
    }
    let plane = Fit::new(targets, camera).plane().ok_or(PoolError::NoPlane { fitting: 0, given })?;
    if plane.used < 2 || 2 * plane.used <= given || !(plane.misfit <= limits::PLANE_MISFIT) {
        return Err(PoolError::NoPlane { fitting: plane.used, given });
    }
    for target in targets {
        if let Some(poles) = plane.poles(target) {
            poles.correct(target, &plane.line.covariance, plane.misfit);
        }
    }
    Ok(plane)
}

/// Whether there are two that cannot be the same target.
fn apart(targets: &[Target]) -> bool {
    let Some((first, others)) = targets.split_first() else { return false };
    let radius = first.circles.first().map_or(0.0, |outer| outer.ellipse.a);
    others.iter().any(|other| {
        let (dx, dy) = other.centre.offset_from(first.centre);
        dx * dx + dy * dy > radius * radius
    })
}

/// The search for the line.
struct Fit<'t> {
    targets: &'t [Target],
    camera: Option<&'t Camera>,
    /// Middle of the box around all centres, without distortion.
    origin: Position,
    /// From there to its corners, px.
    reach: f32,
}

/// How much a target counts.
#[derive(Clone, Copy)]
enum Regard {
    /// All alike.
    All,
    /// The less, the less it fits, for this misfit of the others.
    Doubt(f32),
    /// Not at all where it does not fit.
    Fitting(f32),
}

/// Normal equations of the line.
#[derive(Default)]
struct Sums {
    m: Matrix<2>,
    right: [f32; 2],
    squares: f32,
    /// Residuals.
    count: f32,
    targets: usize,
}

impl<'t> Fit<'t> {
    fn new(targets: &'t [Target], camera: Option<&'t Camera>) -> Self {
        let (mut low, mut high) = ((i32::MAX, i32::MAX), (i32::MIN, i32::MIN));
        for target in targets {
            let Position { x, y } = target.centre;
            low = (low.0.min(x), low.1.min(y));
            high = (high.0.max(x), high.1.max(y));
        }
        let middle = Position { x: low.0.midpoint(high.0), y: low.1.midpoint(high.1) };
        let (dx, dy) = middle.offset_from(Position { x: low.0, y: low.1 });
        let origin = camera.and_then(|camera| camera.undistort(middle)).unwrap_or(middle);
        Self { targets, camera, origin, reach: crate::math::sqrt(dx * dx + dy * dy) }
    }

    /// From all targets at first, then with less and less regard to those that do not fit, then from those that do.
    fn plane(&self) -> Option<Plane> {
        let mut line = (0.0, 0.0);
        let mut misfit = 1.0;
        let mut step = |regard: fn(f32) -> Regard| {
            for _ in 0..STEPS {
                let sums = self.sums(line, regard(misfit));
                line = self.step(line, &sums)?;
                misfit = sums.misfit();
            }
            Some(())
        };
        step(|_| Regard::All)?;
        step(Regard::Doubt)?;
        step(Regard::Fitting)?;
        let sums = self.sums(line, Regard::Fitting(misfit));
        let factor = Factor::new(&sums.m)?;
        let ([xx, xy], [_, yy]) = (factor.solve([misfit, 0.0]), factor.solve([0.0, misfit]));
        let covariance = Covariance { xx, xy, yy };
        Some(Plane {
            line: VanishingLine { origin: self.origin, x: line.0, y: line.1, covariance },
            used: sums.targets,
            left_out: self.targets.len().saturating_sub(sums.targets),
            misfit,
            camera: self.camera.copied(),
        })
    }

    fn sums(&self, line: (f32, f32), regard: Regard) -> Sums {
        let mut sums = Sums::default();
        for target in self.targets {
            let Some(poles) = Poles::new(target, self.camera, self.origin, line) else { continue };
            let weight = match regard {
                Regard::All => 1.0,
                Regard::Doubt(misfit) => 1.0 / (1.0 + poles.excess(misfit)),
                Regard::Fitting(misfit) => {
                    if !poles.fit(misfit) {
                        continue;
                    }
                    1.0
                }
            };
            sums.add(&poles, weight);
        }
        sums
    }

    fn step(&self, line: (f32, f32), sums: &Sums) -> Option<(f32, f32)> {
        let [x, y] = Factor::new(&sums.m)?.solve(sums.right);
        let change = self.reach * crate::math::sqrt(x * x + y * y);
        let scale = if change > MAX_CHANGE { MAX_CHANGE / change } else { 1.0 };
        Some((line.0 + scale * x, line.1 + scale * y))
    }
}

impl Sums {
    fn add(&mut self, poles: &Poles, weight: f32) {
        let [[xx, _], [yx, yy]] = poles.m;
        self.m[0][0] += weight * xx;
        self.m[1][0] += weight * yx;
        self.m[1][1] += weight * yy;
        self.right[0] += weight * poles.right[0];
        self.right[1] += weight * poles.right[1];
        self.squares += weight * poles.squares;
        self.count += weight * poles.free;
        self.targets += 1;
    }

    /// Mean square of the residuals, less the two that the line takes; at least 1.
    fn misfit(&self) -> f32 {
        (self.squares / (self.count - 2.0).max(1.0)).max(1.0)
    }
}

/// Targets that cannot be pooled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PoolError {
    /// Less than two.
    TooFew {
        /// Targets given.
        given: usize,
    },
    /// All of them where the first one is.
    OnePlace {
        /// Targets given.
        given: usize,
    },
    /// Not more than half of them on one plane.
    NoPlane {
        /// Targets on the plane that fits best.
        fitting: usize,
        /// Targets given.
        given: usize,
    },
}

impl fmt::Display for PoolError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { given } => write!(f, "a plane takes two targets or more: {given} given"),
            Self::OnePlace { given } => {
                write!(f, "a plane takes two targets or more that are apart: {given} in one place given")
            }
            Self::NoPlane { fitting, given } => write!(
                f,
                "{fitting} of {given} targets fit on one plane: they must lie on one, and lens distortion must be in the \
                 camera's parameters"
            ),
        }
    }
}

impl core::error::Error for PoolError {}

#[cfg(test)]
mod tests;
