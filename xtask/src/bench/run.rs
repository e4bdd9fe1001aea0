//! Builds the firmware of a processor and runs it in QEMU.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Error, Result, bail, ensure};
use rustc_demangle::demangle;
use serde::Deserialize;

use crate::Root;
use crate::image::{Forbidden, Image};
use crate::stack;
use crate::steps;
use crate::toolchain::Toolchain;

use super::processor::Processor;
use super::results::{Counts, Frame, Measured, Symbols};

/// The function of the firmware that measures a frame.
const ENTRY: &str = "measure_frame";
/// Compiles for size.
const FOR_SIZE: &str = "profile.release.opt-level='s'";
/// Functions that are listed with their instructions, and where few frames are looked at.
const LISTED: usize = 20;
const LISTED_OF_FEW: usize = 60;
/// Longest wait for a firmware. The slowest takes a tenth of it on a slow machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// A frame of the job and what the desktop sends for it.
#[derive(Clone, Debug, Deserialize)]
pub struct Wanted {
    scene: String,
    width: u32,
    height: u32,
    targets: u32,
    dropped: u32,
    report: String,
}

/// Features of the library, each of which takes flash.
pub const FEATURES: [&str; 3] = ["arcs", "camera", "joint"];
/// Leaves them out.
const LEAN: [&str; 1] = ["--no-default-features"];

/// Which frames are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frames<'a> {
    /// All of them.
    All,
    /// The small ones.
    Small,
    /// Those that have this in their names.
    Named(&'a str),
}

impl Frames<'_> {
    fn arguments(self) -> Vec<String> {
        match self {
            Self::All => Vec::new(),
            Self::Small => vec!["--quick".to_owned()],
            Self::Named(name) => vec!["--scene".to_owned(), name.to_owned()],
        }
    }
}

/// What every processor is given.
pub struct Job {
    folder: PathBuf,
    plugin: PathBuf,
    wanted: Vec<Wanted>,
    /// Which features the library is built with, for cargo.
    selection: &'static [&'static str],
    /// Functions that are listed.
    listed: usize,
}

impl Job {
    /// Renders the frames, and builds the plugin that counts.
    ///
    /// # Errors
    /// Something does not build.
    pub fn prepare(root: &Root, frames: Frames<'_>) -> Result<Self> {
        Self::select(root, frames, ("bench", &[]))
    }

    /// The same for the library without its features.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare).
    pub fn prepare_lean(root: &Root, frames: Frames<'_>) -> Result<Self> {
        Self::select(root, frames, ("bench/lean", &LEAN))
    }

    fn select(
        root: &Root,
        frames: Frames<'_>,
        (folder, selection): (&str, &'static [&'static str]),
    ) -> Result<Self> {
        let folder = root.target.join(folder);
        fs::create_dir_all(&folder)?;
        let mut render = root.cargo(&["run", "--quiet", "--release", "--package", "concentric-host"]);
        render.args(selection).args(["--example", "bench", "--"]).arg(&folder);
        render.args(frames.arguments());
        steps::run(&mut render)?;
        let wanted = serde_json::from_slice(&fs::read(folder.join("frames.json"))?)?;
        steps::run(counter(root, "build").args(["--quiet", "--release"]))?;
        let library =
            format!("{}concentric_counter{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let plugin = root.target.join("counter/release").join(library);
        ensure!(plugin.is_file(), "the build left no {}", plugin.display());
        let listed = if matches!(frames, Frames::Named(_)) { LISTED_OF_FEW } else { LISTED };
        Ok(Self { folder, plugin, wanted, selection, listed })
    }

    /// Measures on a processor; `in_full` with what takes more builds.
    ///
    /// # Errors
    /// The firmware does not build or does not run to its end.
    pub fn measure(&self, root: &Root, processor: &Processor, in_full: bool) -> Result<Measured> {
        let built = processor.package.build_with(root, self.selection)?;
        let elf = self.folder.join(processor.id).with_extension("elf");
        fs::copy(&built, &elf)?;
        let image = Image::read(&elf)?;
        let first = self.run(processor, &elf)?;
        let second = self.run(processor, &elf)?;
        let mut measured = self.read(&first)?;
        measured.processor = processor.id.to_owned();
        measured.compiler = Toolchain::find(processor.package.target)?.to_string();
        measured.runs_are_equal = first == second;
        measured.flash = image.flash();
        measured.forbidden = Symbols {
            panic: image.find(Forbidden::Panic).len(),
            heap: image.find(Forbidden::Heap).len(),
            f64: image.find(Forbidden::F64).len(),
        };
        if let Some(bound) = stack::bound(&elf, &image, processor.package.target, ENTRY) {
            let stack = &mut measured.stack;
            stack.bound =
                Some(bound.bytes).filter(|_| bound.unknown.is_empty() && bound.recursion.is_empty());
            (stack.chain, stack.unknown, stack.recursion) = (bound.chain, bound.unknown, bound.recursion);
        }
        if in_full {
            self.measure_flash(root, processor, &mut measured)?;
        }
        Ok(measured)
    }

    fn measure_flash(&self, root: &Root, processor: &Processor, measured: &mut Measured) -> Result<()> {
        let flash = |arguments: &[&str]| {
            Ok::<_, Error>(Image::read(&processor.package.build_with(root, arguments)?)?.flash())
        };
        let without = flash(&[self.selection, &["--features", "empty"]].concat())?;
        measured.library_flash = measured.flash.checked_sub(without);
        let for_size = ["--config", FOR_SIZE, "--features", "panics-halt"];
        let all = flash(&[self.selection, &for_size].concat())?;
        measured.library_flash_small = all.checked_sub(without);
        for feature in FEATURES.into_iter().filter(|_| self.selection.is_empty()) {
            let others: Vec<&str> = FEATURES.into_iter().filter(|other| *other != feature).collect();
            let others = others.join(",");
            let less = flash(&[&LEAN[..], &["--features", &others], &for_size].concat())?;
            if let Some(bytes) = all.checked_sub(less) {
                measured.features.insert(feature.to_owned(), bytes);
            }
        }
        Ok(())
    }

    /// What the firmware prints, and what the plugin writes.
    fn run(&self, processor: &Processor, elf: &Path) -> Result<[String; 2]> {
        let file = |name: &str| self.folder.join(format!("{}.{name}", processor.id));
        let (printed, counted) = (file("out"), file("counts"));
        let mut qemu = emulator(processor);
        let frames = self.folder.join("frames.bin");
        let loader = format!("loader,file={},addr={:#x},force-raw=on", frames.display(), processor.frames);
        let plugin = format!("{},model={},out={}", self.plugin.display(), processor.model, counted.display());
        qemu.args(["-device", &loader, "-plugin", &plugin, "-kernel"]).arg(elf);
        qemu.stdin(Stdio::null()).stdout(File::create(&printed)?);
        run_to_end(&mut qemu)
            .with_context(|| format!("{} in {}", elf.display(), processor.emulator.program()))?;
        Ok([fs::read_to_string(printed)?, fs::read_to_string(counted)?])
    }

    fn read(&self, [printed, counted]: &[String; 2]) -> Result<Measured> {
        let mut measured = Measured { reports_are_equal: true, ..Measured::default() };
        let lines: Vec<&str> = printed.lines().collect();
        ensure!(lines.len() == self.wanted.len(), "{} of {} frames measured", lines.len(), self.wanted.len());
        for ((number, wanted), line) in (0..).zip(&self.wanted).zip(lines) {
            let words: Vec<&str> = line.split(' ').collect();
            let &[at, stack, storage, report] = &words[..] else { bail!("the firmware prints `{line}`") };
            ensure!(at.parse() == Ok(number), "frame {at} instead of {number}");
            measured.reports_are_equal &= report == wanted.report;
            measured.stack.measured = measured.stack.measured.max(stack.parse()?);
            let Wanted { scene, width, height, targets, dropped, .. } = wanted.clone();
            let storage = storage.parse()?;
            measured.frames.push(Frame {
                scene,
                width,
                height,
                targets,
                dropped,
                storage,
                ..Frame::default()
            });
        }
        for line in counted.lines() {
            take_counts(line, &mut measured).with_context(|| format!("the plugin writes `{line}`"))?;
        }
        measured.functions.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        measured.functions.truncate(self.listed);
        Ok(measured)
    }
}

/// A line of the plugin: the counts of a region of a frame, or the instructions of a function.
fn take_counts(line: &str, measured: &mut Measured) -> Result<()> {
    if let Some(function) = line.strip_prefix("function ") {
        let (name, instructions) = function.rsplit_once(' ').context("no count")?;
        measured.functions.push((format!("{:#}", demangle(name)), instructions.parse()?));
        return Ok(());
    }
    let numbers: Vec<u64> = line.split(' ').map(str::parse).collect::<Result<_, _>>()?;
    let &[frame, region, instructions, loads, stores, branches, cycles] = &numbers[..] else {
        bail!("not seven numbers")
    };
    let frame = measured.frames.get_mut(usize::try_from(frame)?).context("no such frame")?;
    let counts = Counts { instructions, loads, stores, branches, cycles };
    match region {
        1 => frame.scan = counts,
        2 => frame.target = counts,
        3 => frame.report = counts,
        _ => bail!("no such region"),
    }
    Ok(())
}

/// Runs the firmware of a processor that compares its kernels with models of them; prints what it found.
///
/// # Errors
/// The firmware does not build, or a kernel differs from its model, or it did not notice a flaw.
pub fn compare_kernels(root: &Root, processor: &Processor) -> Result<()> {
    let elf = processor.package.build_with(root, &[&LEAN[..], &["--features", "kernels"]].concat())?;
    let printed = elf.with_extension("out");
    let mut qemu = emulator(processor);
    qemu.arg("-kernel").arg(&elf).stdin(Stdio::null()).stdout(File::create(&printed)?);
    let end = run_to_end(&mut qemu);
    print!("{}:\n{}", processor.name, fs::read_to_string(printed)?);
    end.with_context(|| format!("kernels of {}", processor.name))
}

/// The emulator of a processor, whose output is the firmware's.
fn emulator(processor: &Processor) -> Command {
    let mut qemu = Command::new(processor.emulator.program());
    qemu.args(processor.machine).args(["-display", "none", "-serial", "none", "-monitor", "none"]);
    qemu.args(["-chardev", "stdio,id=out"]);
    qemu.args(["-semihosting-config", "enable=on,target=native,chardev=out"]);
    qemu
}

/// `cargo SUBCOMMAND` for the plugin that counts.
pub fn counter(root: &Root, subcommand: &str) -> Command {
    let mut command =
        root.cargo(&[subcommand, "--manifest-path", "xtask/counter/Cargo.toml", "--target-dir"]);
    command.arg(root.target.join("counter"));
    command
}

/// Runs a program that has to succeed, and not for ever.
fn run_to_end(command: &mut Command) -> Result<()> {
    let began = Instant::now();
    let mut child = command.spawn()?;
    loop {
        if let Some(status) = child.try_wait()? {
            ensure!(status.success(), "{status}");
            return Ok(());
        }
        if began.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            bail!("not done within {} s", PATIENCE.as_secs());
        }
        thread::sleep(Duration::from_millis(20));
    }
}
