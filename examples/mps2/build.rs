//! Links with the memory map of the board: that of the repository's root, or the one beside this file.

use std::env;
use std::path::Path;

fn main() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = match env::var_os("CARGO_FEATURE_AN500") {
        Some(_) => package.join("an500"),
        None => package.join("../.."),
    };
    println!("cargo:rustc-link-search={}", folder.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    // Tells `cargo xtask firmware` who calls what must not be called.
    println!("cargo:rustc-link-arg-bins=--emit-relocs");
    // Sections need no padding to a page: the image is not loaded by an operating system.
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rerun-if-changed={}", folder.join("memory.x").display());
}
