//! True centres of concentric-circle targets, found row by row on the camera itself.
//!
//! A circle seen at an angle is imaged as an ellipse whose centre is *not* the image of the circle's centre. With two or
//! more concentric circles the true centre follows from one picture, without calibration: from the ellipse centres, by
//! eq. (7) of Huo et al. 2013 or, exactly, by a closed form of the same cost
//! ([`centre`]). For one circle, or to compare, [`model`] has the equations with known geometry.
//!
//! A frame is never stored. Rows come in; outlines grow; as soon as nothing can close around a target any more it is
//! measured and handed out, and its memory is free again.
//!
//! # The pipeline
//!
//! 1. [`Detector::begin`], [`Scan::push_row`]: rows in ([`Settings`], [`Storage`]).
//! 2. `scan`: local threshold, runs, outlines of both polarities with exact moments, crossings with their samples.
//! 3. `candidate`: closed ellipses, which lie in which ([`Reject`]).
//! 4. `edge`: levels under one illumination plane, blur, edge points in 1/256 px.
//! 5. `fit`: exact integer sums, a 5 x 5 system, one geometric step; ellipses with covariance.
//! 6. [`centre`]: eq. (7), the exact form, the conic pencil, the plane seen by a known [`Camera`]; covariance of the centre.
//! 7. [`Target`]s out; [`report`]: the bytes that a head sends for a frame.
//!
//! # Conventions
//!
//! [Image coordinates](target#image-coordinates) have pixel centres at integers. Arithmetic is integer and `f32` with
//! `libm` by name, so that reports are bit-identical on every processor. Nothing here panics: the caller's mistakes are
//! errors, full buffers and rejected candidates are counted in the [`Summary`].
//!
//! # Features
//!
//! On by default, and left out by a part with little flash (`default-features = false`). What the linker drops by itself, because
//! the firmware does not call it, has no feature: [`code`], [`coplanar`], [`model`], [`refine`], [`report`], [`track`].
//!
//! | feature | without it | flash, compiled for size, kB |
//! | --- | --- | --- |
//! | `arcs` | circles are refused that are partly hidden, that something touches, or that the frame cuts | 28.5 to 36.1 |
//! | `camera` | there is no [`Settings::camera`](Settings#structfield.camera), so no undistorted fit and no normal | 8.5 to 15.4 |
//! | `joint` | each circle is measured by itself: more error, most where targets are small, tight or blurred | 18.0 to 25.3 |
//!
//! Off by default: `defmt` (logs and `Format`), `hal` (the module `head`).
//!
//! # Example
//!
//! ```
//! use concentric::{Detector, Image, Settings, Storage, TargetSpec};
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! # let pixels: Vec<u8> = (0..96 * 96).map(|i| {
//! #     let r = f32::hypot((i % 96) as f32 - 47.3, (i / 96) as f32 - 48.6);
//! #     let edge = |radius: f32| (radius - r + 0.5).clamp(0.0, 1.0);
//! #     (200.0 - 160.0 * (edge(30.0) - edge(15.0))) as u8
//! # }).collect();
//! let spec = TargetSpec::ring(0.5)?; // inner radius / outer radius
//! let mut storage = Storage::<96, 16, 1024>::new(); // a static in firmware
//! let mut detector = Detector::new(Settings::new(spec), &mut storage);
//!
//! let image = Image::new(&pixels, 96, 96)?;
//! let targets: Vec<_> = detector.detect(&image)?.collect();
//! let (x, y) = targets[0].centre.to_px();
//! assert!((x - 47.3).abs() < 0.02 && (y - 48.6).abs() < 0.02);
//! # Ok(())
//! # }
//! ```
#![no_std]
#![deny(unsafe_code)]

mod abilities;
mod appearance;
mod arcs;
#[cfg(all(target_arch = "arm", target_os = "none"))]
#[allow(unsafe_code)]
mod arm;
mod camera;
mod candidate;
pub mod centre;
pub mod code;
pub mod coplanar;
mod detector;
mod edge;
mod fit;
mod fixed;
#[cfg(feature = "hal")]
pub mod head;
mod list;
mod log;
mod math;
mod measure;
pub mod model;
pub mod refine;
mod region;
mod reject;
pub mod report;
mod scan;
mod settings;
mod storage;
mod summary;
pub mod target;
pub mod track;

pub use camera::{Camera, CameraError, Distortion};
pub use code::{Code, CodeError, Reading};
pub use detector::{
    Detection, Detector, FrameError, Image, MAX_HEIGHT, MAX_WIDTH, MIN_SIZE, Rest, RowError, Scan, Targets,
};
pub use region::Region;
pub use reject::{Dropped, Observer, Reject, Rejected, Rejects};
pub use scan::Run;
#[cfg(feature = "self-test")]
#[doc(hidden)]
pub use scan::agree;
pub use settings::{Compensation, Effort, MAX_SPEC_CIRCLES, Polarity, Settings, SettingsError, TargetSpec};
pub use storage::Storage;
pub use summary::{Summary, Used};
pub use target::{Circle, Covariance, Ellipse, Flags, MAX_CIRCLES, Position, Target};

/// The README's example is compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
