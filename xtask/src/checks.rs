//! The steps that need nothing but the host's toolchain.

use anyhow::Result;

use crate::Root;
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

/// Clippy on everything that compiles for the host; on the library with every feature and with none.
pub fn lint(root: &Root, tally: &mut Tally) -> Result<()> {
    let selections: [&[&str]; 3] = [
        &["--workspace", "--all-targets"],
        &["--package", "concentric", "--all-features"],
        &["--package", "concentric", "--no-default-features"],
    ];
    for selection in selections {
        tally.run(root.cargo(&["clippy", "--quiet"]).args(selection).args(["--", "-D", "warnings"]));
    }
    Ok(())
}

/// Documentation of the library with every feature, and of the desktop side.
pub fn doc(root: &Root, tally: &mut Tally) -> Result<()> {
    // Only libraries: the program's pages would overwrite those of the library, whose name it has.
    let arguments = ["doc", "--quiet", "--workspace", "--lib", "--no-deps", "--all-features"];
    tally.run(root.cargo(&arguments).env("RUSTDOCFLAGS", "-D warnings"));
    Ok(())
}

/// Every test of the workspace, optimised as it is used.
pub fn host(root: &Root, tally: &mut Tally) -> Result<()> {
    tally.run_tests(&mut root.cargo(&["test", "--release", "--workspace", "--no-fail-fast"]))
}
