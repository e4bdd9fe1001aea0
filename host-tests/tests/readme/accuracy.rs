//! The accuracy study and the paper, from the pages that the tests `accuracy` and `paper` have checked.

use crate::read;

/// The page of the reduced grid.
const PAGE: &str = "host-tests/golden/accuracy/accuracy.md";

/// Its table of goals.
pub fn goals() -> String {
    let page = read(PAGE);
    let goals = page.split("## Goals\n\n").nth(1).and_then(|rest| rest.split("\n\n").next());
    format!("{}\n", goals.unwrap_or_else(|| panic!("{PAGE} has no goals")))
}

/// The page of the paper.
const PAPER: &str = "host-tests/golden/paper/paper.md";

/// Its short table.
pub fn paper() -> String {
    let page = read(PAPER);
    let short = page.split("## In short\n\n").nth(1).and_then(|rest| rest.split("\n\n").next());
    format!("{}\n", short.unwrap_or_else(|| panic!("{PAPER} has no short table")))
}
