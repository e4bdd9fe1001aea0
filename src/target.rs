//! What the library hands out: a [`Target`], its [`Circle`]s, the [`Flags`] that qualify it.
//!
//! # Image coordinates
//!
//! Pixel centres are at integer coordinates: the centre of the top-left pixel is (0, 0), x runs right, y runs
//! down (OpenCV's convention). Every type with coordinates in this crate means these.

use crate::code::Reading;
use crate::list::rolled;
use heapless::Vec;

/// Largest number of circles kept for a target. A circle drawn as a line has two outlines, so this is
/// enough for four of those.
pub const MAX_CIRCLES: usize = 8;

/// A place in the image, in 1/65536 px, in the [image coordinates](self#image-coordinates).
///
/// An integer because an `f32` at column 4000 resolves only 2.4e-4 px; this resolves 1.5e-5 px everywhere and
/// compares bit by bit. Range +-32767 px.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Position {
    /// Column, 1/65536 px.
    pub x: i32,
    /// Row, 1/65536 px.
    pub y: i32,
}

impl Position {
    /// Units in a pixel.
    pub const SCALE: i32 = 1 << 16;

    /// The place `(dx, dy)` px from the pixel `(x, y)`, rounded to the grid. Saturates at the range.
    pub(crate) fn from_origin(x: i32, y: i32, dx: f32, dy: f32) -> Self {
        let axis = |origin: i32, offset: f32| {
            origin.saturating_mul(Self::SCALE).saturating_add(crate::math::round(offset * Self::SCALE as f32))
        };
        Self { x: axis(x, dx), y: axis(y, dy) }
    }

    /// The place `(dx, dy)` px from here, rounded to the grid. Saturates at the range.
    pub(crate) fn moved(self, (dx, dy): (f32, f32)) -> Self {
        let axis = |from: i32, by: f32| from.saturating_add(crate::math::round(by * Self::SCALE as f32));
        Self { x: axis(self.x, dx), y: axis(self.y, dy) }
    }

    /// `(x, y)` in px, rounded to `f32` (up to 1.2e-4 px of rounding at column 4000).
    pub fn to_px(self) -> (f32, f32) {
        let scale = 1.0 / Self::SCALE as f32;
        (self.x as f32 * scale, self.y as f32 * scale)
    }

    /// `(self - other)` in px; exact to `f32` of the difference.
    pub fn offset_from(self, other: Self) -> (f32, f32) {
        let scale = 1.0 / Self::SCALE as f32;
        (self.x.wrapping_sub(other.x) as f32 * scale, self.y.wrapping_sub(other.y) as f32 * scale)
    }
}

/// Covariance of a place in the image, px^2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Covariance {
    /// Variance of x.
    pub xx: f32,
    /// Covariance of x and y.
    pub xy: f32,
    /// Variance of y.
    pub yy: f32,
}

impl Covariance {
    /// `factor` times as large.
    #[inline(never)]
    pub(crate) fn scaled(&self, factor: f32) -> Self {
        Self { xx: factor * self.xx, xy: factor * self.xy, yy: factor * self.yy }
    }

    /// That of a place after the linear map `m`.
    #[inline(never)]
    pub(crate) fn mapped(&self, [[a, b], [c, d]]: [[f32; 2]; 2]) -> Self {
        let Self { xx, xy, yy } = *self;
        Self {
            xx: a * (a * xx + b * xy) + b * (a * xy + b * yy),
            xy: a * (c * xx + d * xy) + b * (c * xy + d * yy),
            yy: c * (c * xx + d * xy) + d * (c * xy + d * yy),
        }
    }
}

/// The image of one circle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ellipse {
    /// Ellipse centre (B in Huo et al. 2013). With a camera in the settings, where the image shows the centre of the ellipse
    /// that a lens without distortion would show.
    pub centre: Position,
    /// Semi-major axis, px. With a camera, this and what follows are of that ellipse: in undistorted px.
    pub a: f32,
    /// Semi-minor axis, px, `<= a`.
    pub b: f32,
    /// Direction of the major axis from +x towards +y, radians, in (-pi/2, pi/2].
    pub theta: f32,
}

/// One circle of a target: its ellipse and how well that was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Circle {
    /// The fitted ellipse.
    pub ellipse: Ellipse,
    /// Covariance of the ellipse centre, px^2.
    pub covariance: Covariance,
    /// RMS distance of the edge points from the ellipse, px; undistorted px with a camera.
    pub rms: f32,
    /// Edge points in the fit.
    pub points: u16,
    /// Largest angle without edge points, degrees as the circle itself is divided, in steps of 11.25; 0: none.
    pub gap: f32,
    /// Radius as a ratio of the outer circle's: the nominal one where the target is known, else measured.
    pub ratio: f32,
    /// The measured ratio, also where a nominal one was given; 1 for the outer circle.
    pub measured_ratio: f32,
}

/// What qualifies a target. A set of bits; names in [`Flags::NAMES`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Flags(pub u16);

impl Flags {
    /// Brighter side clipped at the top of the grey scale (or darker side at 0) at one edge point in ten or more.
    pub const CLIPPED: Flags = Flags(1 << 0);
    /// Contrast below 40 grey levels.
    pub const LOW_CONTRAST: Flags = Flags(1 << 1);
    /// Inner semi-minor axis or narrowest gap below 4 px: levels and covariance are less sure.
    pub const SMALL: Flags = Flags(1 << 2);
    /// An arc of an outline is missing.
    pub const OCCLUDED: Flags = Flags(1 << 3);
    /// Residual of an ellipse is higher than the noise explains.
    pub const RESIDUAL: Flags = Flags(1 << 4);
    /// The correction is lost in its own noise; [`Compensation::Auto`](crate::Compensation::Auto) leaves it out.
    pub const INSIGNIFICANT: Flags = Flags(1 << 5);
    /// Light on dark.
    pub const LIGHT: Flags = Flags(1 << 6);
    /// No ratio was given; the circles' ratios were measured.
    pub const MEASURED_RATIO: Flags = Flags(1 << 7);
    /// The frame's border cuts an outline.
    pub const CUT: Flags = Flags(1 << 8);
    /// Refined on the pixels of the image.
    pub const REFINED: Flags = Flags(1 << 9);

    /// Every flag with the name used in reports and JSON.
    pub const NAMES: [(Flags, &'static str); 10] = [
        (Self::CLIPPED, "clipped"),
        (Self::LOW_CONTRAST, "low_contrast"),
        (Self::SMALL, "small"),
        (Self::OCCLUDED, "occluded"),
        (Self::RESIDUAL, "residual"),
        (Self::INSIGNIFICANT, "insignificant"),
        (Self::LIGHT, "light"),
        (Self::MEASURED_RATIO, "measured_ratio"),
        (Self::CUT, "cut"),
        (Self::REFINED, "refined"),
    ];

    /// Whether every bit of `other` is set.
    pub const fn contains(self, other: Flags) -> bool {
        self.0 & other.0 == other.0
    }

    /// Sets the bits of `flag` when `on`.
    pub(crate) fn set(&mut self, flag: Flags, on: bool) {
        if on {
            self.0 |= flag.0;
        }
    }

    /// Names of the flags that are set.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES.into_iter().filter(move |(flag, _)| self.contains(*flag)).map(|(_, name)| name)
    }
}

/// A target found in a frame.
///
/// With a camera in the settings all ellipses are those that a lens without distortion would show. Places and
/// covariances are nevertheless in the image as it is: each is put back through the lens.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Target {
    /// True centre by the [`Compensation`](crate::Compensation) of the settings.
    pub centre: Position,
    /// Covariance of `centre`, px^2.
    pub covariance: Covariance,
    /// Centre by eq. (7) of Huo et al. 2013.
    pub eq7: Position,
    /// Centre by the exact form.
    pub exact: Position,
    /// Unit normal of the target's plane, towards the camera, in camera axes (x right, y down, z forward, so that z is
    /// negative). Only with a camera ([`Settings::camera`](crate::Settings::camera)) that the ellipses do not contradict.
    pub normal: Option<[f32; 3]>,
    /// The code that it carries, if one was read ([`code::read`](crate::code::read())).
    pub code: Option<Reading>,
    /// The circles, outermost first; at least two.
    pub circles: Vec<Circle, MAX_CIRCLES>,
    /// Bright minus dark level at the target's middle, grey levels.
    pub contrast: f32,
    /// Standard deviation of the grey levels in the flat areas at the edges about their plane, grey levels: sensor noise,
    /// rounding and texture of the print.
    pub noise: f32,
    /// Standard deviation of the edge's blur, pixel box included, px.
    pub blur: f32,
    /// What qualifies it.
    pub flags: Flags,
}

impl Target {
    /// The same with variances `factor` times as large.
    pub(crate) fn less_sure(mut self, factor: f32) -> Self {
        self.covariance = self.covariance.scaled(factor);
        for circle in rolled(&mut self.circles) {
            circle.covariance = circle.covariance.scaled(factor);
        }
        self
    }

    /// Distance between the outer ellipse's centre and `centre`, px: the systematic error that was removed.
    pub fn eccentricity(&self) -> f32 {
        self.circles.first().map_or(0.0, |outer| {
            let (dx, dy) = outer.ellipse.centre.offset_from(self.centre);
            crate::math::sqrt(dx * dx + dy * dy)
        })
    }

    /// Distance between the centres by eq. (7) and by the exact form, px: what eq. (7) leaves.
    pub fn model_difference(&self) -> f32 {
        let (dx, dy) = self.eq7.offset_from(self.exact);
        crate::math::sqrt(dx * dx + dy * dy)
    }

    /// RMS distance of all edge points from their ellipses, px.
    pub fn residual(&self) -> f32 {
        let (squares, points) = self.circles.iter().fold((0.0, 0.0), |(squares, points), circle| {
            let count = f32::from(circle.points);
            (squares + count * circle.rms * circle.rms, points + count)
        });
        if points > 0.0 { crate::math::sqrt(squares / points) } else { 0.0 }
    }

    /// Largest angle without edge points on any of the circles, degrees; see [`Circle::gap`].
    pub fn gap(&self) -> f32 {
        self.circles.iter().fold(0.0, |largest, circle| circle.gap.max(largest))
    }
}
