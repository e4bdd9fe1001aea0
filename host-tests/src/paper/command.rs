//! The command line of `paper`.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use clap::Args as ClapArgs;
use concentric::TargetSpec;
use indicatif::{ProgressBar, ProgressStyle};

use super::{board::picture, own, page, plots, report::Report};
use crate::{
    detect::{camera, command::parse_spec},
    layout::Layout,
    picture::Picture,
    table::{BOLD, Table, paint},
};

const EXAMPLES: &str = "\
Examples:
  concentric paper                    everything, in a minute; writes the folder `paper`
  concentric paper --out report       the same into another folder
  concentric paper photo.png          the methods on a picture of your own
  concentric paper --camera f=2580 photo.png
  concentric paper --layout board.layout view*.png

Written are paper.md (printed values, ours, and the difference), figures 4, 5 and 8 as SVG,
6 and 7 as PNG. With pictures of your own nothing is written; what is printed are distances
from eq. (7), because the truth is not known.";

const BAR: &str = "{bar:40} {pos} of {len} experiments, {eta} left";

/// Reproduce the paper: every equation, table and figure, beside what is printed
///
/// Huo et al. 2013, "Eccentricity error identification and compensation for high-accuracy 3D optical measurement". Or
/// compare its methods on pictures of your own
#[derive(Clone, Debug, ClapArgs)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Pictures of your own on which to compare the methods instead: PNG, PGM or JPEG files
    #[arg(value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// Folder for paper.md and the figures
    #[arg(long, value_name = "DIR", default_value = "paper", conflicts_with = "images")]
    out: PathBuf,
    /// What is on the board of which the pictures are views, four or more
    ///
    /// The camera is calibrated from them, so that methods that need poses and radii are there too
    #[arg(long, value_name = "FILE", requires = "images", conflicts_with_all = ["ratio", "camera"])]
    layout: Option<PathBuf>,
    /// Inner radii over the outer radius, or `any`, as for `detect`
    #[arg(long, value_name = "R,R..|any", default_value = "any", value_parser = parse_spec, requires = "images")]
    ratio: TargetSpec,
    /// The camera, as for `detect`: methods that need one are there too
    #[arg(long, value_name = "f=PX|FILE.json", value_parser = camera::parse, requires = "images")]
    camera: Option<camera::Given>,
}

/// Calculates and writes everything, or compares the methods on pictures.
///
/// # Errors
/// A folder that cannot be written to, before anything is calculated; pictures that cannot be read, or on which too little
/// is found for a board.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<()> {
    if !args.images.is_empty() {
        out.write_all(own(args)?.as_bytes())?;
        return Ok(());
    }
    let refused = || format!("cannot write to the folder {}", args.out.display());
    prepare(&args.out).with_context(refused)?;
    let progress = ProgressBar::new(0).with_style(ProgressStyle::with_template(BAR)?);
    let report = Report::new(&progress)?;
    progress.finish_and_clear();
    write!(out, "{}", summary(&report))?;
    write(&report, &args.out).with_context(refused)?;
    writeln!(out, "\nwritten: {}", args.out.join("paper.md").display())?;
    Ok(())
}

fn own(args: &Args) -> Result<String> {
    let read = |path: &PathBuf| Picture::read(path).with_context(|| path.display().to_string());
    let pictures = args.images.iter().map(read).collect::<Result<Vec<_>>>()?;
    if let Some(path) = &args.layout {
        return own::board(pictures, &Layout::read(path)?);
    }
    let text = pictures.iter().map(|picture| {
        let camera = args.camera.map(|given| given.of(picture)).transpose()?;
        own::single(picture, args.ratio, camera).with_context(|| picture.name.clone())
    });
    Ok(text.collect::<Result<Vec<_>>>()?.join("\n"))
}

/// Makes the folder and tries whether it can be written to.
fn prepare(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    tempfile::tempfile_in(folder)?;
    Ok(())
}

fn write(report: &Report, folder: &Path) -> Result<()> {
    let plots = plots::plots(report)?;
    for plot in &plots {
        fs::write(folder.join(plot.file), &plot.svg)?;
    }
    report.single.overlay()?.save(&folder.join("figure6.png"))?;
    picture::draw(&report.board.stages)?.save(folder.join("figure7.png"))?;
    fs::write(folder.join("paper.md"), page::page(report, &page::FIGURES))?;
    Ok(())
}

/// The tables and the board in short.
fn summary(report: &Report) -> String {
    let mut text = String::new();
    for (number, table) in (1..).zip(&report.tables) {
        let mut lines = Table::new(&["row", "printed", "ours", "uncorrected"]);
        for (row, _) in &table.rows {
            let uncorrected = format!("{:.3}", row.outer);
            lines.row(vec![row.label.to_owned(), row.printed.to_owned(), row.rounded(), uncorrected]);
        }
        text += &format!("{}\n{lines}\n", paint(BOLD, &format!("Table {number}, px")));
    }
    let header = ["noise", "found", "deviation", "largest", "eq. (7)", "eq. (3)", "pooled"];
    let mut lines = Table::new(&header);
    for level in &report.board.levels {
        let spreads =
            [level.deviation.rms, level.deviation.largest, level.eq7.rms, level.eq3.rms, level.pooled.rms];
        let mut row = vec![format!("{:.0}", level.noise), level.found.to_string()];
        row.extend(spreads.map(|px| format!("{:.2}", 1000.0 * px)));
        lines.row(row);
    }
    let title = "Board: eq. (3) less eq. (7), and each less the true centre; one coordinate, mpx";
    text + &format!("{}\n{lines}", paint(BOLD, title))
}
