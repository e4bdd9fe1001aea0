//! The report as lines of text, in the manner of NMEA 0183: a name, fields between commas, a checksum.

use core::fmt::{self, Write};

use super::body::{Details, FrameHead, Shape, TargetEntry};
use super::{Detail, EncodeError};

const FRAME_LINE: usize = "$CCF,4294967295,65535,65535,4294967295,4294967295,4294967295*FF\r\n".len();
const TARGET_LINE: usize =
    "$CCT,4294967295,4294967295,65535,-32768.0000,-32768.0000,0.99998,0.99998,-1.00,65535,,,,,65535,65535*FF\r\n".len();
const SHAPE: usize = "524287.9998524287.9998-180.000.99998".len();

/// Largest length of a report with up to `targets` targets as text.
pub const fn max_text_len(targets: usize, detail: Detail) -> usize {
    let line = match detail {
        Detail::Terse => TARGET_LINE,
        Detail::Normal | Detail::Full => TARGET_LINE + SHAPE,
    };
    FRAME_LINE.saturating_add(targets.saturating_mul(line))
}

pub(super) fn write<'b>(
    head: &FrameHead,
    targets: &[TargetEntry],
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let available = buffer.len();
    let mut text = Text { out: buffer, len: 0, check: 0 };
    // Past its end the text only counts: writing never fails.
    let _ = write_lines(&mut text, head, targets);
    let needed = text.len;
    buffer.get(..needed).ok_or(EncodeError::BufferTooSmall { needed, available })
}

fn write_lines(text: &mut Text<'_>, head: &FrameHead, targets: &[TargetEntry]) -> fmt::Result {
    let &FrameHead { seq, width, height, dropped_targets, dropped_reports, .. } = head;
    text.begin();
    write!(text, "CCF,{seq},{width},{height},{},{dropped_targets},{dropped_reports}", targets.len())?;
    text.end()?;
    for (number, target) in (1u32..).zip(targets) {
        text.begin();
        write!(text, "CCT,{seq},{number},{}", target.id)?;
        text.fixed::<65536, 4>(target.centre.x.into())?;
        text.fixed::<65536, 4>(target.centre.y.into())?;
        text.fixed::<65536, 5>(target.sigma_x.into())?;
        text.fixed::<65536, 5>(target.sigma_y.into())?;
        text.fixed::<127, 2>(target.correlation.into())?;
        write!(text, ",{}", target.flags.0)?;
        match outer(&target.details) {
            Some(shape) => {
                text.fixed::<4096, 4>(shape.a.into())?;
                text.fixed::<4096, 4>(shape.b.into())?;
                text.fixed::<32768, 2>(i64::from(shape.theta) * 180)?;
                text.fixed::<65536, 5>(shape.rms.into())?;
            }
            None => text.write_str(",,,,")?,
        }
        write!(text, ",{},{}", target.track, target.age)?;
        text.end()?;
    }
    Ok(())
}

/// The outer circle, where the level of detail has it.
fn outer(details: &Details) -> Option<Shape> {
    match details {
        Details::Terse => None,
        Details::Normal(shape) => Some(*shape),
        Details::Full(full) => Some(full.circles.first().map(|circle| circle.shape).unwrap_or_default()),
    }
}

/// Text being written. Past the end of `out` it only counts, so that the length needed is known.
struct Text<'b> {
    out: &'b mut [u8],
    len: usize,
    /// XOR of the line's characters.
    check: u8,
}

impl Text<'_> {
    fn begin(&mut self) {
        self.append(b'$');
        self.check = 0;
    }

    fn end(&mut self) -> fmt::Result {
        let check = self.check;
        write!(self, "*{check:02X}\r\n")
    }

    /// A comma and `units / UNIT` with a fixed number of digits after the point, rounded.
    fn fixed<const UNIT: u64, const DIGITS: u32>(&mut self, units: i64) -> fmt::Result {
        let ten = const { 10u64.pow(DIGITS) };
        let rounded = units.unsigned_abs().wrapping_mul(ten).wrapping_add(UNIT / 2) / UNIT;
        let sign = if units < 0 && rounded > 0 { "-" } else { "" };
        write!(self, ",{sign}{}.", rounded / ten)?;
        let mut place = ten;
        while place > 1 {
            place /= 10;
            self.write_char(char::from(b'0' + (rounded / place.max(1) % 10) as u8))?;
        }
        Ok(())
    }

    fn append(&mut self, byte: u8) {
        if let Some(place) = self.out.get_mut(self.len) {
            *place = byte;
        }
        self.check ^= byte;
        self.len = self.len.wrapping_add(1);
    }
}

impl Write for Text<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.append(byte));
        Ok(())
    }
}
