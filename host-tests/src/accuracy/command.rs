//! The command line of `accuracy`.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
use clap::Args as ClapArgs;
use indicatif::{ProgressBar, ProgressStyle};

use super::{
    cell::Cell,
    csv,
    goals::goals,
    grid::Extent,
    markdown,
    method::{MAIN, METHODS},
    plots::plots,
    run::run,
    study::Study,
};
use crate::table::{BOLD, Table, paint};

const EXAMPLES: &str = "\
Examples:
  concentric accuracy                         the whole study, some minutes; writes a folder
  concentric accuracy --quick                 a reduced grid with fewer frames, in seconds
  concentric accuracy --cell shading          only cells with `shading` in their name
  concentric accuracy --cell 'R30 w45' --frames 2000 --method none,exact

Columns: RMS errors of one coordinate in mpx (1/1000 px); their ratio to the Cramer-Rao bound
with its 95 % confidence interval, without what the noise of these frames makes of any good
estimate; sys, what is the same for every noise; bias and drift, the
mean error in the image and in directions of the light or the tilt; err/sigma, in units of the
reported standard deviation. Cells in brackets are outside the range of the goals.";

const BAR: &str = "{bar:40} {pos} of {len} frames, {eta} left";
const FOLDER: &str = "accuracy";

/// Measure the library's accuracy on rendered frames, against the least error that is possible
#[derive(Clone, Debug, ClapArgs)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A reduced grid, and fewer frames a cell
    #[arg(long)]
    quick: bool,
    /// Folder for accuracy.md, accuracy.csv and the plots [default: accuracy; none with --cell]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Frames of every cell [default: 500; with --quick 200]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    frames: Option<u32>,
    /// Only cells with this in their name, as in `size` or `R30 w45`
    #[arg(long, value_name = "TEXT")]
    cell: Option<String>,
    /// Forms of the centre of which to print every cell
    #[arg(
        long, value_name = "NAME", default_value = MAIN, value_delimiter = ',',
        value_parser = METHODS.map(|method| method.name)
    )]
    method: Vec<String>,
}

impl Args {
    fn extent(&self) -> Extent {
        if self.quick { Extent::Quick } else { Extent::Full }
    }

    fn cells(&self) -> Result<Vec<Cell>> {
        let mut cells = self.extent().cells();
        let wanted = self.cell.as_deref().unwrap_or("");
        cells.retain(|cell| cell.name().contains(wanted));
        ensure!(!cells.is_empty(), "--cell {wanted}: no cell has that in its name");
        Ok(cells)
    }

    fn folder(&self) -> Option<PathBuf> {
        let usual = || self.cell.is_none().then(|| FOLDER.into());
        self.out.clone().or_else(usual)
    }
}

/// Runs the study.
///
/// # Errors
/// A name that no cell has, a folder that cannot be written to; both before the study.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<()> {
    let cells = args.cells()?;
    let folder = args.folder();
    if let Some(folder) = &folder {
        prepare(folder).with_context(|| format!("cannot write to the folder {}", folder.display()))?;
    }
    let frames = args.frames.unwrap_or(args.extent().frames());
    let style = ProgressStyle::with_template(BAR)?;
    let progress = ProgressBar::new(0).with_style(style);
    let study = Study { frames, outcomes: run(&cells, frames, &progress)? };
    progress.finish_and_clear();
    for method in &args.method {
        writeln!(out, "{}\n{}", paint(BOLD, method), cell_table(&study, method))?;
    }
    write!(out, "{}", goal_table(&study))?;
    if let Some(folder) = &folder {
        write(&study, folder).with_context(|| format!("cannot write to the folder {}", folder.display()))?;
        writeln!(out, "\nwritten: {}", folder.join("accuracy.md").display())?;
    }
    Ok(())
}

/// Makes the folder and tries whether it can be written to.
fn prepare(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    tempfile::tempfile_in(folder)?;
    Ok(())
}

fn write(study: &Study, folder: &Path) -> Result<()> {
    let plots = plots(study)?;
    for plot in &plots {
        fs::write(folder.join(plot.file), &plot.svg)?;
    }
    fs::write(folder.join("accuracy.md"), markdown::page(study, &plots))?;
    fs::write(folder.join("accuracy.csv"), csv::text(study)?)?;
    Ok(())
}

fn cell_table(study: &Study, method: &str) -> Table {
    let mut table = Table::new(&[
        "found",
        "frames",
        "bound",
        "RMS",
        "ratio",
        "+-",
        "sys",
        "bias",
        "drift",
        "err/sigma",
        "in 95 %",
        "cell",
    ]);
    for outcome in &study.outcomes {
        let name = outcome.cell.name();
        let name = if outcome.cell.in_range() { name } else { format!("({name})") };
        let frames = outcome.samples().count().to_string();
        let Some(f) = outcome.figures(method) else {
            table.row([vec!["0".to_owned(), frames], vec![String::new(); 9], vec![name]].concat());
            continue;
        };
        let mpx = |px: f64| format!("{:.2}", 1000.0 * px);
        let mut row = vec![f.found.to_string(), frames, mpx(f.bound), mpx(f.rms)];
        row.extend([f.ratio(), f.ratio_spread()].map(|value| format!("{value:.3}")));
        row.push(f.systematic.map_or(String::new(), mpx));
        row.extend([f.bias, f.drift].map(mpx));
        row.extend([format!("{:.3}", f.over_sigma.0), format!("{:.1}", 100.0 * f.within), name]);
        table.row(row);
    }
    table
}

fn goal_table(study: &Study) -> Table {
    let mut table = Table::new(&["goal", "reached", "measured", "figure"]);
    for goal in goals(study) {
        let reached = if goal.reached { "yes" } else { "no" };
        table.row(vec![goal.goal, reached.to_owned(), goal.measured, goal.figure]);
    }
    table
}
