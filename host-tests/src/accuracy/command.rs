//! The command `accuracy`.

use std::{io::Write, path::PathBuf};

use anyhow::{Result, ensure};
use clap::Args as ClapArgs;
use indicatif::{ProgressBar, ProgressStyle};

use super::{
    cell::Cell,
    grid::Extent,
    method::{MAIN, METHODS},
    run::{Group, Outcome, run},
    statistics::Figures,
};
use crate::table::Table;

const EXAMPLES: &str = "\
Examples:
  concentric accuracy                             the whole study, written to the folder accuracy
  concentric accuracy --quick                     a reduced grid with fewer frames
  concentric accuracy --cell shading --frames 500 only cells with `shading` in their name
  concentric accuracy --quick --method none       another way to the centre";

/// Measure the library's accuracy on rendered frames, against the least error that is possible.
#[derive(Clone, Debug, ClapArgs)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A reduced grid, and fewer frames a cell
    #[arg(long)]
    quick: bool,
    /// Folder to write to: accuracy.md, accuracy.csv, plots
    #[arg(long, value_name = "DIR", default_value = "accuracy")]
    out: PathBuf,
    /// Frames of every cell [default: 500; with --quick 60]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    frames: Option<u32>,
    /// Only cells with this in their name, as in `size` or `R30 w45`
    #[arg(long, value_name = "TEXT")]
    cell: Option<String>,
    /// Ways to the centre to print
    #[arg(long, value_name = "NAME", default_value = MAIN, value_delimiter = ',', value_parser = METHODS.map(|m| m.name))]
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
}

/// Runs the study.
///
/// # Errors
/// A name that no cell has, output that cannot be written.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<()> {
    let cells = args.cells()?;
    let frames = args.frames.unwrap_or(args.extent().frames());
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left")?;
    let progress = ProgressBar::new(0).with_style(style);
    let outcomes = run(&cells, frames, &progress)?;
    progress.finish_and_clear();
    for (index, method) in METHODS.iter().enumerate() {
        if args.method.iter().any(|name| name == method.name) {
            writeln!(out, "{}\n{}", method.name, table(&outcomes, index))?;
        }
    }
    Ok(())
}

fn table(outcomes: &[Outcome], method: usize) -> Table {
    let mut table = Table::new(&[
        "found",
        "frames",
        "bound mpx",
        "RMS mpx",
        "ratio",
        "+-",
        "sys",
        "bias",
        "drift",
        "err/sigma",
        "in 95 %",
        "cell",
    ]);
    for outcome in outcomes {
        let groups: Vec<&Group> = outcome.groups.iter().collect();
        let name = outcome.cell.name();
        let name = if outcome.cell.in_range() { name } else { format!("({name})") };
        let Some(f) = Figures::new(&groups, method) else {
            table.row([vec!["0".to_owned()], vec![String::new(); 10], vec![name]].concat());
            continue;
        };
        let mpx = |px: f64| format!("{:.2}", 1000.0 * px);
        table.row(vec![
            f.found.to_string(),
            f.frames.to_string(),
            mpx(f.bound),
            mpx(f.rms),
            format!("{:.3}", f.ratio()),
            format!("{:.3}", f.ratio_spread()),
            f.systematic.map_or("-".to_owned(), mpx),
            mpx(f.bias),
            mpx(f.drift),
            format!("{:.3}", f.over_sigma),
            format!("{:.1}", 100.0 * f.within),
            name,
        ]);
    }
    table
}
