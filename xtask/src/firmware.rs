//! Builds the firmware, looks into its image, runs it in QEMU.

use std::env;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow, ensure};

use crate::Root;
use crate::image::{Forbidden, Image};
use crate::package::{NOWHERE, Package};
use crate::setup::Emulator;
use crate::steps::Tally;
use crate::toolchain::Target;

/// The camera head on the M4F.
const MPS2: Package = Package {
    name: "concentric-mps2",
    folder: "examples/mps2",
    target: Target::Armv7Em,
    cpu: None,
    features: &[],
};
/// Tells the desktop side where the image is.
const ELF: &str = "CONCENTRIC_MPS2_ELF";
/// The firmware's `Storage`.
const STORAGE: &str = "STORAGE";

/// Builds the firmware and checks its image.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    if let Some(mut clippy) = MPS2.clippy(root)? {
        tally.run(&mut clippy);
    }
    let image = Image::read(&MPS2.build(root)?)?;
    println!("flash {} bytes, RAM {} bytes", image.flash(), image.ram());
    tally.check(check_storage(&image));
    check_symbols(&image, tally);
    tally.check(check_that_a_panic_is_noticed(root));
    Ok(())
}

/// Runs the firmware in QEMU: the same frames must give the same bytes as on the desktop.
pub fn qemu_step(root: &Root, tally: &mut Tally) -> Result<()> {
    Emulator::Arm.ensure()?;
    let elf = MPS2.build(root)?;
    let test = ["test", "--release", "--package", "concentric-host", "--test", "mps2", "--", "--ignored"];
    tally.run_tests(root.cargo(&test).env(ELF, elf))
}

/// Runs the firmware for a user who reads its serial port.
pub fn play(root: &Root, arguments: &[String]) -> Result<ExitCode> {
    let manifest = root.folder.join("Cargo.toml");
    let mut play = root.cargo(&["run", "--quiet", "--release", "--manifest-path"]);
    play.arg(manifest).args(["--package", "concentric-host", "--example", "mps2", "--"]).args(arguments);
    // The user's files are named from where the user is.
    play.current_dir(env::current_dir()?);
    if !arguments.iter().any(|argument| ["-h", "--help"].contains(&argument.as_str())) {
        Emulator::Arm.ensure()?;
        play.env(ELF, MPS2.build(root)?);
    }
    let status = play.status().context("cannot run cargo")?;
    Ok(ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1)))
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

fn check_storage(image: &Image) -> Result<()> {
    let storage = image.variable(STORAGE).with_context(|| format!("no variable {STORAGE} in the image"))?;
    println!("{STORAGE}: {} bytes in {}", storage.size, storage.section);
    ensure!(storage.section == ".bss", "{STORAGE} is in {}: its start value takes flash", storage.section);
    Ok(())
}

/// Builds the firmware with a panic in it, which must not link.
fn check_that_a_panic_is_noticed(root: &Root) -> Result<()> {
    let package = Package { features: &["reachable-panic"], ..MPS2 };
    let output = package.cargo(root, "build")?.arg("--quiet").output()?;
    let message = String::from_utf8_lossy(&output.stderr);
    ensure!(!output.status.success(), "the firmware with a reachable panic links");
    ensure!(
        message.contains(NOWHERE),
        "the firmware with a reachable panic fails for another reason:\n{message}"
    );
    println!("a reachable panic keeps the firmware from linking");
    Ok(())
}
