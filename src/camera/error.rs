//! What is wrong with the parameters of a camera.

use core::fmt;

/// A parameter of a [`Camera`](super::Camera) outside its range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CameraError {
    /// The parameter: `fx`, `fy`, `cx`, `cy`, `k1`, `k2`, `p1`, `p2` or `k3`.
    pub name: &'static str,
    /// The value given.
    pub value: f32,
    /// Least value allowed.
    pub min: f32,
    /// Largest value allowed.
    pub max: f32,
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, min, max } = self;
        let unit = if name.starts_with('f') || name.starts_with('c') { " px" } else { "" };
        write!(f, "camera: {name} = {value}{unit} is outside {min}..={max}")
    }
}

impl core::error::Error for CameraError {}
