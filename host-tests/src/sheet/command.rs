//! `concentric sheet`: targets to print.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;

use super::{Page, Plan, Sheet, pdf, svg};
use crate::{layout::CodeName, render::pair};

/// Draw targets to print, as SVG and PDF in true millimetres, and write the layout of the sheet beside them.
///
/// Writes OUT.svg, OUT.pdf and OUT.layout. The origin of the layout is the middle of the grid, x runs right, y down. Print at
/// 100 %, without fitting to the page, and measure the ruler at the bottom.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// What is on the sheet
    #[arg(value_enum)]
    preset: Preset,
    /// Path of the files, without their endings
    #[arg(long, short, value_name = "OUT")]
    out: PathBuf,
    /// The paper; laid across where the targets fit only so
    #[arg(long, value_enum, default_value_t = Page::A4)]
    page: Page,
    /// Radii of the circles, mm, outermost first, two to four [default: 40,20 of a single target, 8,4 in a grid]
    #[arg(long, value_name = "MM,MM..", value_delimiter = ',')]
    radii: Vec<f64>,
    /// Columns and rows of the grid
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = pair::<u32>('x', "COLUMNSxROWS"), default_value = "4x5")]
    grid: (u32, u32),
    /// Distance of the targets, mm [default: as near as they may be; 22 on the board]
    #[arg(long, value_name = "MM")]
    pitch: Option<f64>,
    /// A ring of segments with an id around each target
    #[arg(long, value_enum, value_name = "CODE")]
    code: Option<CodeName>,
    /// The ids, row by row; targets beyond them carry none [default: those of the code in turn]
    #[arg(long, value_name = "ID,ID..", value_delimiter = ',', requires = "code")]
    ids: Vec<u16>,
    /// Light circles on a dark ground
    #[arg(long)]
    light: bool,
}

/// What is on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Preset {
    /// One target
    Single,
    /// A grid of targets
    Grid,
    /// 58 targets and five with the ids of the code `five`, in a grid of 9 x 7
    Board,
}

impl Args {
    fn plan(&self) -> Result<Plan> {
        if self.preset == Preset::Board {
            ensure!(self.code.is_none(), "the board has the code five: --code is for `single` and `grid`");
            let board = Plan { light: self.light, ..Plan::board() };
            let radii = if self.radii.is_empty() { board.radii.clone() } else { self.radii.clone() };
            return Ok(Plan { radii, pitch: self.pitch.or(board.pitch), ..board });
        }
        let (grid, usual) = match self.preset {
            Preset::Single => ([1, 1], [40.0, 20.0]),
            _ => ([self.grid.0, self.grid.1], [8.0, 4.0]),
        };
        let places = (u64::from(grid[0]) * u64::from(grid[1])).min(1000) as usize;
        let ids = |name: CodeName| match &self.ids[..] {
            [] => name.code().ids().take(places).collect(),
            ids => ids.to_vec(),
        };
        Ok(Plan {
            grid,
            pitch: self.pitch,
            radii: if self.radii.is_empty() { usual.to_vec() } else { self.radii.clone() },
            code: self.code.map(|name| (name, ids(name))),
            light: self.light,
            coded: Vec::new(),
        })
    }

    /// What the strip at the bottom says.
    fn title(&self, plan: &Plan) -> String {
        let [columns, rows] = plan.grid;
        let radii: Vec<_> = plan.radii.iter().map(f64::to_string).collect();
        let mut title = format!("Radii {} mm", radii.join(" "));
        if columns * rows > 1 {
            title += &format!(", {columns} x {rows} targets, {} mm apart", plan.pitch());
        }
        if let Some((code, _)) = &plan.code {
            title += &format!(", code {}", code.name());
        }
        title
    }

    /// The sheet.
    ///
    /// # Errors
    /// Options that make none; says what is allowed.
    pub fn sheet(&self) -> Result<Sheet> {
        let plan = self.plan()?;
        Sheet::new(plan.layout()?, self.page, &self.title(&plan))
    }
}

/// Writes the files and says what is on them.
///
/// # Errors
/// Options that make no sheet, or a file that cannot be written.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<()> {
    let sheet = args.sheet()?;
    let path = |ending: &str| PathBuf::from(format!("{}.{ending}", args.out.display()));
    if args.out.file_name().is_none() {
        bail!("--out {}: must end in a name", args.out.display());
    }
    write(&path("svg"), svg::text(&sheet).as_bytes())?;
    write(&path("pdf"), &pdf::bytes(&sheet))?;
    sheet.layout.write(&path("layout"))?;
    let coded = sheet.layout.targets.iter().filter(|target| target.id.is_some()).count();
    writeln!(
        out,
        "{} targets, {coded} with ids, on {} x {} mm: {}, {}, {}",
        sheet.layout.targets.len(),
        sheet.size.x,
        sheet.size.y,
        path("svg").display(),
        path("pdf").display(),
        path("layout").display()
    )?;
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
