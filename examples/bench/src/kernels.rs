//! The kernels of this processor, compared with models of them.

use core::fmt::Write as _;

use concentric::agree;

use crate::Console;

/// Prints a line for each comparison: results compared, and how many of them differ, as they are and with a flaw in what the
/// kernels are given. `None` if one differs, or if the flaw is not noticed.
pub fn agree() -> Option<()> {
    let mut good = true;
    for (name, compare) in agree::ALL {
        let (found, flawed) = (compare(false), compare(true));
        good &= found.compared > 0 && found.different == 0 && flawed.different > 0;
        let (compared, different, noticed) = (found.compared, found.different, flawed.different);
        writeln!(Console, "{name}: {compared} compared, {different} differ; with a flaw {noticed}").ok()?;
    }
    good.then_some(())
}
