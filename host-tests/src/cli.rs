//! The command line: subcommands, exit codes, and what happens to errors.

use std::{
    io::{self, Write},
    process::ExitCode,
};

use clap::{Parser, Subcommand};

use crate::{accuracy, calibrate, demo, detect, monitor, paper, render, sheet};

const EXAMPLES: &str = "\
Examples:
  concentric                                      a demonstration on a rendered board
  concentric detect photo.png                     true centres of all targets, as a table
  concentric detect --ratio 0.5 --overlay marked.png photo.jpg
  concentric detect --json *.png | jq .targets
  concentric calibrate --layout board.txt views/  the camera, from pictures of a board with coded targets
  concentric render --tilt 40 --out frame.png     a frame to try it on, with the truth beside it
  concentric sheet board --out board              58 + 5 targets to print, with their layout
  concentric monitor /dev/ttyACM0                 reports of a camera head as JSON lines
  cat photo.pgm | concentric detect --csv -

Exit codes: 0 done, also where no target was found; 2 wrong arguments, or a file that cannot be read or written.";

/// True centres of concentric-circle targets in images.
#[derive(Debug, Parser)]
#[command(name = "concentric", version, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Detect(detect::command::Args),
    Calibrate(calibrate::command::Args),
    Render(Box<render::command::Args>),
    Sheet(sheet::command::Args),
    Monitor(monitor::command::Args),
    Accuracy(accuracy::command::Args),
    Paper(paper::command::Args),
    Demo(demo::Args),
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let command = Cli::parse().command.unwrap_or(Command::Demo(demo::Args::default()));
    let mut out = anstream::stdout();
    let result = match command {
        Command::Detect(args) => detect::command::execute(&args, &mut out),
        Command::Calibrate(args) => calibrate::command::execute(&args, &mut out),
        Command::Render(args) => render::command::run(&args).map(|()| true),
        Command::Sheet(args) => sheet::command::execute(&args, &mut out).map(|()| true),
        Command::Monitor(args) => monitor::command::run(&args).map(|()| true),
        Command::Accuracy(args) => accuracy::command::execute(&args, &mut out).map(|()| true),
        Command::Paper(args) => paper::command::execute(&args, &mut out).map(|()| true),
        Command::Demo(args) => demo::execute(&args, &mut out).map(|()| true),
    };
    match result.and_then(|all_well| out.flush().map(|()| all_well).map_err(Into::into)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(2),
        // Whoever reads the output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&format!("{error:#}"));
            ExitCode::from(2)
        }
    }
}

/// Prints one line to standard error.
pub fn complain(message: &str) {
    // Where standard error is closed there is nobody left to tell.
    let _ = writeln!(anstream::stderr(), "concentric: {message}");
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    };
    error.chain().any(broken)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn arguments_are_consistent() {
        super::Cli::command().debug_assert();
    }
}
