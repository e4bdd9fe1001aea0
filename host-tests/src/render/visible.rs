//! Which arcs of a circle are seen.

use super::camera::View;
use super::scene::Scene;
use super::truth::CircleTruth;
use glam::DVec2;
use std::f64::consts::TAU;

/// Points of a circle at which is asked whether it is seen; the ends of arcs are then found between them.
const PROBES: u32 = 720;
/// Halvings of the distance between two probes: to 1e-7 of a turn.
const HALVINGS: u32 = 15;

/// The circle of `radius` mm about the middle of a target, and what is seen of it.
pub struct Visible<'s> {
    pub scene: &'s Scene,
    pub view: View,
    pub centre: DVec2,
    pub radius: f64,
}

impl Visible<'_> {
    fn point(&self, turn: f64) -> DVec2 {
        self.centre + DVec2::from_angle(TAU * turn) * self.radius
    }

    fn seen(&self, turn: f64) -> bool {
        let Scene { camera, targets, occluders, .. } = self.scene;
        let place = self.view.at(self.point(turn)).0;
        let inside = |position: f64, size: u32| (-0.5..=f64::from(size) - 0.5).contains(&position);
        inside(place.x, camera.width)
            && inside(place.y, camera.height)
            && !occluders.iter().any(|occluder| occluder.hides(place, targets, camera))
    }

    /// Where what is seen ends or begins between two turns.
    fn change(&self, mut from: f64, mut to: f64) -> f64 {
        let first = self.seen(from);
        for _ in 0..HALVINGS {
            let middle = (from + to) / 2.0;
            if self.seen(middle) == first { from = middle } else { to = middle }
        }
        (from + to) / 2.0
    }

    /// The arcs that are seen, in turns on the target.
    fn arcs(&self) -> Vec<[f64; 2]> {
        let turn = |i: u32| f64::from(i) / f64::from(PROBES);
        let seen: Vec<bool> = (0..PROBES).map(|i| self.seen(turn(i))).collect();
        let changes: Vec<f64> = (0..PROBES)
            .zip(seen.iter().zip(seen.iter().cycle().skip(1)))
            .filter(|(_, (here, next))| here != next)
            .map(|(i, _)| self.change(turn(i), turn(i + 1)))
            .collect();
        let starts_seen = seen.first().is_some_and(|&seen| seen);
        match (&changes[..], starts_seen) {
            ([], true) => vec![[0.0, 1.0]],
            ([], false) => Vec::new(),
            ([first, inner @ .., last], true) => {
                let whole = inner.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
                whole.chain([[*last, first + 1.0]]).collect()
            }
            (changes, _) => changes.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect(),
        }
    }

    /// Its truth.
    pub fn truth(&self) -> CircleTruth {
        let ellipse = self.view.ellipse(self.centre, self.radius);
        let arcs = self.arcs();
        let direction = |turn: f64| {
            let spoke = self.view.undistorted(self.point(turn)) - DVec2::new(ellipse.x, ellipse.y);
            spoke.to_angle().to_degrees().rem_euclid(360.0)
        };
        let seen = |[from, to]: [f64; 2]| {
            let (first, last) = (direction(from), direction(to));
            let whole = to - from >= 1.0;
            if whole { [0.0, 360.0] } else { [first, last + if last < first { 360.0 } else { 0.0 }] }
        };
        CircleTruth {
            radius_mm: self.radius,
            ellipse,
            hidden: 1.0 - arcs.iter().fold(0.0, |sum, [from, to]| sum + to - from),
            visible: arcs.into_iter().map(seen).collect(),
        }
    }
}
