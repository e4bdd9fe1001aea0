//! Layout files: which targets are on an object, and where.
//!
//! A layout is a text that people read, edit and compare line by line:
//!
//! ```text
//! concentric-layout: 1
//! # The corner plate. Lengths in mm.
//! code: five
//! ink: dark
//! id,x_mm,y_mm,z_mm,radii_mm
//! 32,-40,-30,0,5 2.5
//! ,-24,-30,0,5 2.5
//! ```
//!
//! The first line gives the version. What follows `#`, and empty lines, count for nothing. `code` is one of `none` (as
//! without the line), `cct14`, `cct12`, `five`; `ink`, the tone of the outer circles and the segments, is `dark` (as without the line) or `light`.
//! Then one target a line: its id, or nothing for a plain one; the place of its centre; the radii of its circles, outermost
//! first, separated by spaces. Seen from the front, x runs right, y runs down and z runs away.

mod parse;

use std::{fmt::Write, fs, path::Path};

use anyhow::{Context, Result, ensure};
use clap::ValueEnum;
use concentric::Code;
use serde::{Deserialize, Serialize};

use crate::render::{Artwork, Camera, CodeRing, Pose, Scene, Target, Tone};

/// Version of the format.
pub const VERSION: u32 = 1;
/// The line above the targets.
pub const COLUMNS: &str = "id,x_mm,y_mm,z_mm,radii_mm";

/// The codes that the program knows, by their names on the command line and in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CodeName {
    /// 14 segments, ids 1 to 516
    Cct14,
    /// 12 segments, ids 1 to 147
    Cct12,
    /// 14 segments, ids 32, 123, 336, 366 and 515; two wrong segments are repaired
    Five,
}

impl CodeName {
    /// The code with all its ids.
    pub fn code(self) -> Code {
        match self {
            Self::Cct14 => Code::cct14(),
            Self::Cct12 => Code::cct12(),
            Self::Five => Code::five(),
        }
    }

    /// Its name on the command line and in files.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// A target of a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutTarget {
    /// The id that it carries.
    pub id: Option<u16>,
    /// Centre of its circles, mm.
    pub position: [f64; 3],
    /// Radii of its circles, mm, falling.
    pub radii: Vec<f64>,
}

impl LayoutTarget {
    /// How far its print reaches from its centre, mm, the ring of segments included.
    pub fn reach(&self) -> f64 {
        let outer = self.radii.first().copied().unwrap_or(0.0);
        if self.id.is_some() { outer * f64::from(concentric::code::OUTER) } else { outer }
    }
}

/// The targets on an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// The code of the targets with ids.
    pub code: Option<CodeName>,
    /// Light circles on a dark ground.
    pub light: bool,
    /// The targets; ids are different, and no two targets overlap.
    pub targets: Vec<LayoutTarget>,
}

impl Layout {
    /// Reads a layout file.
    ///
    /// # Errors
    /// A file that cannot be read, or is no layout; names the file, and the line and the field that are wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let text =
            fs::read_to_string(path).with_context(|| format!("cannot read layout {}", path.display()))?;
        Self::parse(&text).with_context(|| format!("layout {}", path.display()))
    }

    /// Takes the text of a layout file.
    ///
    /// # Errors
    /// Names the line and the field that are wrong, and what is allowed.
    pub fn parse(text: &str) -> Result<Self> {
        parse::parse(text)
    }

    /// Its text. Every number is written with the digits that give it back exactly.
    pub fn text(&self) -> String {
        let mut text = format!("concentric-layout: {VERSION}\n");
        if let Some(code) = self.code {
            let _ = writeln!(text, "code: {}", code.name());
        }
        if self.light {
            text.push_str("ink: light\n");
        }
        let _ = writeln!(text, "{COLUMNS}");
        for LayoutTarget { id, position: [x, y, z], radii } in &self.targets {
            let id = id.map_or_else(String::new, |id| id.to_string());
            let radii: Vec<String> = radii.iter().map(f64::to_string).collect();
            let _ = writeln!(text, "{id},{x},{y},{z},{}", radii.join(" "));
        }
        text
    }

    /// Writes it as a file.
    ///
    /// # Errors
    /// When the file cannot be written; names the file.
    pub fn write(&self, path: &Path) -> Result<()> {
        fs::write(path, self.text()).with_context(|| format!("cannot write layout {}", path.display()))
    }

    /// The layout, which must be plane, with its origin at that of `pose`, before `camera`.
    ///
    /// # Errors
    /// A target with another z than 0, or what [`Scene::validate`] refuses.
    pub fn scene(&self, camera: Camera, pose: Pose) -> Result<Scene> {
        let mut scene = Scene::empty(camera);
        let (paper, ink) = if self.light { (Tone::Dark, Tone::Light) } else { (Tone::Light, Tone::Dark) };
        scene.paper = paper;
        for LayoutTarget { id, position: [x, y, z], radii } in &self.targets {
            ensure!(*z == 0.0, "target at ({x}, {y}, {z}) mm: a layout in one plane has z = 0 everywhere");
            let code = self.code.zip(*id).map(|(code, id)| CodeRing::new(code, id));
            let artwork = Artwork { radii: radii.clone(), ink, code, ..Artwork::annulus(1.0, 0.5) };
            scene.targets.push(Target { artwork, pose, at: [*x, *y] });
        }
        scene.validate()?;
        Ok(scene)
    }

    /// The code for the settings: with the ids of the layout only, which is the strongest guard against wrong ones.
    ///
    /// # Errors
    /// An id that the code does not have.
    pub fn settings_code(&self) -> Result<Option<Code>> {
        let ids: Vec<u16> = self.targets.iter().filter_map(|target| target.id).collect();
        let code = self.code.map(CodeName::code).filter(|_| !ids.is_empty());
        Ok(code.map(|code| code.only(&ids)).transpose()?)
    }
}

#[cfg(test)]
mod tests;
