//! From bytes back to version, kind and body: COBS and CRC-32 taken off.

use heapless::Vec;

use super::frame::CRC;
use super::{DecodeError, SEPARATOR, WIRE_VERSION};

/// Takes a stream apart at its separators, byte by byte.
#[derive(Clone, Debug)]
pub(super) struct Unframer<const N: usize> {
    state: State,
    plain: Vec<u8, N>,
    pending: usize,
}

/// `repr` makes the first state zero, so that a decoder in a static takes no flash.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
enum State {
    /// No byte since the last separator.
    Between,
    /// In a COBS block, `left` bytes before its end; a zero follows unless it is the last one or `full`.
    Block { left: u8, full: bool },
    /// The message was too long; the rest of it is no new one.
    Skip,
}

impl State {
    fn block(code: u8) -> Self {
        Self::Block { left: code.saturating_sub(1), full: code == u8::MAX }
    }
}

impl<const N: usize> Unframer<N> {
    pub(super) const fn new() -> Self {
        Self { state: State::Between, plain: Vec::new(), pending: 0 }
    }

    /// Takes the next byte; returns kind and body, or what is wrong, if it ends a stretch.
    pub(super) fn push(&mut self, byte: u8) -> Option<Result<(u8, &[u8]), DecodeError>> {
        if byte == SEPARATOR {
            return self.end();
        }
        self.pending = self.pending.saturating_add(1);
        self.state = match self.state {
            State::Between => {
                self.plain.clear();
                State::block(byte)
            }
            State::Block { left: 0, full: true } => State::block(byte),
            State::Block { left: 0, full: false } => match self.plain.push(0) {
                Ok(()) => State::block(byte),
                Err(_) => State::Skip,
            },
            State::Block { left, full } => match self.plain.push(byte) {
                Ok(()) => State::Block { left: left.saturating_sub(1), full },
                Err(_) => State::Skip,
            },
            State::Skip => State::Skip,
        };
        None
    }

    pub(super) fn pending(&self) -> usize {
        self.pending
    }

    fn end(&mut self) -> Option<Result<(u8, &[u8]), DecodeError>> {
        self.pending = 0;
        match core::mem::replace(&mut self.state, State::Between) {
            State::Between => None,
            State::Skip => Some(Err(DecodeError::TooLong)),
            State::Block { left: 0, .. } => Some(check(&self.plain)),
            State::Block { .. } => Some(Err(DecodeError::Cobs)),
        }
    }
}

fn check(plain: &[u8]) -> Result<(u8, &[u8]), DecodeError> {
    let (content, crc) = plain.split_last_chunk::<4>().ok_or(DecodeError::TooShort)?;
    let ([version, kind], body) = content.split_first_chunk::<2>().ok_or(DecodeError::TooShort)?;
    if CRC.checksum(content) != u32::from_le_bytes(*crc) {
        return Err(DecodeError::Checksum);
    }
    if *version != WIRE_VERSION {
        return Err(DecodeError::Version(*version));
    }
    Ok((*kind, body))
}
