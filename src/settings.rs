//! What to look for, how to compensate, and every threshold of the library with its unit and reason.

pub(crate) mod limits;

use core::fmt;

#[cfg(feature = "camera")]
use crate::camera::Camera;
use crate::code::Code;

/// Largest number of circles in a [`TargetSpec`].
pub const MAX_SPEC_CIRCLES: usize = 4;

/// Whether the outer circle is darker or lighter than what surrounds it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Polarity {
    /// Dark on light.
    #[default]
    Dark,
    /// Light on dark.
    Light,
}

/// Which concentric circles make a target.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TargetSpec {
    ratios: [f32; MAX_SPEC_CIRCLES - 1],
    inner: u8,
    polarity: Polarity,
}

impl TargetSpec {
    /// Smallest ratio of a circle's radius to the outer one.
    pub const MIN_RATIO: f32 = 0.1;
    /// Largest ratio of a circle's radius to the next larger one.
    pub const MAX_STEP: f32 = 0.95;

    /// Two or more concentric outlines of any radii, dark on light. The ratios are measured.
    pub const fn any() -> Self {
        Self { ratios: [0.0; MAX_SPEC_CIRCLES - 1], inner: 0, polarity: Polarity::Dark }
    }

    /// Two circles: inner radius / outer radius = `ratio`, dark on light.
    ///
    /// # Errors
    /// [`SettingsError::Ratio`] outside 0.1..=0.95.
    pub const fn ring(ratio: f32) -> Result<Self, SettingsError> {
        Self::circles(&[ratio])
    }

    /// Two to four circles, dark on light: `ratios` are the radii of the inner ones as ratios of the outer
    /// radius, descending.
    ///
    /// # Errors
    /// [`SettingsError::RatioCount`] unless there are one to three; [`SettingsError::Ratio`] for one below 0.1 or
    /// above 0.95 of its predecessor.
    pub const fn circles(ratios: &[f32]) -> Result<Self, SettingsError> {
        if ratios.is_empty() || ratios.len() >= MAX_SPEC_CIRCLES {
            return Err(SettingsError::RatioCount { given: ratios.len() });
        }
        let mut spec = Self::any();
        let mut previous = 1.0;
        let mut i = 0;
        while i < ratios.len() {
            let (value, max) = (ratios[i], previous * Self::MAX_STEP);
            // Written so that NaN fails too.
            if !(value >= Self::MIN_RATIO && value <= max) {
                return Err(SettingsError::Ratio { value, max });
            }
            spec.ratios[i] = value;
            previous = value;
            i += 1;
        }
        spec.inner = ratios.len() as u8;
        Ok(spec)
    }

    /// The same circles, light on dark.
    pub const fn light(self) -> Self {
        self.with_polarity(Polarity::Light)
    }

    /// The same circles with this polarity.
    pub const fn with_polarity(mut self, polarity: Polarity) -> Self {
        self.polarity = polarity;
        self
    }

    /// Radii of the inner circles as ratios of the outer one, descending; empty for [`any`](Self::any).
    pub fn ratios(&self) -> &[f32] {
        self.ratios.get(..self.inner as usize).unwrap_or(&[])
    }

    /// Polarity of the outer circle.
    pub const fn polarity(&self) -> Polarity {
        self.polarity
    }
}

/// How the true centre is made from the ellipse centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Compensation {
    /// Not at all: the outer ellipse's centre.
    None,
    /// Eq. (7) of Huo et al. 2013.
    Eq7,
    /// The form of eq. (7) that is exact for any perspective.
    #[default]
    Exact,
    /// The exact form as far as its correction is significant against its own noise
    /// ([`Significance`](crate::centre::Significance)), from the mean of the ellipse centres: better where targets are small,
    /// noisy or seen from the front. Where the eccentricity is 3 to 10 times the standard deviation of the outer ellipse's
    /// centre it is up to 10 % worse than `Exact`.
    Auto,
    /// With a known camera ([`Settings::camera`]): the shapes of the ellipses tell the plane of the target, and with it the
    /// centre at less than half the noise. The covariance holds for a camera that is right: a focal length that is off by a
    /// share moves the centre by that share of the eccentricity. Where the ellipses contradict the camera beyond their noise,
    /// the centre is the exact form's, and the target has no normal.
    Known,
}

/// How much is done for the accuracy of a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Effort {
    /// All that the pixels tell: a few per cent more than the least error that is possible.
    #[default]
    Full,
    /// Each edge point from two samples and each circle by itself, in two short passes: a fifth to two fifths of the instructions, and
    /// about a tenth more error. A target that is hidden in part, clipped, dirty, noisy (6 % of the contrast), blurred (1.3 px), of
    /// which two edges are nearer than 3 px or one bends in less than 2.4 px is measured in full all the same, and so is every one
    /// with a known camera.
    Quick,
}

/// Settings of a [`Detector`](crate::Detector).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// What to look for.
    pub spec: TargetSpec,
    /// How to compensate.
    pub compensation: Compensation,
    /// How much is done for the accuracy of a target; the noise of its centre grows by a tenth with [`Effort::Quick`].
    pub effort: Effort,
    /// The camera, if it is known. Feature `camera`.
    #[cfg(feature = "camera")]
    pub camera: Option<Camera>,
    /// The code that targets may carry, if any.
    pub code: Option<Code>,
    /// Pixels of the frame for each dark run of a row that may be followed, on average; 0: any number. That bounds the work up to
    /// the candidates: whatever a frame shows, its pixels and those of 64 rows more, divided by this, are the runs that it may
    /// have, with the crossings of their outlines. What is more is dropped and counted: first what is too fine to be a target,
    /// 32 x 4 px with more than 40 changes between dark and light (16 where hardly any pixels are left), which costs no more
    /// than the threshold ([`Dropped::runs`](crate::Dropped::runs)); then outlines that begin, while those that are open go on
    /// ([`Dropped::crossings`](crate::Dropped::crossings)); then the right ends of rows. A frame that uses its pixels up is
    /// searched for no arcs either.
    ///
    /// [`DEFAULT_PX_PER_RUN`](Self::DEFAULT_PX_PER_RUN) at first. With 32 a frame of 640 px width or more still has room for 60
    /// targets that cover an eighth of it, with [`BOUNDED_PX_PER_RUN`](Self::BOUNDED_PX_PER_RUN) for 4 of them, or 12 at 1280 px.
    pub px_per_run: u16,
}

impl Settings {
    /// A frame of 320 x 240 px may have 19200 runs: 60 annuli of 9 px radius have 1600, but noise in uneven light has many.
    pub const DEFAULT_PX_PER_RUN: u16 = 4;

    /// With this, whatever a frame shows takes at most 15 instructions a pixel up to the candidates on a Cortex-M4F, 25 on an M0+,
    /// 20 on RV32IMC.
    pub const BOUNDED_PX_PER_RUN: u16 = 144;

    /// Settings for `spec` with the exact compensation.
    pub const fn new(spec: TargetSpec) -> Self {
        let px_per_run = Self::DEFAULT_PX_PER_RUN;
        Self {
            spec,
            compensation: Compensation::Exact,
            effort: Effort::Full,
            #[cfg(feature = "camera")]
            camera: None,
            code: None,
            px_per_run,
        }
    }

    /// The same with another bound of the work that clutter makes.
    pub const fn px_per_run(mut self, px: u16) -> Self {
        self.px_per_run = px;
        self
    }

    /// The same with another compensation.
    pub const fn compensation(mut self, compensation: Compensation) -> Self {
        self.compensation = compensation;
        self
    }

    /// The same with another effort.
    pub const fn effort(mut self, effort: Effort) -> Self {
        self.effort = effort;
        self
    }

    /// The same with a known camera: edge points are freed from lens distortion before the ellipses are fitted, and targets
    /// have a normal. Feature `camera`.
    #[cfg(feature = "camera")]
    pub const fn camera(mut self, camera: Camera) -> Self {
        self.camera = Some(camera);
        self
    }

    /// The camera, if it is known and cameras are built in.
    #[cfg(feature = "camera")]
    pub(crate) fn known_camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    #[cfg(not(feature = "camera"))]
    pub(crate) fn known_camera(&self) -> Option<&crate::Camera> {
        None
    }

    /// The same with targets that may carry a code. A target without one is found all the same.
    pub const fn code(mut self, code: Code) -> Self {
        self.code = Some(code);
        self
    }
}

/// A setting that makes no sense.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SettingsError {
    /// A ratio outside its range.
    Ratio {
        /// The value given.
        value: f32,
        /// Largest value allowed in its place.
        max: f32,
    },
    /// No ratio, or too many.
    RatioCount {
        /// How many were given.
        given: usize,
    },
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ratio { value, max } => write!(
                f,
                "ratio {value} is outside {}..={max}: radii of the inner circles over the outer radius, descending, \
                 each at most {} of the one before",
                TargetSpec::MIN_RATIO,
                TargetSpec::MAX_STEP
            ),
            Self::RatioCount { given } => {
                write!(f, "{given} ratios given: 1..={} inner circles are possible", MAX_SPEC_CIRCLES - 1)
            }
        }
    }
}

impl core::error::Error for SettingsError {}

#[cfg(test)]
mod tests {
    use super::*;

    const _: () = assert!(TargetSpec::ring(0.5).is_ok());

    #[test]
    fn bad_ratios_are_refused_with_their_range() {
        for bad in [0.0, 0.09, 0.96, 1.2, -1.0, f32::NAN, f32::INFINITY] {
            assert!(matches!(TargetSpec::ring(bad), Err(SettingsError::Ratio { .. })), "{bad}");
        }
        assert!(matches!(TargetSpec::circles(&[0.5, 0.6]), Err(SettingsError::Ratio { .. })));
        assert_eq!(TargetSpec::circles(&[]), Err(SettingsError::RatioCount { given: 0 }));
        assert_eq!(TargetSpec::circles(&[0.9, 0.8, 0.7, 0.6]), Err(SettingsError::RatioCount { given: 4 }));
        assert_eq!(TargetSpec::circles(&[0.75, 0.5]).unwrap().ratios(), [0.75, 0.5]);
    }
}
