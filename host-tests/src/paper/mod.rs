//! The command `paper`: Huo et al. 2013, every equation, table and figure, beside what is printed.
//!
//! 1. [`printed`]: what the paper says.
//! 2. [`equations`]: (1) to (3) against the projection of conics.
//! 3. [`simulation`]: tables 1 and 2, figures 4 and 5.
//! 4. [`lens`]: eq. (8).
//! 5. [`single`]: figure 6.
//! 6. [`board`]: figures 7 and 8, and every method on the same pictures; [`one_circle`]: one of them.
//! 7. [`report`], [`page`], [`plots`]: all results, and what is written.
//! 8. [`own`]: the methods on pictures of one's own.

pub mod board;
pub mod command;
pub mod equations;
pub mod lens;
pub mod one_circle;
pub mod own;
pub mod page;
pub mod plots;
pub mod printed;
pub mod report;
pub mod simulation;
pub mod single;
