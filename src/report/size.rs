//! Worst-case lengths, so that buffers are sized when the program is built.

use super::Detail;
use crate::{MAX_CIRCLES, Reject};

const U16: usize = 3;
const U32: usize = 5;
const I8: usize = 1;
const PLACE: usize = 2 * U32;

/// Version, kind and CRC-32.
const ENVELOPE: usize = 1 + 1 + 4;

const HELLO: usize = 3 * U16 + 3 * U16 + 1 + U32 + U16 + 1;
const HEAD: usize = U32 + 2 * U16 + 1 + Reject::ALL.len() * U32 + 4 * U32 + 2 * U32 + 1;
const TERSE: usize = 3 * U16 + PLACE + 2 * U16 + I8 + U16;
const SHAPE: usize = 2 * U32 + 2 * U16;
const CIRCLE: usize = PLACE + SHAPE + 4 * U16;
const FULL: usize = 2 * PLACE + 3 * U16 + 1 + MAX_CIRCLES * CIRCLE;

/// Largest length of an encoded hello, both separators included.
pub const HELLO_MAX_LEN: usize = 1 + framed(ENVELOPE + HELLO);

/// A list of ratios as long as it can be.
const RATIOS: usize = 1 + 8 * U16;
const COMMAND: usize = U16 + 1 + RATIOS;
/// The longest outcome is that of a ratio.
const ANSWER: usize = U16 + (1 + 3 * U16) + RATIOS + 4 + 2 * U16 + 1;

/// Longest command before COBS.
pub(super) const COMMAND_PLAIN: usize = ENVELOPE + COMMAND;
/// Largest length of an encoded command, both separators included.
pub const COMMAND_MAX_LEN: usize = 1 + framed(COMMAND_PLAIN);
/// Largest length of an encoded answer, both separators included.
pub const ANSWER_MAX_LEN: usize = 1 + framed(ENVELOPE + ANSWER);

/// Largest length of an encoded frame report with up to `targets` targets, separator included.
pub const fn max_len(targets: usize, detail: Detail) -> usize {
    let target = match detail {
        Detail::Terse => TERSE,
        Detail::Normal => TERSE + SHAPE,
        Detail::Full => TERSE + FULL,
    };
    framed((ENVELOPE + HEAD + varint(targets)).saturating_add(targets.saturating_mul(target)))
}

/// Length of `plain` bytes after COBS (one byte more for every 254) and with the separator.
const fn framed(plain: usize) -> usize {
    plain.saturating_add(plain.div_ceil(254)).saturating_add(1)
}

/// Length of a varint: 7 bits a byte.
const fn varint(mut value: usize) -> usize {
    let mut len = 1;
    while value >= 128 {
        value >>= 7;
        len += 1;
    }
    len
}
