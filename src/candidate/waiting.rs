//! Closed outlines that wait until nothing can close around them any more.

use super::{broken, can_be_concentric, concentric, ready_row, shape};
use crate::abilities::ARCS;
use crate::fit::Shape;
use crate::reject::Reject;
use crate::scan::{NONE, Outline, Outlines, Scanner};
use crate::settings::limits;

/// Outlines that wait for one around them: a list through [`Outline::next`]. Each is the head of a chain of concentric ones
/// through [`Outline::inner`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting {
    head: u16,
    /// Searches for arcs that are left in this frame.
    searches: u16,
    /// Outlines that were not searched.
    pub unsearched: u32,
}

impl Waiting {
    /// For a frame of this size.
    pub fn new(width: u16, height: u16) -> Self {
        let share = u32::from(width) * u32::from(height) / limits::PX_PER_SEARCH;
        let searches = (limits::FEW_SEARCHES + share).min(limits::MAX_SEARCHES) as u16;
        Self { head: NONE, searches, unsearched: 0 }
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.head == NONE
    }

    /// Takes a closed outline. An error is the reason why it is none of a target; its slot is then still in use.
    pub fn add(&mut self, label: u16, scanner: &mut Scanner<'_>) -> Result<(), Reject> {
        let outline = *scanner.outlines.get(label).ok_or(Reject::BufferFull)?;
        let alone = outline.is_usable() && self.stays_alone(&outline, scanner);
        if alone && !broken::is_worth_a_search(&outline, Reject::NotElliptic) {
            return Err(Reject::Alone);
        }
        let shape = shape(&outline);
        if alone && shape.is_ok() {
            return Err(Reject::Alone);
        }
        let whole = !ARCS || shape.is_ok_and(|shape| !broken::is_bent(&outline, &shape, &scanner.pool));
        if !whole && self.search(label, &outline, shape.err(), scanner) {
            return Ok(());
        }
        // One that is bent without an arc of another ellipse stays what it is.
        shape.map(|shape| self.insert_ellipse(label, &shape, scanner))
    }

    /// Whether there is nothing that a closed outline could be concentric with: no open outline around it, none about it that
    /// has just closed, and none that waits, of which what is only an arc may be anywhere. Most of clutter is told by that
    /// before anyone looks closer.
    fn stays_alone(&self, outline: &Outline, scanner: &Scanner<'_>) -> bool {
        let outlines = &scanner.outlines;
        let overlaps = |other: &Outline| {
            other.left < outline.right
                && outline.left < other.right
                && other.top <= outline.bottom
                && outline.top <= other.bottom
        };
        let waits = |other: &Outline| other.is_partial() || overlaps(other);
        let around = |other: &Outline| !other.lossy && other.is_around(outline);
        let mut open = scanner.last_transitions().iter().map(|transition| transition.label);
        !(self.labels(outlines).any(|label| outlines.get(label).is_some_and(waits))
            || outlines.closed().any(|label| outlines.get(label).is_some_and(overlaps))
            || open.any(|label| outlines.get(label).is_some_and(around)))
    }

    /// Takes the arcs of an outline that is no ellipse for `cause`. `false` if there are none or none may be looked for.
    fn search(
        &mut self,
        label: u16,
        outline: &Outline,
        cause: Option<Reject>,
        scanner: &mut Scanner<'_>,
    ) -> bool {
        let worth = broken::is_worth_a_search(outline, cause.unwrap_or(Reject::NotElliptic));
        if !worth {
            return false;
        }
        if !self.may_search(scanner) {
            self.unsearched = self.unsearched.saturating_add(1);
            return false;
        }
        self.searches -= 1;
        scanner.budget.take_search();
        broken::add(label, cause.is_none(), self, scanner)
    }

    /// Whether arcs may be looked for.
    fn may_search(&self, scanner: &Scanner<'_>) -> bool {
        ARCS && self.searches > 0 && scanner.budget.has_room_for_search()
    }

    /// Takes an outline that is an ellipse, with what is concentric inside it.
    pub(super) fn insert(&mut self, label: u16, scanner: &mut Scanner<'_>) {
        if let Some(Ok(shape)) = scanner.outlines.get(label).map(shape) {
            self.insert_ellipse(label, &shape, scanner);
        }
    }

    /// The same where its ellipse is known.
    fn insert_ellipse(&mut self, label: u16, shape: &Shape, scanner: &mut Scanner<'_>) {
        let Some(outline) = scanner.outlines.get(label).copied() else { return };
        let width = scanner.width();
        let inside = |inner: &Outline| concentric(&outline, shape, inner, width);
        let mut inner = self.take_inner(inside, &mut scanner.outlines);
        if inner == NONE && !outline.is_partial() {
            inner = self.take_from_arc(inside, &mut scanner.outlines);
        }
        if inner == NONE && self.insert_inside(label, scanner) {
            return;
        }
        let ready = ready_row(&outline, scanner);
        if let Some(outline) = scanner.outlines.get_mut(label) {
            (outline.inner, outline.ready, outline.next) = (inner, ready, self.head);
            self.head = label;
        }
    }

    /// Puts an outline into a chain: an arc, which can be found after what is around it, or a circle around which an arc was
    /// found before it had closed. `false` if it does not belong to any.
    fn insert_inside(&self, label: u16, scanner: &mut Scanner<'_>) -> bool {
        let (width, outlines) = (scanner.width(), &mut scanner.outlines);
        let Some(new) = outlines.get(label).copied() else { return false };
        let around = |head: &Outline| {
            can_be_concentric(head, &new)
                && shape(head).is_ok_and(|shape| concentric(head, &shape, &new, width))
        };
        let Some(mut before) = self.labels(outlines).find(|&head| outlines.get(head).is_some_and(around))
        else {
            return false;
        };
        let larger = |outline: &&Outline| outline.moments.area.abs() > new.moments.area.abs();
        while let Some(inner) = outlines.get(before).map(|outline| outline.inner)
            && outlines.get(inner).filter(larger).is_some()
        {
            before = inner;
        }
        let Some(before) = outlines.get_mut(before) else { return false };
        let inner = core::mem::replace(&mut before.inner, label);
        if let Some(new) = outlines.get_mut(label) {
            new.inner = inner;
        }
        true
    }

    /// The heads of the chains.
    pub(super) fn labels<'o>(&self, outlines: &'o Outlines<'_>) -> impl Iterator<Item = u16> + use<'o> {
        let mut at = self.head;
        core::iter::from_fn(move || {
            let label = at;
            at = outlines.get(label)?.next;
            Some(label)
        })
    }

    /// All outlines of the chains.
    pub(super) fn members<'o>(&self, outlines: &'o Outlines<'_>) -> impl Iterator<Item = u16> + use<'o> {
        self.labels(outlines).flat_map(move |head| {
            let mut at = head;
            core::iter::from_fn(move || {
                let label = at;
                at = outlines.get(label)?.inner;
                Some(label)
            })
        })
    }

    /// The head of a chain that nothing can close around any more after `rows` rows. Where it lacks a circle around it, of
    /// the polarity `dark`, that is looked for in outlines that are still open.
    pub fn take_ready(&mut self, rows: u16, dark: bool, scanner: &mut Scanner<'_>) -> Option<u16> {
        loop {
            let head = self.take(&mut scanner.outlines, |_, outline| outline.ready <= rows)?;
            let outline = *scanner.outlines.get(head)?;
            let complete = outline.inner != NONE && (outline.moments.area > 0) == dark;
            if complete || !self.may_search(scanner) {
                return Some(head);
            }
            let open = broken::open_around(&outline, scanner);
            if open.is_empty() {
                return Some(head);
            }
            self.searches -= 1;
            scanner.budget.take_search();
            match broken::find_around(head, &open, rows, scanner) {
                broken::Around::Nothing => return Some(head),
                broken::Around::Found(outer) => {
                    self.put_back(head, rows, scanner);
                    self.insert(outer, scanner);
                }
                broken::Around::Later(ready) => self.put_back(head, ready, scanner),
            }
        }
    }

    /// Puts the head of a chain back into the list until `ready` rows.
    fn put_back(&mut self, head: u16, ready: u16, scanner: &mut Scanner<'_>) {
        if let Some(outline) = scanner.outlines.get_mut(head) {
            (outline.ready, outline.next) = (ready, self.head);
            self.head = head;
        }
    }

    /// Takes a whole outline that is `concentric`, with what is inside it, out of a chain in which only an arc is around it.
    fn take_from_arc(&self, concentric: impl Fn(&Outline) -> bool, outlines: &mut Outlines<'_>) -> u16 {
        let wanted = |&label: &u16| {
            let Some(arc) = outlines.get(label).filter(|outline| outline.is_partial()) else { return false };
            outlines.get(arc.inner).is_some_and(|inner| !inner.is_partial() && concentric(inner))
        };
        let around = self.members(outlines).find(wanted);
        let arc = around.and_then(|label| outlines.get_mut(label));
        arc.map_or(NONE, |arc| core::mem::replace(&mut arc.inner, NONE))
    }

    /// Takes the largest waiting outline that is `concentric`.
    fn take_inner(&mut self, concentric: impl Fn(&Outline) -> bool, outlines: &mut Outlines<'_>) -> u16 {
        let (mut at, mut best, mut area) = (self.head, NONE, 0);
        while let Some(inner) = outlines.get(at) {
            if inner.moments.area.abs() > area && concentric(inner) {
                (best, area) = (at, inner.moments.area.abs());
            }
            at = inner.next;
        }
        self.take(outlines, |label, _| label == best).unwrap_or(NONE)
    }

    /// Takes the first outline out of the list for which `wanted` holds.
    fn take(&mut self, outlines: &mut Outlines<'_>, wanted: impl Fn(u16, &Outline) -> bool) -> Option<u16> {
        let (mut before, mut at) = (NONE, self.head);
        while let Some(outline) = outlines.get(at) {
            let next = outline.next;
            if wanted(at, outline) {
                match outlines.get_mut(before) {
                    Some(before) => before.next = next,
                    None => self.head = next,
                }
                return Some(at);
            }
            (before, at) = (at, next);
        }
        None
    }
}
