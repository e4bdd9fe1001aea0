//! Runs the steps of the test, counts what passes, and sums it up.

use std::io::{BufRead, BufReader};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

/// Checks of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    passed: u32,
    failed: u32,
}

impl Tally {
    /// Counts a check, and says why it failed.
    pub fn check(&mut self, outcome: Result<()>) {
        match outcome {
            Ok(()) => self.passed += 1,
            Err(error) => {
                self.failed += 1;
                println!("xtask: failed: {error:#}");
            }
        }
    }

    /// Whether nothing failed.
    pub fn is_good(self) -> bool {
        self.failed == 0
    }

    /// Runs a command that counts as one check.
    pub fn run(&mut self, command: &mut Command) {
        self.check(run(command));
    }

    /// Runs `cargo test` and counts its tests.
    pub fn run_tests(&mut self, command: &mut Command) -> Result<()> {
        announce(command);
        let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| cannot_run(command))?;
        let mut tests = Tally::default();
        if let Some(output) = child.stdout.take() {
            for line in BufReader::new(output).lines() {
                let line = line?;
                println!("{line}");
                tests.add(Self::of_result_line(&line).unwrap_or_default());
            }
        }
        let succeeded = child.wait()?.success();
        self.add(tests);
        // A test program that does not compile, or dies, prints no result to be counted.
        ensure!(succeeded || tests.failed > 0, "{} failed outside its tests", line_of(command));
        ensure!(tests.passed + tests.failed > 0, "{} ran no test", line_of(command));
        Ok(())
    }

    fn add(&mut self, other: Tally) {
        self.passed += other.passed;
        self.failed += other.failed;
    }

    /// Reads `test result: ok. 12 passed; 0 failed; ...`.
    fn of_result_line(line: &str) -> Option<Self> {
        let (_, counts) = line.strip_prefix("test result: ")?.split_once(". ")?;
        let count = |word: &str| {
            let number = counts.split("; ").find_map(|part| part.strip_suffix(word))?;
            number.trim().parse().ok()
        };
        Some(Self { passed: count("passed")?, failed: count("failed")? })
    }
}

/// The steps that were run.
#[derive(Default)]
pub struct Steps(Vec<(&'static str, Tally, Duration)>);

impl Steps {
    /// Runs a step. What goes wrong in it is counted and does not keep the next one from running.
    pub fn run(&mut self, name: &'static str, work: impl FnOnce(&mut Tally) -> Result<()>) {
        println!("==> {name}");
        let began = Instant::now();
        let mut tally = Tally::default();
        if let Err(error) = work(&mut tally) {
            tally.check(Err(error));
        }
        let time = began.elapsed();
        println!("==> {}", line(name, tally, time));
        self.0.push((name, tally, time));
    }

    /// Whether no step was run.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Prints the summary.
    pub fn close(self) -> ExitCode {
        let mut sum = Tally::default();
        println!();
        for &(name, tally, time) in &self.0 {
            println!("{}", line(name, tally, time));
            sum.add(tally);
        }
        println!("{} passed, {} failed", sum.passed, sum.failed);
        if sum.failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

fn line(name: &str, tally: Tally, time: Duration) -> String {
    let verdict = if tally.failed == 0 { "ok" } else { "FAILED" };
    let Tally { passed, failed } = tally;
    format!("{name:<9} {verdict:<6} {passed:>4} passed {failed:>3} failed {:>7.1} s", time.as_secs_f64())
}

/// Runs a command to its end, its output shown.
///
/// # Errors
/// It cannot be started, or fails.
pub fn run(command: &mut Command) -> Result<()> {
    announce(command);
    let status = command.status().with_context(|| cannot_run(command))?;
    if !status.success() {
        bail!("{}: {status}", line_of(command));
    }
    Ok(())
}

/// What a command prints, without the white space around it; `None` when it cannot be run or fails.
pub fn output_of(command: &mut Command) -> Option<String> {
    let output = command.stderr(Stdio::null()).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn announce(command: &Command) {
    println!("  $ {}", line_of(command));
}

fn cannot_run(command: &Command) -> String {
    format!("cannot run {}", command.get_program().display())
}

/// The command as it would be typed, the program without its folder.
fn line_of(command: &Command) -> String {
    let program = std::path::Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_results_of_the_tests_are_counted() {
        let ok =
            "test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 3 filtered out; finished in 0.10s";
        let bad =
            "test result: FAILED. 3 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1s";
        assert_eq!(Tally::of_result_line(ok), Some(Tally { passed: 12, failed: 0 }));
        assert_eq!(Tally::of_result_line(bad), Some(Tally { passed: 3, failed: 2 }));
        assert_eq!(Tally::of_result_line("test scan::rows ... ok"), None);
    }

    #[test]
    fn a_step_that_goes_wrong_fails_the_whole() {
        let mut steps = Steps::default();
        steps.run("good", |tally| {
            tally.check(Ok(()));
            Ok(())
        });
        assert_eq!(steps.0.iter().map(|(_, tally, _)| tally.failed).sum::<u32>(), 0);
        steps.run("bad", |_| bail!("on purpose"));
        assert_eq!(steps.0.iter().map(|(_, tally, _)| tally.failed).sum::<u32>(), 1);
    }
}
