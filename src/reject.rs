//! Why a candidate is no target, and what full buffers cost.

use crate::target::Position;

/// Why a candidate was not reported as a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum Reject {
    /// Outline smaller than the smallest circle that can be measured.
    TooSmall,
    /// Outline touches the frame's border.
    CutByFrame,
    /// Outline is no ellipse.
    NotElliptic,
    /// Ellipse without a second concentric one.
    Alone,
    /// Ellipses inside each other that no two concentric circles can give.
    NotConcentric,
    /// Concentric circles whose radii do not have the wanted ratios, or the wrong polarity.
    Ratio,
    /// Outline with too large an arc missing.
    OpenOutline,
    /// Edge too weak against the noise.
    LowContrast,
    /// Crossings of the outline were lost because the pool was full.
    BufferFull,
}

impl Reject {
    /// Every cause with the name used in reports and JSON.
    pub const ALL: [(Reject, &'static str); 9] = [
        (Reject::TooSmall, "too_small"),
        (Reject::CutByFrame, "cut_by_frame"),
        (Reject::NotElliptic, "not_elliptic"),
        (Reject::Alone, "alone"),
        (Reject::NotConcentric, "not_concentric"),
        (Reject::Ratio, "ratio"),
        (Reject::OpenOutline, "open_outline"),
        (Reject::LowContrast, "low_contrast"),
        (Reject::BufferFull, "buffer_full"),
    ];

    /// Name used in reports and JSON.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize % Self::ALL.len()].1
    }
}

/// Number of rejected candidates by cause. Saturates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rejects([u32; Reject::ALL.len()]);

impl Rejects {
    /// Number rejected for `cause`.
    pub fn count(&self, cause: Reject) -> u32 {
        self.0.get(cause as usize).copied().unwrap_or(0)
    }

    /// `(cause, count)` for every cause.
    pub fn iter(&self) -> impl Iterator<Item = (Reject, u32)> + '_ {
        Reject::ALL.iter().zip(self.0).map(|(&(cause, _), count)| (cause, count))
    }

    pub(crate) fn add(&mut self, cause: Reject) {
        if let Some(count) = self.0.get_mut(cause as usize) {
            *count = count.saturating_add(1);
        }
    }
}

/// From the counts that [`Rejects::iter`] gives; causes that are left out count 0.
impl FromIterator<(Reject, u32)> for Rejects {
    fn from_iter<I: IntoIterator<Item = (Reject, u32)>>(counts: I) -> Self {
        let mut rejects = Self::default();
        for (cause, count) in counts {
            if let Some(place) = rejects.0.get_mut(cause as usize) {
                *place = count;
            }
        }
        rejects
    }
}

/// What was lost because a buffer was full. Saturates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dropped {
    /// Runs that were too many for a row's list or for [`px_per_run`](crate::Settings::px_per_run): what lies right of them in
    /// that row was not seen; and runs of 32 x 4 px that were too fine.
    pub runs: u32,
    /// Outlines that did not fit in the table.
    pub outlines: u32,
    /// Outlines whose crossings did not fit in the pool or in the work that [`px_per_run`](crate::Settings::px_per_run) allows.
    pub crossings: u32,
}

/// A rejected candidate, for an [`Observer`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rejected {
    /// Why.
    pub cause: Reject,
    /// Middle of its bounding box.
    pub centre: Position,
    /// Width of its bounding box, px.
    pub width: u16,
    /// Height of its bounding box, px.
    pub height: u16,
}

/// Is told of every rejected candidate; `()` ignores them at no cost.
pub trait Observer {
    /// Called once for each rejected candidate, in the order in which they close.
    fn rejected(&mut self, candidate: &Rejected);
}

impl Observer for () {
    fn rejected(&mut self, _: &Rejected) {}
}

impl<F: FnMut(&Rejected)> Observer for F {
    fn rejected(&mut self, candidate: &Rejected) {
        self(candidate);
    }
}
