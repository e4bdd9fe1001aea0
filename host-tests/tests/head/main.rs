//! The loop of a camera head with a sensor, pins and a line that are only played.

mod asynch;
mod commands;
mod exposure;
mod line;
mod support;
mod text;
mod tracking;
