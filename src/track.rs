//! The same target from frame to frame: an id that stays, and an age.
//!
//! Targets do not overlap, so that a target whose centre lies less than its semi-major axis from where a track expects it can
//! be no other one. Expected is the place of the last frame, moved on by as much as between the two frames before.
//!
//! What is followed need not be looked for in the whole frame: [`Tracker::regions`] are the places where it is expected, for
//! [`Scan::within`](crate::Scan::within). Every so many frames there are none, and the whole frame is searched: for new
//! targets, and for those that have left their regions.
//!
//! ```
//! # use concentric::{Detector, Image, Settings, Storage, TargetSpec};
//! use concentric::track::Tracker;
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! # let pixels = [200; 96 * 96];
//! # let mut storage = Storage::<96, 16, 1024>::new();
//! # let mut detector = Detector::new(Settings::new(TargetSpec::any()), &mut storage);
//! let mut tracker = Tracker::<16>::new().whole_every(10);
//! for _ in 0..20 {
//!     tracker.begin();
//!     let regions = tracker.regions(96, 96);
//!     let mut scan = detector.begin(96, 96)?;
//!     if let Some(regions) = &regions {
//!         scan = scan.within(regions)?;
//!     }
//!     for row in pixels.chunks(96) {
//!         for target in scan.push_row(row)? {
//!             tracker.follow(&target);
//!         }
//!     }
//!     for target in scan.finish()? {
//!         tracker.follow(&target);
//!     }
//! }
//! # Ok(())
//! # }
//! ```

use core::mem;

use crate::code::QUIET;
use crate::region::Region;
use crate::target::Target;
use heapless::Vec;

/// Frames in which a target may be missing before its track ends.
pub const MAX_MISSED: u8 = 4;
/// Columns and rows beside a target that its measurement looks at, px: stretches on a row lead farther away.
const SURROUNDINGS: [f32; 2] = [24.0, 12.0];

/// A target that is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Track {
    /// From 1 on; given to no other target until 65534 more have appeared.
    pub id: u16,
    /// Frames since it appeared, 0 in the first. Saturates.
    pub age: u32,
    /// Frames in a row in which it was missing up to the one before this.
    pub missed: u8,
    /// Its centre in the last frame in which it was seen, px.
    place: (f32, f32),
    /// From frame to frame, px.
    step: (f32, f32),
    /// From its centre to the farthest of what belongs to it, px.
    reach: f32,
    seen: bool,
}

impl Track {
    /// Where its centre is expected in this frame, px.
    pub fn expected(&self) -> (f32, f32) {
        let frames = f32::from(self.missed) + 1.0;
        (self.place.0 + frames * self.step.0, self.place.1 + frames * self.step.1)
    }

    /// Where it is looked for in a frame of this size; `None` if that is outside. Room for a change of its motion by half of
    /// it, or by a quarter of its size from rest, and for as much again in every frame in which it was missing.
    pub fn region(&self, width: u16, height: u16) -> Option<Region> {
        let (x, y) = self.expected();
        let frames = f32::from(self.missed) + 1.0;
        let span = |centre: f32, step: f32, size: u16, around: f32| {
            let change = (0.5 * step.abs()).max(0.25 * self.reach);
            let reach = self.reach + around + frames * change;
            let (first, last) = (centre - reach, centre + reach);
            (last >= 0.0 && first < f32::from(size)).then(|| (first as u16, (last as u16).min(size - 1)))
        };
        let [beside, above] = SURROUNDINGS;
        let (left, right) = span(x, self.step.0, width, beside)?;
        let (top, bottom) = span(y, self.step.1, height, above)?;
        Some(Region { top, bottom, left, right })
    }

    fn see(&mut self, (x, y): (f32, f32), reach: f32) {
        let frames = f32::from(self.missed) + 1.0;
        self.step = ((x - self.place.0) / frames, (y - self.place.1) / frames);
        (self.place, self.seen, self.reach) = ((x, y), true, reach);
    }
}

/// Follows up to `TARGETS` targets. Work for a target: a comparison with every track.
#[derive(Clone, Debug, Default)]
pub struct Tracker<const TARGETS: usize> {
    tracks: Vec<Track, TARGETS>,
    last_id: u16,
    /// Frames from one that is searched as a whole to the next, and since the last.
    period: u16,
    since_whole: u16,
    found_again: u32,
}

impl<const TARGETS: usize> Tracker<TARGETS> {
    /// Follows nothing yet, and searches whole frames.
    pub const fn new() -> Self {
        Self { tracks: Vec::new(), last_id: 0, period: 0, since_whole: 0, found_again: 0 }
    }

    /// Has one frame in `period` searched as a whole, and the others only where targets are expected; 0 and 1: all as a
    /// whole. More than [`MAX_MISSED`] + 1 costs a target that has left its region its id.
    pub const fn whole_every(mut self, period: u16) -> Self {
        self.period = period;
        self
    }

    /// Frames from one that is searched as a whole to the next.
    pub fn period(&self) -> u16 {
        self.period
    }

    /// Changes that from the next frame on.
    pub fn set_period(&mut self, period: u16) {
        self.period = period;
    }

    /// Where the targets are expected in the frame that has begun, of this size, sorted by row; `None`: search it as a whole.
    /// It is, too, when nothing is followed.
    pub fn regions(&self, width: u16, height: u16) -> Option<Vec<Region, TARGETS>> {
        if self.is_whole() {
            return None;
        }
        let mut regions = Vec::new();
        for region in self.tracks.iter().filter_map(|track| track.region(width, height)) {
            // Cannot fail, as there is room for every track; `collect` would bring code that panics.
            let _ = regions.push(region);
        }
        sort(&mut regions);
        Some(regions)
    }

    /// Whether the frame that has begun is to be searched as a whole.
    pub fn is_whole(&self) -> bool {
        self.since_whole == 0
    }

    /// How often a target that had been missing was found again under its id, by the search of a whole frame or where it was
    /// expected. One that has moved farther than its semi-major axis from there gets a new id. Saturates.
    pub fn found_again(&self) -> u32 {
        self.found_again
    }

    /// Starts a frame: tracks of targets that were missing too often end.
    pub fn begin(&mut self) {
        self.tracks.retain(|track| track.seen || track.missed < MAX_MISSED);
        for track in &mut self.tracks {
            track.missed = if track.seen { 0 } else { track.missed + 1 };
            track.age = track.age.saturating_add(1);
            track.seen = false;
        }
        let next = self.since_whole + 1;
        self.since_whole = if next >= self.period || self.tracks.is_empty() { 0 } else { next };
    }

    /// The track of a target of this frame: the nearest one that can be its own, or else a new one. `None` for a new target when
    /// there are `TARGETS` already.
    pub fn follow(&mut self, target: &Target) -> Option<Track> {
        let (x, y) = target.centre.to_px();
        let size = target.circles.first()?.ellipse.a;
        let reach = if target.code.is_some() { QUIET * size } else { size };
        let mut least = size * size;
        let mut nearest = None;
        for track in self.tracks.iter_mut().filter(|track| !track.seen) {
            let (ex, ey) = track.expected();
            let square = (x - ex) * (x - ex) + (y - ey) * (y - ey);
            if square < least {
                (least, nearest) = (square, Some(track));
            }
        }
        if let Some(track) = nearest {
            if track.missed > 0 {
                self.found_again = self.found_again.saturating_add(1);
            }
            track.see((x, y), reach);
            return Some(*track);
        }
        let id = self.last_id.checked_add(1).unwrap_or(1);
        let track = Track { id, age: 0, missed: 0, place: (x, y), step: (0.0, 0.0), reach, seen: true };
        self.tracks.push(track).ok()?;
        self.last_id = id;
        Some(track)
    }

    /// All tracks; those that were not seen in this frame have waited for it in vain so far.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }
}

/// By their first rows. The sort of `core` has paths that panic; and these are nearly sorted, as targets come from top to bottom.
fn sort(regions: &mut [Region]) {
    for end in 1..=regions.len() {
        let mut sorted = regions.get_mut(..end).unwrap_or_default();
        while let Some((last, rest)) = sorted.split_last_mut() {
            match rest.last_mut() {
                Some(before) if before.top > last.top => mem::swap(before, last),
                _ => break,
            }
            sorted = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;

    #[test]
    fn regions_are_sorted_by_their_first_rows() {
        let tops = |tops: &[u16]| {
            tops.iter()
                .map(|&top| Region { top, bottom: 900, left: top, right: 900 })
                .collect::<std::vec::Vec<_>>()
        };
        for mixed in [&[5u16, 3, 9, 1, 7, 3][..], &[1, 2, 3], &[3, 2, 1, 0], &[4], &[]] {
            let mut regions = tops(mixed);
            sort(&mut regions);
            let mut right = mixed.to_vec();
            right.sort_unstable();
            assert_eq!(regions, tops(&right));
        }
    }
}
