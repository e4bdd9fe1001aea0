//! The image of a circle whose place before the camera is known: what eq. (7) does without.
//!
//! Equations (1) to (8) of Huo et al. 2013, "Eccentricity error identification and compensation for high-accuracy 3D optical
//! measurement", Meas. Sci. Technol. 24, 075402; (1) to (3) are from Ahn, Warnecke and Kotowski 1999, "Systematic geometric
//! image measurement errors of circular object targets: mathematical formulation and correction", Photogramm. Rec. 16(93).
//!
//! | equation | here |
//! | --- | --- |
//! | (1) true centre | [`Scene::centre`] |
//! | (2) ellipse centre | [`Scene::ellipse_centre`] |
//! | (3) eccentricity, exact | [`Scene::eccentricity`]; taken off a measured centre by [`Plane::correct`] |
//! | (4) to (6) eccentricity, to the order of the squared radius | [`Scene::coefficients`], [`Scene::approximation`] |
//! | (7) true centre from two ellipse centres | [`from_two`]; what it leaves: [`Scene::residual`] |
//! | (8) the same with lens distortion | [`Lens`] |
//!
//! Everything is generic over `f32` and `f64` and costs some tens of operations. The detector needs none of it; it is for
//! who knows the pose and wants to predict, to compare, or to correct a single circle.

mod lens;
mod plane;
mod scene;

pub use lens::Lens;
pub use plane::Plane;
pub use scene::Scene;

use crate::centre::{Real, weights};

/// Eq. (7): the true centre from the ellipse centres of two concentric circles, k1 B2 - k2 B1 with
/// k1 = r1^2 / (r1^2 - r2^2) and k2 = r2^2 / (r1^2 - r2^2).
///
/// `ratio` is r2 / r1, inner over outer. These are the [`weights`] for t = 0. It follows from (5) and (6), so it leaves
/// what (4) neglects: [`Scene::residual`]. `None` if the ratio is 1.
pub fn from_two<T: Real>(outer: (T, T), inner: (T, T), ratio: T) -> Option<(T, T)> {
    let one = T::from(1.0);
    let weights = weights(&[(one, one), (ratio, one)], T::from(0.0))?;
    let (&minus_k2, &k1) = (weights.first()?, weights.get(1)?);
    Some((k1 * inner.0 + minus_k2 * outer.0, k1 * inner.1 + minus_k2 * outer.1))
}

#[cfg(test)]
mod tests;
