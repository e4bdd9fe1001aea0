//! What a frame really shows.

use super::camera::{Camera, Ellipse, View};
use super::decoy::Decoy;
use super::occluder::Occluder;
use super::photometry::Photometry;
use super::scene::Scene;
use super::target::{Artwork, Target};
use super::texture::Texture;
use super::visible::Visible;
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The image of one outline of a target, without lens distortion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CircleTruth {
    /// Radius on the target, mm.
    pub radius_mm: f64,
    /// Its exact ellipse.
    #[serde(flatten)]
    pub ellipse: Ellipse,
    /// Share of its circumference on the target that an occluder or the frame's border hides.
    pub hidden: f64,
    /// The arcs that are seen, each from one direction to another as seen from the ellipse's centre, without lens
    /// distortion, from +x towards +y, degrees: the first from 0 to 360, the second beyond it by at most 360.
    pub visible: Vec<[f64; 2]>,
}

/// A place in the image, px.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Column.
    pub x: f64,
    /// Row.
    pub y: f64,
}

/// A target of the frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TargetTruth {
    /// True centre (projection of the circles' centre), column, px, lens distortion included.
    pub x: f64,
    /// True centre, row, px.
    pub y: f64,
    /// True centre without lens distortion.
    pub undistorted: Place,
    /// All outlines, outermost first (two for a circle drawn as a line), without lens distortion.
    pub circles: Vec<CircleTruth>,
    /// Whether the outermost outline lies inside the frame, at least 1 px from its border; it can be hidden all the same.
    pub complete: bool,
    /// Distance of the circles' centre from the camera's centre, mm.
    pub distance: f64,
    /// Angle between the target's normal and the optical axis, degrees.
    pub tilt: f64,
    /// Direction of the axis about which it is tilted, from +x towards +y, degrees.
    pub azimuth: f64,
    /// What is printed.
    pub artwork: Artwork,
}

impl TargetTruth {
    /// The truth about `target` in `scene`.
    pub fn new(target: &Target, scene: &Scene) -> Self {
        let camera = &scene.camera;
        let view: View = target.view(camera);
        let centre = target.centre();
        let seen = view.at(centre).0;
        let undistorted = view.undistorted(centre);
        let circle = |radius: f64| Visible { scene, view, centre, radius }.truth();
        let inside = |position: f64, size: u32| (0.5..=f64::from(size) - 1.5).contains(&position);
        Self {
            x: seen.x,
            y: seen.y,
            undistorted: Place { x: undistorted.x, y: undistorted.y },
            circles: target.artwork.outlines().into_iter().map(circle).collect(),
            complete: target
                .rim_in_image(camera)
                .iter()
                .all(|p| inside(p.x, camera.width) && inside(p.y, camera.height)),
            distance: view.point(centre).length(),
            tilt: target.pose.tilt,
            azimuth: target.pose.azimuth,
            artwork: target.artwork.clone(),
        }
    }
}

/// Everything about a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Width, px.
    pub width: u32,
    /// Height, px.
    pub height: u32,
    /// Seed of the noise.
    pub seed: u64,
    /// The camera.
    pub camera: Camera,
    /// Blur, light and sensor.
    pub photometry: Photometry,
    /// The targets.
    pub targets: Vec<TargetTruth>,
    /// What is no target.
    pub decoys: Vec<Decoy>,
    /// Cloudy background.
    pub texture: Option<Texture>,
    /// What lies over it.
    pub occluders: Vec<Occluder>,
}

impl Truth {
    /// Reads what the `render` command wrote beside a picture.
    ///
    /// # Errors
    /// When the file cannot be read or is no truth file; names the file.
    pub fn read(path: &Path) -> Result<Self> {
        let text =
            std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        serde_json::from_str(&text).with_context(|| format!("{} is no truth file", path.display()))
    }

    /// Writes it as JSON.
    ///
    /// # Errors
    /// When the file cannot be written; names the file.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        std::fs::write(path, text + "\n").with_context(|| format!("cannot write {}", path.display()))
    }
}
