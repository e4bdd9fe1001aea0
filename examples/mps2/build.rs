//! Links with the memory map of the repository's root.

use std::path::Path;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    println!("cargo:rustc-link-search={}", root.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    // Tells `cargo xtask firmware` who calls what must not be called.
    println!("cargo:rustc-link-arg-bins=--emit-relocs");
    // Sections need no padding to a page: the image is not loaded by an operating system.
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rerun-if-changed={}", root.join("memory.x").display());
}
