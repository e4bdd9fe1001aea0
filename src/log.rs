//! Logs at the borders of the stages, for a debug probe; nothing without the feature `defmt`.

/// `log!(level, format, arguments)`, with the levels and the format of `defmt`.
#[cfg(feature = "defmt")]
macro_rules! log {
    ($level:ident, $($arguments:tt)*) => { ::defmt::$level!($($arguments)*) };
}

/// Nothing. The arguments are named all the same, so that both builds check them.
#[cfg(not(feature = "defmt"))]
macro_rules! log {
    ($level:ident, $format:literal $(, $argument:expr)* $(,)?) => {{ $( let _ = &$argument; )* }};
}

pub(crate) use log;
