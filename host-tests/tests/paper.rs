//! The command `paper` against the page of a run before.
//!
//! `CONCENTRIC_BLESS=1 cargo test --release -p concentric-host --test paper` writes that anew.

mod common;

use common::golden;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::LazyLock;

use concentric_host::paper::{
    board::{USUAL, level::Level, scene},
    page,
    plots::plots,
    printed::{DEVIATION, TABLE_1, TARGETS, VIEWS},
    report::Report,
};
use indicatif::ProgressBar;

/// Shown in the checkout: the pictures of the others are large.
const SHOWN: [&str; 3] = ["figure4.svg", "figure5.svg", "figure8.svg"];

static REPORT: LazyLock<Report> =
    LazyLock::new(|| Report::new(&ProgressBar::hidden()).expect("every experiment can be done"));

fn compare(name: &str, text: &str) {
    golden::compare(&format!("paper/{name}"), text, "paper");
}

#[test]
fn page_and_figures_are_as_before() {
    compare("paper.md", &page::page(&REPORT, &SHOWN));
    let plots = plots(&REPORT).expect("plots");
    for name in SHOWN {
        let plot = plots.iter().find(|plot| plot.file == name).unwrap_or_else(|| panic!("no {name}"));
        compare(name, &plot.svg);
    }
}

/// Whatever the golden page says.
#[test]
fn table_1_is_printed_digit_by_digit() {
    let page = page::page(&REPORT, &[]);
    for (radius, printed) in TABLE_1 {
        let line = page.lines().find(|line| line.starts_with(&format!("| {radius} | "))).expect("a row");
        let cells: Vec<_> = line.split(" | ").collect();
        assert_eq!((cells[2], cells[3], cells[4]), (printed, printed, "0"), "{line}");
    }
}

fn level(noise: f64) -> &'static Level {
    REPORT.board.levels.iter().find(|level| level.noise == noise).expect("a level of that noise")
}

/// Figure 8: all are found, the deviations are as small as printed at a noise, and the centres three times as far off.
#[test]
fn board_shows_what_the_deviations_hide() {
    for level in &REPORT.board.levels {
        assert_eq!((level.found, level.wrong, level.unmatched), (TARGETS * VIEWS, 0, 0), "{}", level.noise);
    }
    let implied = REPORT.board.implied().expect("a noise");
    assert!(implied.noise >= USUAL && implied.deviation.largest < DEVIATION);
    let hidden = implied.eq7.rms / implied.deviation.rms;
    assert!((2.5..4.0).contains(&hidden), "{hidden}");
    let (usual, clean) = (level(USUAL), level(0.0));
    assert!(usual.pooled.rms * 2f64.sqrt() < 0.003, "{:?}", usual.pooled);
    // Teeth: the goal does not hold for a centre by itself, nor is it met without noise only.
    assert!(usual.eq7.rms * 2f64.sqrt() > 0.003 && clean.pooled.rms < 0.0005, "{usual:?}");
    assert!(REPORT.board.levels.last().expect("levels").deviation.largest > DEVIATION);
}

/// What each method leaves, in its order of size.
#[test]
fn methods_leave_what_theory_says() {
    let left = |part: &str, noisy: usize| {
        let method = REPORT.board.methods.iter().find(|method| method.name.starts_with(part));
        method.unwrap_or_else(|| panic!("no {part}")).left[noisy].rms
    };
    // Without noise only the raw ellipses are off; the inner one by a quarter.
    let [outer, inner] = ["centre of the outer", "centre of the inner"].map(|part| left(part, 0));
    assert!(outer > 0.05 && (outer / inner - 4.0).abs() < 0.1, "{outer} {inner}");
    for method in &REPORT.board.methods[2..] {
        assert!(method.left[0].rms < 0.001, "{method:?}");
    }
    // With a known camera or a shared correction less than half the noise.
    let eq7 = left("eq. (7)", 1);
    for part in ["two circles, known camera", "correction shared"] {
        assert!(left(part, 1) < 0.47 * eq7, "{part}: {} of {eq7}", left(part, 1));
    }
    assert!((left("exact form", 1) / eq7 - 1.0).abs() < 0.01);
    // An ellipse's centre taken for the true one shows in the focal length, corrected inside it does not.
    let truth = scene::camera().f;
    let off = |index: usize| (REPORT.board.calibrated[index].cameras[0].focal_length - truth).abs();
    assert!(
        off(1) > 0.2 && off(0) > 0.04 && off(2).max(off(3)) < 0.02,
        "{} {} {} {}",
        off(0),
        off(1),
        off(2),
        off(3)
    );
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_concentric"));
    command.arg("paper").args(arguments).current_dir(folder).output().expect("the program")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

#[test]
fn help_tells_what_is_written_and_a_folder_that_cannot_be_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let help = text(&run(folder.path(), &["--help"]).stdout);
    for part in ["--out <DIR>", "--layout <FILE>", "paper.md", "Examples:"] {
        assert!(help.contains(part), "{part}: {help}");
    }
    std::fs::write(folder.path().join("file"), b"").expect("a file");
    let output = run(folder.path(), &["--out", "file/report"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("cannot write to the folder file/report"), "{message}");
    assert!(output.stdout.is_empty(), "nothing is calculated before");
}

/// The views of the board as if they were someone's photographs.
#[test]
fn methods_are_compared_on_pictures_of_ones_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let layout = &REPORT.board.stages[0].layout;
    layout.write(&folder.path().join("board.layout")).expect("a file");
    let names: Vec<_> = (1..=VIEWS).map(|number| format!("view{number}.png")).collect();
    for (stage, name) in REPORT.board.stages.iter().zip(&names) {
        let picture = stage.picture(USUAL, 1).expect("a picture");
        let [width, height] = [picture.width, picture.height].map(|side| side as u32);
        let image = image::GrayImage::from_raw(width, height, picture.pixels).expect("a picture");
        image.save(folder.path().join(name)).expect("a file");
    }
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    let output = run(folder.path(), &[&["--layout", "board.layout"], &names[..]].concat());
    let printed = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(printed.contains("464 targets in 8 views"), "{printed}");
    assert!(printed.contains("eq. (3), inner ellipse: the compared method"), "{printed}");

    let output = run(folder.path(), &["--camera", "f=2580.645", "--ratio", "0.5", names[0]]);
    let printed = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(printed.contains("two circles, camera") && printed.contains("view1.png: "), "{printed}");

    for (arguments, part) in [
        (&["--layout", "board.layout", "view1.png", "view2.png", "view3.png"][..], "3 views"),
        (&["--layout", "nowhere.layout", "view1.png"], "cannot read layout nowhere.layout"),
        (&["nowhere.png"], "nowhere.png: cannot be read"),
        (&["--layout", "board.layout"], "<IMAGE>"),
    ] {
        let output = run(folder.path(), arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(message.contains(part), "{arguments:?}: {message}");
    }
}
