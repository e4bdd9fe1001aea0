//! What the features of the library take, in the bench's page and in the library's documentation.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::Root;

use super::page;
use super::processor::Processor;
use super::results::{Measured, Results};
use super::run::FEATURES;

/// The first cells of a line of the library's table of features.
const LINE: &str = "//! | `";

/// Bytes of each feature on each processor.
pub fn table(measured: &[(&Processor, &Measured)]) -> String {
    let rows = FEATURES.iter().map(|&feature| {
        let bytes = |(_, m): &(&Processor, &Measured)| {
            m.features.get(feature).map_or("not determined".to_owned(), u64::to_string)
        };
        [format!("`{feature}`")].into_iter().chain(measured.iter().map(bytes)).collect()
    });
    page::table(&page::head(&["feature"], measured), rows)
}

/// The library's documentation.
fn path(root: &Root) -> PathBuf {
    root.folder.join("src/lib.rs")
}

/// Puts the figures into the documentation of the library.
///
/// # Errors
/// It cannot be read or written.
pub fn write(root: &Root, results: &Results) -> Result<()> {
    let text = fs::read_to_string(path(root))?;
    fs::write(path(root), with_figures(&text, results)?)?;
    Ok(())
}

/// The text with the figures in the last column of its table of features: fewest and most of all processors, kB.
fn with_figures(text: &str, results: &Results) -> Result<String> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for feature in FEATURES {
        let start = format!("{LINE}{feature}` |");
        let line = lines.iter_mut().find(|line| line.starts_with(&start));
        let line = line.with_context(|| format!("no line `{start}` in src/lib.rs"))?;
        let bytes = results.processors.iter().filter_map(|m| m.features.get(feature));
        let (Some(least), Some(most)) = (bytes.clone().min(), bytes.max()) else { continue };
        let kb = |bytes: &u64| format!("{:.1}", *bytes as f64 / 1000.0);
        let cells = line.trim_end_matches(" |").rsplit_once(" | ").map_or("", |(cells, _)| cells);
        *line = format!("{cells} | {} to {} |", kb(least), kb(most));
    }
    Ok(lines.join("\n") + "\n")
}

#[cfg(test)]
mod tests {
    use super::super::baseline;
    use super::*;

    #[test]
    fn the_library_says_what_its_features_take() {
        let root = Root::find().expect("the checkout");
        let results = baseline::read(&root).expect("a baseline");
        if std::env::var_os("CONCENTRIC_BLESS").is_some_and(|value| value == "1") {
            write(&root, &results).expect("the documentation can be written");
        }
        let text = fs::read_to_string(path(&root)).expect("the library");
        assert_eq!(with_figures(&text, &results).expect("a table"), text);
    }

    #[test]
    fn figures_go_into_the_last_column() {
        let measured = |bytes| Measured {
            features: FEATURES.map(|feature| (feature.to_owned(), bytes)).into(),
            ..Measured::default()
        };
        let results = Results { processors: vec![measured(1_234), measured(9_960)], ..Results::default() };
        let text = FEATURES.map(|feature| format!("{LINE}{feature}` | what | 5 |\n")).concat();
        let right = FEATURES.map(|feature| format!("{LINE}{feature}` | what | 1.2 to 10.0 |\n")).concat();
        assert_eq!(with_figures(&text, &results).expect("a table"), right);
        assert!(with_figures("//! nothing\n", &results).is_err());
    }
}
