//! Links with the memory map of the target's board.

use std::path::Path;
use std::{env, fs};

fn main() {
    let target = env::var("TARGET").expect("cargo names the target");
    let is_m7 = env::var_os("CARGO_FEATURE_M7").is_some();
    let board = match target.split('-').next() {
        Some("thumbv6m") => "mps2-an386",
        Some("thumbv7em") if is_m7 => "mps2-an500",
        Some("thumbv7em") => "mps2-an386",
        Some("thumbv8m.main") => "mps2-an505",
        Some("riscv32imc") => "virt",
        _ => panic!("no board for {target}"),
    };
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("boards").join(board).with_extension("x");
    let out = env::var("OUT_DIR").expect("cargo names the folder");
    fs::copy(&map, Path::new(&out).join("memory.x")).expect("the memory map can be copied");
    println!("cargo:rustc-link-search={out}");
    if target.starts_with("riscv") {
        println!("cargo:rustc-link-arg-bins=-Tmemory.x");
    }
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    // Tells `cargo xtask bench` who calls what must not be called.
    println!("cargo:rustc-link-arg-bins=--emit-relocs");
    // Sections need no padding to a page: the image is not loaded by an operating system.
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rerun-if-changed={}", map.display());
}
