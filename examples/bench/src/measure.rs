//! A frame through the detector, with a mark after each piece of work.

use core::cell::Cell;

use concentric::report::{Report, max_len};
use concentric::{Detector, Observer, Rejected, Run, Summary};

use crate::hardware::mark;
use crate::job::{CONTRAST, DETAIL, MAX_TARGETS, MOST};

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

/// A frame, and what is known of it.
pub struct Frame<'f, 'r> {
    pub pixels: &'f [u8],
    pub width: u16,
    pub height: u16,
    /// Where it is searched, if not as a whole.
    pub regions: Option<&'f [concentric::Region]>,
    pub runs: Option<Runs<'f, 'r>>,
}

/// The runs of the rows, and room for those of one.
pub struct Runs<'f, 'r> {
    pub rest: &'f mut &'r [u8],
    pub row: &'f mut [Run; MOST],
}

impl Runs<'_, '_> {
    fn take_row(&mut self) -> Option<&[Run]> {
        let runs = self.row.get_mut(..take_word(self.rest)? as usize)?;
        for run in runs.iter_mut() {
            let word = take_word(self.rest)?;
            *run = Run { start: word as u16, end: (word >> 16) as u16 };
        }
        Some(runs)
    }
}

/// The next word.
pub fn take_word(rest: &mut &[u8]) -> Option<u32> {
    let (word, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(u32::from_le_bytes(*word))
}

/// Shows the whole frame to the detector before it is measured.
pub fn see_noise(detector: &mut Detector<'_>, frame: &Frame<'_, '_>) -> Option<()> {
    let refusals = Refusals::default();
    let mut scan = detector.begin_observed(frame.width, frame.height, &refusals).ok()?;
    for row in frame.pixels.chunks_exact(usize::from(frame.width).max(1)) {
        scan.push_row(row).ok()?.for_each(drop);
    }
    scan.finish().ok()?.for_each(drop);
    Some(())
}

/// Gives the rows of a frame to the detector, and its targets to the report.
#[inline(never)]
pub fn measure_frame<'b>(
    detector: &mut Detector<'_>,
    frame: Frame<'_, '_>,
    report: &mut Report<MAX_TARGETS>,
    bytes: &'b mut Bytes,
) -> Option<&'b [u8]> {
    mark(Region::Outside);
    let refusals = Refusals::default();
    let Frame { pixels, width, height, regions, mut runs } = frame;
    let mut scan = detector.begin_observed(width, height, &refusals).ok()?;
    if let Some(regions) = regions {
        scan = scan.within(regions).ok()?;
    }
    for row in pixels.chunks_exact(usize::from(width).max(1)) {
        let targets = match &mut runs {
            Some(runs) => {
                let runs = runs.take_row()?;
                mark(Region::Outside);
                scan.push_row_with_runs(row, runs, CONTRAST).ok()?
            }
            None => scan.push_row(row).ok()?,
        };
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
