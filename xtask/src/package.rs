//! A package of firmware: how it is built, and where its panics are if it does not link.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, anyhow, ensure};

use crate::Root;
use crate::image::{Forbidden, Image};
use crate::steps::{self, output_of};
use crate::toolchain::{Target, Toolchain};

/// The function that the panic handlers call and that does not exist.
pub const NOWHERE: &str = "a_panic_is_reachable";

/// Firmware for a processor.
#[derive(Clone, Copy, Debug)]
pub struct Package {
    /// Name of the package and of its program.
    pub name: &'static str,
    /// Its folder in the checkout.
    pub folder: &'static str,
    /// The processor's family.
    pub target: Target,
    /// The processor, for rustc; `None` for any of the family.
    pub cpu: Option<&'static str>,
    /// Features of the package.
    pub features: &'static [&'static str],
}

impl Package {
    /// Builds the image.
    ///
    /// # Errors
    /// It does not compile or not link; names the panics that keep it from linking.
    pub fn build(&self, root: &Root) -> Result<PathBuf> {
        self.build_with(root, &[])
    }

    /// Builds the image with more arguments for cargo.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn build_with(&self, root: &Root, arguments: &[&str]) -> Result<PathBuf> {
        let elf = root.target.join("firmware").join(self.target.triple()).join("release").join(self.name);
        let built = steps::run(self.cargo(root, "build")?.arg("--quiet").args(arguments));
        built.map_err(|error| match self.find_panics(root, &elf) {
            Some(places) => anyhow!("{error:#}; a panic is reachable:\n  {}", places.join("\n  ")),
            None => error,
        })?;
        ensure!(elf.is_file(), "the build left no {}", elf.display());
        Ok(elf)
    }

    /// Where the panics are: links it with something in place of the missing function.
    fn find_panics(&self, root: &Root, elf: &Path) -> Option<Vec<String>> {
        let mut command = self.cargo(root, "rustc").ok()?;
        command.args(["--quiet", "--", "-C", &format!("link-arg=--defsym={NOWHERE}=0")]);
        output_of(&mut command)?;
        let mut places = Image::read(elf).ok()?.find(Forbidden::Panic);
        // Kept for a closer look, where nobody runs it by mistake.
        let aside = elf.with_extension("with-panics");
        fs::rename(elf, &aside).ok()?;
        places.push(format!("lines of the source: llvm-addr2line -fie {} ADDRESS", aside.display()));
        Some(places)
    }

    /// `cargo SUBCOMMAND` in the package, for its target, optimised.
    ///
    /// # Errors
    /// There is no compiler for the target.
    pub fn cargo(&self, root: &Root, subcommand: &str) -> Result<Command> {
        let mut command = Toolchain::find(self.target)?.cargo(subcommand)?;
        command.current_dir(root.folder.join(self.folder)).args(["--release", "--target-dir"]);
        command.arg(root.target.join("firmware"));
        if let Some(cpu) = self.cpu {
            command.env("RUSTFLAGS", format!("-C target-cpu={cpu}"));
        }
        if !self.features.is_empty() {
            command.args(["--features", &self.features.join(",")]);
        }
        Ok(command)
    }

    /// Clippy, warnings are errors; `None` where the compiler has none.
    ///
    /// # Errors
    /// As [`cargo`](Self::cargo).
    pub fn clippy(&self, root: &Root) -> Result<Option<Command>> {
        let toolchain = Toolchain::find(self.target)?;
        if !toolchain.has_clippy() {
            println!("clippy was not run on {}: {toolchain}", self.name);
            return Ok(None);
        }
        let mut command = self.cargo(root, "clippy")?;
        command.args(["--quiet", "--", "-D", "warnings"]);
        Ok(Some(command))
    }
}
