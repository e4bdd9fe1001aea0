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
    /// (sin, cos) of radians.
    fn sin_cos(self) -> (Self, Self);
}

impl Real for f32 {
    fn sqrt(self) -> Self {
        crate::math::sqrt(self)
    }

    fn sin_cos(self) -> (Self, Self) {
        crate::math::sincos(self)
    }
}

impl Real for f64 {
    fn sqrt(self) -> Self {
        if self > 0.0 { libm::sqrt(self) } else { 0.0 }
    }

    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
}
