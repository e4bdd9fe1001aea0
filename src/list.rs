//! Lists of fixed capacity from iterators.

use heapless::Vec;

/// The first `N` items. `collect` would panic where there are more, and the linker does not know that there are not.
pub(crate) fn list<T, const N: usize>(items: impl Iterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    for item in items {
        if list.push(item).is_err() {
            break;
        }
    }
    list
}
