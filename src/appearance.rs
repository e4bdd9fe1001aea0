//! What the library takes a target to be: nested ellipses of two levels under one plane of light, blurred. Its unknowns are
//! found by Gauss-Newton steps, on stored crossings ([`crate::measure`]) or on the pixels of an image ([`crate::refine`]).

mod saddle;

use crate::fit::{Frame, Matrix, Shape};
use crate::target::MAX_CIRCLES;
use heapless::Vec;
pub(crate) use saddle::Saddle;

/// Most that a step may change the blur, relative.
const BLUR_STEP: f32 = 0.3;
/// Range of the blur, px.
const BLUR: (f32, f32) = (0.2, 6.0);

/// Terms of a conic.
pub(crate) const OWN: usize = 5;
/// Dark, bright, the light's slopes in units of the target's size, logarithm of the blur.
pub(crate) const SHARED: usize = 5;

/// One circle's image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    pub shape: Shape,
    pub frame: Frame,
    /// Its determinant and its semi-axes, px.
    pub det: f32,
    pub major: f32,
    pub minor: f32,
    /// Change of lightness from outside to inside, +1 or -1.
    pub inside: f32,
}

impl Outline {
    pub fn new(shape: Shape, inside: f32) -> Option<Self> {
        let frame = Frame::new(&shape)?;
        let (major, minor) = shape.semi_axes();
        Some(Self { shape, frame, det: shape.det(), major, minor, inside })
    }
}

/// The model. Coordinates in px about the target's integer origin.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// Outermost first.
    pub outlines: Vec<Outline, MAX_CIRCLES>,
    pub dark: f32,
    pub bright: f32,
    /// Slope of the light, 1/px.
    pub gx: f32,
    pub gy: f32,
    /// Standard deviation of the blur, px.
    pub blur: f32,
}

/// A step of every unknown.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub own: Vec<[f32; OWN], MAX_CIRCLES>,
    pub shared: [f32; SHARED],
}

/// Covariances of an outline's stretch and centre in the frame where it is the unit circle, for a unit variance of the
/// levels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Where levels, light and blur are known.
    pub own: Matrix<4>,
    /// What it is more because they are measured too.
    pub shared: Matrix<4>,
}

impl Model {
    pub fn contrast(&self) -> f32 {
        self.bright - self.dark
    }

    /// Weights of what is known of the shared unknowns beforehand, that of one pixel: keep a level that is seen nowhere in
    /// bounds.
    pub fn prior(&self) -> [f32; SHARED] {
        let square = self.contrast() * self.contrast();
        [1.0, 1.0, square, square, square]
    }

    /// Takes a step; `size` px is the unit of the light's slopes. Returns how far it moves an outline at most, px.
    pub fn take(&mut self, step: &Step, size: f32) -> Option<f32> {
        let mut farthest = 0.0f32;
        for (outline, step) in self.outlines.iter_mut().zip(&step.own) {
            let largest = step.iter().fold(0.0f32, |largest, term| largest.max(term.abs()));
            farthest = farthest.max(0.5 * largest * outline.major);
            *outline = Outline::new(outline.frame.moved(&outline.shape, step)?, outline.inside)?;
        }
        let [dark, bright, gx, gy, blur] = step.shared;
        self.dark += dark;
        self.bright += bright;
        self.gx += gx / size;
        self.gy += gy / size;
        self.blur = (self.blur * (1.0 + blur.clamp(-BLUR_STEP, BLUR_STEP))).clamp(BLUR.0, BLUR.1);
        (self.contrast() > 0.0).then_some(farthest)
    }
}
