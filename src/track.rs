//! The same target from frame to frame: an id that stays, and an age.
//!
//! Targets do not overlap, so that a target whose centre lies less than its semi-major axis from where a track expects it can
//! be no other one. Expected is the place of the last frame, moved on by as much as between the two frames before.

use crate::target::Target;
use heapless::Vec;

/// Frames in which a target may be missing before its track ends.
pub const MAX_MISSED: u8 = 4;

/// A target that is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Track {
    /// Given to no other target until 65535 more have appeared.
    pub id: u16,
    /// Frames since it appeared, 0 in the first. Saturates.
    pub age: u32,
    /// Frames in a row in which it was missing up to the one before this.
    pub missed: u8,
    /// Its centre in the last frame in which it was seen, px.
    place: (f32, f32),
    /// From frame to frame, px.
    step: (f32, f32),
    seen: bool,
}

impl Track {
    /// Where its centre is expected in this frame, px.
    pub fn expected(&self) -> (f32, f32) {
        let frames = f32::from(self.missed) + 1.0;
        (self.place.0 + frames * self.step.0, self.place.1 + frames * self.step.1)
    }

    fn see(&mut self, (x, y): (f32, f32)) {
        let frames = f32::from(self.missed) + 1.0;
        self.step = ((x - self.place.0) / frames, (y - self.place.1) / frames);
        (self.place, self.seen) = ((x, y), true);
    }
}

/// Follows up to `TARGETS` targets. Work for a target: a comparison with every track.
#[derive(Clone, Debug, Default)]
pub struct Tracker<const TARGETS: usize> {
    tracks: Vec<Track, TARGETS>,
    next_id: u16,
}

impl<const TARGETS: usize> Tracker<TARGETS> {
    /// Follows nothing yet.
    pub const fn new() -> Self {
        Self { tracks: Vec::new(), next_id: 0 }
    }

    /// Starts a frame: tracks of targets that were missing too often end.
    pub fn begin(&mut self) {
        self.tracks.retain(|track| track.seen || track.missed < MAX_MISSED);
        for track in &mut self.tracks {
            track.missed = if track.seen { 0 } else { track.missed + 1 };
            track.age = track.age.saturating_add(1);
            track.seen = false;
        }
    }

    /// The track of a target of this frame: the nearest one that can be its own, or else a new one. `None` for a new target when
    /// there are `TARGETS` already.
    pub fn follow(&mut self, target: &Target) -> Option<Track> {
        let (x, y) = target.centre.to_px();
        let reach = target.circles.first()?.ellipse.a;
        let mut least = reach * reach;
        let mut nearest = None;
        for track in self.tracks.iter_mut().filter(|track| !track.seen) {
            let (ex, ey) = track.expected();
            let square = (x - ex) * (x - ex) + (y - ey) * (y - ey);
            if square < least {
                (least, nearest) = (square, Some(track));
            }
        }
        if let Some(track) = nearest {
            track.see((x, y));
            return Some(*track);
        }
        let track =
            Track { id: self.next_id, age: 0, missed: 0, place: (x, y), step: (0.0, 0.0), seen: true };
        self.tracks.push(track).ok()?;
        self.next_id = self.next_id.wrapping_add(1);
        Some(track)
    }

    /// All tracks; those that were not seen in this frame have waited for it in vain so far.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }
}
