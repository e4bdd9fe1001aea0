//! Files that tests compare with.

use std::path::Path;

/// Compares `text` with the golden file `name`, or writes it where `CONCENTRIC_BLESS` is 1. `test` is the test to run for that.
pub fn compare(name: &str, text: &str, test: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(name);
    if std::env::var_os("CONCENTRIC_BLESS").is_some_and(|value| value == "1") {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(&path, text).expect("a file");
        return;
    }
    let how = format!(
        "{name}: if that is right, write it with\nCONCENTRIC_BLESS=1 cargo test --release -p concentric-host --test {test}"
    );
    let before = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    for (before, now) in before.lines().zip(text.lines()) {
        assert_eq!(before, now, "{how}");
    }
    assert_eq!(before.lines().count(), text.lines().count(), "{how}");
}
