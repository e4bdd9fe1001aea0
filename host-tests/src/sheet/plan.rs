//! Which targets are on a sheet, and on which paper.

use anyhow::{Result, bail, ensure};
use clap::ValueEnum;
use concentric::{Code, code};
use glam::{DVec2, Vec2Swizzles};

use super::{MARGIN, ROOM, STRIP};
use crate::layout::{CodeName, Layout, LayoutTarget};

/// Paper; of the two ways to lay it the one on which the targets fit, upright where both do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Page {
    /// 210 x 297 mm
    A4,
    /// 297 x 420 mm
    A3,
    /// 8.5 x 11 inches, 215.9 x 279.4 mm
    Letter,
}

impl Page {
    /// Width and height upright, mm.
    pub fn size(self) -> DVec2 {
        match self {
            Self::A4 => DVec2::new(210.0, 297.0),
            Self::A3 => DVec2::new(297.0, 420.0),
            Self::Letter => DVec2::new(215.9, 279.4),
        }
    }

    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Size as it is laid to hold `needed` mm between its margins.
    ///
    /// # Errors
    /// Too little room; says which paper has enough.
    pub(super) fn holding(self, needed: DVec2) -> Result<DVec2> {
        let free = |size: DVec2| size - DVec2::new(2.0 * MARGIN, 2.0 * MARGIN + STRIP);
        let ways = |page: Self| [page.size(), page.size().yx()];
        let fits = |size: &DVec2| needed.cmple(free(*size) + 1e-9).all();
        if let Some(size) = ways(self).iter().find(|size| fits(size)) {
            return Ok(*size);
        }
        let larger: Vec<_> = [Self::Letter, Self::A4, Self::A3]
            .into_iter()
            .filter(|page| ways(*page).iter().any(&fits))
            .map(Self::name)
            .collect();
        let [upright, across] = ways(self).map(free);
        bail!(
            "the targets need {:.1} x {:.1} mm; {} has {:.1} x {:.1} mm upright and {:.1} x {:.1} mm across, less \
             margins and ruler; {}",
            needed.x,
            needed.y,
            self.name(),
            upright.x,
            upright.y,
            across.x,
            across.y,
            if larger.is_empty() {
                "no paper is large enough: smaller radii, a smaller pitch or fewer targets".to_owned()
            } else {
                format!("they fit on {}", larger.join(" and "))
            }
        )
    }
}

/// Targets in a grid about the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Columns and rows.
    pub grid: [u32; 2],
    /// Distance of neighbours, mm; `None`: the least that they allow.
    pub pitch: Option<f64>,
    /// Radii of the circles, mm, falling.
    pub radii: Vec<f64>,
    /// The code, and the ids in the order of the rows; with fewer ids than targets the others carry none.
    pub code: Option<(CodeName, Vec<u16>)>,
    /// Light circles on a dark ground.
    pub light: bool,
    /// Places, column and row, of the targets with ids; empty: the first ones.
    pub coded: Vec<[u32; 2]>,
}

impl Plan {
    /// Most targets of a sheet.
    const MOST: u32 = 2000;

    /// 58 targets and five with the ids of [`Code::five`] in a grid of nine by seven, 5 and 2.5 mm, as on the board of Huo et
    /// al. 2013, section 4.2, as far as that is told: the grid and the places of the five are this project's.
    pub fn board() -> Self {
        Self {
            grid: [9, 7],
            pitch: Some(22.0),
            radii: vec![5.0, 2.5],
            code: Some((CodeName::Five, Code::FIVE.to_vec())),
            light: false,
            coded: vec![[1, 1], [7, 1], [4, 2], [1, 5], [7, 5]],
        }
    }

    /// Distance of neighbours, mm.
    pub fn pitch(&self) -> f64 {
        let outer = self.radii.first().copied().unwrap_or(0.0);
        let least = if self.code.is_some() { f64::from(code::QUIET + code::OUTER) + 0.5 } else { 1.0 + ROOM };
        self.pitch.unwrap_or(least * outer)
    }

    /// The targets.
    ///
    /// # Errors
    /// What a layout does not allow, and more ids than places.
    pub fn layout(&self) -> Result<Layout> {
        let [columns, rows] = self.grid;
        let count = u64::from(columns) * u64::from(rows);
        ensure!(
            (1..=u64::from(Self::MOST)).contains(&count),
            "a grid of {columns} x {rows} targets: must be 1 to {} in all",
            Self::MOST
        );
        let pitch = self.pitch();
        ensure!(pitch.is_finite() && pitch > 0.0, "pitch {pitch} mm: must be above 0");
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
        let mut ids = self.code.iter().flat_map(|(_, ids)| ids.iter().copied());
        let place = |i: u32, count: u32| (f64::from(i) - f64::from(count - 1) / 2.0) * pitch;
        let mut layout = Layout {
            code: self.code.as_ref().map(|(name, _)| *name),
            light: self.light,
            targets: Vec::new(),
        };
        for cell in cells {
            let coded = self.coded.is_empty() || self.coded.contains(&cell);
            layout.targets.push(LayoutTarget {
                id: if coded { ids.next() } else { None },
                position: [place(cell[0], columns), place(cell[1], rows), 0.0],
                radii: self.radii.clone(),
            });
        }
        let left = ids.count();
        ensure!(left == 0, "{left} of the ids have no place on the sheet: fewer --ids or a larger --grid");
        // Whatever makes a file that could not be read again.
        Layout::parse(&layout.text())
    }
}
