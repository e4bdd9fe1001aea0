//! The report on the wire: round trip, lengths, saturation, damage, and the specification's examples.

mod capacity;
mod fixed;
mod specification;
mod stream;
mod support;
