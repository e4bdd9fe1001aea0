//! The command `accuracy`: how far the library's centres are from the truth, against the least that is possible.
//!
//! 1. [`cell`], [`grid`]: the conditions, and the scenes that show them.
//! 2. [`bound`]: the Cramer-Rao bound of each scene.
//! 3. [`run`], [`method`]: frames through the library; the forms of the centre that are compared. [`efficient`]: what chance makes of
//!    any good one.
//! 4. [`statistics`], [`study`]: errors to figures.
//! 5. [`exactness`]: the closed forms without pictures.
//! 6. [`goals`]: what is asked, and what came out.
//! 7. [`markdown`], [`csv`], [`plots`]: what is written.

pub mod bound;
pub mod cell;
pub mod command;
pub mod csv;
pub mod efficient;
pub mod exactness;
pub mod goals;
pub mod grid;
pub mod markdown;
pub mod method;
pub mod plots;
pub mod run;
pub mod statistics;
pub mod study;
