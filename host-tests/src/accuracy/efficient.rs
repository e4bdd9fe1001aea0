//! What the noise of a picture makes of any good estimate of the centre.
//!
//! Near the truth the estimate of maximum likelihood is linear in the noise of the pixels: weights that need the truth, and a
//! variance that follows from them exactly. An estimate that is nearly as good has nearly the same error in each picture, so that
//! what chance has made of its mean square in a few hundred pictures shows in the mean square of this one, whose expectation is
//! known: a control variate (Lavenberg and Welch 1981, "A perspective on the use of control variables to increase the efficiency
//! of Monte Carlo simulations", Manage. Sci. 27).

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use nalgebra::{DMatrix, DVector};

use super::bound::ROUNDING;
use crate::render::{Ellipse, Levels, Photometry, Scene, TargetTruth};

/// Unknowns of an ellipse; levels, slopes of the light and blur, which all share.
const OWN: usize = 5;
const SHARED: usize = 5;
/// How far from an edge pixels are taken, px.
const REACH: f64 = 8.0;
/// Steps to the nearest place of an ellipse.
const STEPS: usize = 8;

/// The estimate for a target.
#[derive(Clone, Debug)]
pub struct Efficient {
    /// Pixels, and how far a grey level moves the centre, px.
    weights: Vec<(usize, DVec2)>,
    /// Mean variance of both coordinates, px^2.
    variance: f64,
}

impl Efficient {
    /// For the target of `truth` without lens distortion, of whose ellipse centres the centre is the sum with the weights
    /// `combination`. `None` where the pixels do not tell everything.
    pub fn new(scene: &Scene, truth: &TargetTruth, combination: &[f64], levels: &Levels) -> Option<Self> {
        let view = View::new(&scene.photometry, truth);
        let all = OWN * view.outlines.len() + SHARED;
        let mut information = DMatrix::zeros(all, all);
        let mut slopes = Vec::new();
        for (i, &level) in levels.values.iter().enumerate() {
            let place = DVec2::new((i % levels.width) as f64, (i / levels.width) as f64);
            if let Some(slope) = view.slope(place, level) {
                information.ger(1.0, &slope, &slope, 1.0);
                slopes.push((i, slope));
            }
        }
        let inverse = information.cholesky()?.inverse();
        let [x, y] = [0, 1].map(|axis| {
            let mut row = DVector::zeros(all);
            combination.iter().enumerate().for_each(|(k, weight)| row[OWN * k + axis] = *weight);
            &inverse * row
        });
        let weights: Vec<_> =
            slopes.into_iter().map(|(i, slope)| (i, DVec2::new(x.dot(&slope), y.dot(&slope)))).collect();
        let gain = weights.iter().map(|(_, weight)| weight.length_squared()).sum::<f64>();
        let pixel = scene.photometry.noise.powi(2) + ROUNDING;
        Some(Self { weights, variance: 0.5 * gain * pixel })
    }

    /// Its squared error in a picture over the expectation of that, less 1: 0 on average.
    pub fn control(&self, pixels: &[u8], levels: &Levels) -> f64 {
        let noise = |i: usize| f64::from(pixels[i]) - levels.values[i];
        let error = self.weights.iter().map(|&(i, weight)| weight * noise(i)).sum::<DVec2>();
        error.length_squared() / (2.0 * self.variance) - 1.0
    }
}

/// A target as the pixels see it.
struct View<'a> {
    photometry: &'a Photometry,
    /// Outermost first.
    outlines: Vec<Ellipse>,
    /// Standard deviation of the blur, pixel box included, px.
    blur: f64,
}

impl<'a> View<'a> {
    fn new(photometry: &'a Photometry, truth: &TargetTruth) -> Self {
        let outlines = truth.circles.iter().map(|circle| circle.ellipse).collect();
        Self { photometry, outlines, blur: photometry.blur.hypot(ROUNDING.sqrt()) }
    }

    /// Derivatives of the level of the pixel at `place` by the unknowns. `None` far from all edges.
    fn slope(&self, place: DVec2, level: f64) -> Option<DVector<f64>> {
        let Photometry { black, white, shading, .. } = *self.photometry;
        let light = shading.map_or(1.0, |light| light.at(place.x, place.y));
        let shared = OWN * self.outlines.len();
        let mut slope = DVector::zeros(shared + SHARED);
        let mut near = false;
        let mut inside = -1.0;
        for (k, outline) in self.outlines.iter().enumerate() {
            if let Some(edge) = Nearest::new(outline, place) {
                near = true;
                let (z, lead) = (edge.distance / self.blur, 0.5 * edge.curvature * self.blur);
                let density = (-0.5 * (z + lead).powi(2)).exp() / TAU.sqrt();
                let change = inside * (white - black) * light * density;
                slope.rows_mut(OWN * k, OWN).copy_from_slice(&edge.moves.map(|by| change * by / self.blur));
                slope[shared + 4] += change * (z - lead);
            }
            inside = -inside;
        }
        let outer = self.outlines.first()?;
        let lightness = (level / light - black) / (white - black);
        let from = (place - DVec2::new(outer.x, outer.y)) / outer.a * level / light;
        slope.rows_mut(shared, 4).copy_from_slice(&[
            (1.0 - lightness) * light,
            lightness * light,
            from.x,
            from.y,
        ]);
        near.then_some(slope)
    }
}

/// The place of an ellipse that is nearest to another place.
struct Nearest {
    /// Distance, px, positive outside.
    distance: f64,
    /// Curvature there, 1/px.
    curvature: f64,
    /// How far it moves outwards with the unknowns: the centre by 1 px in x and in y; the semi-axes by 1 px, and shear.
    moves: [f64; OWN],
}

impl Nearest {
    /// `None` farther than [`REACH`].
    fn new(ellipse: &Ellipse, place: DVec2) -> Option<Self> {
        let Ellipse { x, y, a, b, theta } = *ellipse;
        let turn = DVec2::from_angle(theta);
        let own = DVec2::from_angle(-theta).rotate(place - DVec2::new(x, y));
        let radius = (own / DVec2::new(a, b)).length();
        // The least that it can be away.
        if (radius - 1.0) * b > REACH || (1.0 - radius) * b > REACH {
            return None;
        }
        let mut angle = (own.y * a).atan2(own.x * b);
        for _ in 0..STEPS {
            let (sin, cos) = angle.sin_cos();
            let off = DVec2::new(a * cos, b * sin) - own;
            let along = DVec2::new(-a * sin, b * cos);
            // Far inside there are several, and no telling which.
            let bend = (along.length_squared() - off.dot(DVec2::new(a * cos, b * sin))).max(0.1 * b * b);
            angle -= (off.dot(along) / bend).clamp(-0.25 * PI, 0.25 * PI);
        }
        let (sin, cos) = angle.sin_cos();
        let normal = DVec2::new(cos / a, sin / b).normalize();
        let distance = (own - DVec2::new(a * cos, b * sin)).dot(normal);
        let centre = turn.rotate(normal);
        let moves = [centre.x, centre.y, normal.x * cos, normal.y * sin, normal.x * sin + normal.y * cos];
        let curvature = a * b / (a * sin).hypot(b * cos).powi(3);
        (distance.abs() <= REACH).then_some(Self { distance, curvature, moves })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::{
        bound::{Bounds, per_coordinate},
        cell::Cell,
    };

    /// It is as good as the bound says, and chance leaves nothing of its mean that its expectation does not tell.
    #[test]
    fn it_is_efficient_and_its_expectation_is_known() {
        for cell in [
            Cell::default(),
            Cell { radius: 12.0, tilt: 0.0, shading: 0.3, ..Cell::default() },
            Cell { radius: 20.0, tilt: 60.0, psf: 1.5, noise: 1.0, ..Cell::default() },
        ] {
            let scene = cell.scene(3);
            let (truth, levels) = (scene.truth(0).targets.remove(0), scene.levels());
            let bounds =
                Bounds::new(&truth, &scene.camera, &scene.photometry, &|_| true).expect("all is visible");
            let efficient =
                Efficient::new(&scene, &truth, &bounds.combination, &levels).expect("pixels tell all");
            let ratio = efficient.variance.sqrt() / per_coordinate(bounds.centre);
            // The bound takes levels and blur as known, and edges as straight.
            assert!((0.97..1.05).contains(&ratio), "{ratio} {}", cell.label());
            let controls: Vec<_> = (0..300)
                .map(|draw| efficient.control(&scene.photometry.digitise(&levels.values, draw), &levels))
                .collect();
            let mean = controls.iter().sum::<f64>() / controls.len() as f64;
            assert!(mean.abs() < 0.2, "{mean} {}", cell.label());
            assert!(controls.iter().any(|control| *control > 1.0));
        }
    }
}
