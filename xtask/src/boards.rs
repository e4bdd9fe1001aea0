//! Builds the firmware of boards that no emulator here knows.

use anyhow::{Result, ensure};

use crate::Root;
use crate::image::Image;
use crate::steps::{self, Tally};
use crate::toolchain::{Target, Toolchain};

/// Folders in `examples`, and their processors.
const BOARDS: [(&str, Target); 2] = [("rp2350", Target::Armv8M), ("stm32h7", Target::Armv7Em)];

/// Builds all of them, and prints their sizes.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    for (folder, target) in BOARDS {
        tally.check(build(root, folder, target));
    }
    Ok(())
}

fn build(root: &Root, folder: &str, target: Target) -> Result<()> {
    let toolchain = Toolchain::find(target)?;
    let built = root.target.join("firmware");
    let cargo = |subcommand: &str| -> Result<_> {
        let mut command = toolchain.cargo(subcommand)?;
        command.current_dir(root.folder.join("examples").join(folder));
        command.args(["--quiet", "--release", "--target-dir"]).arg(&built);
        Ok(command)
    };
    if toolchain.has_clippy() {
        steps::run(cargo("clippy")?.args(["--", "-D", "warnings"]))?;
    }
    steps::run(&mut cargo("build")?)?;
    let elf = built.join(target.triple()).join("release").join(format!("concentric-{folder}"));
    let image = Image::read(&elf)?;
    println!("{folder}: flash {} bytes, RAM {} bytes", image.flash(), image.ram());
    ensure!(
        image.variable("STORAGE").is_some_and(|storage| storage.section == ".bss"),
        "STORAGE takes flash"
    );
    Ok(())
}
