//! The README tells the truth: every number in it is computed here, its commands exist, its picture is what the
//! program draws.
//!
//! `CONCENTRIC_BLESS=1 cargo test --release -p concentric-host --test readme` writes them anew.

mod accuracy;
#[path = "../common/mod.rs"]
mod common;
mod cost;
mod document;
mod figures;
mod limits;
mod picture;
mod program;
mod sizes;

use std::path::{Path, PathBuf};

use document::Document;

/// A file of the checkout.
fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

fn read(name: &str) -> String {
    std::fs::read_to_string(file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Whether to write what is computed instead of comparing it.
fn bless() -> bool {
    std::env::var_os("CONCENTRIC_BLESS").is_some_and(|value| value == "1")
}

const HOW_TO_BLESS: &str = "if that is right, write it with\nCONCENTRIC_BLESS=1 cargo test --release -p concentric-host --test readme";

#[test]
fn tables_and_outputs_are_as_computed() {
    let mut readme = Document::new(read("README.md"));
    readme.put("output:demo", &program::demo());
    readme.put("output:detect", &program::detect(readme.text()));
    readme.put("table:accuracy", &figures::accuracy());
    readme.put("table:goals", &accuracy::goals());
    readme.put("table:paper", &accuracy::paper());
    readme.put("table:found", &figures::found());
    readme.put("table:cost", &cost::table());
    readme.put("table:memory", &sizes::memory());
    readme.put("table:report", &sizes::report());
    readme.put("table:limits", &limits::table());
    if bless() {
        std::fs::write(file("README.md"), readme.text()).expect("README.md can be written");
    } else {
        assert!(readme.changes().is_empty(), "README.md: {}\n{HOW_TO_BLESS}", readme.changes());
    }
}

#[test]
fn no_number_goes_unchecked() {
    assert_eq!(Document::new(read("README.md")).unchecked_numbers(), [""; 0]);
}

#[test]
fn compiler_is_the_one_of_the_manifest() {
    let manifest = read("Cargo.toml");
    let version =
        manifest.lines().find_map(|line| line.strip_prefix("rust-version = ")).expect("rust-version");
    let sentence = format!("Rust {}", version.trim_matches('"'));
    assert!(
        read("README.md").contains(&format!("{sentence} or later")),
        "README.md does not say `{sentence} or later`"
    );
}

#[test]
fn unit_is_that_of_the_library() {
    let unit = format!("integers in 1/{} px", concentric::Position::SCALE);
    assert!(read("README.md").contains(&unit), "README.md does not say `{unit}`");
}

#[test]
fn example_has_at_most_30_lines() {
    let readme = read("README.md");
    let example =
        readme.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    assert!(example.lines().count() <= 30, "{} lines", example.lines().count());
    for call in ["begin(", "push_row(", "finish()"] {
        assert!(example.contains(call), "`{call}` is not shown");
    }
}

#[test]
fn files_that_are_named_exist() {
    for page in ["README.md", "CONTRIBUTING.md"] {
        let text = read(page);
        let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        let rows = text.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
        let paths = rows.filter(|name| name.contains('/') && !name.contains(' '));
        for name in links.filter(|link| !link.starts_with("http")).chain(paths) {
            assert!(file(name).exists(), "{page} names {name}, which does not exist");
        }
    }
}
