//! The table of outlines: exact moments, bounding boxes, and what became of each.

use super::crossings::CrossingList;
use super::moments::{Moments, SHORT};
use crate::abilities::ARCS;
use crate::list::rolled;
use crate::settings::limits;

/// No outline, no crossing.
pub(crate) const NONE: u16 = u16::MAX;

/// How much of an outline is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seen {
    /// All of it.
    Whole,
    /// Only arcs; its moments and box are those of the whole ellipse.
    Arcs,
    /// The same where nothing lies in its gap: it is open by itself.
    Open,
}

/// An outline: the border of a region of either polarity, seen from outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    pub moments: Moments,
    /// Column and row of the first transition.
    first: (u16, u16),
    /// Sum of the signs of the transitions in the row under way; they alternate.
    balance: i8,
    /// Leftmost column.
    pub left: u16,
    /// One past the rightmost column.
    pub right: u16,
    /// First row.
    pub top: u16,
    /// Last row.
    pub bottom: u16,
    pub crossings: CrossingList,
    /// Transitions of the current row that belong to it.
    ends: u16,
    /// The outline it was joined to, or itself.
    alias: u16,
    /// Next one in the list that this one is in: free, joined, closed, or waiting.
    pub next: u16,
    /// The largest concentric one inside.
    pub inner: u16,
    /// Row after which nothing concentric can close around it.
    pub ready: u16,
    /// How much of it is seen.
    pub seen: Seen,
    /// Touches the frame's border.
    pub cut: bool,
    /// Part of it, or of its crossings, is lost.
    pub lossy: bool,
}

impl Outline {
    pub const ZERO: Self = Self {
        moments: Moments::ZERO,
        first: (0, 0),
        balance: 0,
        left: 0,
        right: 0,
        top: 0,
        bottom: 0,
        crossings: CrossingList::ZERO,
        ends: 0,
        alias: 0,
        next: 0,
        inner: 0,
        ready: 0,
        seen: Seen::Whole,
        cut: false,
        lossy: false,
    };

    /// Whether only arcs of it are seen.
    pub fn is_partial(&self) -> bool {
        ARCS && self.seen != Seen::Whole
    }

    /// Whether nothing lies in its gap.
    pub fn is_open(&self) -> bool {
        ARCS && self.seen == Seen::Open
    }

    pub fn width(&self) -> u16 {
        self.right.saturating_sub(self.left)
    }

    pub fn height(&self) -> u16 {
        (self.bottom + 1).saturating_sub(self.top)
    }

    /// Whether it is too small for a circle: nobody asks for its moments and crossings.
    pub fn is_small(&self) -> bool {
        self.width().min(self.height()) < limits::MIN_EXTENT
    }

    /// Whether nothing of it is missing and it is large enough.
    pub fn is_usable(&self) -> bool {
        !self.cut && !self.lossy && !self.is_small()
    }

    /// Whether it closes when so many ends meet.
    pub fn closes(&self, ends: u16) -> bool {
        self.ends <= ends
    }

    /// Adds a transition at `(x, y)`; `sign` is +1 where dark turns light.
    #[inline(always)]
    pub fn add_transition(&mut self, sign: i32, x: u16, y: u16) {
        let was_short = self.is_short();
        self.reach(x, y);
        self.balance = self.balance.wrapping_add(sign as i8);
        let (dx, dy) = self.since_first(x, y);
        if self.is_short() {
            self.moments.add_short(sign, dx, dy);
        } else {
            if was_short {
                self.moments.lengthen();
            }
            self.moments.add_long(sign, dx, dy);
        }
    }

    /// Whether its sums are in the lower halves of [`Moments`] only.
    fn is_short(&self) -> bool {
        self.right - self.left < SHORT && self.bottom - self.top < SHORT
    }

    /// Makes whole sums of them.
    fn lengthen(&mut self) {
        if self.is_short() {
            self.moments.lengthen();
        }
    }

    /// The place `(x, y)` from the first transition on.
    fn since_first(&self, x: u16, y: u16) -> (i32, i32) {
        (i32::from(x) - i32::from(self.first.0), i32::from(y) - i32::from(self.first.1))
    }

    /// Extends its box to a transition at `(x, y)`.
    #[inline(always)]
    pub fn reach(&mut self, x: u16, y: u16) {
        self.left = self.left.min(x);
        self.right = self.right.max(x);
        self.bottom = y;
    }

    /// The same, or as far where the frame cuts it.
    pub fn is_around(&self, other: &Self) -> bool {
        let reaches = self.left <= other.left && self.right >= other.right && self.top <= other.top;
        self.surrounds(other) || self.cut && reaches
    }

    /// Whether its bounding box reaches beyond that of `other` on the left, right and top.
    pub fn surrounds(&self, other: &Self) -> bool {
        self.left < other.left && self.right > other.right && self.top < other.top
    }
}

/// Table of outlines under way.
#[derive(Debug)]
pub(crate) struct Outlines<'s> {
    slots: &'s mut [Outline],
    /// Slots used at least once; those above need no list to be free.
    touched: u16,
    free: u16,
    joined: u16,
    /// Open outlines that keep crossings.
    keeping: u16,
    /// First and last of those that have closed.
    closed: (u16, u16),
}

impl<'s> Outlines<'s> {
    pub fn new(slots: &'s mut [Outline]) -> Self {
        Self { slots, touched: 0, free: NONE, joined: NONE, keeping: 0, closed: (NONE, NONE) }
    }

    pub fn clear(&mut self) {
        (self.touched, self.free, self.joined, self.closed) = (0, NONE, NONE, (NONE, NONE));
        self.keeping = 0;
    }

    /// Most slots used at a time.
    pub fn used(&self) -> u16 {
        self.touched
    }

    pub fn get(&self, label: u16) -> Option<&Outline> {
        self.slots.get(usize::from(label))
    }

    pub fn get_mut(&mut self, label: u16) -> Option<&mut Outline> {
        self.slots.get_mut(usize::from(label))
    }

    /// Starts an outline with two ends at `(x, y)`. [`NONE`] when the table is full.
    #[inline(never)]
    pub fn open(&mut self, x: u16, y: u16) -> u16 {
        let label = if self.free != NONE {
            let label = self.free;
            self.free = self.get(label).map_or(NONE, |o| o.next);
            label
        } else if usize::from(self.touched) < self.slots.len() {
            self.touched += 1;
            self.touched - 1
        } else {
            return NONE;
        };
        self.keeping += 1;
        if let Some(slot) = self.get_mut(label) {
            *slot = Outline {
                first: (x, y),
                left: x,
                right: x,
                top: y,
                bottom: y,
                crossings: CrossingList::EMPTY,
                ends: 2,
                alias: label,
                next: NONE,
                inner: NONE,
                ..Outline::ZERO
            };
        }
        label
    }

    /// Starts one that no transition belongs to.
    pub fn open_closed(&mut self) -> u16 {
        let label = self.open(0, 0);
        if let Some(outline) = self.get_mut(label) {
            outline.ends = 0;
            self.keeping = self.keeping.saturating_sub(1);
        }
        label
    }

    /// The outline that `label` stands for now.
    pub fn root(&self, mut label: u16) -> u16 {
        // Each joined outline points to one that was alive at that time, so the chain is finite; the bound only makes
        // that plain.
        for _ in 0..=self.slots.len() {
            match self.get(label) {
                Some(outline) if outline.alias != label => label = outline.alias,
                _ => break,
            }
        }
        label
    }

    /// Joins `b` to `a`, both roots and different, in row `y`. The crossings of `b` must have been moved before.
    pub fn join(&mut self, a: u16, b: u16, y: u16) {
        let joined = self.joined;
        let Some(other) = self.get_mut(b) else { return };
        (other.alias, other.next) = (a, joined);
        other.lengthen();
        let other = *other;
        self.joined = b;
        let Some(outline) = self.get_mut(a) else { return };
        // Of two that kept theirs one is left, of one none.
        let keeps = !outline.lossy || !other.lossy;
        outline.lengthen();
        let (dx, dy) = outline.since_first(other.first.0, other.first.1);
        outline.moments.join(&other.moments, (dx.into(), dy.into()));
        // As if the other had been balanced by a transition at its first column, which adds nothing to its own sums.
        let (_, row) = outline.since_first(0, y);
        outline.moments.add_long(other.balance.into(), dx, row);
        outline.balance = outline.balance.wrapping_add(other.balance);
        outline.left = outline.left.min(other.left);
        outline.right = outline.right.max(other.right);
        outline.top = outline.top.min(other.top);
        outline.bottom = outline.bottom.max(other.bottom);
        outline.ends += other.ends;
        outline.cut |= other.cut;
        outline.lossy |= other.lossy;
        self.keeping = self.keeping.saturating_sub(keeps.into());
    }

    /// Open outlines that keep their crossings.
    pub fn keeping(&self) -> u16 {
        self.keeping
    }

    /// Marks an outline that has lost a part. Its crossings, which are of no use then, are to be given back.
    pub fn lose(&mut self, label: u16) -> Option<&mut CrossingList> {
        let outline = self.slots.get_mut(usize::from(label))?;
        if !outline.lossy && outline.ends > 0 {
            self.keeping = self.keeping.saturating_sub(1);
        }
        outline.lossy = true;
        Some(&mut outline.crossings)
    }

    /// Two ends of `label` have met, or one has met the end of an outline that was lost.
    pub fn end(&mut self, label: u16, ends: u16) {
        let Some(outline) = self.get_mut(label) else { return };
        outline.ends = outline.ends.saturating_sub(ends);
        if outline.ends > 0 {
            return;
        }
        outline.next = NONE;
        let keeps = !outline.lossy;
        if keeps && !outline.is_small() {
            outline.lengthen();
            let (x, y) = outline.first;
            outline.moments.close((x.into(), y.into()));
        }
        self.keeping = self.keeping.saturating_sub(keeps.into());
        // In the order of their closing, because an inner outline must be known before the one around it.
        let (first, last) = self.closed;
        match self.get_mut(last) {
            Some(last) if first != NONE => last.next = label,
            _ => self.closed.0 = label,
        }
        self.closed.1 = label;
    }

    /// Whether outlines were joined since the last [`free_joined`](Self::free_joined).
    pub fn any_joined(&self) -> bool {
        self.joined != NONE
    }

    /// Gives back the slots of joined outlines. No transition may carry their labels any more.
    pub fn free_joined(&mut self) {
        while self.joined != NONE {
            let label = self.joined;
            self.joined = self.get(label).map_or(NONE, |o| o.next);
            self.free(label);
        }
    }

    /// The outlines that have closed and were not taken.
    pub fn closed(&self) -> impl Iterator<Item = u16> {
        let (mut at, last) = self.closed;
        core::iter::from_fn(move || {
            let label = at;
            at = if label == last { NONE } else { self.get(label)?.next };
            (label != NONE).then_some(label)
        })
    }

    /// The next of the outlines that have closed, in the order of their closing.
    pub fn take_closed(&mut self) -> Option<u16> {
        let (label, last) = self.closed;
        let next = self.get_mut(label).map(|o| core::mem::replace(&mut o.next, NONE))?;
        self.closed = if label == last { (NONE, NONE) } else { (next, last) };
        Some(label)
    }

    /// Gives a slot back.
    pub fn free(&mut self, label: u16) {
        let free = self.free;
        if let Some(slot) = self.get_mut(label) {
            slot.next = free;
            slot.alias = label;
            slot.crossings = CrossingList::EMPTY;
            self.free = label;
        }
    }

    /// The outline with the most crossings of those that are `wanted`.
    #[inline(never)]
    pub fn largest(&self, wanted: impl Fn(&Outline) -> bool) -> Option<u16> {
        let used = self.slots.get(..usize::from(self.touched))?;
        let wanted = rolled(used.iter().enumerate()).filter(|(_, o)| wanted(o));
        let (label, outline) = wanted.max_by_key(|(_, o)| o.crossings.len())?;
        (outline.crossings.len() > 0).then_some(label as u16)
    }
}
