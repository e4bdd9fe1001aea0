//! Arguments of `monitor`, and its loop over the stream.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::{Path, PathBuf},
    sync::mpsc::{RecvTimeoutError, Sender, channel},
    time::Duration,
};

use anyhow::{Context, Result, anyhow, bail, ensure};
use clap::Args as ClapArgs;

use super::ask::Word;
use super::{Counts, Event, Monitor, Source, json};

/// Decode a camera head's stream of reports to one JSON object per message and line.
///
/// The last line has the counts: frames lost, messages damaged. Damage is told on standard error as it comes.
#[derive(Clone, Debug, ClapArgs)]
pub struct Args {
    /// A file, `-` for standard input, tcp:HOST:PORT, or a serial port such as /dev/ttyACM0, /dev/pts/3 or COM3
    #[arg(value_name = "SOURCE")]
    source: Source,

    /// Speed of the serial port, bits per second
    #[arg(long, default_value_t = 115_200, value_parser = clap::value_parser!(u32).range(1..))]
    baud: u32,

    /// Print the counts only
    #[arg(long)]
    quiet: bool,

    /// Record the bytes of the stream in FILE
    #[arg(long, value_name = "FILE")]
    raw: Option<PathBuf>,

    /// Stop after N frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,

    /// Tell the head: settings, hello, ratio=0.5 or ratio=0.75,0.5 or ratio=any, polarity=dark|light,
    /// compensation=none|eq7|exact|auto|known, detail=terse|normal|full, format=binary|text,
    /// whole-every=N (search one frame in N as a whole, the others where targets are expected),
    /// px-per-run=N (follow at most one dark run for so many pixels of the frame),
    /// effort=full|quick (quick: less time for each target, a little more error); can be given several times
    #[arg(long, value_name = "WHAT")]
    command: Vec<Word>,

    /// Give up when nothing arrives for S seconds
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    timeout: Option<Duration>,
}

fn parse_seconds(text: &str) -> Result<Duration> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.filter(|seconds| !seconds.is_zero()).context("wanted a number of seconds above 0, as in 2.5")
}

/// Runs the command on the standard streams.
///
/// # Errors
/// A source that cannot be read or holds no message, `--raw` that cannot be written, silence for longer than
/// `--timeout`; each names the source or the file.
pub fn run(args: &Args) -> Result<()> {
    execute(args, &mut io::stdout().lock(), &mut io::stderr())
}

/// Runs the command; lines go to `out`, what is wrong with the stream but ends nothing to `notes`.
///
/// # Errors
/// As for [`run`].
pub fn execute(args: &Args, out: &mut dyn Write, notes: &mut dyn Write) -> Result<()> {
    let mut monitor = Monitor::default();
    let end = listen(args, &mut monitor, out, notes);
    let counts = if matches!(end, Ok(End::Stream)) { monitor.finish() } else { monitor.counts() };
    if counts.truncated > 0 {
        let pending = monitor.pending();
        note(
            notes,
            args,
            &format!("the stream ends in mid-message: {pending} bytes after the last separator"),
        );
    }
    writeln!(out, "{}", json::summary(&counts))?;
    out.flush()?;
    if matches!(end?, End::Stream) {
        ensure_messages(args, &counts)?;
    }
    Ok(())
}

/// Where lines, notes and the tags of answers go.
struct Output<'a> {
    out: &'a mut dyn Write,
    notes: &'a mut dyn Write,
    answers: Sender<u16>,
}

/// Why the listening ended well.
enum End {
    Stream,
    Count,
}

fn listen(args: &Args, monitor: &mut Monitor, out: &mut dyn Write, notes: &mut dyn Write) -> Result<End> {
    let source = &args.source;
    let mut raw = args.raw.as_ref().map(|path| Record::create(path, source)).transpose()?;
    ensure!(
        args.command.is_empty() || source.has_way_back(),
        "{source}: commands need a serial port or tcp:HOST:PORT"
    );
    let (answers, answered) = channel();
    let chunks = source.clone().read(args.baud, args.command.clone(), answered);
    let mut output = Output { out, notes, answers };
    loop {
        let chunk = match args.timeout {
            None => chunks.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(timeout) => chunks.recv_timeout(timeout),
        };
        let chunk = match chunk {
            // As text: an error of the source must not pass for one of the output.
            Ok(chunk) => chunk.map_err(|error| anyhow!("{source}: {error}"))?,
            Err(RecvTimeoutError::Disconnected) => return Ok(End::Stream),
            Err(RecvTimeoutError::Timeout) => {
                bail!("{source}: nothing arrived for {} s", args.timeout.unwrap_or_default().as_secs_f64())
            }
        };
        let taken = take(args, &chunk, monitor, &mut output)?;
        if let Some(raw) = &mut raw {
            raw.write(&chunk[..taken])?;
        }
        if args.count.is_some_and(|count| monitor.counts().frames >= count) {
            return Ok(End::Count);
        }
    }
}

/// Takes bytes of `chunk` up to its end or the last frame wanted; returns how many.
fn take(args: &Args, chunk: &[u8], monitor: &mut Monitor, output: &mut Output<'_>) -> Result<usize> {
    let Output { out, notes, answers } = output;
    for (index, &byte) in chunk.iter().enumerate() {
        match monitor.push(byte) {
            Some(Event::Line(line)) if !args.quiet => writeln!(out, "{line}")?,
            Some(Event::Answer(tag, line)) => {
                if !args.quiet {
                    writeln!(out, "{line}")?;
                }
                // Commands that were given up wait for no answer.
                let _ = answers.send(tag);
            }
            Some(Event::Damaged { error, len, at }) => {
                note(*notes, args, &format!("{len} bytes at byte {at}: {error}"));
            }
            Some(Event::Line(_)) | None => {}
        }
        if args.count.is_some_and(|count| monitor.counts().frames >= count) {
            return Ok(index + 1);
        }
    }
    Ok(chunk.len())
}

fn note(notes: &mut dyn Write, args: &Args, text: &str) {
    // Where standard error is closed there is nobody left to tell.
    let _ = writeln!(notes, "concentric: {}: {text}", args.source);
}

fn ensure_messages(args: &Args, counts: &Counts) -> Result<()> {
    let Counts { bytes, hellos, frames, .. } = counts;
    let source = &args.source;
    ensure!(*bytes > 0, "{source}: empty; wanted a stream of reports");
    ensure!(hellos + frames > 0, "{source}: no report in {bytes} bytes; wanted the stream of a camera head");
    Ok(())
}

/// The file of `--raw`.
struct Record {
    path: PathBuf,
    file: File,
}

impl Record {
    fn create(path: &Path, source: &Source) -> Result<Self> {
        if let Source::File(read) = source {
            let same =
                fs::canonicalize(read).is_ok_and(|read| fs::canonicalize(path).is_ok_and(|it| it == read));
            ensure!(!same, "{}: cannot be read and recorded over at once", path.display());
        }
        let file = File::create(path).map_err(|error| Self::error(path, &error))?;
        Ok(Self { path: path.to_owned(), file })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).map_err(|error| Self::error(&self.path, &error))
    }

    fn error(path: &Path, error: &io::Error) -> anyhow::Error {
        anyhow!("{}: {error}", path.display())
    }
}
