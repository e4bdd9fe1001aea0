//! Outlines that are no ellipse: the arcs of circles in them.

use core::hint::black_box;

use super::{Waiting, origin, set_arc, shape};
use crate::arcs::{self, Arc, Points};
use crate::fit::Shape;
use crate::list::rolled;
use crate::reject::Reject;
use crate::scan::{CrossingList, NONE, Outline, Pool, Scanner, Seen};
use crate::settings::limits;
use heapless::Vec;

/// Most arcs taken out of one outline.
const MAX_ARCS: usize = 4;
/// Most waiting outlines whose circles are looked for in another one.
const MAX_ANCHORS: usize = 4;
/// Most open outlines that are searched for what is around a waiting one.
const MAX_OPEN: usize = 3;
/// An outline is whole though noise bends it if an arc leaves no more than one crossing for so many that it takes.
const LEFT: u16 = 10;
/// Fewest crossings of an outline in which any arc is looked for, and in which one concentric with a known circle is.
const MIN_CROSSINGS: u16 = 20;
const MIN_CROSSINGS_AROUND: u16 = 12;
/// Smallest larger side of the box of an outline with an arc that is worth it, px.
const MIN_EXTENT: u16 = 9;
/// Two arcs can be of the same circle if their areas squared have this ratio or less, because an arc alone leaves its ellipse
/// unsure, ...
const LIKE_DET: f32 = 8.0;
/// ... if their centres are not farther apart than this, in units of the ellipse, ...
const LIKE_CENTRE: f32 = 1.0;
/// ... and at least this share of their points lies on one ellipse.
const SAME_SHARE: f32 = 0.85;

/// Whether an outline that was refused for `cause` can have arcs of circles.
pub(super) fn is_worth_a_search(outline: &Outline, cause: Reject) -> bool {
    matches!(cause, Reject::NotElliptic | Reject::CutByFrame)
        && !outline.lossy
        && outline.crossings.len() >= MIN_CROSSINGS
        && outline.width().min(outline.height()) >= limits::MIN_EXTENT
        && outline.width().max(outline.height()) >= MIN_EXTENT
}

/// Whether an outline with the moments of the ellipse `shape` has a dent or a bump all the same.
pub(super) fn is_bent(outline: &Outline, shape: &Shape, pool: &Pool<'_>) -> bool {
    let arc = Arc { shape: *shape, dark_inside: outline.moments.area > 0 };
    arcs::are_off(&arc, outline.crossings, pool, origin(outline))
}

/// Takes the arcs of the outline as outlines of their own, the first in its slot. `false`, and the outline is as it was, if
/// there are none, or if nothing else is left of one that is an ellipse.
pub(super) fn add(label: u16, is_ellipse: bool, waiting: &mut Waiting, scanner: &mut Scanner<'_>) -> bool {
    let Some(outline) = scanner.outlines.get_mut(label) else { return false };
    let mut list = core::mem::replace(&mut outline.crossings, CrossingList::EMPTY);
    let outline = *outline;
    let about = origin(&outline);
    let mut anchors = anchors(&outline, waiting, scanner);
    let (mut found, mut slot) = (0, label);
    let mut placed = Vec::<(Arc, CrossingList, u16), MAX_ARCS>::new();
    while found < MAX_ARCS {
        let Some((arc, mut taken)) = next_arc(&mut list, &anchors, found == 0, about, scanner) else { break };
        if is_ellipse && found == 0 && LEFT * list.len() <= taken.len() {
            scanner.pool.append(&mut taken, list);
            list = taken;
            break;
        }
        found += 1;
        let joined = join(&arc, taken, about, waiting, scanner);
        let _ = anchors.push(joined.unwrap_or(arc));
        if joined.is_none() {
            let label =
                if slot == NONE { scanner.open_outline() } else { core::mem::replace(&mut slot, NONE) };
            place(label, &arc, taken, about, scanner);
            waiting.insert(label, scanner);
            let _ = placed.push((arc, taken, label));
        }
    }
    mark_open(&placed, list, about, scanner);
    if found == 0 {
        if let Some(outline) = scanner.outlines.get_mut(label) {
            outline.crossings = list;
        }
        return false;
    }
    scanner.pool.free(&mut list);
    if slot != NONE {
        scanner.outlines.free(slot);
    }
    true
}

/// Marks the outer circle of an open ring in whose gap nothing lies.
fn mark_open(
    placed: &[(Arc, CrossingList, u16)],
    rest: CrossingList,
    about: (u16, u16),
    scanner: &mut Scanner<'_>,
) {
    let [(a, a_list, a_label), (b, b_list, b_label), ..] = placed else { return };
    let a_is_outer = a.shape.det() < b.shape.det();
    let circles = if a_is_outer { [(a, *a_list), (b, *b_list)] } else { [(b, *b_list), (a, *a_list)] };
    if a.dark_inside != b.dark_inside && arcs::shows_paper(circles, rest, &scanner.pool, about) {
        let outer = if a_is_outer { *a_label } else { *b_label };
        if let Some(outer) = scanner.outlines.get_mut(outer) {
            outer.seen = Seen::Open;
        }
    }
}

/// The circles of waiting outlines inside the box of `outline`, about its origin, the newest last.
fn anchors(
    outline: &Outline,
    waiting: &Waiting,
    scanner: &Scanner<'_>,
) -> Vec<Arc, { MAX_ANCHORS + MAX_ARCS }> {
    let about = origin(outline);
    let mut anchors = Vec::new();
    for head in waiting.labels(&scanner.outlines) {
        let inside = |head: &&Outline| {
            let (x, y) = origin(head);
            (outline.left..outline.right).contains(&x) && (outline.top..=outline.bottom).contains(&y)
        };
        let head = scanner.outlines.get(head).filter(inside);
        if anchors.len() < MAX_ANCHORS
            && let Some(arc) = head.and_then(|head| arc_of(head, about))
        {
            let _ = anchors.push(arc);
        }
    }
    let mut rest = anchors.as_mut_slice();
    // As `reverse`, which would be unrolled.
    while let [first, between @ .., last] = rest {
        core::mem::swap(first, black_box(last));
        rest = between;
    }
    anchors
}

/// The ellipse of an outline about `about`.
fn arc_of(outline: &Outline, about: (u16, u16)) -> Option<Arc> {
    let arc = Arc { shape: shape(outline).ok()?, dark_inside: outline.moments.area > 0 };
    Some(arc.moved(origin(outline), about))
}

/// Takes the crossings of one more arc out of `list`: of a circle concentric with one of the anchors, the last first, or of
/// `any`.
fn next_arc(
    list: &mut CrossingList,
    anchors: &[Arc],
    any: bool,
    about: (u16, u16),
    scanner: &mut Scanner<'_>,
) -> Option<(Arc, CrossingList)> {
    let pool = &mut scanner.pool;
    for anchor in anchors.iter().rev() {
        if let Some(arc) = arcs::around(anchor, *list, pool, about)
            && let Some(taken) = arcs::take(&arc, list, (pool, about), limits::MIN_SEEN_AROUND)
        {
            return Some((arc, taken));
        }
    }
    if !any {
        return None;
    }
    let arc = arcs::free(Points::few(*list, pool, about))?;
    let taken = arcs::take(&arc, list, (pool, about), limits::MIN_SEEN)?;
    Some((arc, taken))
}

/// Makes the outline in slot `label` that of `arc`.
fn place(label: u16, arc: &Arc, mut taken: CrossingList, about: (u16, u16), scanner: &mut Scanner<'_>) {
    let frame = (scanner.width(), scanner.height());
    match scanner.outlines.get_mut(label) {
        Some(outline) => {
            set_arc(outline, arc, about, frame);
            outline.crossings = taken;
        }
        None => scanner.pool.free(&mut taken),
    }
}

/// Adds an arc to a waiting one of the same circle. Gives the ellipse of both; `None` if there is none.
fn join(
    arc: &Arc,
    taken: CrossingList,
    about: (u16, u16),
    waiting: &Waiting,
    scanner: &mut Scanner<'_>,
) -> Option<Arc> {
    let frame = (scanner.width(), scanner.height());
    let Scanner { outlines, pool, .. } = scanner;
    let like = |outline: &Outline| {
        let Some(other) = arc_of(outline, about).filter(|_| outline.is_partial()) else { return false };
        let (dx, dy) = (arc.shape.cx - other.shape.cx, arc.shape.cy - other.shape.cy);
        let ratio = other.shape.det() / arc.shape.det();
        other.dark_inside == arc.dark_inside
            && (1.0 / LIKE_DET..LIKE_DET).contains(&ratio)
            && other.shape.square(dx, dy) < LIKE_CENTRE * LIKE_CENTRE
    };
    let labels = waiting.members(outlines).filter(|&label| outlines.get(label).is_some_and(like));
    let both = |label| {
        let mut joined = outlines.get(label)?.crossings;
        pool.append(&mut joined, taken);
        let points = Points::few(joined, pool, about);
        Some((label, joined, arcs::common(&points, arc.dark_inside, SAME_SHARE)?))
    };
    let (label, joined, arc) = labels.take(MAX_ANCHORS).find_map(both)?;
    let outline = outlines.get_mut(label)?;
    // No longer open: two pieces with something between them.
    set_arc(outline, &arc, about, frame);
    outline.crossings = joined;
    Some(arc)
}

/// What [`find_around`] came to.
pub(super) enum Around {
    Nothing,
    /// The label of the outline around, which has the other as its inner one.
    Found(u16),
    /// There is one, but it is not complete before this number of rows.
    Later(u16),
}

/// Looks in the outlines `open` after `rows` rows for a circle around the waiting outline `label`.
pub(super) fn find_around(label: u16, open: &[u16], rows: u16, scanner: &mut Scanner<'_>) -> Around {
    let Some(inner) = scanner.outlines.get(label) else { return Around::Nothing };
    let about = origin(inner);
    let Some(anchor) = arc_of(inner, about) else { return Around::Nothing };
    for &open in open {
        let Some(outline) = scanner.outlines.get(open).copied() else { continue };
        let mut list = outline.crossings;
        let arc = arcs::around(&anchor, list, &scanner.pool, about);
        let Some(arc) = arc.filter(|arc| arc.shape.det() < anchor.shape.det()) else {
            continue;
        };
        let bottom = f32::from(about.1) + arc.shape.cy + arc.shape.extent().1;
        if rows < scanner.height() && bottom as u16 >= rows && (bottom as u16) < scanner.height() {
            return Around::Later((bottom as u16).saturating_add(4));
        }
        let pool = &mut scanner.pool;
        let Some(taken) = arcs::take(&arc, &mut list, (pool, about), limits::MIN_SEEN_AROUND) else {
            continue;
        };
        if let Some(outline) = scanner.outlines.get_mut(open) {
            outline.crossings = list;
        }
        let outer = scanner.open_outline();
        place(outer, &arc, taken, about, scanner);
        return if outer == NONE { Around::Nothing } else { Around::Found(outer) };
    }
    Around::Nothing
}

/// Labels of the open outlines whose boxes surround that of `inner` and that have enough crossings.
pub(super) fn open_around(inner: &Outline, scanner: &Scanner<'_>) -> Vec<u16, MAX_OPEN> {
    let mut open = Vec::new();
    for transition in rolled(scanner.last_transitions()) {
        let around = |outline: &Outline| {
            outline.is_around(inner) && !outline.lossy && outline.crossings.len() >= MIN_CROSSINGS_AROUND
        };
        let label = transition.label;
        if scanner.outlines.get(label).is_some_and(around) && rolled(&open).all(|other| *other != label) {
            let _ = open.push(label);
        }
    }
    open
}
