//! The steps that need nothing but the host's toolchain.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use crate::Root;
use crate::bench::FEATURES;
use crate::steps::Tally;

/// Is the code formatted?
pub fn fmt(root: &Root, tally: &mut Tally) -> Result<()> {
    tally.run(&mut root.cargo(&["fmt", "--all", "--check"]));
    for package in ["embassy-line", "mailbox-head", "mps2", "riscv-softcore", "rp2350", "stm32h7"] {
        let manifest = format!("examples/{package}/Cargo.toml");
        tally.run(&mut root.cargo(&["fmt", "--manifest-path", &manifest, "--check"]));
    }
    Ok(())
}

/// Clippy on everything that compiles for the host; on the library with every feature, with none, and with each that takes
/// flash alone.
pub fn lint(root: &Root, tally: &mut Tally) -> Result<()> {
    let selections =
        [vec!["--workspace", "--all-targets"], vec!["--package", "concentric", "--all-features"], lean(None)];
    for selection in selections.into_iter().chain(FEATURES.map(|feature| lean(Some(feature)))) {
        tally.run(root.cargo(&["clippy", "--quiet"]).args(selection).args(["--", "-D", "warnings"]));
    }
    let mut too_long = Vec::new();
    find_too_long(&root.folder, &mut too_long)?;
    let is_good = too_long.is_empty();
    tally.check(
        is_good.then_some(()).with_context(|| format!("{MAX_LINES} lines or more: {}", too_long.join(", "))),
    );
    Ok(())
}

/// Lines that a source file must not reach.
const MAX_LINES: usize = 400;

/// The source files in `folder` and below that reach [`MAX_LINES`].
fn find_too_long(folder: &Path, too_long: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            find_too_long(&path, too_long)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let lines = fs::read_to_string(&path)?.lines().count();
            if lines >= MAX_LINES {
                too_long.push(format!("{} ({lines})", path.display()));
            }
        }
    }
    Ok(())
}

/// Selects the library with this feature only, or with none.
fn lean(feature: Option<&'static str>) -> Vec<&'static str> {
    let mut selection = vec!["--package", "concentric", "--no-default-features"];
    selection.extend(feature.into_iter().flat_map(|feature| ["--features", feature]));
    selection
}

/// Documentation of the library with every feature, and of the desktop side.
pub fn doc(root: &Root, tally: &mut Tally) -> Result<()> {
    // Only libraries: the program's pages would overwrite those of the library, whose name it has.
    let arguments = ["doc", "--quiet", "--workspace", "--lib", "--no-deps", "--all-features"];
    tally.run(root.cargo(&arguments).env("RUSTDOCFLAGS", "-D warnings"));
    Ok(())
}

/// Every test of the workspace, optimised as it is used; those of the library also with none of the features that take flash
/// and with each alone.
pub fn host(root: &Root, tally: &mut Tally) -> Result<()> {
    tally.run_tests(&mut root.cargo(&["test", "--release", "--workspace", "--no-fail-fast"]))?;
    for feature in [None].into_iter().chain(FEATURES.map(Some)) {
        tally.run_tests(root.cargo(&["test", "--release", "--lib"]).args(lean(feature)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_that_are_too_long_are_named() {
        let folder = std::env::temp_dir().join(format!("concentric-lines-{}", std::process::id()));
        fs::create_dir_all(folder.join("below/target")).unwrap();
        for (name, lines) in
            [("a.rs", 399), ("below/b.rs", 400), ("below/c.txt", 900), ("below/target/d.rs", 900)]
        {
            fs::write(folder.join(name), "\n".repeat(lines)).unwrap();
        }
        let mut too_long = Vec::new();
        find_too_long(&folder, &mut too_long).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(too_long.len(), 1);
        assert!(too_long[0].ends_with("b.rs (400)"), "{too_long:?}");
    }
}
