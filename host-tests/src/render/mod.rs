//! The simulator: frames of concentric-circle targets with exact area coverage, and the truth about them.
//!
//! 1. [`Camera`], [`Pose`]: a pinhole camera with lens distortion; planes before it.
//! 2. [`Target`], [`Decoy`], [`Texture`]: what is printed on them, and what is no target; [`Occluder`]: what lies over them.
//! 3. [`Coverage`]: how much of each pixel an outline covers, through the lens's blur, to 1e-6 of the contrast.
//! 4. [`Photometry`]: levels, uneven light, response, noise, rounding.
//! 5. [`Frame`], [`Truth`]: the picture; true centres and exact ellipses.
//!
//! Pixel centres are at integer coordinates, x right, y down. Plane coordinates in mm, angles in degrees in
//! all public fields except [`Ellipse::theta`] (radians, as the library reports it).

mod camera;
mod coded;
pub mod command;
mod crowd;
mod decoy;
mod glyphs;
mod occlude;
mod occluder;
mod options;
mod outline;
mod photometry;
mod raster;
mod scene;
mod sweep;
mod target;
mod texture;
mod truth;
mod visible;

pub use camera::{Camera, Distortion, Ellipse, Pose, View};
pub use coded::CodeRing;
pub use decoy::{Decoy, DecoyKind};
pub use occluder::{Cover, Occluder};
pub use outline::{Outline, Piece};
pub use photometry::{Photometry, Shading};
pub use raster::Coverage;
pub use scene::{Frame, Levels, Scene};
pub use sweep::pair;
pub use target::{Artwork, Mark, Style, Target, Tone};
pub use texture::Texture;
pub use truth::{CircleTruth, Place, TargetTruth, Truth};
