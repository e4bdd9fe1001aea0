//! The order of the steps.

use nalgebra::{Vector2, Vector3};

use super::{
    Calibration, CalibrationError, Fitted, Intrinsics, MIN_POINTS, MIN_VIEWS, Options, Placed, Pose,
    Residual, View,
    adjust::{Adjustment, whitening},
    start::start,
};
use crate::matching::plane::Plane;

/// Length of a residual, in standard deviations, above which its point contradicts the others. One of 300,000 good ones
/// does.
const GATE: f64 = 5.0;
/// Most points that may be left out, as a share of all.
const MOST_REJECTED: f64 = 0.2;
/// Largest RMS residual of a camera that fits, as a share of the frame's larger side.
const MOST_RMS: f64 = 1e-3;
/// Largest standard deviation of focal lengths and principal point, as a share of the focal length.
const MOST_SIGMA: f64 = 0.01;

/// The camera that took `views`, at least [`MIN_VIEWS`] with [`MIN_POINTS`] points each.
///
/// # Errors
/// [`CalibrationError`]: what is missing.
pub fn calibrate(views: &[View], options: &Options) -> Result<Calibration, CalibrationError> {
    check(views)?;
    let plane = Plane::through(views.iter().flat_map(|view| &view.points).map(|point| point.object));
    let centres_of_ellipses = views.iter().flat_map(|view| &view.points).any(|point| point.radius > 0.0);
    if centres_of_ellipses && plane.is_none() {
        return Err(CalibrationError::NoPlane);
    }
    let normal = plane.map_or_else(Vector3::z, |plane| plane.normal());
    let mut state = start(views)?;
    let mut kept: Vec<_> = views.iter().map(|view| vec![true; view.points.len()]).collect();
    let mut passes = 0;
    let mut scope = Scope::View;
    loop {
        let (solved, converged) = Adjustment::new(views, &kept, normal, options, state).solve();
        let result = Solved { views, options, normal, kept: &kept, passes, solved: &solved };
        let mut next = result.contradictions(scope);
        if next == kept {
            scope = Scope::All;
            next = result.contradictions(scope);
        }
        if passes == options.passes || next == kept {
            return result.finish(converged);
        }
        check_kept(views, &next)?;
        state = (solved.intrinsics, solved.poses);
        kept = next;
        passes += 1;
    }
}

fn check(views: &[View]) -> Result<(), CalibrationError> {
    let Some(first) = views.first().filter(|_| views.len() >= MIN_VIEWS) else {
        return Err(CalibrationError::TooFewViews { views: views.len() });
    };
    for view in views {
        let name = view.name.clone();
        if view.size != first.size {
            return Err(CalibrationError::Sizes {
                first: first.name.clone(),
                size: first.size,
                view: name,
                other: view.size,
            });
        }
        if view.points.len() < MIN_POINTS {
            return Err(CalibrationError::TooFewPoints { view: name, points: view.points.len() });
        }
        let wrong = view.points.iter().position(|point| {
            let numbers = point.object.iter().chain(&point.image).chain(&point.covariance);
            !numbers.chain([&point.radius]).all(|value| value.is_finite())
                || point.radius < 0.0
                || whitening(point.covariance).is_none()
        });
        if let Some(point) = wrong {
            return Err(CalibrationError::Point { view: name, point });
        }
    }
    Ok(())
}

/// Whether enough is left.
fn check_kept(views: &[View], kept: &[Vec<bool>]) -> Result<(), CalibrationError> {
    let rejected = |kept: &[bool]| kept.iter().filter(|&&kept| !kept).count();
    let all: usize = kept.iter().map(|kept| rejected(kept)).sum();
    let points: usize = kept.iter().map(Vec::len).sum();
    let few = kept.iter().any(|kept| kept.len() - rejected(kept) < MIN_POINTS);
    if !few && all as f64 <= MOST_REJECTED * points as f64 {
        return Ok(());
    }
    let worst = views.iter().zip(kept).max_by_key(|(_, kept)| rejected(kept));
    let view = worst.map(|(view, _)| view.name.clone()).unwrap_or_default();
    Err(CalibrationError::Contradictions { rejected: all, points, view })
}

/// Whose median residual is the scale for the others.
#[derive(Clone, Copy, PartialEq)]
enum Scope {
    /// That of the same view, so that a wrong point takes no good ones of its view with it.
    View,
    /// That of all views, so that a view does not pass by being wrong as a whole.
    All,
}

/// What an adjustment found, for the views that it is about.
struct Solved<'a> {
    views: &'a [View],
    options: &'a Options,
    normal: Vector3<f64>,
    kept: &'a [Vec<bool>],
    passes: u32,
    solved: &'a Adjustment,
}

impl Solved<'_> {
    fn residuals(&self, index: usize) -> Vec<Residual> {
        let (view, pose) = (&self.views[index], &self.solved.poses[index]);
        let placed = Placed::new(pose, self.normal);
        let residual = |(point, &kept): (&super::Point, &bool)| {
            let place = placed.seen_centre(&self.solved.intrinsics, &point.object.into(), point.radius);
            let shift = Vector2::from(point.image) - place;
            let whitened = match whitening(point.covariance) {
                Some(whiten) if self.options.weighted => whiten * shift,
                _ => shift,
            };
            Residual { image: point.image, shift: shift.into(), normalised: whitened.norm(), kept }
        };
        view.points.iter().zip(&self.kept[index]).map(residual).collect()
    }

    /// Which points to keep.
    fn contradictions(&self, scope: Scope) -> Vec<Vec<bool>> {
        let residuals: Vec<_> = (0..self.views.len()).map(|index| self.residuals(index)).collect();
        let common = self.gate(residuals.iter().flatten());
        let keep = |residuals: &Vec<Residual>| {
            let gate = if scope == Scope::View { self.gate(residuals.iter()) } else { common };
            residuals.iter().map(|residual| residual.normalised <= gate).collect()
        };
        residuals.iter().map(keep).collect()
    }

    fn gate<'a>(&self, residuals: impl Iterator<Item = &'a Residual>) -> f64 {
        let mut squares: Vec<_> = residuals.filter(|r| r.kept).map(|r| r.normalised * r.normalised).collect();
        squares.sort_by(f64::total_cmp);
        let median = squares.get(squares.len() / 2).copied().unwrap_or(0.0);
        // The median of a chi square with two degrees of freedom.
        GATE * self.enlarge(median / (2.0 * std::f64::consts::LN_2))
    }

    /// What standard deviations are multiplied by.
    fn enlarge(&self, variance_factor: f64) -> f64 {
        // Covariances that are given are not made smaller by a lucky draw.
        if self.options.weighted { variance_factor.max(1.0).sqrt() } else { variance_factor.sqrt() }
    }

    fn finish(&self, converged: bool) -> Result<Calibration, CalibrationError> {
        let residuals: Vec<_> = (0..self.views.len()).map(|index| self.residuals(index)).collect();
        let kept = || residuals.iter().flatten().filter(|residual| residual.kept);
        let freedom = self.solved.rows().saturating_sub(self.solved.columns()).max(1) as f64;
        let variance_factor = kept().map(|r| r.normalised * r.normalised).sum::<f64>() / freedom;
        let rms = rms(kept());
        let scale = self.enlarge(variance_factor);
        let size = self.views[0].size;
        let angle = self.angle();
        let open = |name, sigma, allowed| CalibrationError::Undetermined { name, sigma, allowed, angle };
        let intrinsics = self.solved.intrinsics;
        if !(rms <= MOST_RMS * f64::from(size[0].max(size[1]))) {
            return Err(CalibrationError::NotConverged { rms });
        }
        let allowed = MOST_SIGMA * intrinsics.fx.abs();
        let Some((covariance, poses)) = self.solved.covariance() else {
            return Err(open("the focal length", f64::INFINITY, allowed));
        };
        let covariance = covariance * (scale * scale);
        let sigma = Intrinsics::from_array(std::array::from_fn(|i| covariance[(i, i)].sqrt()));
        let pixels = sigma.to_array().into_iter().zip(Intrinsics::NAMES).take(4);
        if let Some((sigma, name)) = pixels.into_iter().find(|&(sigma, _)| !(sigma <= allowed)) {
            return Err(open(name, sigma, allowed));
        }
        if !converged {
            return Err(CalibrationError::NotConverged { rms });
        }
        let mut sigmas = poses.chunks_exact(6);
        let fitted = |((view, pose), residuals): ((&View, &Pose), Vec<Residual>)| Fitted {
            name: view.name.clone(),
            pose: *pose,
            sigma: sigmas.next().map_or([0.0; 6], |of| std::array::from_fn(|i| of[i].sqrt() * scale)),
            rms: self::rms(residuals.iter().filter(|residual| residual.kept)),
            residuals,
        };
        let views = self.views.iter().zip(&self.solved.poses).zip(residuals).map(fitted).collect();
        let passes = self.passes;
        Ok(Calibration { size, intrinsics, sigma, covariance, views, rms, variance_factor, passes, angle })
    }

    fn angle(&self) -> f64 {
        let normals: Vec<_> = self.solved.poses.iter().map(|pose| pose.rotation() * self.normal).collect();
        let pairs = normals.iter().flat_map(|a| normals.iter().map(move |b| a.angle(b)));
        pairs.fold(0.0, f64::max).to_degrees()
    }
}

fn rms<'a>(residuals: impl Iterator<Item = &'a Residual> + Clone) -> f64 {
    let count = residuals.clone().count().max(1) as f64;
    (residuals.map(|r| r.shift[0].powi(2) + r.shift[1].powi(2)).sum::<f64>() / count).sqrt()
}
