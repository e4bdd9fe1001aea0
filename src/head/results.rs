//! What a head keeps of its frames: the report of the last one, and which target is which from frame to frame.

use crate::Target;
use crate::report::{Detail, Report};
use crate::track::Tracker;

/// The report of a frame, and the tracks of up to `N` targets.
///
/// At level terse it is all zeros: a static that takes no flash. [`Report::set_detail`] changes the level at run time.
#[derive(Clone, Debug)]
pub struct Results<const N: usize> {
    /// The report of the last frame.
    pub report: Report<N>,
    /// The targets that are followed. Every report has their numbers; frames are searched as a whole until
    /// [`Tracker::set_period`] or a command says otherwise.
    pub tracker: Tracker<N>,
}

impl<const N: usize> Results<N> {
    /// None yet.
    pub const fn new(detail: Detail) -> Self {
        Self { report: Report::new(detail), tracker: Tracker::new() }
    }

    /// The frame `seq` begins.
    pub(super) fn begin(&mut self, seq: u32) {
        self.report.begin(seq);
        self.tracker.begin();
    }

    pub(super) fn take(&mut self, targets: impl Iterator<Item = Target>) {
        for target in targets {
            let track = self.tracker.follow(&target);
            self.report.push_tracked(&target, track.as_ref());
        }
    }
}
