//! Builds the firmware, looks into its image, runs it in QEMU.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow, ensure};

use crate::Root;
use crate::bench;
use crate::image::{Forbidden, Image};
use crate::package::{NOWHERE, Package};
use crate::setup::Emulator;
use crate::stack;
use crate::steps::Tally;
use crate::toolchain::Target;

/// A board that QEMU emulates, and its firmware.
#[derive(Clone, Copy, Debug)]
struct Board {
    name: &'static str,
    package: Package,
    emulator: Emulator,
    /// Tells the desktop side where the image is.
    elf: &'static str,
}

const AN386: Board = Board {
    name: "mps2-an386",
    package: Package {
        name: "concentric-mps2",
        folder: "examples/mps2",
        target: Target::Armv7Em,
        cpu: None,
        features: &[],
    },
    emulator: Emulator::Arm,
    elf: "CONCENTRIC_MPS2_AN386_ELF",
};
const AN500: Board = Board {
    name: "mps2-an500",
    package: Package { features: &["an500"], ..AN386.package },
    elf: "CONCENTRIC_MPS2_AN500_ELF",
    ..AN386
};
const VIRT: Board = Board {
    name: "riscv-virt",
    package: Package {
        name: "concentric-riscv-softcore",
        folder: "examples/riscv-softcore",
        target: Target::Rv32Imc,
        cpu: None,
        features: &[],
    },
    emulator: Emulator::Riscv32,
    elf: "CONCENTRIC_RISCV_VIRT_ELF",
};
const BOARDS: [Board; 3] = [AN386, AN500, VIRT];

/// The firmware's `Storage`.
const STORAGE: &str = "STORAGE";

/// Builds the firmware and checks its images.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    for board in BOARDS {
        println!("{}:", board.name);
        check(root, board, tally)?;
    }
    Ok(())
}

fn check(root: &Root, board: Board, tally: &mut Tally) -> Result<()> {
    if let Some(mut clippy) = board.package.clippy(root)? {
        tally.run(&mut clippy);
    }
    let elf = board.build(root)?;
    let image = Image::read(&elf)?;
    println!("flash {} bytes, RAM {} bytes", image.flash(), image.ram());
    tally.check(check_storage(&image));
    tally.check(stack::check_room(&elf, &image, board.package.target));
    check_symbols(&image, tally);
    tally.check(board.check_that_a_panic_is_noticed(root));
    Ok(())
}

/// Checks that an image has no panics, no heap and no 64-bit floats.
pub fn check_symbols(image: &Image, tally: &mut Tally) {
    for kind in Forbidden::ALL {
        let found = image.find(kind);
        println!("{kind} symbols: {}", found.len());
        let verdict =
            if found.is_empty() { Ok(()) } else { Err(anyhow!("{kind}:\n  {}", found.join("\n  "))) };
        tally.check(verdict);
    }
}

/// Runs the firmware in QEMU: the kernels of every processor must give what their models do, and the same frames the same
/// bytes as on the desktop.
pub fn qemu_step(root: &Root, tally: &mut Tally) -> Result<()> {
    bench::compare_kernels(root, tally)?;
    let mut test = root.cargo(&[
        "test",
        "--release",
        "--package",
        "concentric-host",
        "--test",
        "heads",
        "--",
        "--ignored",
    ]);
    for board in BOARDS {
        board.emulator.ensure()?;
        test.env(board.elf, board.build(root)?);
    }
    tally.run_tests(&mut test)
}

/// Runs the firmware for a user who reads its serial port.
pub fn play(root: &Root, arguments: &[String]) -> Result<ExitCode> {
    let manifest = root.folder.join("Cargo.toml");
    let mut play = root.cargo(&["run", "--quiet", "--release", "--manifest-path"]);
    play.arg(manifest).args(["--package", "concentric-host", "--example", "mps2", "--"]).args(arguments);
    // The user's files are named from where the user is.
    play.current_dir(env::current_dir()?);
    if !arguments.iter().any(|argument| ["-h", "--help"].contains(&argument.as_str())) {
        AN386.emulator.ensure()?;
        play.env(AN386.elf, AN386.build(root)?);
    }
    let status = play.status().context("cannot run cargo")?;
    Ok(ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1)))
}

impl Board {
    /// Builds the image.
    fn build(&self, root: &Root) -> Result<PathBuf> {
        let elf = self.package.build(root)?;
        // Under a name of its own: boards of one package differ in features only.
        let image = root.target.join("firmware").join(self.name).with_extension("elf");
        fs::copy(&elf, &image).with_context(|| format!("cannot copy {}", elf.display()))?;
        Ok(image)
    }

    /// Builds the firmware with a panic in it, which must not link.
    fn check_that_a_panic_is_noticed(&self, root: &Root) -> Result<()> {
        let output =
            self.package.cargo(root, "build")?.args(["--quiet", "--features", "reachable-panic"]).output()?;
        let message = String::from_utf8_lossy(&output.stderr);
        ensure!(!output.status.success(), "the firmware with a reachable panic links");
        ensure!(
            message.contains(NOWHERE),
            "the firmware with a reachable panic fails for another reason:\n{message}"
        );
        println!("a reachable panic keeps the firmware from linking");
        Ok(())
    }
}

fn check_storage(image: &Image) -> Result<()> {
    let storage = image.variable(STORAGE).with_context(|| format!("no variable {STORAGE} in the image"))?;
    println!("{STORAGE}: {} bytes in {}", storage.size, storage.section);
    ensure!(storage.section == ".bss", "{STORAGE} is in {}: its start value takes flash", storage.section);
    Ok(())
}
