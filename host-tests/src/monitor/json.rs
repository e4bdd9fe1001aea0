//! The lines. Units as in the lines of `detect`.

use std::f32::consts::PI;

use concentric::Rejects;
use concentric::report::{
    Answer, CircleEntry, Details, FrameHead, FrameReport, FullEntry, HeadSettings, Hello, Pixels, RATIO_ONE,
    Shape, TargetEntry, Version,
};
use serde::{Serialize, Serializer};

use super::Counts;
use crate::measure::Place;

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Line<'a> {
    Hello {
        firmware: String,
        library: String,
        pixels: &'static str,
        position_scale: u32,
        max_width: u16,
        detail: String,
    },
    Frame {
        seq: u32,
        width: u16,
        height: u16,
        limited: bool,
        targets: Vec<Target>,
        #[serde(serialize_with = "counts")]
        rejected: &'a Rejects,
        dropped: Dropped,
        unsearched: u32,
    },
    Answer {
        tag: u16,
        outcome: String,
        settings: Settings,
    },
    Summary(&'a Counts),
}

#[derive(Serialize)]
struct Settings {
    ratios: Vec<f32>,
    polarity: String,
    compensation: String,
    detail: String,
    format: String,
    whole_every: u16,
    px_per_run: u16,
    effort: String,
}

#[derive(Serialize)]
struct Dropped {
    runs: u32,
    outlines: u32,
    crossings: u32,
    targets: u32,
    /// Since the head's reset.
    reports: u32,
}

/// What the report's level of detail leaves out is left out here too.
#[derive(Default, Serialize)]
struct Target {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u16>,
    #[serde(flatten)]
    track: Option<Track>,
    x: f64,
    y: f64,
    /// `null` when a standard deviation is 1 px or more.
    cov: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    eq7: Option<Place>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exact: Option<Place>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    circles: Vec<Circle>,
    #[serde(flatten)]
    quality: Option<Quality>,
    flags: Vec<&'static str>,
}

#[derive(Serialize)]
struct Track {
    track: u16,
    age: u16,
}

#[derive(Serialize)]
struct Quality {
    model_difference: f32,
    contrast: f32,
    noise: f32,
    blur: f32,
    /// `null` when the RMS of a circle is 1 px or more.
    residual: Option<f32>,
    gap: f32,
}

#[derive(Serialize)]
struct Circle {
    #[serde(flatten)]
    centre: Option<Place>,
    a: f32,
    b: f32,
    theta: f32,
    /// `null` when it is 1 px or more.
    rms: Option<f32>,
    #[serde(flatten)]
    fit: Option<Fit>,
}

#[derive(Serialize)]
struct Fit {
    points: u16,
    gap: f32,
    ratio: f32,
    measured_ratio: f32,
}

/// The line of a hello.
pub(super) fn hello(hello: &Hello) -> String {
    let version = |Version { major, minor, patch }| format!("{major}.{minor}.{patch}");
    print(&Line::Hello {
        firmware: version(hello.firmware),
        library: version(hello.library),
        pixels: match hello.pixels {
            Pixels::CentresAtIntegers => "centres_at_integers",
            _ => "unknown",
        },
        position_scale: hello.position_scale,
        max_width: hello.max_width,
        detail: lower(hello.detail),
    })
}

/// The line of an answer.
pub(super) fn answer(answer: &Answer) -> String {
    let HeadSettings { ratios, polarity, compensation, detail, format, whole_every, px_per_run, effort } =
        &answer.settings;
    print(&Line::Answer {
        tag: answer.tag,
        outcome: answer.outcome.to_string(),
        settings: Settings {
            ratios: ratios.iter().map(|&ratio| f32::from(ratio) / RATIO_ONE).collect(),
            polarity: lower(polarity),
            compensation: lower(compensation),
            detail: lower(detail),
            format: lower(format),
            whole_every: *whole_every,
            px_per_run: *px_per_run,
            effort: lower(effort),
        },
    })
}

fn lower(name: impl std::fmt::Debug) -> String {
    format!("{name:?}").to_lowercase()
}

/// The line of a frame report.
pub(super) fn frame(report: &FrameReport<'_>) -> String {
    let FrameHead {
        seq,
        width,
        height,
        limited,
        ref rejected,
        dropped,
        unsearched,
        dropped_targets,
        dropped_reports,
        ..
    } = report.head;
    print(&Line::Frame {
        seq,
        width,
        height,
        limited,
        targets: report.targets().map(Target::from).collect(),
        rejected,
        dropped: Dropped {
            runs: dropped.runs,
            outlines: dropped.outlines,
            crossings: dropped.crossings,
            targets: dropped_targets,
            reports: dropped_reports,
        },
        unsearched,
    })
}

/// The line that ends the output.
pub(super) fn summary(counts: &Counts) -> String {
    print(&Line::Summary(counts))
}

fn print(line: &Line<'_>) -> String {
    serde_json::to_string(line).expect("keys are strings")
}

fn counts<S: Serializer>(rejects: &&Rejects, serializer: S) -> Result<S::Ok, S::Error> {
    let seen = rejects.iter().filter(|&(_, count)| count > 0);
    serializer.collect_map(seen.map(|(cause, count)| (cause.name(), count)))
}

/// `units` of `1 / scale`; the largest number of them means "or more".
fn spread(units: u16, scale: f32) -> Option<f32> {
    (units < u16::MAX).then(|| f32::from(units) / scale)
}

impl From<TargetEntry> for Target {
    fn from(entry: TargetEntry) -> Self {
        let Place { x, y } = entry.centre.into();
        let target = Self {
            id: (entry.id > 0).then_some(entry.id),
            track: (entry.track > 0).then_some(Track { track: entry.track, age: entry.age }),
            x,
            y,
            cov: covariance(&entry),
            flags: entry.flags.names().collect(),
            ..Self::default()
        };
        match entry.details {
            Details::Terse => target,
            Details::Normal(shape) => Self { circles: vec![Circle::new(&shape)], ..target },
            Details::Full(full) => Self {
                eq7: Some(full.eq7.into()),
                exact: Some(full.exact.into()),
                circles: full.circles.iter().map(Circle::from).collect(),
                quality: Some(Quality::from(&full)),
                ..target
            },
        }
    }
}

impl From<&FullEntry> for Quality {
    fn from(full: &FullEntry) -> Self {
        let circles = full.circles.iter().map(|entry| concentric::Circle {
            rms: f32::from(entry.shape.rms) / 65536.0,
            points: entry.points,
            gap: f32::from(entry.gap) / 16.0,
            ..Default::default()
        });
        let target = concentric::Target {
            eq7: full.eq7,
            exact: full.exact,
            circles: circles.collect(),
            ..Default::default()
        };
        let saturated = full.circles.iter().any(|entry| entry.shape.rms == u16::MAX);
        Self {
            model_difference: target.model_difference(),
            contrast: f32::from(full.contrast) / 16.0,
            noise: f32::from(full.noise) / 256.0,
            blur: f32::from(full.blur) / 256.0,
            residual: (!saturated).then(|| target.residual()),
            gap: target.gap(),
        }
    }
}

/// Covariance (xx, xy, yy) of the centre, px^2; `None` when a standard deviation is 1 px or more.
pub(crate) fn covariance(entry: &TargetEntry) -> Option<[f32; 3]> {
    let (x, y) = (spread(entry.sigma_x, 65536.0)?, spread(entry.sigma_y, 65536.0)?);
    Some([x * x, f32::from(entry.correlation) / 127.0 * x * y, y * y])
}

impl Circle {
    fn new(shape: &Shape) -> Self {
        Self {
            centre: None,
            a: shape.a as f32 / 4096.0,
            b: shape.b as f32 / 4096.0,
            theta: f32::from(shape.theta) * (PI / 32768.0),
            rms: spread(shape.rms, 65536.0),
            fit: None,
        }
    }
}

impl From<&CircleEntry> for Circle {
    fn from(entry: &CircleEntry) -> Self {
        let fit = Fit {
            points: entry.points,
            gap: f32::from(entry.gap) / 16.0,
            ratio: f32::from(entry.ratio) / 65535.0,
            measured_ratio: f32::from(entry.measured_ratio) / 65535.0,
        };
        Self { centre: Some(entry.centre.into()), fit: Some(fit), ..Self::new(&entry.shape) }
    }
}
