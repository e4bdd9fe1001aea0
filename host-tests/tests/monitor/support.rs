//! The command on streams made here.

use std::{fs, path::Path};

use clap::Parser;
use concentric::report::{Detail, HELLO_MAX_LEN, Hello, Report, Version, max_len};
use concentric::track::Tracker;
use concentric::{Circle, Covariance, Dropped, Ellipse, Flags, Position, Reject, Summary, Target};
use concentric_host::monitor::command::{Args, execute};
use serde_json::Value;
use tempfile::TempDir;

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: Args,
}

pub struct Outcome {
    pub lines: Vec<Value>,
    pub notes: String,
    pub error: Option<String>,
}

impl Outcome {
    pub fn summary(&self) -> &Value {
        self.lines.last().unwrap()
    }

    pub fn seqs(&self) -> Vec<u64> {
        self.lines.iter().filter_map(|line| line["seq"].as_u64()).collect()
    }
}

pub fn monitor(arguments: &[&str]) -> Outcome {
    let args = Cli::try_parse_from([&["monitor"], arguments].concat()).unwrap().args;
    let (mut out, mut notes) = (Vec::new(), Vec::new());
    let error = execute(&args, &mut out, &mut notes).err().map(|error| format!("{error:#}"));
    let lines = String::from_utf8(out).unwrap();
    let lines = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    Outcome { lines, notes: String::from_utf8(notes).unwrap(), error }
}

pub fn refusal(arguments: &[&str]) -> String {
    Cli::try_parse_from([&["monitor"], arguments].concat()).err().expect("refused").to_string()
}

pub fn target() -> Target {
    let at = |x: i32, y: i32| Position { x, y };
    let circle = |ratio: f32| Circle {
        ellipse: Ellipse { centre: at(66048, 131072), a: 64.25 * ratio, b: 32.5 * ratio, theta: 0.5 },
        covariance: Covariance::default(),
        rms: 0.03125,
        points: 77,
        gap: 33.75,
        ratio,
        measured_ratio: ratio * 0.75,
    };
    let mut target = Target {
        centre: at(65536 + 16384, 2 * 65536 - 32768),
        covariance: Covariance { xx: 1.0 / 16384.0, xy: 0.0, yy: 4.0 },
        eq7: at(65536, 65536),
        exact: at(-65536, 0),
        contrast: 180.5,
        noise: 2.25,
        blur: 0.75,
        flags: Flags(Flags::LIGHT.0 | Flags::SMALL.0),
        ..Target::default()
    };
    target.circles.push(circle(1.0)).unwrap();
    target.circles.push(circle(0.5)).unwrap();
    target
}

pub fn hello() -> Vec<u8> {
    let firmware = Version { major: 3, minor: 2, patch: 1 };
    Hello::new(firmware, 1280, Detail::Terse).encode(&mut [0; HELLO_MAX_LEN]).unwrap().to_vec()
}

pub fn frame(seq: u32, detail: Detail, targets: usize) -> Vec<u8> {
    let mut report = Report::<4>::new(detail);
    report.begin(seq);
    let mut tracker = Tracker::<4>::new();
    (0..targets).for_each(|_| report.push_tracked(&target(), tracker.follow(&target()).as_ref()));
    let rejected = [(Reject::Alone, 3), (Reject::Ratio, 0)].into_iter().collect();
    let dropped = Dropped { runs: 1, outlines: 2, crossings: 3 };
    let targets_found = targets as u32;
    let summary = Summary {
        width: 640,
        height: 480,
        limited: true,
        targets: targets_found,
        rejected,
        dropped,
        unsearched: 6,
        ..Summary::default()
    };
    report.finish(&summary, &mut [0; max_len(4, Detail::Full)]).unwrap().to_vec()
}

pub fn stream(seqs: impl IntoIterator<Item = u32>) -> Vec<u8> {
    let frames = seqs.into_iter().map(|seq| frame(seq, Detail::Normal, 1));
    std::iter::once(hello()).chain(frames).flatten().collect()
}

pub fn file(folder: &TempDir, bytes: &[u8]) -> String {
    let path = folder.path().join("stream.bin");
    fs::write(&path, bytes).unwrap();
    name(&path)
}

pub fn name(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

pub fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}
