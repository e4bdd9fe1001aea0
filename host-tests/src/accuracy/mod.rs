//! The command `accuracy`: how far the library's centres are from the truth, against the least that is possible.
//!
//! 1. [`cell`], [`grid`]: the conditions, and the scenes that show them.
//! 2. [`bound`]: the Cramer-Rao bound of each scene.
//! 3. [`run`], [`method`]: frames through the library; the ways to a centre that are compared.
//! 4. [`statistics`]: errors to figures.

pub mod bound;
pub mod cell;
pub mod command;
pub mod grid;
pub mod method;
pub mod run;
pub mod statistics;
