//! Builds the firmware of boards that no emulator here knows.

use anyhow::{Result, ensure};

use crate::Root;
use crate::image::Image;
use crate::package::Package;
use crate::stack;
use crate::steps::{self, Tally};
use crate::toolchain::Target;

/// Their firmware.
const PACKAGES: [Package; 2] = [
    Package {
        name: "concentric-rp2350",
        folder: "examples/rp2350",
        target: Target::Armv8M,
        cpu: None,
        features: &[],
    },
    Package {
        name: "concentric-stm32h7",
        folder: "examples/stm32h7",
        target: Target::Armv7Em,
        cpu: None,
        features: &[],
    },
];

/// Builds all of it, and prints the sizes.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    for package in PACKAGES {
        if let Some(mut clippy) = package.clippy(root)? {
            tally.run(&mut clippy);
        }
        tally.check(check(root, package));
    }
    tally.check(check_logs(root));
    Ok(())
}

fn check(root: &Root, package: Package) -> Result<()> {
    let elf = package.build(root)?;
    let image = Image::read(&elf)?;
    println!("{}: flash {} bytes, RAM {} bytes", package.name, image.flash(), image.ram());
    ensure!(
        image.variable("STORAGE").is_some_and(|storage| storage.section == ".bss"),
        "STORAGE takes flash"
    );
    stack::check_room(&elf, &image, package.target)
}

/// The library with its logs, for a board; a link would need somewhere for them to go.
fn check_logs(root: &Root) -> Result<()> {
    let package = Package { name: "concentric", folder: ".", features: &["defmt", "hal"], ..PACKAGES[1] };
    steps::run(package.cargo(root, "check")?.args(["--quiet", "--package", "concentric"]))
}
