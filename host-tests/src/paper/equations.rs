//! Section 2: the equations with known geometry against the projection of conics.

use anyhow::{Context, Result};
use concentric::model::Scene as Model;
use glam::DVec2;
use rand_distr::{Distribution, Uniform};
use rand_pcg::{Pcg64, rand_core::SeedableRng};

use crate::render::{Camera, Pose};

/// Random scenes.
pub const SCENES: usize = 1000;
/// Goal for the differences, px.
pub const EXACT: f64 = 1e-9;

/// Largest differences over all scenes, px.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst {
    /// Of eq. (1) from the projected centre.
    pub centre: f64,
    /// Of eq. (2) from the centre of the projected circle.
    pub ellipse: f64,
    /// Of eq. (3) from the distance between these two.
    pub eccentricity: f64,
    /// The same with the cos(omega) that the paper prints in (4), where cos(alpha) belongs.
    pub misprint: f64,
}

/// Circles of any size before any camera, at tilts up to 80 degrees.
///
/// # Errors
/// None that a caller can cause.
pub fn worst() -> Result<Worst> {
    let mut random = Pcg64::seed_from_u64(1);
    let mut within = |low: f64, high: f64| Uniform::new(low, high).map(|range| range.sample(&mut random));
    let mut worst = Worst::default();
    let mut scenes = 0;
    while scenes < SCENES {
        // The principal point is the origin, so that nothing has to be taken off again.
        let camera = Camera { cx: 0.0, cy: 0.0, ..Camera::new(1, 1, within(500.0, 4000.0)?) };
        let (omega, alpha, d) = (within(-1.4, 1.4)?, within(-1.3, 1.3)?, within(150.0, 2000.0)?);
        let (x, radius) = (within(-0.4, 0.4)? * d, within(0.001, 0.3)? * d);
        // Where O appears.
        let y = -camera.f * (omega - alpha).tan();
        let pose = Pose { x: 0.0, y, distance: d, tilt: omega.to_degrees(), azimuth: 0.0 };
        let (view, at) = (pose.view(&camera), DVec2::new(x, 0.0));
        if (omega - alpha).abs() > 0.75 || view.least_depth(at, 1.2 * radius) <= 0.0 {
            continue;
        }
        scenes += 1;
        let model = Model::new(camera.f, x, d, omega, alpha).context("a plane before the camera")?;
        let (truth, seen) = (view.undistorted(at), view.ellipse(at, radius));
        let seen = DVec2::new(seen.x, seen.y);
        let shift = model.eccentricity(radius).context("a circle before the camera")?;
        let ellipse = model.ellipse_centre(radius).context("a circle before the camera")?;
        let printed = (shift.0, shift.1 * omega.cos() / alpha.cos());
        let off = |(x, y): (f64, f64), from: DVec2| DVec2::new(x, y).distance(from);
        worst.centre = worst.centre.max(off(model.centre(), truth));
        worst.ellipse = worst.ellipse.max(off(ellipse, seen));
        worst.eccentricity = worst.eccentricity.max(off(shift, seen - truth));
        worst.misprint = worst.misprint.max(off(printed, seen - truth));
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_the_projection() {
        let worst = worst().unwrap();
        assert!(worst.centre.max(worst.ellipse).max(worst.eccentricity) < EXACT, "{worst:?}");
        assert!(worst.misprint > 1.0, "{worst:?}");
    }
}
