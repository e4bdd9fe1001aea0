//! The bodies of the messages, in wire units. Field order is wire order.

use heapless::Vec;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::fixed::{angle, correlation, sigma, unsigned16, unsigned32};
use crate::track::Track;
use crate::{Circle, Dropped, Ellipse, Flags, MAX_CIRCLES, Position, Reject, Rejects, Target};

/// How much is sent for a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Detail {
    /// Centre, its uncertainty, flags: about 16 bytes.
    #[default]
    Terse,
    /// And the outer ellipse's shape: about 26 bytes.
    Normal,
    /// And every circle, both corrected centres, contrast, noise and blur: about 92 bytes for two circles.
    Full,
}

/// What (0, 0) is in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Pixels {
    /// The centre of the top-left pixel: pixel centres are at integer coordinates.
    #[default]
    CentresAtIntegers,
}

/// Version of a piece of software.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Version {
    /// Changes when something that worked no longer does.
    pub major: u16,
    /// Changes when something is new.
    pub minor: u16,
    /// Changes when something is repaired.
    pub patch: u16,
}

impl Version {
    /// This library.
    pub const LIBRARY: Self = Self {
        major: number(env!("CARGO_PKG_VERSION_MAJOR")),
        minor: number(env!("CARGO_PKG_VERSION_MINOR")),
        patch: number(env!("CARGO_PKG_VERSION_PATCH")),
    };
}

const fn number(text: &str) -> u16 {
    match u16::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => u16::MAX,
    }
}

/// Who is speaking and in which units; sent first after a reset, and as often as wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hello {
    /// The firmware.
    pub firmware: Version,
    /// This library in it.
    pub library: Version,
    /// What (0, 0) is.
    pub pixels: Pixels,
    /// Position units in a pixel.
    pub position_scale: u32,
    /// Widest frame that the head can take, px.
    pub max_width: u16,
    /// Level of detail of its reports.
    pub detail: Detail,
}

impl Hello {
    /// The hello of a head that runs this library.
    pub const fn new(firmware: Version, max_width: u16, detail: Detail) -> Self {
        Self {
            firmware,
            library: Version::LIBRARY,
            pixels: Pixels::CentresAtIntegers,
            position_scale: Position::SCALE as u32,
            max_width,
            detail,
        }
    }
}

/// What a report says of the frame itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrameHead {
    /// Number of the frame.
    pub seq: u32,
    /// Width, px.
    pub width: u16,
    /// Height, px.
    pub height: u16,
    /// Only regions of it were searched, where targets were expected.
    pub limited: bool,
    /// Candidates that are no targets, by cause.
    #[serde(with = "counts")]
    pub rejected: Rejects,
    /// What full buffers cost while the frame was searched.
    #[serde(with = "Losses")]
    pub dropped: Dropped,
    /// Broken outlines in which no arcs were looked for, because the frame had used up its searches.
    pub unsearched: u32,
    /// Targets that were found and did not fit in the report.
    pub dropped_targets: u32,
    /// Reports that the head has given up since its reset, because its line was too slow for them.
    pub dropped_reports: u32,
    /// How much follows for each target.
    pub detail: Detail,
}

/// A target in a report. Values out of range are sent as the nearest in range.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TargetEntry {
    /// Number that the target carries; 0: it carries none.
    pub id: u16,
    /// Number of its track, the same from frame to frame; 0: it is not followed.
    pub track: u16,
    /// Frames since it appeared; 65535: that or more.
    pub age: u16,
    /// True centre, in the [image coordinates](crate::target#image-coordinates).
    #[serde(with = "Place")]
    pub centre: Position,
    /// Standard deviation of its x, 1/65536 px; 65535: 1 px or more.
    pub sigma_x: u16,
    /// Standard deviation of its y, 1/65536 px; 65535: 1 px or more.
    pub sigma_y: u16,
    /// Correlation of x and y, 1/127.
    pub correlation: i8,
    /// What qualifies it.
    #[serde(with = "FlagBits")]
    pub flags: Flags,
    /// What the level of detail adds.
    #[serde(skip_deserializing)]
    pub details: Details,
}

/// What the level of detail adds to a target. No mark of its own on the wire: the frame's head says which it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put the large one on")]
pub enum Details {
    /// Nothing.
    #[default]
    Terse,
    /// The outer circle.
    Normal(Shape),
    /// Everything.
    Full(FullEntry),
}

/// Shape of an ellipse and how well it was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shape {
    /// Semi-major axis, 1/4096 px.
    pub a: u32,
    /// Semi-minor axis, 1/4096 px.
    pub b: u32,
    /// Direction of the major axis from +x towards +y, pi/32768 rad.
    pub theta: i16,
    /// RMS distance of the edge points from the ellipse, 1/65536 px; 65535: 1 px or more.
    pub rms: u16,
}

/// What full detail adds to a target.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FullEntry {
    /// Centre by eq. (7) of Huo et al. 2013.
    #[serde(with = "Place")]
    pub eq7: Position,
    /// Centre by the exact form.
    #[serde(with = "Place")]
    pub exact: Position,
    /// Bright minus dark level, 1/16 grey level.
    pub contrast: u16,
    /// Standard deviation of the grey levels in the flat areas, 1/256 grey level.
    pub noise: u16,
    /// Standard deviation of the edge's blur, 1/256 px.
    pub blur: u16,
    /// The circles, outermost first.
    pub circles: Vec<CircleEntry, MAX_CIRCLES>,
}

/// A circle of a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CircleEntry {
    /// Ellipse centre.
    #[serde(with = "Place")]
    pub centre: Position,
    /// Shape of the ellipse.
    pub shape: Shape,
    /// Edge points in the fit.
    pub points: u16,
    /// Largest angle without edge points, 1/16 degree.
    pub gap: u16,
    /// Radius as a ratio of the outer circle's, 1/65535.
    pub ratio: u16,
    /// The same as it was measured, 1/65535.
    pub measured_ratio: u16,
}

impl TargetEntry {
    pub(super) fn new(target: &Target, track: Option<&Track>, detail: Detail) -> Self {
        let details = match detail {
            Detail::Terse => Details::Terse,
            Detail::Normal => Details::Normal(target.circles.first().map(Shape::new).unwrap_or_default()),
            Detail::Full => Details::Full(FullEntry::new(target)),
        };
        Self {
            id: target.code.map_or(0, |code| code.id),
            track: track.map_or(0, |track| track.id),
            age: track.map_or(0, |track| track.age.min(u16::MAX.into()) as u16),
            centre: target.centre,
            sigma_x: sigma(target.covariance.xx),
            sigma_y: sigma(target.covariance.yy),
            correlation: correlation(&target.covariance),
            flags: target.flags,
            details,
        }
    }

    /// Reads an entry of level `detail` from the front of `bytes`; returns it and the rest.
    pub(super) fn take(detail: Detail, bytes: &[u8]) -> postcard::Result<(Self, &[u8])> {
        let (entry, bytes): (Self, _) = postcard::take_from_bytes(bytes)?;
        let (details, bytes) = match detail {
            Detail::Terse => (Details::Terse, bytes),
            Detail::Normal => {
                let (shape, bytes) = postcard::take_from_bytes(bytes)?;
                (Details::Normal(shape), bytes)
            }
            Detail::Full => {
                let (full, bytes) = postcard::take_from_bytes(bytes)?;
                (Details::Full(full), bytes)
            }
        };
        Ok((Self { details, ..entry }, bytes))
    }
}

impl Shape {
    fn new(circle: &Circle) -> Self {
        let Ellipse { a, b, theta, .. } = circle.ellipse;
        Self {
            a: unsigned32(a, 4096.0),
            b: unsigned32(b, 4096.0),
            theta: angle(theta),
            rms: unsigned16(circle.rms, 65536.0),
        }
    }
}

impl FullEntry {
    fn new(target: &Target) -> Self {
        let mut circles = Vec::new();
        for circle in &target.circles {
            // Cannot fail, as both lists have the same capacity; `collect` would bring code that panics.
            let _ = circles.push(CircleEntry::new(circle));
        }
        Self {
            eq7: target.eq7,
            exact: target.exact,
            contrast: unsigned16(target.contrast, 16.0),
            noise: unsigned16(target.noise, 256.0),
            blur: unsigned16(target.blur, 256.0),
            circles,
        }
    }
}

impl CircleEntry {
    fn new(circle: &Circle) -> Self {
        Self {
            centre: circle.ellipse.centre,
            shape: Shape::new(circle),
            points: circle.points,
            gap: unsigned16(circle.gap, 16.0),
            ratio: unsigned16(circle.ratio, 65535.0),
            measured_ratio: unsigned16(circle.measured_ratio, 65535.0),
        }
    }
}

impl Serialize for Details {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Terse => serializer.serialize_unit(),
            Self::Normal(shape) => shape.serialize(serializer),
            Self::Full(full) => full.serialize(serializer),
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Position")]
struct Place {
    x: i32,
    y: i32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Flags")]
struct FlagBits(u16);

#[derive(Serialize, Deserialize)]
#[serde(remote = "Dropped")]
struct Losses {
    runs: u32,
    outlines: u32,
    crossings: u32,
}

/// [`Rejects`] as one count a cause, in the order of [`Reject::ALL`].
mod counts {
    use super::*;
    use crate::list::rolled;
    use serde::ser::SerializeTuple;

    type Counts = [u32; Reject::ALL.len()];

    pub(super) fn serialize<S: Serializer>(rejected: &Rejects, serializer: S) -> Result<S::Ok, S::Error> {
        // As an array, but in a loop, which the compiler does not unroll.
        let mut counts = serializer.serialize_tuple(Reject::ALL.len())?;
        rolled(rejected.iter()).try_for_each(|(_, count)| counts.serialize_element(&count))?;
        counts.end()
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Rejects, D::Error> {
        let counts = Counts::deserialize(deserializer)?;
        Ok(Reject::ALL.iter().zip(counts).map(|(&(cause, _), count)| (cause, count)).collect())
    }
}
