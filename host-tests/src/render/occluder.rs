//! What lies over the targets: objects, scratches, glare.

use super::camera::{Camera, View};
use super::outline::Outline;
use super::target::Target;
use anyhow::{Result, ensure};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Shapes of an occluder. Places in px, parallel to the sensor, unless they lie on a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Cover {
    /// A fan of triangles on the plane of a target, from its circles' centre to more than half a radius beyond its outermost
    /// outline: it hides the same share of every circle.
    Wedge {
        /// Index of the target.
        target: usize,
        /// Share of each circumference, above 0, below 1.
        share: f64,
        /// Direction of its middle as seen in the image, from +x towards +y, degrees.
        direction: f64,
    },
    /// A straight strip: a cable, or a scratch.
    Strip {
        /// Column of its middle.
        x: f64,
        /// Row of its middle.
        y: f64,
        /// Width.
        width: f64,
        /// Length.
        length: f64,
        /// Direction of its length, from +x towards +y, degrees.
        direction: f64,
    },
    /// A disc: a bite out of the rim, a drop.
    Disc {
        /// Column of its middle.
        x: f64,
        /// Row of its middle.
        y: f64,
        /// Radius.
        radius: f64,
    },
    /// A reflection: light is added, `strength exp(-(distance / radius)^2 / 2)` in units of white minus black.
    Glare {
        /// Column of its middle.
        x: f64,
        /// Row of its middle.
        y: f64,
        /// Standard deviation.
        radius: f64,
        /// Light added in the middle.
        strength: f64,
    },
}

/// Something between the targets and the camera.
///
/// Its border is blurred as everything else. Where it crosses another edge the two profiles are multiplied, which is exact
/// only farther than the blur from there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Occluder {
    /// Shape and place.
    #[serde(flatten)]
    pub cover: Cover,
    /// Reflectance, 0 black to 1 white; of no effect for a glare.
    pub tone: f64,
}

/// Distance of a wedge's outer sides from its tip in radii of the target's outermost outline.
const REACH: f64 = 1.5;
/// Light in units of white minus black that hides what is behind it.
const BLINDING: f64 = 0.5;

impl Occluder {
    /// # Errors
    /// When a value is out of its range; says which and what is allowed.
    pub fn validate(&self, targets: &[Target]) -> Result<()> {
        let tone = self.tone;
        ensure!((0.0..=1.0).contains(&tone), "tone {tone}: must be 0 (black) to 1 (white)");
        let place = |x: f64, y: f64| {
            ensure!(x.abs() <= 1e5 && y.abs() <= 1e5, "place ({x}, {y}) px: must be within 100000");
            Ok(())
        };
        let size = |name: &str, value: f64| {
            ensure!((0.1..=1e5).contains(&value), "{name} {value} px: must be 0.1 to 100000");
            Ok(())
        };
        match self.cover {
            Cover::Wedge { target, share, direction } => {
                ensure!(target < targets.len(), "wedge on target {target}: there are {}", targets.len());
                ensure!(share > 0.0 && share < 1.0, "share {share}: must be above 0 and below 1");
                ensure!(direction.is_finite(), "direction {direction} is not finite");
                Ok(())
            }
            Cover::Strip { x, y, width, length, direction } => {
                place(x, y)?;
                ensure!(direction.is_finite(), "direction {direction} is not finite");
                size("width", width).and(size("length", length))
            }
            Cover::Disc { x, y, radius } => place(x, y).and(size("radius", radius)),
            Cover::Glare { x, y, radius, strength } => {
                ensure!((0.0..=100.0).contains(&strength), "strength {strength}: must be 0 to 100");
                place(x, y).and(size("radius", radius))
            }
        }
    }

    /// Its plane through `camera`: that of its target, or one parallel to the sensor on which 1 mm is 1 px.
    pub fn view(&self, targets: &[Target], camera: &Camera) -> Option<View> {
        match self.cover {
            Cover::Wedge { target, .. } => targets.get(target).map(|target| target.view(camera)),
            Cover::Strip { x, y, .. } | Cover::Disc { x, y, .. } | Cover::Glare { x, y, .. } => {
                Some(View::flat(camera, x, y))
            }
        }
    }

    /// Its outline on that plane; a glare has none.
    pub fn outline(&self, targets: &[Target], camera: &Camera) -> Option<Outline> {
        match self.cover {
            Cover::Wedge { target, share, direction } => {
                let target = targets.get(target)?;
                let start = wedge_start(target, camera, share, direction);
                let side = TAU * share / sides(share);
                let radius = REACH * target.artwork.reach() / (side / 2.0).cos();
                let corner =
                    |i: u32| target.centre() + DVec2::from_angle(start + f64::from(i) * side) * radius;
                let rim = (0..=sides(share) as u32).map(corner);
                Some(Outline::polygon(&[target.centre()].into_iter().chain(rim).collect::<Vec<_>>()))
            }
            Cover::Strip { width, length, direction, .. } => {
                let strip = Outline::rectangle(DVec2::ZERO, length / 2.0, width / 2.0);
                Some(strip.placed(DVec2::ZERO, direction.to_radians(), 1.0))
            }
            Cover::Disc { radius, .. } => Some(Outline::circle(DVec2::ZERO, radius)),
            Cover::Glare { .. } => None,
        }
    }

    /// Light that it adds at the point of its plane, in units of white minus black.
    pub fn light(&self, point: DVec2) -> f64 {
        match self.cover {
            Cover::Glare { radius, strength, .. } => {
                strength * (-point.length_squared() / (2.0 * radius * radius)).exp()
            }
            _ => 0.0,
        }
    }

    /// Whether it hides what appears at the pixel `place`.
    pub fn hides(&self, place: DVec2, targets: &[Target], camera: &Camera) -> bool {
        let Some(point) = self.view(targets, camera).map(|view| view.plane(place)) else { return false };
        match self.cover {
            Cover::Wedge { target, share, direction } => targets.get(target).is_some_and(|target| {
                let spoke = point - target.centre();
                let turn = spoke.to_angle() - wedge_start(target, camera, share, direction);
                let side = TAU * share / sides(share);
                let from_middle = turn.rem_euclid(TAU).rem_euclid(side) - side / 2.0;
                turn.rem_euclid(TAU) < TAU * share
                    && spoke.length() * from_middle.cos() < REACH * target.artwork.reach()
            }),
            Cover::Strip { width, length, direction, .. } => {
                let along = DVec2::from_angle(-direction.to_radians()).rotate(point).abs();
                along.x < length / 2.0 && along.y < width / 2.0
            }
            Cover::Disc { radius, .. } => point.length() < radius,
            Cover::Glare { .. } => self.light(point) > BLINDING,
        }
    }
}

/// Angle on the plane at which a wedge of this share begins.
fn wedge_start(target: &Target, camera: &Camera, share: f64, direction: f64) -> f64 {
    let slope = target.view(camera).at(target.centre()).1;
    let middle = slope.inverse() * DVec2::from_angle(direction.to_radians());
    middle.to_angle() - PI * share
}

/// Number of a wedge's outer sides: straight, so that they are no circle of their own.
fn sides(share: f64) -> f64 {
    (4.0 * share).ceil()
}
