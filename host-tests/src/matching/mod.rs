//! Which measured target is which on the layout.

pub mod homography;
