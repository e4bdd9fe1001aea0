//! Builds the firmware, looks into its image, runs it in QEMU.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, anyhow, ensure};

use crate::Root;
use crate::image::{Forbidden, Image};
use crate::setup::Emulator;
use crate::steps::{self, Tally, output_of};
use crate::toolchain::{Target, Toolchain};

/// A board that QEMU emulates, and its firmware.
#[derive(Clone, Copy, Debug)]
struct Board {
    name: &'static str,
    /// Folder in `examples`; the package has its name with `concentric-` in front.
    folder: &'static str,
    features: &'static [&'static str],
    target: Target,
    emulator: Emulator,
    /// Tells the desktop side where the image is.
    elf: &'static str,
}

const AN386: Board = Board {
    name: "mps2-an386",
    folder: "mps2",
    features: &[],
    target: Target::Armv7Em,
    emulator: Emulator::Arm,
    elf: "CONCENTRIC_MPS2_AN386_ELF",
};
const AN500: Board =
    Board { name: "mps2-an500", features: &["an500"], elf: "CONCENTRIC_MPS2_AN500_ELF", ..AN386 };
const VIRT: Board = Board {
    name: "riscv-virt",
    folder: "riscv-softcore",
    features: &[],
    target: Target::Rv32Imc,
    emulator: Emulator::Riscv32,
    elf: "CONCENTRIC_RISCV_VIRT_ELF",
};
const BOARDS: [Board; 3] = [AN386, AN500, VIRT];

/// The function that the panic handler calls and that does not exist.
const NOWHERE: &str = "a_panic_is_reachable";
/// The firmware's `Storage`.
const STORAGE: &str = "STORAGE";

/// Builds the firmware and checks its images.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    for board in BOARDS {
        println!("{}:", board.name);
        check(root, board, tally)?;
    }
    tally.check(check_logs(root));
    Ok(())
}

/// The library with its logs; a link would need somewhere for them to go.
fn check_logs(root: &Root) -> Result<()> {
    let mut command = Toolchain::find(AN386.target)?.cargo("check")?;
    command.current_dir(&root.folder).args(["--quiet", "--package", "concentric", "--features", "defmt,hal"]);
    steps::run(command.arg("--target-dir").arg(root.target.join("firmware")))
}

fn check(root: &Root, board: Board, tally: &mut Tally) -> Result<()> {
    let toolchain = Toolchain::find(board.target)?;
    if toolchain.has_clippy() {
        tally.run(board.cargo(root, toolchain, "clippy")?.args(["--quiet", "--", "-D", "warnings"]));
    } else {
        println!("clippy was not run on the firmware: {toolchain}");
    }
    let image = Image::read(&board.build(root, toolchain)?)?;
    println!("flash {} bytes, RAM {} bytes", image.flash(), image.ram());
    tally.check(check_storage(&image));
    for kind in Forbidden::ALL {
        let found = image.find(kind);
        println!("{kind} symbols: {}", found.len());
        let verdict =
            if found.is_empty() { Ok(()) } else { Err(anyhow!("{kind}:\n  {}", found.join("\n  "))) };
        tally.check(verdict);
    }
    tally.check(board.check_that_a_panic_is_noticed(root, toolchain));
    Ok(())
}

/// Runs the firmware in QEMU: the same frames must give the same bytes as on the desktop.
pub fn qemu_step(root: &Root, tally: &mut Tally) -> Result<()> {
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
        test.env(board.elf, board.build(root, Toolchain::find(board.target)?)?);
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
        play.env(AN386.elf, AN386.build(root, Toolchain::find(AN386.target)?)?);
    }
    let status = play.status().context("cannot run cargo")?;
    Ok(ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1)))
}

impl Board {
    /// Builds the image.
    fn build(self, root: &Root, toolchain: Toolchain) -> Result<PathBuf> {
        let folder = root.target.join("firmware");
        let elf =
            folder.join(self.target.triple()).join("release").join(format!("concentric-{}", self.folder));
        let built = steps::run(self.cargo(root, toolchain, "build")?.arg("--quiet"));
        built.map_err(|error| match self.find_panics(root, toolchain, &elf) {
            Some(places) => anyhow!("{error:#}; a panic is reachable:\n  {}", places.join("\n  ")),
            None => error,
        })?;
        // Under a name of its own: boards of one package differ in features only.
        let image = folder.join(self.name).with_extension("elf");
        fs::copy(&elf, &image).with_context(|| format!("the build left no {}", elf.display()))?;
        Ok(image)
    }

    /// Where the panics are that keep the firmware from linking: links it with something in place of the missing function.
    fn find_panics(self, root: &Root, toolchain: Toolchain, elf: &Path) -> Option<Vec<String>> {
        let mut command = self.cargo(root, toolchain, "rustc").ok()?;
        command.args(["--quiet", "--", "-C", &format!("link-arg=--defsym={NOWHERE}=0")]);
        output_of(&mut command)?;
        let mut places = Image::read(elf).ok()?.find(Forbidden::Panic);
        // Kept for a closer look, where nobody runs it by mistake.
        let aside = elf.with_extension("with-panics");
        fs::rename(elf, &aside).ok()?;
        places.push(format!("lines of the source: llvm-addr2line -fie {} ADDRESS", aside.display()));
        Some(places)
    }

    /// `cargo SUBCOMMAND` in the firmware's package, for its target, optimised.
    fn cargo(self, root: &Root, toolchain: Toolchain, subcommand: &str) -> Result<Command> {
        let mut command = toolchain.cargo(subcommand)?;
        command
            .current_dir(root.folder.join("examples").join(self.folder))
            .args(["--release", "--target-dir"]);
        command.arg(root.target.join("firmware")).arg(format!("--features={}", self.features.join(",")));
        Ok(command)
    }

    /// Builds the firmware with a panic in it, which must not link.
    fn check_that_a_panic_is_noticed(self, root: &Root, toolchain: Toolchain) -> Result<()> {
        let mut command = self.cargo(root, toolchain, "build")?;
        let output = command.args(["--quiet", "--features", "reachable-panic"]).output()?;
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
