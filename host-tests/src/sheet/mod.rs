//! Targets to print: sheets in true millimetres as SVG and PDF, and the layout of what is on them.
//!
//! 1. [`Plan`]: which targets, in which grid; [`Page`]: on which paper.
//! 2. [`Sheet`]: shapes in mm from the page's top left corner, x right, y down; text and ruler too.
//! 3. [`svg`], [`pdf`]: the files.

pub mod command;
pub mod pdf;
mod plan;
pub mod svg;

use anyhow::{Result, ensure};
use concentric::code;
use glam::DVec2;

pub use plan::{Page, Plan};

use crate::{
    layout::{Layout, LayoutTarget},
    render::CodeRing,
};

/// What printers leave blank at the paper's edges, mm.
const MARGIN: f64 = 10.0;
/// Height of the strip with ruler and title at the bottom of the page, mm.
const STRIP: f64 = 16.0;
/// Length of the ruler, mm.
const RULER: f64 = 100.0;
/// Ground around a plain target, in outer radii.
const ROOM: f64 = 1.4;
/// Ground around light targets beyond that, mm.
const BORDER: f64 = 2.0;
/// Largest height of an id, mm, and in outer radii.
const ID_HEIGHT: (f64, f64) = (3.0, 0.6);

/// Ink or paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tint {
    /// Ink.
    Black,
    /// Paper.
    White,
}

/// What is drawn, mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A filled rectangle.
    Rectangle {
        /// Top left corner.
        from: DVec2,
        /// Bottom right corner.
        to: DVec2,
        /// Its tint.
        tint: Tint,
    },
    /// A filled disc.
    Disc {
        /// Its middle.
        at: DVec2,
        /// Its radius.
        radius: f64,
        /// Its tint.
        tint: Tint,
    },
    /// A part of a ring.
    Segment {
        /// Middle of the ring.
        at: DVec2,
        /// Inner and outer radius.
        radii: [f64; 2],
        /// Where it begins, and by how much it goes on, from +x towards +y, radians.
        arc: [f64; 2],
        /// Its tint.
        tint: Tint,
    },
    /// A thin black line.
    Line {
        /// Start.
        from: DVec2,
        /// End.
        to: DVec2,
    },
    /// Black or white text.
    Text {
        /// Middle of its base line.
        at: DVec2,
        /// Height of a line.
        size: f64,
        /// The text.
        text: String,
        /// Its tint.
        tint: Tint,
    },
}

/// Width of a line, mm.
pub const LINE_WIDTH: f64 = 0.2;

/// A page with targets.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Width and height, mm.
    pub size: DVec2,
    /// What is drawn, in this order.
    pub shapes: Vec<Shape>,
    /// The targets; the origin of the layout is at [`origin`](Self::origin).
    pub layout: Layout,
    /// Place of the layout's origin on the page, mm.
    pub origin: DVec2,
}

/// How far from its centre nothing else may be printed, mm.
fn room(target: &LayoutTarget) -> f64 {
    let outer = target.radii.first().copied().unwrap_or(0.0);
    outer * if target.id.is_some() { f64::from(code::QUIET) } else { ROOM }
}

/// Corners of the rectangle that the targets take with the ground around them, mm from the layout's origin.
fn extent(layout: &Layout) -> [DVec2; 2] {
    let mut corners = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    for target in &layout.targets {
        let (at, room) = (DVec2::new(target.position[0], target.position[1]), DVec2::splat(room(target)));
        corners = [corners[0].min(at - room), corners[1].max(at + room)];
    }
    corners
}

impl Sheet {
    /// The targets of a plane layout on a page, with a ruler and `title` below.
    ///
    /// # Errors
    /// Targets that come too near to each other, or that do not fit on the page; says how much room they need.
    pub fn new(layout: Layout, page: Page, title: &str) -> Result<Self> {
        for (k, a) in layout.targets.iter().enumerate() {
            for b in layout.targets.iter().skip(k + 1) {
                let distance = (a.position[0] - b.position[0]).hypot(a.position[1] - b.position[1]);
                let outer = |target: &LayoutTarget| target.reach();
                let least = (room(a) + outer(b)).max(room(b) + outer(a));
                ensure!(
                    distance >= least - 1e-9,
                    "targets are {distance:.2} mm apart: with these radii they must be at least {least:.2} mm \
                     (a larger --pitch, or smaller --radii)"
                );
            }
        }
        let [low, high] = extent(&layout);
        let ground = if layout.light { BORDER } else { 0.0 };
        let needed = high - low + DVec2::splat(2.0 * ground);
        let size = page.holding(needed)?;
        let free = size - DVec2::new(2.0 * MARGIN, 2.0 * MARGIN + STRIP);
        let origin = DVec2::splat(MARGIN) + free / 2.0 - (low + high) / 2.0;
        let mut sheet = Self { size, shapes: Vec::new(), layout, origin };
        if sheet.layout.light {
            let [from, to] = [low - BORDER, high + BORDER].map(|corner| corner + origin);
            sheet.shapes.push(Shape::Rectangle { from, to, tint: Tint::Black });
        }
        for target in sheet.layout.targets.clone() {
            sheet.draw(&target)?;
        }
        sheet.draw_strip(title);
        Ok(sheet)
    }

    fn draw(&mut self, target: &LayoutTarget) -> Result<()> {
        let at = self.origin + DVec2::new(target.position[0], target.position[1]);
        let (ink, ground) =
            if self.layout.light { (Tint::White, Tint::Black) } else { (Tint::Black, Tint::White) };
        let tints = [ink, ground].into_iter().cycle();
        self.shapes.extend(target.radii.iter().zip(tints).map(|(&radius, tint)| Shape::Disc {
            at,
            radius,
            tint,
        }));
        let (Some((code, id)), Some(outer)) = (self.layout.code.zip(target.id), target.radii.first()) else {
            return Ok(());
        };
        let radii = [code::INNER, code::OUTER].map(|radius| f64::from(radius) * outer);
        for arc in CodeRing::new(code, id).arcs()? {
            self.shapes.push(Shape::Segment { at, radii, arc, tint: ink });
        }
        let size = ID_HEIGHT.0.min(ID_HEIGHT.1 * outer);
        // Below on the right, beyond the quiet ground.
        let aside = DVec2::splat((room(target) + 0.8 * size) / std::f64::consts::SQRT_2);
        let at = at + aside + DVec2::new(0.0, 0.35 * size);
        self.shapes.push(Shape::Text { at, size, text: id.to_string(), tint: ink });
        Ok(())
    }

    /// The ruler and the title.
    fn draw_strip(&mut self, title: &str) {
        let middle = self.size.x / 2.0;
        let y = self.size.y - MARGIN - 9.0;
        let start = DVec2::new(middle - RULER / 2.0, y);
        self.shapes.push(Shape::Line { from: start, to: start + DVec2::new(RULER, 0.0) });
        for step in 0..=10u32 {
            let from = start + DVec2::new(f64::from(step) * RULER / 10.0, 0.0);
            let length = if step % 5 == 0 { 3.0 } else { 1.8 };
            self.shapes.push(Shape::Line { from, to: from - DVec2::new(0.0, length) });
            if step % 5 == 0 {
                let text = if step == 10 { "100 mm".to_owned() } else { (10 * step).to_string() };
                let at = from + DVec2::new(0.0, 3.4);
                self.shapes.push(Shape::Text { at, size: 3.0, text, tint: Tint::Black });
            }
        }
        let at = DVec2::new(middle, self.size.y - MARGIN - 1.0);
        let text = format!("{title}. Print at 100 %: the ruler must be 100 mm long.");
        self.shapes.push(Shape::Text { at, size: 3.0, text, tint: Tint::Black });
    }
}
