//! What is built in, by the features of the crate.
//!
//! The detector asks these constants where an ability begins, so that the compiler leaves out what only that ability needs.

/// Circles of which only arcs are seen.
pub(crate) const ARCS: bool = cfg!(feature = "arcs");
/// A known camera.
pub(crate) const CAMERA: bool = cfg!(feature = "camera");
/// A whole target's ellipses, levels, light and blur together.
pub(crate) const JOINT: bool = cfg!(feature = "joint");
