//! Edge points -> ellipse.
//!
//! 1. [`Sums`]: exact integer sums of the edge points' monomials about the target's integer origin.
//! 2. [`Sums::fit`]: trace-constrained algebraic fit, a 5 x 5 linear system in f32.
//! 3. [`Adjustment`]: one reweighted Gauss-Newton step in the frame where that ellipse is the unit circle. It puts
//!    geometric instead of algebraic weights on the points and gives residual and covariance.
//!
//! [`Rough`] is the algebraic fit from whole numbers, for the search of arcs; [`Spread`] a robust standard deviation.

mod adjust;
mod concentric;
mod rough;
mod shape;
mod solve;
mod spread;
mod sums;

pub(crate) use adjust::{Adjusted, Adjustment, CENTRE_TERMS};
pub(crate) use concentric::{Concentric, ConcentricAdjustment, ConcentricStep};
pub(crate) use rough::Rough;
pub(crate) use shape::{Frame, Shape};
pub(crate) use solve::{Factor, Matrix};
pub(crate) use spread::Spread;
pub(crate) use sums::Sums;
