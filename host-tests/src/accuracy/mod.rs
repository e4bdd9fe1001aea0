//! The command `accuracy`: how far the library's centres are from the truth, against the least that is possible.

pub mod bound;
