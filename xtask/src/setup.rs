//! Installs what the steps need, as far as that is possible here.

use std::process::Command;

use anyhow::{Result, bail};

use crate::Root;
use crate::stack;
use crate::steps::{self, Tally, output_of};
use crate::toolchain::{Target, Toolchain};

/// An emulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emulator {
    /// Of 32-bit Arm boards.
    Arm,
    /// Of 32-bit RISC-V boards.
    Riscv32,
}

impl Emulator {
    /// Its program.
    pub fn program(self) -> &'static str {
        match self {
            Self::Arm => "qemu-system-arm",
            Self::Riscv32 => "qemu-system-riscv32",
        }
    }

    /// The package that it is in, by its name in Debian.
    fn package(self) -> &'static str {
        match self {
            Self::Arm => "qemu-system-arm",
            Self::Riscv32 => "qemu-system-misc",
        }
    }

    /// Sees to it that it is there.
    ///
    /// # Errors
    /// It is not and cannot be installed.
    pub fn ensure(self) -> Result<()> {
        let (program, package) = (self.program(), self.package());
        let version = || output_of(Command::new(program).arg("--version"));
        if version().is_none() && !install_packages(&[package]) {
            bail!("no {program}: install it, on Debian or Ubuntu with `apt-get install {package}`");
        }
        if let Some(version) = version() {
            println!("{program}: {}", version.lines().next().unwrap_or_default());
        }
        Ok(())
    }
}

/// Everything that any step needs.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    for component in ["rustfmt", "clippy"] {
        tally.check(ensure_component(root, component));
    }
    for target in Target::ALL {
        tally.check(Toolchain::set_up(target).map(|toolchain| println!("compiler of firmware: {toolchain}")));
    }
    for emulator in [Emulator::Arm, Emulator::Riscv32] {
        tally.check(emulator.ensure());
    }
    tally.check(stack::ensure_disassembler());
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
