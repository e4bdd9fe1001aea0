//! The head's end of the line: bytes on their way out, commands on their way in. Never waits.

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

use crate::report::{Command, CommandDecoder, DecodeError};

/// A line that can be asked before it is used: what a head needs to never wait for it.
///
/// Implemented for everything that has the four traits of `embedded-io`; [`SendOnly`] makes one of a line without a way
/// back.
pub trait Line: Read + ReadReady + Write + WriteReady {}

impl<L: Read + ReadReady + Write + WriteReady> Line for L {}

/// A line that only sends: nothing ever arrives over it.
#[derive(Clone, Copy, Debug)]
pub struct SendOnly<W>(
    /// Where the bytes go.
    pub W,
);

impl<W: ErrorType> ErrorType for SendOnly<W> {
    type Error = W::Error;
}

impl<W: Write> Write for SendOnly<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, W::Error> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> Result<(), W::Error> {
        self.0.flush()
    }
}

impl<W: WriteReady> WriteReady for SendOnly<W> {
    fn write_ready(&mut self) -> Result<bool, W::Error> {
        self.0.write_ready()
    }
}

impl<W: ErrorType> Read for SendOnly<W> {
    fn read(&mut self, _: &mut [u8]) -> Result<usize, W::Error> {
        Ok(0)
    }
}

impl<W: ErrorType> ReadReady for SendOnly<W> {
    fn read_ready(&mut self) -> Result<bool, W::Error> {
        Ok(false)
    }
}

/// The line and what is on its way over it.
#[derive(Debug)]
pub(super) struct Wire<'b, L> {
    pub(super) line: L,
    /// What waits to be sent is `buffer[start..end]`.
    buffer: &'b mut [u8],
    start: usize,
    end: usize,
    inbox: CommandDecoder,
    /// Arrived and not carried out yet; nothing is read behind it.
    arrived: Option<Result<Command, DecodeError>>,
}

impl<'b, L: Line> Wire<'b, L> {
    pub(super) fn new(line: L, buffer: &'b mut [u8]) -> Self {
        Self { line, buffer, start: 0, end: 0, inbox: CommandDecoder::new(), arrived: None }
    }

    /// Bytes that wait to be sent.
    pub(super) fn waiting(&self) -> usize {
        self.end.saturating_sub(self.start)
    }

    /// Bytes that still fit.
    pub(super) fn room(&self) -> usize {
        self.buffer.len().saturating_sub(self.waiting())
    }

    /// Lets `write` put a message behind what waits, into all but the last `reserve` bytes; it returns the message.
    pub(super) fn append<E>(
        &mut self,
        reserve: usize,
        write: impl FnOnce(&mut [u8]) -> Result<&[u8], E>,
    ) -> Result<(), E> {
        self.close_up();
        let last = self.buffer.len().saturating_sub(reserve);
        let free = self.buffer.get_mut(self.end..last).unwrap_or_default();
        self.end = self.end.saturating_add(write(free)?.len());
        Ok(())
    }

    /// Moves what waits to the front of the buffer.
    fn close_up(&mut self) {
        let (start, len) = (self.start, self.waiting());
        if let Some(used) = self.buffer.get_mut(..self.end)
            && start <= used.len()
        {
            used.copy_within(start.., 0);
        }
        (self.start, self.end) = (0, len);
    }

    /// Sends what the line takes at once and reads what has arrived, up to a whole command. Does nothing once `state` is
    /// an error.
    pub(super) fn move_bytes(&mut self, state: &mut Result<(), L::Error>) {
        if state.is_ok() {
            *state = self.send().and_then(|()| self.receive());
        }
    }

    fn send(&mut self) -> Result<(), L::Error> {
        while let Some(waiting) = self.buffer.get(self.start..self.end)
            && !waiting.is_empty()
            && self.line.write_ready()?
        {
            let sent = self.line.write(waiting)?;
            if sent == 0 {
                break;
            }
            self.start = self.start.saturating_add(sent);
        }
        Ok(())
    }

    fn receive(&mut self) -> Result<(), L::Error> {
        while self.arrived.is_none() && self.line.read_ready()? {
            let mut byte = [0];
            if self.line.read(&mut byte)? == 0 {
                break;
            }
            self.arrived = self.inbox.push(byte[0]);
        }
        Ok(())
    }

    /// Sends everything that waits, waiting for the line.
    pub(super) fn flush(&mut self) -> Result<(), L::Error> {
        while let Some(waiting) = self.buffer.get(self.start..self.end)
            && !waiting.is_empty()
        {
            let sent = self.line.write(waiting)?;
            // Against its contract; `write_all` would panic.
            if sent == 0 {
                break;
            }
            self.start = self.start.saturating_add(sent);
        }
        self.line.flush()
    }

    /// The next command, or what arrived instead.
    pub(super) fn take_command(&mut self) -> Option<Result<Command, DecodeError>> {
        self.arrived.take()
    }

    pub(super) fn has_command(&self) -> bool {
        self.arrived.is_some()
    }
}
