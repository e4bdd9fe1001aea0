//! The command line of `paper`.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use clap::Args as ClapArgs;
use indicatif::{ProgressBar, ProgressStyle};

use super::{page, plots, report::Report};
use crate::table::{BOLD, Table, paint};

const EXAMPLES: &str = "\
Examples:
  concentric paper                    everything, in a minute; writes the folder `paper`
  concentric paper --out report       the same into another folder

Written are paper.md (printed values, ours, and the difference), figures 4, 5 and 8 as SVG,
6 and 7 as PNG.";

const BAR: &str = "{bar:40} {pos} of {len} experiments, {eta} left";

/// Reproduce the paper: every equation, table and figure, beside what is printed.
///
/// Huo et al. 2013, \"Eccentricity error identification and compensation for high-accuracy 3D optical measurement\"
#[derive(Clone, Debug, ClapArgs)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Folder for paper.md and the figures
    #[arg(long, value_name = "DIR", default_value = "paper")]
    out: PathBuf,
}

/// Calculates and writes everything.
///
/// # Errors
/// A folder that cannot be written to, before anything is calculated.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<()> {
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

/// Makes the folder and tries whether it can be written to.
fn prepare(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    tempfile::tempfile_in(folder)?;
    Ok(())
}

fn write(report: &Report, folder: &Path) -> Result<()> {
    for plot in plots::plots(report)? {
        fs::write(folder.join(plot.file), &plot.svg)?;
    }
    report.single.overlay()?.save(&folder.join("figure6.png"))?;
    fs::write(folder.join("paper.md"), page::page(report))?;
    Ok(())
}

/// Tables 1 and 2 in short.
fn summary(report: &Report) -> String {
    let mut text = String::new();
    for (number, table) in (1..).zip(&report.tables) {
        let mut lines = Table::new(&["row", "printed", "ours", "uncorrected"]);
        for (row, _) in &table.rows {
            lines.row(vec![
                row.label.to_owned(),
                row.printed.to_owned(),
                row.rounded(),
                format!("{:.3}", row.outer),
            ]);
        }
        text += &format!("{}\n{lines}\n", paint(BOLD, &format!("Table {number}, px")));
    }
    text
}
