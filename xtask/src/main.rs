//! `cargo xtask`: builds, checks and runs concentric for every target.

mod bench;
mod boards;
mod checks;
mod firmware;
mod image;
mod package;
mod setup;
mod stack;
mod steps;
mod toolchain;
mod wrapper;

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use steps::{Steps, Tally};

const HELP: &str = "\
Builds, checks and runs concentric for every target.

Usage: cargo xtask COMMAND

  test      everything below up to bench; ends with the sum of passed and failed checks
  setup     install what the other commands need, or say what to install
  fmt       is the code formatted?
  lint      clippy, warnings are errors
  doc       documentation, warnings are errors
  host      tests of the library and of the desktop program
  firmware  build the firmware, print its sizes, look for panics, heap and f64 arithmetic in it
  boards    build the firmware of boards that are not emulated, and the library with its logs
  qemu      run the firmware in QEMU: every processor's kernels must give what slow models give, and
            the reports must equal the desktop's byte for byte
  bench     count instructions and bytes on five processors, see `cargo xtask bench --help`
  mps2      run the firmware by hand, see `cargo xtask mps2 --help`

Environment:
  CONCENTRIC_TOOLCHAIN  compiler of firmware: `target` (a compiler that has the target, as with
                        `rustup target add`) or `distribution` (the distribution's compiler and source);
                        unset: the first that is there
  CONCENTRIC_PHOTOS     folder of the photographs for the host tests; they are skipped without it
  CARGO_TARGET_DIR      as for cargo";

/// The work of a step.
type Step = fn(&Root, &mut Tally) -> Result<()>;

/// Steps of `test`, in order.
const STEPS: [(&str, Step); 9] = [
    ("setup", setup::step),
    ("fmt", checks::fmt),
    ("lint", checks::lint),
    ("doc", checks::doc),
    ("host", checks::host),
    ("firmware", firmware::step),
    ("boards", boards::step),
    ("qemu", firmware::qemu_step),
    ("bench", bench::step),
];

/// Where things are.
struct Root {
    /// Folder of the checkout.
    folder: PathBuf,
    /// Folder of what cargo builds.
    target: PathBuf,
}

impl Root {
    fn find() -> Result<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).parent().context("xtask has no parent folder")?;
        let target = match env::var_os("CARGO_TARGET_DIR") {
            Some(given) => env::current_dir()?.join(given),
            None => folder.join("target"),
        };
        Ok(Self { folder: folder.to_path_buf(), target })
    }

    /// The cargo that runs this program, in the checkout.
    fn cargo(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.current_dir(&self.folder).args(arguments);
        command
    }
}

fn main() -> ExitCode {
    if wrapper::is_wanted() {
        return wrapper::run();
    }
    let arguments: Vec<String> = env::args().skip(1).collect();
    run(&arguments).unwrap_or_else(|error| {
        eprintln!("xtask: {error:#}");
        ExitCode::from(2)
    })
}

fn run(arguments: &[String]) -> Result<ExitCode> {
    let Some((command, rest)) = arguments.split_first() else {
        println!("{HELP}");
        return Ok(ExitCode::from(2));
    };
    let root = Root::find()?;
    match command.as_str() {
        "-h" | "--help" | "help" => {
            println!("{HELP}");
            return Ok(ExitCode::SUCCESS);
        }
        "mps2" => return firmware::play(&root, rest),
        "bench" => return bench::command(&root, rest),
        _ => {}
    }
    if let Some(unknown) = rest.first() {
        bail!("`{command}` takes no arguments, but `{unknown}` was given");
    }
    let mut steps = Steps::default();
    for (name, work) in STEPS {
        if command == "test" || command == name {
            steps.run(name, |tally| work(&root, tally));
        }
    }
    if steps.is_empty() {
        bail!("no command `{command}`; `cargo xtask --help` lists them");
    }
    Ok(steps.close())
}
