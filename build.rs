//! Sets the cfg `concentric_dsp` where the processor surely has Arm's DSP extension.
//!
//! Of the targets, thumbv7em has it; thumbv8m.main has it only on processors that the flags name, as with
//! `RUSTFLAGS="-C target-cpu=cortex-m33"` or the same in `.cargo/config.toml`. Stable Rust tells neither by a cfg.

use std::env;

/// Processors of the target thumbv8m.main whose name tells rustc that they have it.
const WITH_DSP: [&str; 5] = ["cortex-m33", "cortex-m35p", "cortex-m55", "cortex-m85", "star-mc1"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(concentric_dsp)");
    let target = env::var("TARGET").unwrap_or_default();
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    if target.starts_with("thumbv7em-") || target.starts_with("thumbv8m.main-") && names_dsp(&flags) {
        println!("cargo:rustc-cfg=concentric_dsp");
    }
}

/// Whether the last processor that the flags name has it.
fn names_dsp(flags: &str) -> bool {
    let cpu = flags
        .split('\x1f')
        .filter_map(|flag| flag.trim_start_matches("-C").strip_prefix("target-cpu="))
        .next_back();
    cpu.is_some_and(|cpu| WITH_DSP.contains(&cpu))
}
