//! True centres of concentric-circle targets.
#![no_std]
#![deny(unsafe_code)]

mod math;
mod reject;
pub mod target;

pub use reject::{Dropped, Observer, Reject, Rejected, Rejects};
pub use target::{Circle, Covariance, Ellipse, Flags, MAX_CIRCLES, Position, Target};
