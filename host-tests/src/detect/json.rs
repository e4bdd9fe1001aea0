//! One JSON object per image and line.

use anyhow::Result;
use concentric::{Circle, Dropped, Reading, Rejects, Target};
use serde::{Serialize, Serializer};

use super::Outcome;
use crate::measure::Place;
use crate::picture::Picture;

#[derive(Serialize)]
struct Line<'a> {
    image: &'a str,
    width: usize,
    height: usize,
    ms: f64,
    targets: Vec<TargetEntry>,
    #[serde(serialize_with = "counts")]
    rejected: &'a Rejects,
    dropped: DroppedEntry,
    unsearched: u32,
}

#[derive(Serialize)]
struct TargetEntry {
    x: f64,
    y: f64,
    cov: [f32; 3],
    eq7: Place,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    code: Option<CodeEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    normal: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coplanar: Option<bool>,
    circles: Vec<CircleEntry>,
    eccentricity: f32,
    model_difference: f32,
    contrast: f32,
    noise: f32,
    blur: f32,
    residual: f32,
    gap: f32,
    flags: Vec<&'static str>,
}

#[derive(Serialize)]
struct CodeEntry {
    angle: f32,
    wrong: u8,
    margin: f32,
}

#[derive(Serialize)]
struct CircleEntry {
    x: f64,
    y: f64,
    a: f32,
    b: f32,
    theta: f32,
    rms: f32,
    points: u16,
    gap: f32,
    ratio: f32,
    measured_ratio: f32,
}

#[derive(Serialize)]
struct DroppedEntry {
    runs: u32,
    outlines: u32,
    crossings: u32,
}

/// The line for `picture`, its end included. Lengths in px, `cov` in px^2, `theta` in radians, `gap` in degrees,
/// contrast and noise in grey levels, `ms` in milliseconds. `id` and `code` (direction of the word's beginning in radians, segments repaired,
/// how clear the others are, 0 to 1) are there where a code was read, `normal` (unit, towards the camera, in camera axes) is there
/// with a camera, `coplanar` (on the plane of the others) where a plane was asked for.
///
/// # Errors
/// None that a caller can cause.
pub fn line(picture: &Picture, outcome: &Outcome) -> Result<String> {
    let Dropped { runs, outlines, crossings } = outcome.summary.dropped;
    let line = Line {
        image: &picture.name,
        width: picture.width,
        height: picture.height,
        ms: (outcome.elapsed.as_secs_f64() * 1e6).round() / 1e3,
        targets: outcome.targets.iter().map(|target| entry(target, outcome)).collect(),
        rejected: &outcome.summary.rejected,
        dropped: DroppedEntry { runs, outlines, crossings },
        unsearched: outcome.summary.unsearched,
    };
    Ok(serde_json::to_string(&line)? + "\n")
}

fn counts<S: Serializer>(rejects: &&Rejects, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(rejects.iter().map(|(cause, count)| (cause.name(), count)))
}

fn entry(target: &Target, outcome: &Outcome) -> TargetEntry {
    let Place { x, y } = target.centre.into();
    let cov = target.covariance;
    TargetEntry {
        x,
        y,
        cov: [cov.xx, cov.xy, cov.yy],
        eq7: target.eq7.into(),
        id: target.code.map(|code| code.id),
        code: target.code.map(|Reading { angle, wrong, margin, .. }| CodeEntry { angle, wrong, margin }),
        normal: target.normal,
        coplanar: outcome.plane.map(|plane| plane.holds(target)),
        circles: target.circles.iter().map(CircleEntry::from).collect(),
        eccentricity: target.eccentricity(),
        model_difference: target.model_difference(),
        contrast: target.contrast,
        noise: target.noise,
        blur: target.blur,
        residual: target.residual(),
        gap: target.gap(),
        flags: target.flags.names().collect(),
    }
}

impl From<&Circle> for CircleEntry {
    fn from(circle: &Circle) -> Self {
        let Place { x, y } = circle.ellipse.centre.into();
        let Circle { ellipse, rms, points, gap, ratio, measured_ratio, .. } = *circle;
        Self {
            x,
            y,
            a: ellipse.a,
            b: ellipse.b,
            theta: ellipse.theta,
            rms,
            points,
            gap,
            ratio,
            measured_ratio,
        }
    }
}
