//! Options of the `render` command.

use super::camera::{Camera, Distortion};
use super::coded::CodeRing;
use super::occlude::{self, Occlude};
use super::photometry::{Photometry, Shading};
use super::sweep::{Sweep, pair, sweep, within};
use super::target::{Artwork, Mark, Style, Tone};
use crate::layout::CodeName;
use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};

/// The camera.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Camera")]
pub struct CameraOptions {
    /// Frame size, px
    #[arg(
        long, value_name = "WIDTHxHEIGHT", default_value = "1280x1024",
        value_parser = pair::<u32>('x', "WIDTHxHEIGHT in px")
    )]
    size: (u32, u32),
    /// Focal length, mm
    #[arg(long, value_name = "MM", default_value = "12", value_parser = within(0.01, 10_000.0))]
    f: f64,
    /// Pixel pitch, um
    #[arg(long, value_name = "UM", default_value = "4.65", value_parser = within(0.1, 100.0))]
    pitch: f64,
    /// Principal point, px [default: middle of the frame]
    #[arg(long, value_name = "X,Y", value_parser = pair::<f64>(',', "X,Y in px"), allow_hyphen_values = true)]
    principal: Option<(f64, f64)>,
    /// Radial lens distortion of second order (Brown; normalised coordinates)
    #[arg(
        long, value_name = "K", default_value = "0", value_parser = within(-10.0, 10.0),
        allow_negative_numbers = true
    )]
    k1: f64,
    /// Radial lens distortion of fourth order
    #[arg(
        long, value_name = "K", default_value = "0", value_parser = within(-100.0, 100.0),
        allow_negative_numbers = true
    )]
    k2: f64,
    /// Tangential lens distortion along y
    #[arg(
        long, value_name = "P", default_value = "0", value_parser = within(-1.0, 1.0),
        allow_negative_numbers = true
    )]
    p1: f64,
    /// Tangential lens distortion along x
    #[arg(
        long, value_name = "P", default_value = "0", value_parser = within(-1.0, 1.0),
        allow_negative_numbers = true
    )]
    p2: f64,
}

impl CameraOptions {
    /// The camera.
    pub fn camera(&self) -> Result<Camera> {
        let mut camera = Camera::new(self.size.0, self.size.1, self.f / (self.pitch / 1000.0));
        if let Some((x, y)) = self.principal {
            (camera.cx, camera.cy) = (x, y);
        }
        camera.distortion = Distortion { k1: self.k1, k2: self.k2, p1: self.p1, p2: self.p2 };
        camera.validate()?;
        Ok(camera)
    }
}

/// What is printed and where it lies.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Targets")]
pub struct TargetOptions {
    /// Radii of the circles, mm, outermost first
    #[arg(
        long, value_name = "MM,MM..", value_delimiter = ',', default_value = "24,12",
        value_parser = within(0.001, 1e5)
    )]
    radii: Vec<f64>,
    /// Draw the circles as lines of this width instead of filled bands
    #[arg(long, value_name = "MM", value_parser = within(0.0001, 1e4))]
    line: Option<f64>,
    /// Light ink on dark paper
    #[arg(long)]
    light: bool,
    /// A ring of segments around the circles with the target's id
    #[arg(long, value_enum, value_name = "CODE", requires = "id")]
    code: Option<CodeName>,
    /// The id; with several targets the first one's, and the next ones of the code for the others
    #[arg(long, value_name = "ID", requires = "code")]
    id: Option<u16>,
    /// Mark inside the innermost circle: plus, dot, or 1 to 4 digits
    #[arg(long, value_name = "MARK")]
    mark: Option<String>,
    /// Angle between the target's normal and the optical axis, degrees
    #[arg(
        long, value_name = "DEG", default_value = "30", value_parser = sweep(-89.0, 89.0),
        allow_hyphen_values = true
    )]
    pub tilt: Sweep,
    /// Direction of the axis about which it is tilted, from +x towards +y, degrees
    #[arg(
        long, value_name = "DEG", default_value = "0", value_parser = sweep(-360.0, 360.0),
        allow_hyphen_values = true
    )]
    pub azimuth: Sweep,
    /// Distance from the camera, mm
    #[arg(long, value_name = "MM", default_value = "800", value_parser = sweep(0.1, 1e6))]
    pub distance: Sweep,
    /// Where the target (or the board's middle) appears, px [default: principal point]
    #[arg(long, value_name = "X,Y", value_parser = pair::<f64>(',', "X,Y in px"), allow_hyphen_values = true)]
    pub position: Option<(f64, f64)>,
    /// Moves that place at random by up to this in x and in y, px (from the seed, anew for each frame)
    #[arg(long, value_name = "PX", default_value = "0", value_parser = within(0.0, 1000.0))]
    pub jitter: f64,
    /// A board of targets on one plane instead of one target
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = pair::<u32>('x', "COLUMNSxROWS"))]
    pub board: Option<(u32, u32)>,
    /// Distance of the board's targets, mm [default: 2.5 outer radii]
    #[arg(long, value_name = "MM", requires = "board", value_parser = within(0.001, 1e5))]
    pub spacing: Option<f64>,
    /// This many targets at random places, sizes and tilts instead of one; --radii then only gives the ratios
    #[arg(
        long, value_name = "N",
        conflicts_with_all = ["board", "tilt", "azimuth", "distance", "position", "jitter"],
        value_parser = clap::value_parser!(u32).range(1..=10_000)
    )]
    pub many: Option<u32>,
    /// This many decoys at random places: discs, squares, checkers, triangles, bars, text, eccentric and open
    /// rings, noise
    #[arg(
        long, value_name = "N", default_value = "0",
        value_parser = clap::value_parser!(u32).range(0..=10_000)
    )]
    pub decoys: u32,
    /// Cloudy background of this strength, as a part of the contrast
    #[arg(long, value_name = "PART", default_value = "0", value_parser = within(0.0, 1.0))]
    pub texture: f64,
    /// Something over the targets; may be given many times. A wedge hides a part of every circle of every target,
    /// its middle in this direction in the image. Places and sizes in px, tones 0 (black) to 1 (white), a
    /// glare's strength in units of white minus black: wedge:SHARE,DEG,TONE
    /// strip:X,Y,WIDTH,DEG,TONE scratch:X,Y,WIDTH,LENGTH,DEG,TONE disc:X,Y,RADIUS,TONE
    /// glare:X,Y,RADIUS,STRENGTH
    #[arg(long, value_name = "KIND:VALUES", value_parser = occlude::parse)]
    pub occlude: Vec<Occlude>,
}

impl TargetOptions {
    /// What is printed.
    pub fn artwork(&self) -> Result<Artwork> {
        let mark = match self.mark.as_deref() {
            None => None,
            Some("plus" | "+") => Some(Mark::Plus),
            Some("dot") => Some(Mark::Dot),
            Some(text) => {
                let digits = (1..=4).contains(&text.len()) && text.bytes().all(|c| c.is_ascii_digit());
                ensure!(digits, "--mark '{text}': must be plus, dot, or 1 to 4 digits");
                Some(Mark::Digits(text.to_owned()))
            }
        };
        let style = self.line.map_or(Style::Bands, Style::Lines);
        let artwork = Artwork {
            radii: self.radii.clone(),
            style,
            ink: self.paper().inverse(),
            mark,
            code: self.code()?,
        };
        artwork.validate()?;
        Ok(artwork)
    }

    /// The ring of segments of the first target.
    fn code(&self) -> Result<Option<CodeRing>> {
        let Some((code, id)) = self.code.zip(self.id) else { return Ok(None) };
        ensure!(code.code().has(id), "--id {id} is not in the code {}", code.name());
        Ok(Some(CodeRing::new(code, id)))
    }

    /// Tone of the paper.
    pub fn paper(&self) -> Tone {
        if self.light { Tone::Dark } else { Tone::Light }
    }
}

/// Over what the shading's fraction is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Over {
    /// The frame's width, from its middle.
    Frame,
    /// The first target's longest diameter, from its centre.
    Target,
}

/// Blur, light and sensor.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Light and sensor")]
pub struct PhotometryOptions {
    /// Standard deviation of the lens's blur, px: 0, or 0.02 to 50
    #[arg(long, value_name = "PX", default_value = "0.8", value_parser = sweep(0.0, 50.0))]
    pub blur: Sweep,
    /// Standard deviation of the noise, grey levels
    #[arg(long, value_name = "LEVELS", default_value = "2", value_parser = sweep(0.0, 200.0))]
    pub noise: Sweep,
    /// Grey level of dark ink
    #[arg(long, value_name = "LEVEL", default_value = "30", value_parser = within(0.0, 255.0))]
    black: f64,
    /// Grey level of light paper
    #[arg(long, value_name = "LEVEL", default_value = "220", value_parser = within(0.0, 255.0))]
    white: f64,
    /// Relative change of the light, linear over the frame
    #[arg(
        long, value_name = "PART", default_value = "0", value_parser = within(-2.0, 2.0),
        allow_negative_numbers = true
    )]
    shading: f64,
    /// Direction towards the light, from +x towards +y, degrees
    #[arg(
        long, value_name = "DEG", default_value = "0", value_parser = within(-360.0, 360.0),
        allow_negative_numbers = true
    )]
    shading_direction: f64,
    /// What the change of the light is counted over
    #[arg(long, value_enum, default_value_t = Over::Frame)]
    pub shading_over: Over,
    /// Exponent of the response, 255 (level / 255)^gamma
    #[arg(long, value_name = "EXPONENT", default_value = "1", value_parser = within(0.05, 20.0))]
    gamma: f64,
    /// Factor on the level, after gamma; above 255 it clips
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = within(0.01, 100.0))]
    gain: f64,
}

impl PhotometryOptions {
    /// The photometry with this blur and noise; the light is 1 at `middle` and changes over `span` px.
    pub fn photometry(&self, blur: f64, noise: f64, middle: [f64; 2], span: f64) -> Photometry {
        let shading = (self.shading != 0.0).then_some(Shading {
            fraction: self.shading,
            span,
            direction: self.shading_direction,
            x: middle[0],
            y: middle[1],
        });
        Photometry {
            blur,
            black: self.black,
            white: self.white,
            shading,
            gamma: self.gamma,
            gain: self.gain,
            noise,
        }
    }
}
