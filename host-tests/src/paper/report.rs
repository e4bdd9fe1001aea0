//! Everything that the command calculates.

use anyhow::Result;
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::{
    board::Board,
    equations::{self, Worst},
    lens,
    simulation::{self, Row, Seen},
    single::{self, Single},
};

/// A table of section 4.1, and the figure that shows it.
#[derive(Clone, Debug)]
pub struct Table {
    /// Number of the figure.
    pub figure: u32,
    /// Name of its file.
    pub plot: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Name and unit of the parameter.
    pub axis: &'static str,
    /// Its value.
    pub parameter: fn(&Row) -> f64,
    /// What the equations say, and what was found on pictures, by noise.
    pub rows: Vec<(Row, [Seen; 2])>,
}

/// All results.
#[derive(Clone, Debug)]
pub struct Report {
    /// Section 2.
    pub equations: Worst,
    /// Tables 1 and 2.
    pub tables: [Table; 2],
    /// Eq. (8).
    pub lens: Vec<lens::Row>,
    /// Figure 6.
    pub single: Single,
    /// Figures 7 and 8.
    pub board: Board,
}

impl Report {
    /// Calculates everything.
    ///
    /// # Errors
    /// A picture that the library refuses, or on which nothing is found.
    pub fn new(progress: &ProgressBar) -> Result<Self> {
        let [first, second] = [simulation::table_1()?, simulation::table_2()?];
        progress.set_length((first.len() + second.len() + 1) as u64 + Board::STEPS);
        let with_pictures = |rows: Vec<Row>| -> Result<Vec<_>> {
            let seen = rows.par_iter().map(|row| {
                let seen = simulation::pictures(row);
                progress.inc(1);
                seen
            });
            let seen = seen.collect::<Result<Vec<_>>>()?;
            Ok(rows.into_iter().zip(seen).collect())
        };
        let tables = [
            Table {
                figure: 4,
                plot: "figure4.svg",
                title: "Figure 4: errors over the radius of the larger circle",
                axis: "outer radius, mm",
                parameter: |row| row.radius,
                rows: with_pictures(first)?,
            },
            Table {
                figure: 5,
                plot: "figure5.svg",
                title: "Figure 5: errors over the angle omega",
                axis: "omega, degrees",
                parameter: |row| row.tilt.to_degrees(),
                rows: with_pictures(second)?,
            },
        ];
        let single = single::run()?;
        progress.inc(1);
        let board = Board::new(progress)?;
        Ok(Self { equations: equations::worst()?, tables, lens: lens::rows()?, single, board })
    }
}
