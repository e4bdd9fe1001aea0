//! `cargo xtask bench`: instructions and bytes of the library on five processors.

mod baseline;
mod features;
mod goals;
mod page;
mod processor;
mod results;
mod run;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, anyhow, bail};

use crate::Root;
use crate::setup::Emulator;
use crate::stack;
use crate::steps::{Tally, output_of};
use processor::{ALL, Processor};
use results::{Measured, Results};
pub use run::FEATURES;
use run::{Frames, Job, counter};

const HELP: &str = "\
Measures instructions, flash and stack of the library on Cortex-M0+, M4F, M33, M7 and RV32IMC, in QEMU.

Usage: cargo xtask bench [OPTIONS]

  --only NAME   one processor: m0plus, m4f, m33, m33-dsp, m7, rv32imc
  --quick       small frames only, and no builds for the flash of the library
  --scene NAME  only frames that have this in their names, as `60 targets 320x240` or `radius 30`,
                and where their instructions go: with all features, and without
  --out FOLDER  write bench.md and bench.json there
  --check       compare with xtask/bench/baseline.json: nothing may be more than 3 % worse
  --bless       write the baseline anew";

#[derive(Debug, Default)]
struct Options {
    only: Option<String>,
    quick: bool,
    scene: Option<String>,
    out: Option<PathBuf>,
    check: bool,
    bless: bool,
}

impl Options {
    fn read(arguments: &[String]) -> Result<Self> {
        let mut options = Self::default();
        let mut arguments = arguments.iter();
        while let Some(argument) = arguments.next() {
            let mut value =
                || arguments.next().cloned().with_context(|| format!("`{argument}` needs a value"));
            match argument.as_str() {
                "--only" => options.only = Some(value()?),
                "--out" => options.out = Some(std::env::current_dir()?.join(value()?)),
                "--quick" => options.quick = true,
                "--scene" => options.scene = Some(value()?),
                "--check" => options.check = true,
                "--bless" => options.bless = true,
                unknown => bail!("no option `{unknown}`; `cargo xtask bench --help` lists them"),
            }
        }
        if options.bless && options.quick {
            bail!("`--bless` needs all frames: leave out `--quick`");
        }
        if options.scene.is_some() && (options.bless || options.check || options.quick) {
            bail!(
                "`--scene` measures some frames by themselves: leave out `--bless`, `--check` and `--quick`"
            );
        }
        Ok(options)
    }
}

/// Compares the kernels of every processor with their models.
pub fn compare_kernels(root: &Root, tally: &mut Tally) -> Result<()> {
    for processor in ALL {
        processor.emulator.ensure()?;
        tally.check(run::compare_kernels(root, &processor));
    }
    Ok(())
}

/// The command.
pub fn command(root: &Root, arguments: &[String]) -> Result<ExitCode> {
    if arguments.iter().any(|argument| ["-h", "--help"].contains(&argument.as_str())) {
        println!("{HELP}");
        return Ok(ExitCode::SUCCESS);
    }
    let options = Options::read(arguments)?;
    let processors = processor::selected(options.only.as_deref())?;
    let (results, page) = match &options.scene {
        Some(scene) => {
            let results = measure(root, &processors, Frames::Named(scene))?;
            let page = page::scene(&results);
            (results, page)
        }
        None => {
            let results =
                measure(root, &processors, if options.quick { Frames::Small } else { Frames::All })?;
            let page = page::page(&results);
            (results, page)
        }
    };
    println!("\n{page}");
    if let Some(folder) = &options.out {
        fs::create_dir_all(folder)?;
        fs::write(folder.join("bench.md"), page)?;
        fs::write(folder.join("bench.json"), serde_json::to_string_pretty(&results)?)?;
    }
    if options.bless {
        baseline::write(root, &results)?;
    }
    let mut tally = Tally::default();
    if options.check {
        check(root, &results, &mut tally)?;
    }
    Ok(if tally.is_good() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The quick form as a step of the test: proofs, equal reports, equal runs, the ratchet.
pub fn step(root: &Root, tally: &mut Tally) -> Result<()> {
    tally.run(counter(root, "clippy").args(["--quiet", "--all-targets", "--", "-D", "warnings"]));
    tally.run_tests(&mut counter(root, "test"))?;
    for processor in &ALL {
        if let Some(mut clippy) = processor.package.clippy(root)? {
            tally.run(&mut clippy);
        }
    }
    let results = measure(root, &ALL, Frames::Small)?;
    check(root, &results, tally)
}

fn measure(root: &Root, processors: &[Processor], frames: Frames<'_>) -> Result<Results> {
    for emulator in [Emulator::Arm, Emulator::Riscv32] {
        if processors.iter().any(|processor| processor.emulator == emulator) {
            emulator.ensure()?;
        }
    }
    if let Err(error) = stack::ensure_disassembler() {
        println!("the bound of the stack is not determined: {error:#}");
    }
    let emulator = output_of(Command::new(processors[0].emulator.program()).arg("--version"));
    let emulator = emulator.and_then(|text| text.lines().next().map(str::to_owned)).unwrap_or_default();
    let job = Job::prepare(root, frames)?;
    let lean = Job::prepare_lean(root, if frames == Frames::All { Frames::Small } else { frames })?;
    let in_full = frames == Frames::All;
    let measured = processors.iter().map(|processor| {
        let measure =
            |job: &Job| job.measure(root, processor, in_full).with_context(|| processor.name.to_owned());
        Ok(Measured { lean: Some(Box::new(measure(&lean)?)), ..measure(&job)? })
    });
    Ok(Results { emulator, processors: measured.collect::<Result<_>>()? })
}

fn check(root: &Root, results: &Results, tally: &mut Tally) -> Result<()> {
    let baseline = baseline::read(root)?;
    for measured in &results.processors {
        let lean = measured.lean.iter().map(|lean| (lean.as_ref(), " without features"));
        for (measured, kind) in lean.chain([(measured, "")]) {
            for (name, is_good) in proofs(measured) {
                let name = || anyhow!("{}{kind}: {name}", measured.processor);
                tally.check(if is_good { Ok(()) } else { Err(name()) });
            }
        }
        let worse = baseline::regressions(&baseline, measured);
        let verdict = anyhow!("{} got worse:\n  {}", measured.processor, worse.join("\n  "));
        tally.check(if worse.is_empty() { Ok(()) } else { Err(verdict) });
    }
    Ok(())
}

/// What has to hold on every processor.
fn proofs(measured: &Measured) -> [(&'static str, bool); 7] {
    let Measured { forbidden, stack, .. } = measured;
    [
        ("panics in the image", forbidden.panic == 0),
        ("the heap in the image", forbidden.heap == 0),
        ("64-bit floats in the image", forbidden.f64 == 0),
        ("recursion", stack.recursion.is_empty()),
        ("more stack than its bound", stack.bound.is_none_or(|bound| stack.measured <= bound)),
        ("reports differ from those of the desktop", measured.reports_are_equal),
        ("two runs differ", measured.runs_are_equal),
    ]
}
