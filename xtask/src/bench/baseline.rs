//! The ratchet: what was reached once may not get worse.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::Root;

use super::features;
use super::page::page;
use super::results::{Measured, Results};

/// How much worse a figure may be, with the compiler of the baseline and with another.
const SLACK: f64 = 0.03;
const SLACK_OF_COMPILERS: f64 = 0.10;
/// A figure may always be worse by this much: small ones jump.
const LEAST: f64 = 64.0;

fn path(root: &Root) -> PathBuf {
    root.folder.join("xtask/bench/baseline.json")
}

/// The same as a page.
fn page_path(root: &Root) -> PathBuf {
    path(root).with_extension("md")
}

/// Reads the baseline.
///
/// # Errors
/// There is none, or it is damaged.
pub fn read(root: &Root) -> Result<Results> {
    let path = path(root);
    let text = fs::read(&path).with_context(|| format!("no baseline {}", path.display()))?;
    serde_json::from_slice(&text)
        .with_context(|| format!("{} is damaged; `--bless` writes it anew", path.display()))
}

/// Makes these results the baseline, as far as they go.
///
/// # Errors
/// The file cannot be written.
pub fn write(root: &Root, results: &Results) -> Result<()> {
    let mut all = read(root).unwrap_or_default();
    all.emulator.clone_from(&results.emulator);
    for new in &results.processors {
        all.processors.retain(|old| old.processor != new.processor);
        all.processors.push(new.clone());
    }
    all.processors.sort_by(|a, b| a.processor.cmp(&b.processor));
    let path = path(root);
    fs::create_dir_all(path.parent().context("no folder")?)?;
    fs::write(&path, serde_json::to_string_pretty(&all)? + "\n")?;
    fs::write(page_path(root), page(&all))?;
    features::write(root, &all)?;
    println!("wrote {}", path.display());
    Ok(())
}

/// What is worse on a processor than the baseline allows.
pub fn regressions(baseline: &Results, now: &Measured) -> Vec<String> {
    let Some(then) = baseline.of(&now.processor) else {
        return vec![format!("{} is not in the baseline; `--bless` takes it up", now.processor)];
    };
    let mut found = differences(then, now);
    if let Some(now) = &now.lean {
        found.extend(match &then.lean {
            Some(then) => {
                differences(then, now).iter().map(|text| format!("without features: {text}")).collect()
            }
            None => {
                vec!["the library without features is not in the baseline; `--bless` takes it up".to_owned()]
            }
        });
    }
    found
}

fn differences(then: &Measured, now: &Measured) -> Vec<String> {
    let slack = if then.compiler == now.compiler { SLACK } else { SLACK_OF_COMPILERS };
    let mut found = Vec::new();
    let mut compare = |name: &str, then: u64, now: u64| {
        let limit = (then as f64 * (1.0 + slack)).max(then as f64 + LEAST);
        if now as f64 > limit {
            let percent = 100.0 * (now as f64 / (then as f64).max(1.0) - 1.0);
            found.push(format!("{name}: {now} instead of {then}, {percent:+.1} %"));
        }
    };
    compare("flash", then.flash, now.flash);
    compare("stack", then.stack.measured, now.stack.measured);
    let mut unknown = Vec::new();
    for frame in &now.frames {
        let name = frame.name();
        match then.frame(&frame.scene, frame.width) {
            Some(then) => {
                compare(&format!("{name}, scan"), then.scan.instructions, frame.scan.instructions);
                compare(&format!("{name}, targets"), then.target.instructions, frame.target.instructions);
                compare(&format!("{name}, report"), then.report.instructions, frame.report.instructions);
                compare(&format!("{name}, storage"), then.storage, frame.storage);
            }
            None => unknown.push(format!("{name} is not in the baseline; `--bless` takes it up")),
        }
    }
    found.extend(unknown);
    found
}

#[cfg(test)]
mod tests {
    use super::super::results::{Counts, Frame};
    use super::*;

    fn measured(compiler: &str, instructions: u64) -> Measured {
        let scan = Counts { instructions, ..Counts::default() };
        let frame = Frame { scene: "empty".to_owned(), width: 320, height: 240, scan, ..Frame::default() };
        Measured {
            processor: "m4f".to_owned(),
            compiler: compiler.to_owned(),
            frames: vec![frame],
            ..Measured::default()
        }
    }

    #[test]
    fn three_percent_are_borne_and_not_more() {
        let baseline = Results { processors: vec![measured("a", 10_000)], ..Results::default() };
        assert_eq!(regressions(&baseline, &measured("a", 10_300)), Vec::<String>::new());
        assert_eq!(
            regressions(&baseline, &measured("a", 10_301)),
            ["empty 320x240, scan: 10301 instead of 10000, +3.0 %"]
        );
        assert_eq!(regressions(&baseline, &measured("b", 10_301)), Vec::<String>::new());
        assert_eq!(regressions(&baseline, &measured("b", 11_100)).len(), 1);
        assert_eq!(regressions(&baseline, &measured("a", 5_000)), Vec::<String>::new());
    }

    #[test]
    fn page_shows_the_baseline() {
        let root = Root::find().expect("the checkout");
        let right = page(&read(&root).expect("a baseline"));
        if std::env::var_os("CONCENTRIC_BLESS").is_some_and(|value| value == "1") {
            fs::write(page_path(&root), &right).expect("the page can be written");
        }
        assert_eq!(fs::read_to_string(page_path(&root)).expect("a page"), right);
    }

    #[test]
    fn what_the_baseline_lacks_is_told() {
        let baseline = Results {
            processors: vec![Measured { frames: vec![], ..measured("a", 1) }],
            ..Results::default()
        };
        assert_eq!(regressions(&baseline, &measured("a", 1)).len(), 1);
        assert_eq!(regressions(&Results::default(), &measured("a", 1)).len(), 1);
    }
}
