//! Why there is no calibration.

use std::fmt;

use super::{MIN_POINTS, MIN_VIEWS};

/// Why there is no calibration. The text says what is missing.
#[derive(Clone, Debug, PartialEq)]
pub enum CalibrationError {
    /// Too few views.
    TooFewViews {
        /// How many there are.
        views: usize,
    },
    /// A view with too few points.
    TooFewPoints {
        /// Name of the view.
        view: String,
        /// How many it has.
        points: usize,
    },
    /// Views of different size.
    Sizes {
        /// Name of the first view.
        first: String,
        /// Its size, px.
        size: [u32; 2],
        /// Name of another one.
        view: String,
        /// Its size, px.
        other: [u32; 2],
    },
    /// A point with a number that is not finite, a covariance that is none, or a negative radius.
    Point {
        /// Name of the view.
        view: String,
        /// Number of the point in it, from 0.
        point: usize,
    },
    /// Points of a view that leave its pose open: they lie on a line, on the object or in the image.
    Collinear {
        /// Name of the view.
        view: String,
    },
    /// Ellipse centres of circles whose plane is not known, because the points lie on no plane.
    NoPlane,
    /// The views do not tell a parameter.
    Undetermined {
        /// Its name.
        name: &'static str,
        /// Its standard deviation, px; infinite if nothing tells it.
        sigma: f64,
        /// The largest standard deviation allowed, px.
        allowed: f64,
        /// The largest angle between the normals of two views, degrees.
        angle: f64,
    },
    /// The adjustment found no camera that fits the points.
    NotConverged {
        /// RMS distance between points and their projections where it ended, px.
        rms: f64,
    },
    /// More points contradict the others than can be left out.
    Contradictions {
        /// Points that do.
        rejected: usize,
        /// All points.
        points: usize,
        /// Name of the view with most of them.
        view: String,
    },
}

impl std::error::Error for CalibrationError {}

impl fmt::Display for CalibrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewViews { views } => write!(
                f,
                "{views} view{}; wanted are {MIN_VIEWS} or more, with the board turned and tilted differently: each view of a \
                 plane gives two equations for fx, fy, cx, cy, and with fewer views nothing would tell a wrong one",
                if *views == 1 { "" } else { "s" }
            ),
            Self::TooFewPoints { view, points } => {
                write!(f, "{view}: {points} points; wanted are {MIN_POINTS} or more in each view")
            }
            Self::Sizes { first, size: [w, h], view, other: [u, v] } => {
                write!(
                    f,
                    "{view} is {u} x {v} px, {first} {w} x {h} px; all views must be of one camera and size"
                )
            }
            Self::Point { view, point } => write!(
                f,
                "{view}: point {point} has a number that is not finite, a covariance that is not positive definite, or a \
                 negative radius"
            ),
            Self::Collinear { view } => {
                write!(f, "{view}: its points lie on a line, which leaves the pose open")
            }
            Self::NoPlane => f.write_str(
                "centres of ellipses need targets on one plane; these lie in space: give true centres",
            ),
            Self::Undetermined { name, sigma, allowed, angle } => write!(
                f,
                "the views do not tell {name}: its standard deviation is {sigma:.1} px, allowed are {allowed:.1} px (1 % of \
                 the focal length); the board's normals differ by at most {angle:.1} degrees: add views with the board tilted \
                 by 20 to 50 degrees in different directions"
            ),
            Self::NotConverged { rms } => write!(
                f,
                "no camera fits the points (RMS {rms:.3} px): check that the layout is that of the board, and that all views \
                 are of one camera with unchanged focus and zoom"
            ),
            Self::Contradictions { rejected, points, view } => write!(
                f,
                "{rejected} of {points} points contradict the others, most of them in {view}: check that the layout is that of \
                 the board and that it did not bend or move"
            ),
        }
    }
}
