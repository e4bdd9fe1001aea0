//! Plays the camera of the firmware in QEMU, for somebody who listens to its serial port.
//! `cargo xtask mps2` builds the firmware and runs this.

use std::env;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use concentric_host::link::protocol::Frame;
use concentric_host::link::{Head, MPS2_AN386, Serial, sample_frames};
use concentric_host::picture::Picture;

/// Runs the camera head in QEMU: it measures the images and sends its reports to whoever connects to its serial port.
#[derive(Parser)]
#[command(bin_name = "cargo xtask mps2")]
struct Args {
    /// TCP port of this machine that serves as the head's serial port.
    #[arg(long, default_value_t = 5555, value_parser = clap::value_parser!(u16).range(1..))]
    port: u16,
    /// Inner radius of the targets / outer radius, 0.1 to 0.95; any circles without it.
    #[arg(long, value_parser = ratio)]
    ratio: Option<f32>,
    /// The targets are light on dark.
    #[arg(long)]
    light: bool,
    /// PNG, JPEG or PGM images up to 2048 px wide; without any, ten rendered frames.
    images: Vec<PathBuf>,
}

fn ratio(text: &str) -> Result<f32, String> {
    let range = 0.1..=0.95;
    text.parse()
        .ok()
        .filter(|ratio| range.contains(ratio))
        .ok_or_else(|| "must be a number from 0.1 to 0.95".into())
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo xtask mps2: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args) -> Result<()> {
    let variable = MPS2_AN386.elf;
    let elf = env::var_os(variable)
        .with_context(|| format!("{variable} does not name a firmware; use `cargo xtask mps2`"))?;
    let frames = frames(&args.images)?;
    println!("The head boots as soon as somebody listens to its serial port. In another terminal:");
    println!("\n    cargo run --release -- monitor tcp:127.0.0.1:{}\n", args.port);
    let mut head = Head::boot(MPS2_AN386, &PathBuf::from(elf), Serial::Served(args.port))?;
    let settings = Frame {
        width: 0,
        height: 0,
        ratio: args.ratio.map_or(0, |ratio| (ratio * Frame::RATIO_ONE as f32) as u32),
        light: args.light.into(),
        compensation: 2,
        detail: 2,
    };
    let mut refused = 0;
    for (number, picture) in (1..).zip(&frames) {
        println!("frame {number} is {}", picture.name);
        let frame = Frame { width: picture.width as u32, height: picture.height as u32, ..settings };
        if let Err(error) = head.measure(frame, &picture.pixels) {
            refused += 1;
            eprintln!("{}: {error:#}", picture.name);
        }
    }
    let (status, _) = head.exit(0)?;
    ensure!(status.success(), "the head ended with {status}");
    ensure!(refused == 0, "{refused} of {} frames were not measured", frames.len());
    Ok(())
}

fn frames(images: &[PathBuf]) -> Result<Vec<Picture>> {
    if images.is_empty() { sample_frames() } else { images.iter().map(|path| Picture::read(path)).collect() }
}
