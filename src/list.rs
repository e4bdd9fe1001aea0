//! Lists of fixed capacity from iterators, and iterators for code that runs seldom.

use heapless::Vec;

/// The first `N` items. `collect` would panic where there are more, and the linker does not know that there are not.
pub(crate) fn list<T, const N: usize>(items: impl Iterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    for item in rolled(items) {
        if list.push(item).is_err() {
            break;
        }
    }
    list
}

/// The items in a loop that is not unrolled. Copies of a loop for a handful of items take flash, and the time that they save is lost
/// again where what is left over is sorted out.
#[inline(always)]
pub(crate) fn rolled<T>(items: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    // No instruction: it only keeps the compiler from copying what it is in.
    items.into_iter().inspect(|_| core::hint::black_box(()))
}
