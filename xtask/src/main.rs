//! `cargo xtask`: builds, checks and runs concentric for every target.
fn main() {}
