//! The program as a user meets it: what it prints, its exit codes, its messages.

mod accuracy;
mod calibrate;
mod camera;
#[path = "../common/mod.rs"]
mod common;
mod detect;
mod support;

use support::{Folder, size, text};

#[test]
fn help_and_version() {
    let folder = Folder::new();
    let help = text(&folder.run(&["--help"]).stdout);
    for word in ["detect", "render", "monitor", "accuracy", "paper", "demo", "Examples:"] {
        assert!(help.contains(word), "{help}");
    }
    assert_eq!(
        text(&folder.run(&["--version"]).stdout),
        format!("concentric {}\n", env!("CARGO_PKG_VERSION"))
    );
}

#[test]
fn the_demo_shows_why() {
    let folder = Folder::new();
    let output = folder.run(&[]);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{printed}{}", text(&output.stderr));
    assert!(printed.contains("concentric-demo.png") && printed.contains(" 0 false"), "{printed}");
    let rms = printed.lines().find_map(|line| line.trim_start().strip_prefix("RMS")).unwrap();
    let rms: Vec<f64> = rms.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
    let [outer, eq7, exact, sigma] = rms[..] else { panic!("{rms:?}") };
    assert!(outer > 0.5 && exact < outer / 50.0 && eq7 < outer / 20.0 && sigma < 0.05, "{rms:?}");
    assert!(size(&folder.path("concentric-demo.png")).0 > 1280);
    assert_eq!(folder.run(&["demo", "--out", "other.png"]).status.code(), Some(0));
    assert!(folder.path("other.png").exists());
    assert_eq!(folder.run(&["demo", "--out", "other.bmp"]).status.code(), Some(2));
}
