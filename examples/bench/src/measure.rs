//! A frame through the detector, with a mark after each piece of work.

use core::cell::Cell;

use concentric::report::{Report, max_len};
use concentric::{Detector, Observer, Rejected, Summary};

use crate::hardware::mark;
use crate::job::{DETAIL, MAX_TARGETS};

/// A part of the work whose instructions are counted. See the plugin in `xtask/counter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Region {
    /// Nothing that is measured.
    Outside = 0,
    /// Rows up to the finished candidates.
    Scan = 1,
    /// Candidates to targets, or to nothing.
    Target = 2,
    /// Targets into the report.
    Report = 3,
    /// Ends a frame.
    End = 63,
}

/// Room for a report.
pub type Bytes = [u8; max_len(MAX_TARGETS, DETAIL)];

/// Tells whether a candidate was refused.
#[derive(Default)]
struct Refusals(Cell<u32>);

impl Observer for &Refusals {
    fn rejected(&mut self, _: &Rejected) {
        self.0.set(self.0.get().wrapping_add(1));
    }
}

/// Gives the rows of a frame to the detector, and its targets to the report.
#[inline(never)]
pub fn measure_frame<'b>(
    detector: &mut Detector<'_>,
    (pixels, width, height): (&[u8], u16, u16),
    report: &mut Report<MAX_TARGETS>,
    bytes: &'b mut Bytes,
) -> Option<&'b [u8]> {
    mark(Region::Outside);
    let refusals = Refusals::default();
    let mut scan = detector.begin_observed(width, height, &refusals).ok()?;
    for row in pixels.chunks_exact(usize::from(width).max(1)) {
        let targets = scan.push_row(row).ok()?;
        mark(Region::Scan);
        collect(targets, &refusals, report);
    }
    let mut rest = scan.finish().ok()?;
    mark(Region::Scan);
    collect(rest.by_ref(), &refusals, report);
    let summary: Summary = rest.summary();
    let sent = report.finish(&summary, bytes).ok();
    mark(Region::Report);
    sent
}

/// Takes the targets; what found neither a target nor a refusal was only a look.
#[inline(always)]
fn collect(
    mut targets: impl Iterator<Item = concentric::Target>,
    refusals: &Refusals,
    report: &mut Report<MAX_TARGETS>,
) {
    loop {
        let before = refusals.0.get();
        let target = targets.next();
        let looked = target.is_none() && refusals.0.get() == before;
        mark(if looked { Region::Scan } else { Region::Target });
        let Some(target) = target else { return };
        report.push(&target);
        mark(Region::Report);
    }
}
