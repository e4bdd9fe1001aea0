//! The steps that need nothing but the host's toolchain.

use anyhow::Result;

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
