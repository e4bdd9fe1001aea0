//! Targets: what is printed, and where it lies.

use super::camera::{Camera, Pose, View};
use super::coded::CodeRing;
use super::glyphs;
use super::outline::Outline;
use anyhow::{Result, ensure};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Light or dark paper or ink.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// The photometry's black level.
    Dark,
    /// The photometry's white level.
    Light,
}

impl Tone {
    /// Reflectance: 0 or 1.
    pub fn value(self) -> f64 {
        if self == Tone::Light { 1.0 } else { 0.0 }
    }

    /// The opposite tone.
    pub fn inverse(self) -> Self {
        if self == Tone::Light { Tone::Dark } else { Tone::Light }
    }
}

/// How the circles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// The bands between them are filled in turn, the outermost with ink.
    Bands,
    /// Each is a line of this width, mm, half of it on either side of the radius.
    Lines(f64),
}

/// What is printed inside the innermost circle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// A cross of two strokes, as on the paper's own target.
    Plus,
    /// A filled disc. It is concentric, so it is one more circle of the image.
    Dot,
    /// One to four decimal digits.
    Digits(String),
}

/// What is printed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Artwork {
    /// Radii of the circles, mm, falling.
    pub radii: Vec<f64>,
    /// How they are drawn.
    pub style: Style,
    /// Tone of the ink. Where the paper around has the same tone, a square card of the other tone is put
    /// under.
    pub ink: Tone,
    /// What is printed inside the innermost circle.
    pub mark: Option<Mark>,
    /// The ring of segments around them.
    #[serde(default)]
    pub code: Option<CodeRing>,
}

/// Half side of the square card, in outer radii.
const CARD: f64 = 1.5;
/// Farthest that a target may reach from its true centre, px.
const LARGEST: f64 = 16384.0;
/// Radius of the circle round a mark, in radii of the innermost outline.
const MARK: f64 = 0.55;

impl Artwork {
    /// An annulus in dark ink.
    pub fn annulus(outer: f64, inner: f64) -> Self {
        Self { radii: vec![outer, inner], style: Style::Bands, ink: Tone::Dark, mark: None, code: None }
    }

    /// Radii of all outlines, mm, falling: the circles, or both sides of each line.
    pub fn outlines(&self) -> Vec<f64> {
        match self.style {
            Style::Bands => self.radii.clone(),
            Style::Lines(width) => {
                self.radii.iter().flat_map(|r| [r + width / 2.0, r - width / 2.0]).collect()
            }
        }
    }

    /// Radius of the outermost outline, mm, the ring of segments included.
    pub fn reach(&self) -> f64 {
        let outer = self.outlines().first().copied().unwrap_or(0.0);
        if self.code.is_some() { outer * f64::from(concentric::code::OUTER) } else { outer }
    }

    /// # Errors
    /// When the radii do not fall, are not positive, or lines meet; when the mark is not drawable.
    pub fn validate(&self) -> Result<()> {
        let radii = &self.radii;
        ensure!((1..=8).contains(&radii.len()), "{} radii: must be 1 to 8", radii.len());
        ensure!(radii.iter().all(|r| r.is_finite() && *r > 0.0), "radii {radii:?} mm: each must be above 0");
        ensure!(radii.windows(2).all(|r| r[0] > r[1]), "radii {radii:?} mm: must fall, outermost first");
        if let Style::Lines(width) = self.style {
            ensure!(width.is_finite() && width > 0.0, "line width {width} mm: must be above 0");
            let outlines = self.outlines();
            ensure!(
                outlines.windows(2).all(|r| r[0] > r[1]) && outlines.iter().all(|r| *r > 0.0),
                "line width {width} mm: the lines of radii {radii:?} mm touch; must be below their distances and below \
                 twice the innermost radius"
            );
        }
        if let Some(Mark::Digits(text)) = &self.mark {
            ensure!(
                (1..=4).contains(&text.len()) && text.bytes().all(|c| c.is_ascii_digit()),
                "mark '{text}': must be 1 to 4 decimal digits"
            );
        }
        self.code.map(|code| code.segments()).transpose()?;
        Ok(())
    }
}

/// A target in the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// What is printed.
    pub artwork: Artwork,
    /// Where the plane lies.
    pub pose: Pose,
    /// Where the circles' centre lies on the plane, mm.
    pub at: [f64; 2],
}

impl Target {
    /// The circles' centre on the plane, mm.
    pub fn centre(&self) -> DVec2 {
        self.at.into()
    }

    /// # Errors
    /// When the artwork is invalid, or the target is seen from behind or reaches behind the camera.
    pub fn validate(&self, camera: &Camera) -> Result<()> {
        self.artwork.validate()?;
        let Pose { x, y, distance, tilt, azimuth } = self.pose;
        ensure!(x.is_finite() && y.is_finite() && azimuth.is_finite(), "pose {:?} is not finite", self.pose);
        ensure!(tilt.abs() < 90.0, "tilt {tilt} degrees: must be between -90 and 90");
        ensure!(distance.is_finite() && distance > 0.0, "distance {distance} mm: must be above 0");
        let view = self.pose.view(camera);
        let reach = CARD * self.artwork.reach();
        ensure!(
            view.faces_camera() && view.least_depth(self.centre(), reach * std::f64::consts::SQRT_2) > 0.0,
            "a target of radius {} mm at ({x}, {y}) px, {distance} mm, tilt {tilt} degrees is seen from behind or \
             reaches behind the camera: smaller tilt or radius, or larger distance",
            self.artwork.reach()
        );
        let size = self.extent(camera).1;
        ensure!(
            size <= LARGEST,
            "a target of {size:.0} px in the image: at most {LARGEST} px from its centre"
        );
        let folded = self.rim().iter().any(|p| (view.at(*p).1).determinant() <= 0.0);
        ensure!(!folded, "a target at ({x}, {y}) px reaches to where the lens distortion folds the image");
        Ok(())
    }

    /// Points of the outermost outline on the plane, mm.
    fn rim(&self) -> Vec<DVec2> {
        let spoke = |i: u32| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 360.0);
        (0..360).map(|i| self.centre() + spoke(i) * self.artwork.reach()).collect()
    }

    /// Points of the outermost outline in the image, px.
    pub fn rim_in_image(&self, camera: &Camera) -> Vec<DVec2> {
        let view = self.pose.view(camera);
        self.rim().iter().map(|p| view.at(*p).0).collect()
    }

    /// Where the true centre appears, px, and how far the outermost outline reaches from there, px.
    pub fn extent(&self, camera: &Camera) -> (DVec2, f64) {
        let centre = self.pose.view(camera).at(self.centre()).0;
        let radius = self.rim_in_image(camera).iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        (centre, radius)
    }

    /// A square round the target that keeps texture away from it.
    pub fn card(&self) -> Outline {
        let half = CARD * self.artwork.reach();
        Outline::rectangle(self.centre(), half, half)
    }

    /// Outlines on the plane, each with the change of reflectance inside it, on paper of the given tone.
    pub fn inks(&self, paper: Tone) -> Vec<(Outline, f64)> {
        let ground = self.artwork.ink.inverse();
        let mut inks = Vec::new();
        if paper != ground {
            inks.push((self.card(), ground.value() - paper.value()));
        }
        let mut tone = ground;
        for radius in self.artwork.outlines() {
            inks.push((Outline::circle(self.centre(), radius), tone.inverse().value() - tone.value()));
            tone = tone.inverse();
        }
        if let (Some(code), Some(outer)) = (self.artwork.code, self.artwork.outlines().first()) {
            let change = ground.inverse().value() - ground.value();
            let segments = code.outlines(self.centre(), *outer).unwrap_or_default();
            inks.extend(segments.into_iter().map(|segment| (segment, change)));
        }
        if let (Some(mark), Some(innermost)) = (&self.artwork.mark, self.artwork.outlines().last()) {
            let shapes = match mark {
                Mark::Plus => vec![glyphs::plus()],
                Mark::Dot => vec![Outline::circle(DVec2::ZERO, 0.5)],
                Mark::Digits(text) => glyphs::digits(text),
            };
            let change = tone.inverse().value() - tone.value();
            let placed = |shape: Outline| (shape.placed(self.centre(), 0.0, MARK * innermost), change);
            inks.extend(shapes.into_iter().map(placed));
        }
        inks
    }

    /// The plane through `camera`.
    pub fn view(&self, camera: &Camera) -> View {
        self.pose.view(camera)
    }
}
