//! Edge points -> ellipse.
//!
//! 1. [`rough`]: trace-constrained algebraic fit to sums of the edge points' monomials, a 5 x 5 linear system.
//! 2. [`Adjustment`]: one reweighted Gauss-Newton step in the frame where that ellipse is the unit circle. It puts
//!    geometric instead of algebraic weights on the points and gives residual and covariance.
//!
//! [`Line`] is an ellipse as rows or columns pass it, in integers. Sums are whole numbers, systems are solved in f32. [`Rough`] is for the search of arcs, too; [`Spread`] a robust standard
//! deviation.

mod adjust;
mod concentric;
mod line;
mod rough;
mod shape;
mod solve;
mod spread;

pub(crate) use adjust::{Adjusted, Adjustment, CENTRE_TERMS, FIELD, TERMS, View};
pub(crate) use concentric::{Concentric, ConcentricAdjustment, ConcentricStep};
pub(crate) use line::{Border, Line, Passage};
pub(crate) use rough::{Rough, rough};
pub(crate) use shape::{Frame, Shape};
pub(crate) use solve::{Factor, Matrix, add_scaled, dot};
pub(crate) use spread::Spread;
