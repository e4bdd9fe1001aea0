//! Finds a compiler for the firmware.

use std::env;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::setup::install_packages;
use crate::steps::{self, output_of};
use crate::wrapper;

/// Target of the firmware.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The distribution's compiler, the source of `core`, and a linker, by their names in Debian.
const PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld"];
/// Where they are, past the programs of rustup.
const DISTRIBUTION_RUSTC: &str = "/usr/bin/rustc";
const DISTRIBUTION_CARGO: &str = "/usr/bin/cargo";
const LLD: &str = "ld.lld";
/// Oldest 1.x that compiles the library.
const OLDEST: u32 = 87;

/// A compiler for the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The compiler in use has a compiled `core` for the target.
    Target,
    /// The distribution's compiler, which compiles `core` from source first.
    Distribution,
}

impl Toolchain {
    /// The best compiler that can be had, installed if need be.
    ///
    /// # Errors
    /// None is there and none can be installed; says what to install.
    pub fn set_up() -> Result<Self> {
        Self::allowed()?.iter().copied().find(|toolchain| toolchain.is_here() || toolchain.install()).with_context(|| {
            format!(
                "no compiler for {TARGET}: run `rustup target add {TARGET}`, or on Debian as root `apt-get install {}`",
                PACKAGES.join(" ")
            )
        })
    }

    /// A compiler that is there, or else the best that can be had.
    ///
    /// # Errors
    /// As [`set_up`](Self::set_up).
    pub fn find() -> Result<Self> {
        match Self::allowed()?.iter().copied().find(|toolchain| toolchain.is_here()) {
            Some(toolchain) => Ok(toolchain),
            None => Self::set_up(),
        }
    }

    /// The compilers that the user wants, best first.
    fn allowed() -> Result<&'static [Self]> {
        let wish = env::var("CONCENTRIC_TOOLCHAIN").unwrap_or_default();
        Ok(match wish.as_str() {
            "" => &[Self::Target, Self::Distribution],
            "target" => &[Self::Target],
            "distribution" => &[Self::Distribution],
            _ => bail!("CONCENTRIC_TOOLCHAIN is `{wish}`; it can be `target` or `distribution`"),
        })
    }

    fn is_here(self) -> bool {
        match self {
            Self::Target => has_compiled_core(&rustc()),
            Self::Distribution => {
                minor_version(DISTRIBUTION_RUSTC).is_some_and(|minor| minor >= OLDEST)
                    && Path::new(DISTRIBUTION_CARGO).exists()
                    && has_source_of_core(DISTRIBUTION_RUSTC)
                    && output_of(Command::new(LLD).arg("--version")).is_some()
            }
        }
    }

    fn install(self) -> bool {
        match self {
            Self::Target => _ = steps::run(Command::new("rustup").args(["target", "add", TARGET])),
            Self::Distribution => _ = install_packages(&PACKAGES),
        }
        self.is_here()
    }

    /// Whether clippy can look at the firmware: the distribution's compiler comes without.
    pub fn has_clippy(self) -> bool {
        self == Self::Target
    }

    /// `cargo SUBCOMMAND` for the target.
    ///
    /// # Errors
    /// This program's own path is unknown.
    pub fn cargo(self, subcommand: &str) -> Result<Command> {
        match self {
            Self::Target => {
                let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
                command.args([subcommand, "--target", TARGET]);
                Ok(command)
            }
            Self::Distribution => {
                let mut command = Command::new(DISTRIBUTION_CARGO);
                command.args([subcommand, "--target", TARGET]);
                command.args(["-Zbuild-std=core", "-Zbuild-std-features=compiler-builtins-mem"]);
                command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", LLD);
                command.env("RUSTC", DISTRIBUTION_RUSTC);
                command.env("RUSTC_WRAPPER", env::current_exe()?).env(wrapper::MARK, "1");
                Ok(command)
            }
        }
    }
}

impl fmt::Display for Toolchain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rustc, how) = match self {
            Self::Target => (rustc(), format!("with the target {TARGET}")),
            Self::Distribution => (DISTRIBUTION_RUSTC.into(), "which compiles `core` from source".to_owned()),
        };
        let version = output_of(Command::new(rustc).arg("--version")).unwrap_or_default();
        write!(f, "{version}, {how}")
    }
}

fn rustc() -> PathBuf {
    env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()).into()
}

fn has_compiled_core(rustc: &Path) -> bool {
    output_of(Command::new(rustc).args(["--print", "target-libdir", "--target", TARGET]))
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
