//! Correspondence: which measured target is which on the layout.
//!
//! At least four coded targets give a first map from the layout to the image: a homography if the layout is a plane, else a
//! camera and its pose. From them outwards the map finds the plain targets: a target and a measurement are a pair if each is
//! the nearest to the other, close by compared with the distance to the next target, and of the right size; after each step
//! outwards the map, with the lens's distortion in it, is fitted anew. In the end all pairs are made once more with the final
//! map and a gate from its residuals.

mod error;
mod grow;
pub mod homography;
mod map;
pub mod plane;

pub use error::MatchError;
pub use grow::correspond;

use concentric::{
    Covariance, Target,
    report::{Details, Shape, TargetEntry},
};

use crate::{measure::px, monitor::json::covariance};

/// Fewest coded targets of the layout that must be seen.
pub const MIN_CODED: usize = 4;

/// A target that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Its centre, px.
    pub centre: [f64; 2],
    /// Covariance `(xx, xy, yy)` of that, px^2.
    pub covariance: [f64; 3],
    /// The id that it carries, if one was read.
    pub id: Option<u16>,
    /// Mean semi-axis of the outer ellipse, px; 0 if it is not known.
    pub size: f64,
}

/// A target of the layout and a measured one that are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Number of the target on the layout.
    pub target: usize,
    /// Number of the measured one.
    pub measured: usize,
    /// Distance between the measured centre and where the map expects it, px. The map is not a calibrated camera.
    pub distance: f64,
}

/// Which is which. All numbers count from 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correspondence {
    /// The pairs, in the layout's order.
    pub pairs: Vec<Pair>,
    /// Targets of the layout that should be seen and were not measured.
    pub missing: Vec<usize>,
    /// Measured targets that are none of the layout.
    pub unmatched: Vec<usize>,
    /// Targets of the layout with several measured ones where one is expected.
    pub ambiguous: Vec<usize>,
    /// Measured ids that the layout does not have.
    pub foreign: Vec<u16>,
    /// Ids that were measured more than once. They are no starting points, and pairs only by their place.
    pub duplicates: Vec<u16>,
    /// Ids that were read where another target of the layout is, or none.
    pub contradicting: Vec<u16>,
    /// RMS of the distances, px.
    pub rms: f64,
}

impl Measured {
    /// What `target` tells; its centre with all corrections.
    pub fn new(target: &Target) -> Self {
        let Covariance { xx, xy, yy } = target.covariance;
        let outer = target.circles.first().map(|circle| circle.ellipse);
        Self {
            centre: px(target.centre),
            covariance: [xx, xy, yy].map(f64::from),
            id: target.code.map(|code| code.id),
            size: outer.map_or(0.0, |outer| f64::from(outer.a + outer.b) / 2.0),
        }
    }
    /// What a report tells. `None` where it does not say how exact the centre is.
    pub fn reported(entry: &TargetEntry) -> Option<Self> {
        let mean = |shape: &Shape| f64::from(shape.a + shape.b) / 2.0 / 4096.0;
        let size = match &entry.details {
            Details::Terse => 0.0,
            Details::Normal(shape) => mean(shape),
            Details::Full(full) => full.circles.first().map_or(0.0, |circle| mean(&circle.shape)),
        };
        Some(Self {
            centre: px(entry.centre),
            covariance: covariance(entry)?.map(f64::from),
            id: (entry.id > 0).then_some(entry.id),
            size,
        })
    }
}
