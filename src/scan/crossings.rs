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

/// A place where a row or a column passes the threshold, with the grey levels around it.
///
/// The passage is between the pixel `(x, y)` and the one before it on the axis. With `u` counted along the axis from
/// `(x, y)`, the near samples are at u = -2, -1, 0, 1 and the far ones at -4 and 3, where an edge is over.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub x: u16,
    /// Row, with the axis in the top bit.
    y_axis: u16,
    pub near: [u8; 4],
    /// The two far samples until the edge point is placed; then its offset on the axis from `(x, y)`, 1/256 px.
    far: [u8; 2],
    next: u16,
}

const COLUMN: u16 = 1 << 15;

impl Crossing {
    pub const ZERO: Self = Self { x: 0, y_axis: 0, near: [0; 4], far: [0; 2], next: 0 };

    /// `samples` are at u = -4 to 3.
    pub fn new(axis: Axis, x: u16, y: u16, samples: &[u8; 8]) -> Self {
        let y_axis = y | if axis == Axis::Column { COLUMN } else { 0 };
        let [f0, _, n0, n1, n2, n3, _, f1] = *samples;
        let (near, far) = ([n0, n1, n2, n3], [f0, f1]);
        Self { x, y_axis, near, far, next: NONE }
    }

    pub fn y(&self) -> u16 {
        self.y_axis & !COLUMN
    }

    pub fn axis(&self) -> Axis {
        if self.y_axis & COLUMN == 0 { Axis::Row } else { Axis::Column }
    }

    /// The far samples, before the edge point is placed.
    pub fn far(&self) -> [u8; 2] {
        self.far
    }

    /// The edge point's offset on the axis, 1/256 px, after it is placed; `None` where it was refused.
    pub fn offset(&self) -> Option<i16> {
        Some(i16::from_le_bytes(self.far)).filter(|&offset| offset != i16::MIN)
    }

    /// Replaces the far samples, which are spent, by the edge point.
    pub fn place(&mut self, offset: Option<i16>) {
        self.far = offset.unwrap_or(i16::MIN).to_le_bytes();
    }
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
    touched: u16,
    free: u16,
}

impl<'s> Pool<'s> {
    pub fn new(slots: &'s mut [Crossing]) -> Self {
        Self { slots, touched: 0, free: NONE }
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
        (self.touched, self.free) = (0, NONE);
    }

    fn get_mut(&mut self, at: u16) -> Option<&mut Crossing> {
        self.slots.get_mut(usize::from(at))
    }

    /// Appends to `list`. `false` when the pool is full.
    pub fn push(&mut self, list: &mut CrossingList, crossing: Crossing) -> bool {
        let at = if self.free != NONE {
            let at = self.free;
            self.free = self.get_mut(at).map_or(NONE, |c| c.next);
            at
        } else if usize::from(self.touched) < self.slots.len() {
            self.touched += 1;
            self.touched - 1
        } else {
            return false;
        };
        if let Some(slot) = self.get_mut(at) {
            *slot = crossing;
        }
        self.append(list, CrossingList { head: at, tail: at, len: 1 });
        true
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
    pub fn iter(&self, list: CrossingList) -> impl Iterator<Item = &Crossing> {
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
