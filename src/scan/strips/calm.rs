//! Strips to which nothing is done.

use super::super::kernel::{Line, within};
use super::{FLAGS, RESTLESS, Strip, WINDOW, age};

/// The number of strips, from the first of `strips` on, whose samples in `lines` stay in their windows; they are aged.
#[cfg(not(all(target_arch = "arm", target_os = "none")))]
#[inline(never)]
pub(in crate::scan) fn calm<const FIRST: usize>(strips: &mut [Strip], lines: &[Line], width: u32) -> usize {
    let mut count = 0;
    for (strip, line) in strips.iter_mut().zip(lines) {
        if !within::<FIRST>(line, strip[WINDOW], width) {
            break;
        }
        if strip[FLAGS] & RESTLESS != 0 {
            age(strip);
        }
        count += 1;
    }
    count
}

/// The same; those after one that need not be aged are counted with few registers.
#[cfg(all(target_arch = "arm", target_os = "none"))]
pub(in crate::scan) fn calm<const FIRST: usize>(strips: &mut [Strip], lines: &[Line], width: u32) -> usize {
    let mut count = 0;
    while let (Some(strip), Some(line)) = (strips.get_mut(count), lines.get(count)) {
        if !within::<FIRST>(line, strip[WINDOW], width) {
            break;
        }
        if strip[FLAGS] & RESTLESS != 0 {
            age(strip);
        }
        count += 1;
        let (rest, left) = (strips.get(count..).unwrap_or(&[]), lines.get(count..).unwrap_or(&[]));
        count += crate::arm::calm(rest, left, FIRST, width);
    }
    count
}
