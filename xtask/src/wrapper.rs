//! Stands between cargo and rustc when the firmware is built with the distribution's compiler.
//!
//! There `core` is compiled, too, for which cargo hands unstable flags to every call of rustc, and a stable compiler
//! takes those only with `RUSTC_BOOTSTRAP=1`. Set for the whole build, it would leak: build scripts that look for a
//! nightly compiler would find one. So the calls get it one by one, and unstable features stay an error outside of
//! `core`: what builds here builds with a plain stable compiler.

use std::env;
use std::process::{Command, ExitCode};

/// Set for the builds that go through the wrapper.
pub const MARK: &str = "CONCENTRIC_RUSTC_WRAPPER";

/// Whether this process is to be the wrapper.
pub fn is_wanted() -> bool {
    env::var_os(MARK).is_some()
}

/// Calls rustc: `xtask RUSTC ARGUMENT...`.
pub fn run() -> ExitCode {
    let mut arguments = env::args_os().skip(1);
    let Some(rustc) = arguments.next() else {
        eprintln!("xtask: {MARK} is set, but no compiler is given; it is not for use by hand");
        return ExitCode::from(2);
    };
    let arguments: Vec<_> = arguments.collect();
    let is_unstable = arguments.iter().any(|a| a.to_string_lossy().starts_with("-Z"));
    let is_core = arguments.iter().any(|a| a.to_string_lossy().ends_with("force-unstable-if-unmarked"));

    let mut command = Command::new(rustc);
    command.args(arguments).env_remove(MARK);
    if is_unstable || is_core {
        command.env("RUSTC_BOOTSTRAP", "1");
    } else {
        command.env_remove("RUSTC_BOOTSTRAP");
    }
    if is_unstable && !is_core {
        command.arg("-Zallow-features=");
    }
    match command.status() {
        Ok(status) => ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(101)),
        Err(error) => {
            eprintln!("xtask: cannot run {}: {error}", command.get_program().display());
            ExitCode::from(101)
        }
    }
}
