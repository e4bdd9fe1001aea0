//! Finds a compiler for each of the firmware's targets.

use std::env;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::setup::install_packages;
use crate::steps::{self, output_of};
use crate::wrapper;

/// A target of firmware, by the family of its processors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Cortex-M0 and M0+.
    Armv6M,
    /// Cortex-M4F and M7.
    Armv7Em,
    /// Cortex-M33.
    Armv8M,
    /// RISC-V soft cores: 32 bit, multiplier, no floating-point unit.
    Rv32Imc,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Armv6M, Self::Armv7Em, Self::Armv8M, Self::Rv32Imc];

    /// Its name for rustc.
    pub fn triple(self) -> &'static str {
        match self {
            Self::Armv6M => "thumbv6m-none-eabi",
            Self::Armv7Em => "thumbv7em-none-eabihf",
            Self::Armv8M => "thumbv8m.main-none-eabihf",
            Self::Rv32Imc => "riscv32imc-unknown-none-elf",
        }
    }

    /// The variable in which cargo looks for the target's linker.
    fn linker_variable(self) -> String {
        let name = self.triple().to_ascii_uppercase().replace(['-', '.'], "_");
        format!("CARGO_TARGET_{name}_LINKER")
    }
}

/// The distribution's compiler, the source of `core`, and a linker, by their names in Debian.
const PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld"];
/// Where they are, past the programs of rustup.
const DISTRIBUTION_RUSTC: &str = "/usr/bin/rustc";
const DISTRIBUTION_CARGO: &str = "/usr/bin/cargo";
const LLD: &str = "ld.lld";
/// Oldest 1.x that compiles the library.
const OLDEST: u32 = 87;

/// Where a compiler comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// The compiler in use has a compiled `core` for the target.
    Target,
    /// The distribution's compiler, which compiles `core` from source first.
    Distribution,
}

/// A compiler for a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Toolchain {
    source: Source,
    target: Target,
}

impl Toolchain {
    /// The best compiler that can be had for a target, installed if need be.
    ///
    /// # Errors
    /// None is there and none can be installed; says what to install.
    pub fn set_up(target: Target) -> Result<Self> {
        Self::allowed(target)?.find(|toolchain| toolchain.is_here() || toolchain.install()).with_context(|| {
            let triple = target.triple();
            format!(
                "no compiler for {triple}: run `rustup target add {triple}`, or on Debian as root `apt-get install {}`",
                PACKAGES.join(" ")
            )
        })
    }

    /// A compiler that is there, or else the best that can be had.
    ///
    /// # Errors
    /// As [`set_up`](Self::set_up).
    pub fn find(target: Target) -> Result<Self> {
        match Self::allowed(target)?.find(|toolchain| toolchain.is_here()) {
            Some(toolchain) => Ok(toolchain),
            None => Self::set_up(target),
        }
    }

    /// The compilers that the user wants, best first.
    fn allowed(target: Target) -> Result<impl Iterator<Item = Self>> {
        let wish = env::var("CONCENTRIC_TOOLCHAIN").unwrap_or_default();
        let sources: &[Source] = match wish.as_str() {
            "" => &[Source::Target, Source::Distribution],
            "target" => &[Source::Target],
            "distribution" => &[Source::Distribution],
            _ => bail!("CONCENTRIC_TOOLCHAIN is `{wish}`; it can be `target` or `distribution`"),
        };
        Ok(sources.iter().map(move |&source| Self { source, target }))
    }

    fn is_here(self) -> bool {
        match self.source {
            Source::Target => has_compiled_core(&rustc(), self.target),
            Source::Distribution => {
                minor_version(DISTRIBUTION_RUSTC).is_some_and(|minor| minor >= OLDEST)
                    && Path::new(DISTRIBUTION_CARGO).exists()
                    && has_source_of_core(DISTRIBUTION_RUSTC)
                    && output_of(Command::new(LLD).arg("--version")).is_some()
            }
        }
    }

    fn install(self) -> bool {
        match self.source {
            Source::Target => {
                _ = steps::run(Command::new("rustup").args(["target", "add", self.target.triple()]));
            }
            Source::Distribution => _ = install_packages(&PACKAGES),
        }
        self.is_here()
    }

    /// Whether clippy can look at the firmware: the distribution's compiler comes without.
    pub fn has_clippy(self) -> bool {
        self.source == Source::Target
    }

    /// `cargo SUBCOMMAND` for the target.
    ///
    /// # Errors
    /// This program's own path is unknown.
    pub fn cargo(self, subcommand: &str) -> Result<Command> {
        let program = match self.source {
            Source::Target => env::var_os("CARGO").unwrap_or_else(|| "cargo".into()),
            Source::Distribution => DISTRIBUTION_CARGO.into(),
        };
        let mut command = Command::new(program);
        command.args([subcommand, "--target", self.target.triple()]);
        if self.source == Source::Distribution {
            command.args(["-Zbuild-std=core", "-Zbuild-std-features=compiler-builtins-mem"]);
            command.env(self.target.linker_variable(), LLD);
            command.env("RUSTC", DISTRIBUTION_RUSTC);
            command.env("RUSTC_WRAPPER", env::current_exe()?).env(wrapper::MARK, "1");
        }
        Ok(command)
    }
}

impl fmt::Display for Toolchain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rustc, how) = match self.source {
            Source::Target => (rustc(), "with the target"),
            Source::Distribution => (DISTRIBUTION_RUSTC.into(), "which compiles `core` from source, for"),
        };
        let version = output_of(Command::new(rustc).arg("--version")).unwrap_or_default();
        write!(f, "{version}, {how} {}", self.target.triple())
    }
}

fn rustc() -> PathBuf {
    env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()).into()
}

fn has_compiled_core(rustc: &Path, target: Target) -> bool {
    output_of(Command::new(rustc).args(["--print", "target-libdir", "--target", target.triple()]))
        .and_then(|folder| fs::read_dir(folder).ok())
        .is_some_and(|files| {
            files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
        })
}

fn has_source_of_core(rustc: &str) -> bool {
    output_of(Command::new(rustc).args(["--print", "sysroot"]))
        .is_some_and(|root| Path::new(&root).join("lib/rustlib/src/rust/library/core/Cargo.toml").exists())
}

fn minor_version(rustc: &str) -> Option<u32> {
    let version = output_of(Command::new(rustc).arg("--version"))?;
    version.strip_prefix("rustc 1.")?.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cargo_finds_the_linker_of_a_target_with_a_point_in_its_name() {
        assert_eq!(Target::Armv8M.linker_variable(), "CARGO_TARGET_THUMBV8M_MAIN_NONE_EABIHF_LINKER");
    }
}
