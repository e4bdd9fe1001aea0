//! The pool of crossings: edge profiles kept until the levels of their target are known.

use super::outlines::NONE;

/// Direction in which a crossing's samples lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    /// Along a row; the edge is steep.
    Row,
    /// Along a column; the edge is flat.
    Column,
}

/// The sum of the levels of a stretch of 1, 2, 4, 8 or 16 pixels that leads away from an edge. Not rounded, because the mean
/// of many pixels has less noise than a whole level needs to stay unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stretch(u16);

impl Stretch {
    /// Bits of the sum; above it is the binary logarithm of the number of pixels.
    const BITS: u32 = 12;

    /// All of `levels`; `log` is the binary logarithm of their number.
    #[inline]
    pub fn of(levels: &[u8], log: u32) -> Self {
        let (fours, rest) = levels.as_chunks::<4>();
        let sum = |levels: &[u8]| levels.iter().fold(0, |sum, &level| sum + u32::from(level));
        let sum = fours.iter().fold(sum(rest), |all, four| all + sum(four));
        Self((sum | log << Self::BITS) as u16)
    }

    /// Of one pixel.
    pub fn of_one(level: u8) -> Self {
        Self(level.into())
    }

    /// Only the nearest of its pixels if the scale ends at the farthest but not there: then only that tells the light.
    pub fn unless_clipped(self, nearest: u8, farthest: u8) -> Self {
        let clipped = |level: u8| !(END..=255 - END).contains(&level);
        if clipped(farthest) && !clipped(nearest) { Self::of_one(nearest) } else { self }
    }

    /// Binary logarithm of the number of pixels, and the sum of their levels.
    pub fn sum(self) -> (u32, u16) {
        (u32::from(self.0 >> Self::BITS), self.0 & ((1 << Self::BITS) - 1))
    }

    /// Number of pixels, and their mean level.
    pub fn mean(self) -> (f32, f32) {
        let (log, sum) = self.sum();
        let pixels = f32::from(1u16 << log);
        (pixels, f32::from(sum) / pixels)
    }
}

/// Near samples of a crossing.
pub(crate) const NEAR: usize = 6;
/// Levels from either end of the scale that noise clips, grey levels.
const END: u8 = 4;

/// The binary logarithm of the most pixels that a stretch can have where `clear` are there; at least one.
pub(super) fn log_length(clear: usize) -> u32 {
    match clear {
        0..2 => 0,
        2..4 => 1,
        4..8 => 2,
        8..16 => 3,
        _ => 4,
    }
}

/// A place where a row or a column passes the threshold, with the grey levels around it.
///
/// The passage is between the pixel `(x, y)` and the one before it on the axis. With `u` counted along the axis from
/// `(x, y)`, the near samples are at u = -3 to 2 and the far stretches begin at -4 and 3, where an edge is over, and
/// lead away from it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub x: u16,
    /// Row, with the axis in the top bit.
    y_axis: u16,
    pub near: [u8; NEAR],
    /// The far stretches until the edge point is placed; then that.
    far: [Stretch; 2],
    next: u16,
}

const COLUMN: u16 = 1 << 15;

impl Crossing {
    pub const ZERO: Self = Self { x: 0, y_axis: 0, near: [0; NEAR], far: [Stretch(0); 2], next: 0 };

    pub fn new(axis: Axis, (x, y): (u16, u16), near: [u8; NEAR], far: [Stretch; 2]) -> Self {
        let y_axis = y | if axis == Axis::Column { COLUMN } else { 0 };
        Self { x, y_axis, near, far, next: NONE }
    }

    pub fn y(&self) -> u16 {
        self.y_axis & !COLUMN
    }

    pub fn axis(&self) -> Axis {
        if self.y_axis & COLUMN == 0 { Axis::Row } else { Axis::Column }
    }

    /// Whether light follows dark along the axis.
    #[inline(always)]
    pub fn is_rising(&self) -> bool {
        let [_, a, b, c, d, _] = self.near.map(i32::from);
        c + d > a + b
    }

    /// The middle between its inner samples about an origin, px / 2.
    #[inline(always)]
    pub fn middle(&self, origin: (u16, u16)) -> (i32, i32) {
        let x = 2 * (i32::from(self.x) - i32::from(origin.0));
        let y = 2 * (i32::from(self.y()) - i32::from(origin.1));
        if self.axis() == Axis::Row { (x - 1, y) } else { (x, y - 1) }
    }

    /// The far stretches, before the edge point is placed.
    pub fn far(&self) -> [Stretch; 2] {
        self.far
    }

    /// The edge point after it is placed; `None` where it was refused.
    pub fn edge_point(&self) -> Option<EdgePoint> {
        let [Stretch(offset), Stretch(other)] = self.far;
        let ([excess, misfit], offset) = (other.to_le_bytes(), offset as i16);
        (offset != i16::MIN).then_some(EdgePoint { offset, excess: excess as i8, misfit })
    }

    /// Replaces the far stretches, which are spent, by the edge point.
    pub fn place(&mut self, placed: Option<EdgePoint>) {
        let EdgePoint { offset, excess, misfit } =
            placed.unwrap_or(EdgePoint { offset: i16::MIN, excess: 0, misfit: 0 });
        self.far = [Stretch(offset as u16), Stretch(u16::from_le_bytes([excess as u8, misfit]))];
    }
}

/// Where the edge passes at a crossing. Lightness in 1/256 of the contrast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EdgePoint {
    /// On the axis from the crossing's pixel, 1/256 px.
    pub offset: i16,
    /// Lightness beside the edge beyond what the target's levels give.
    pub excess: i8,
    /// Largest difference of a sample from the edge's profile.
    pub misfit: u8,
}

/// The crossings of an outline: a list in the pool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CrossingList {
    head: u16,
    tail: u16,
    len: u16,
}

impl CrossingList {
    pub const ZERO: Self = Self { head: 0, tail: 0, len: 0 };
    pub const EMPTY: Self = Self { head: NONE, tail: NONE, len: 0 };

    pub fn len(&self) -> u16 {
        self.len
    }
}

/// Pool shared by all outlines.
#[derive(Debug)]
pub(crate) struct Pool<'s> {
    slots: &'s mut [Crossing],
    /// Slots used at least once; those above need no list to be free.
    touched: u16,
    /// First free slot. The last in their list is the first that was never used, or where there is none the end.
    free: u16,
}

impl<'s> Pool<'s> {
    pub fn new(slots: &'s mut [Crossing]) -> Self {
        Self { slots, touched: 0, free: 0 }
    }

    /// Slots.
    pub fn capacity(&self) -> usize {
        self.slots.len()
    }

    /// Most slots used at a time.
    pub fn used(&self) -> u16 {
        self.touched
    }

    pub fn clear(&mut self) {
        (self.touched, self.free) = (0, 0);
    }

    fn get_mut(&mut self, at: u16) -> Option<&mut Crossing> {
        self.slots.get_mut(usize::from(at))
    }

    /// Whether there is no slot left.
    pub fn is_full(&self) -> bool {
        usize::from(self.free) >= self.slots.len()
    }

    /// Appends a slot to `list`. `None` when the pool is full.
    #[inline(always)]
    pub fn push(&mut self, list: &mut CrossingList) -> Option<&mut Crossing> {
        let at = self.free;
        let next = self.slots.get(usize::from(at))?.next;
        if at == self.touched {
            self.touched += 1;
            self.free = self.touched;
        } else {
            self.free = next;
        }
        if list.len == 0 {
            list.head = at;
        } else if let Some(last) = self.get_mut(list.tail) {
            last.next = at;
        }
        list.tail = at;
        list.len += 1;
        self.get_mut(at)
    }

    /// Moves all of `other` to the end of `list`.
    pub fn append(&mut self, list: &mut CrossingList, other: CrossingList) {
        if other.len == 0 {
            return;
        }
        match self.get_mut(list.tail) {
            Some(last) if list.len > 0 => last.next = other.head,
            _ => list.head = other.head,
        }
        list.tail = other.tail;
        list.len += other.len;
    }

    /// Parts `list` into those that are `wanted` and the others, both in their order.
    pub fn split(
        &mut self,
        list: CrossingList,
        wanted: impl Fn(&Crossing) -> bool,
    ) -> (CrossingList, CrossingList) {
        let (mut yes, mut no) = (CrossingList::EMPTY, CrossingList::EMPTY);
        let mut at = list.head;
        for _ in 0..list.len {
            let Some(crossing) = self.get_mut(at) else { break };
            let next = crossing.next;
            let into = if wanted(crossing) { &mut yes } else { &mut no };
            self.append(into, CrossingList { head: at, tail: at, len: 1 });
            at = next;
        }
        (yes, no)
    }

    /// Gives all of `list` back.
    pub fn free(&mut self, list: &mut CrossingList) {
        let free = self.free;
        if list.len > 0
            && let Some(last) = self.get_mut(list.tail)
        {
            last.next = free;
            self.free = list.head;
        }
        *list = CrossingList::EMPTY;
    }

    /// The crossings of `list`.
    pub fn iter(&self, list: CrossingList) -> impl Iterator<Item = &Crossing> + Clone {
        let mut at = list.head;
        (0..list.len).map_while(move |_| {
            let crossing = self.slots.get(usize::from(at))?;
            at = crossing.next;
            Some(crossing)
        })
    }

    /// Calls `f` with each crossing of `list`.
    pub fn for_each_mut(&mut self, list: CrossingList, mut f: impl FnMut(&mut Crossing)) {
        let mut at = list.head;
        for _ in 0..list.len {
            let Some(crossing) = self.slots.get_mut(usize::from(at)) else { return };
            at = crossing.next;
            f(crossing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_has_the_mean_of_the_pixels_that_fit() {
        for (given, used) in [(1u8, 1u8), (2, 2), (3, 2), (4, 4), (7, 4), (15, 8), (16, 16), (40, 16)] {
            let levels: [u8; 40] = core::array::from_fn(|i| 100 + i as u8);
            let log = log_length(given.into());
            let stretch = Stretch::of(&levels[..1 << log], log);
            assert_eq!(stretch.mean(), (f32::from(used), 100.0 + 0.5 * f32::from(used - 1)));
        }
        assert_eq!(Stretch::of(&[255; 16], 4).mean(), (16.0, 255.0));
        assert_eq!((log_length(0), Stretch::of(&[9], 0).mean()), (0, (1.0, 9.0)));
    }

    #[test]
    fn a_crossing_keeps_place_and_stretches_apart() {
        let far = [Stretch::of(&[200; 16], 4), Stretch::of(&[40, 41], 1)];
        let mut crossing = Crossing::new(Axis::Column, (4095, 16383), [1, 2, 3, 4, 5, 6], far);
        assert_eq!((crossing.x, crossing.y(), crossing.axis()), (4095, 16383, Axis::Column));
        assert_eq!(crossing.far(), far);
        let point = EdgePoint { offset: -300, excess: -7, misfit: 200 };
        crossing.place(Some(point));
        assert_eq!(crossing.edge_point(), Some(point));
        crossing.place(None);
        assert_eq!(crossing.edge_point(), None);
    }
}
