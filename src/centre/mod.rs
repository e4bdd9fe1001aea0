//! Ellipse centres -> true centre.
//!
//! The image of a circle of radius r about the true centre C is an ellipse whose centre is
//! `B(r) = C + K g(r)`, with `g = r^2 / (1 - t r^2)` where r is in units of the outer circle and t is
//! (radius x sin(tilt) / distance)^2 of the outer circle. So C is where the line through the ellipse centres, each at its
//! g, comes to g = 0.
//!
//! * `t = 0` is eq. (7) of Huo et al. 2013, "Eccentricity error identification and compensation for high-accuracy 3D
//!   optical measurement", Meas. Sci. Technol. 24, 075402.
//! * t from the distance of two ellipse centres and the shape of the outer ellipse makes it exact for any perspective
//!   ([`perspective`]).
//! * The correction costs noise: [`Significance`] says how much of it is worth that.
//! * A ratio that is not given is measured by the pencil of the two conics ([`Pencil`]).
//! * With a known camera the shape of one ellipse leaves two planes on which it is the image of a circle ([`Sight`]).
//!
//! Everything here is generic over `f32` and `f64`: the device calculates in f32, the desktop checks against f64.

mod combine;
mod pencil;
mod real;
mod section;
mod significance;

pub use combine::{Weights, mean, perspective, weights};
pub use pencil::Pencil;
pub use real::Real;
pub use section::{Misfit, Section, Sight};
pub use significance::Significance;
