//! The accuracy study, from the page that the test `accuracy` has checked.

use crate::read;

/// The page of the reduced grid.
const PAGE: &str = "host-tests/golden/accuracy/accuracy.md";

/// Its table of goals.
pub fn goals() -> String {
    let page = read(PAGE);
    let goals = page.split("## Goals\n\n").nth(1).and_then(|rest| rest.split("\n\n").next());
    format!("{}\n", goals.unwrap_or_else(|| panic!("{PAGE} has no goals")))
}
