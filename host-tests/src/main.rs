//! The program `concentric`.
fn main() {}
