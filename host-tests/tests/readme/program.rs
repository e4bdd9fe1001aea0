//! What the program prints, and the commands that the README names.

use std::{path::Path, process::Command};

use crate::{document::verbatim, read};

const RUN: &str = "cargo run --release";

/// What the program prints on standard output, run in `folder`.
pub fn run(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_concentric")).args(arguments).current_dir(folder).output();
    let output = output.expect("the program runs");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The output without the time that it took.
fn timeless(output: &str) -> String {
    let words = output.split(' ').collect::<Vec<_>>();
    let is_time = |i: usize| words.get(i + 1).is_some_and(|unit| unit.starts_with("ms"));
    let number = |word: &str| word.parse::<f64>().is_ok();
    let kept =
        words.iter().enumerate().map(|(i, &word)| if is_time(i) && number(word) { "..." } else { word });
    kept.collect::<Vec<_>>().join(" ")
}

pub fn demo() -> String {
    let folder = tempfile::tempdir().expect("a folder");
    verbatim(&timeless(&run(folder.path(), &[])))
}

/// The output of the last of the commands that the README gives for `photo.png`, after those before it.
pub fn detect(readme: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let outputs = commands(readme)
        .filter(|arguments| arguments.contains("photo.png"))
        .map(|arguments| run(folder.path(), &arguments.split_whitespace().collect::<Vec<_>>()));
    verbatim(&timeless(&outputs.last().expect("a command with photo.png")))
}

/// The arguments of every command that is named.
fn commands(readme: &str) -> impl Iterator<Item = &str> {
    let rest = readme.split(RUN).skip(1).filter_map(|rest| rest.split(['\n', '`']).next());
    rest.map(|arguments| arguments.trim().trim_start_matches("--").trim())
}

#[test]
fn commands_exist() {
    let (readme, help) = (read("README.md"), run(Path::new("."), &["--help"]));
    let names =
        |text: &str, word: &str| text.lines().any(|line| line.trim_start().starts_with(&format!("{word} ")));
    let commands: Vec<_> =
        commands(&readme).filter_map(|arguments| arguments.split_whitespace().next()).collect();
    for command in &commands {
        assert!(names(&help, command), "`{RUN} -- {command}`: no such command");
    }
    for shown in ["detect", "render", "monitor"] {
        assert!(commands.contains(&shown), "no command shows `{shown}`");
    }
    let tasks = read("xtask/src/main.rs");
    for page in [readme, read("CONTRIBUTING.md")] {
        for rest in page.split("cargo xtask ").skip(1) {
            let task: String = rest.chars().take_while(|c| c.is_ascii_alphanumeric()).collect();
            assert!(names(&tasks, &task), "`cargo xtask {task}`: no such command");
        }
    }
}
