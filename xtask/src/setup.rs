//! Installs what the steps need, as far as that is possible here.

use std::process::Command;

use anyhow::{Result, bail};

use crate::Root;
use crate::steps::{self, Tally, output_of};
use crate::toolchain::Toolchain;

/// The emulator.
const QEMU: &str = "qemu-system-arm";

/// Everything that any step needs.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    for component in ["rustfmt", "clippy"] {
        tally.check(ensure_component(root, component));
    }
    tally.check(Toolchain::set_up().map(|toolchain| println!("compiler of the firmware: {toolchain}")));
    tally.check(ensure_qemu());
    Ok(())
}

/// QEMU for Arm.
///
/// # Errors
/// It is not there and cannot be installed.
pub fn ensure_qemu() -> Result<()> {
    let version = || output_of(Command::new(QEMU).arg("--version"));
    if version().is_none() && !install_packages(&[QEMU]) {
        bail!("no {QEMU}: install it, on Debian or Ubuntu with `apt-get install {QEMU}`");
    }
    if let Some(version) = version() {
        println!("emulator: {}", version.lines().next().unwrap_or_default());
    }
    Ok(())
}

/// Installs packages of the distribution; whether that was possible. It takes root and apt-get.
pub fn install_packages(packages: &[&str]) -> bool {
    if output_of(Command::new("id").arg("-u")).as_deref() != Some("0") {
        return false;
    }
    let apt = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments).args(["-y", "-qq"]);
        steps::run(&mut command).is_ok()
    };
    apt(&["update"]) && apt(&[&["install", "--no-install-recommends"], packages].concat())
}

fn ensure_component(root: &Root, component: &str) -> Result<()> {
    let subcommand = if component == "rustfmt" { "fmt" } else { component };
    if output_of(&mut root.cargo(&[subcommand, "--version"])).is_none()
        && steps::run(Command::new("rustup").args(["component", "add", component])).is_err()
    {
        bail!("no {component}: install it, with rustup by `rustup component add {component}`");
    }
    Ok(())
}
