use core::ops::{Add, Div, Mul, Neg, Sub};

/// The arithmetic that the closed forms need.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + From<f32>
{
    /// Square root; 0 for a negative argument.
    fn sqrt(self) -> Self;
}

impl Real for f32 {
    fn sqrt(self) -> Self {
        crate::math::sqrt(self)
    }
}

impl Real for f64 {
    fn sqrt(self) -> Self {
        if self > 0.0 { libm::sqrt(self) } else { 0.0 }
    }
}
