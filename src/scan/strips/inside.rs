//! Strips in the regions of a frame.

use core::ops::Range;

use super::{HIGH, LOW, NOTHING, SIZE, STRIP, Strip, Strips, UNTIL, WINDOW, age, unknown};

impl Strips<'_> {
    /// The strips that have one of the columns from `left` to `right` are looked at before block `until`.
    pub(super) fn open(&mut self, (left, right, until): (u16, u16, u16)) {
        let [left, right] = [left, right].map(|x| usize::from(x) / STRIP);
        for strip in self.all_mut().get_mut(left..=right).unwrap_or_default() {
            strip[UNTIL] = strip[UNTIL].max(until.into());
        }
    }

    /// Closes the strips that have left their region: first as at the lower border of a frame, then for good.
    pub(super) fn leave(&mut self) {
        let (block, closed) = (u32::from(self.blocks), unknown(self.targets));
        for strip in self.all_mut() {
            if strip[UNTIL] == block {
                age(strip);
                [strip[LOW + 2], strip[HIGH + 2]] = NOTHING;
                strip[WINDOW] = 0;
            } else if strip[UNTIL] + 1 == block {
                *strip = closed;
            }
        }
    }

    /// The next strips from number `from` on that lie in a region.
    pub(super) fn inside(&self, from: usize) -> Range<usize> {
        let is_inside = |strip: &&Strip| u32::from(self.blocks) < strip[UNTIL];
        let strips = self.data.as_chunks::<SIZE>().0.get(from..self.count).unwrap_or_default();
        let outside = strips.iter().take_while(|strip| !is_inside(strip)).count();
        let first = from + outside;
        first..first + strips.iter().skip(outside).take_while(is_inside).count()
    }
}
