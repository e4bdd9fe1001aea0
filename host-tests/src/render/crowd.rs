//! Many targets and clutter at random places.

use super::camera::{Camera, Pose};
use super::decoy::{Decoy, DecoyKind};
use super::scene::Scene;
use super::target::{Artwork, Target};
use anyhow::{Result, bail};
use glam::DVec2;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// Least distance between figures, and of figures from the frame's border, px.
const QUIET: f64 = 6.0;
/// Tries at a place before the figure is made smaller or given up.
const TRIES: usize = 2000;
/// Least and greatest semi-major axis of a target, px; the greatest also in widths of its share of the frame.
const TARGET_SIZES: (f64, f64, f64) = (11.0, 60.0, 0.33);
/// Least semi-minor axis of the innermost circle and least gap between circles along it, px.
const LEAST_GAP: f64 = 4.5;
/// Largest tilt, degrees.
const LARGEST_TILT: f64 = 60.0;
/// Least and greatest size of a decoy, px.
const DECOY_SIZES: (f64, f64) = (5.0, 22.0);

impl Scene {
    /// `count` dark annuli of ratio 0.5 at random places, sizes (semi-major axis 11 to 60 px) and tilts (0 to
    /// 60 degrees, never so small and steep that a gap is below 4.5 px), as many decoys between them when
    /// `clutter`, and 6 px of free paper round everything. The field of view is that of [`Camera::paper`].
    ///
    /// # Errors
    /// When the frame cannot hold that many.
    pub fn many(count: usize, width: u32, height: u32, clutter: bool, seed: u64) -> Result<Self> {
        let paper = Camera::paper();
        let f = paper.f * f64::from(width) / f64::from(paper.width);
        let mut scene = Self::empty(Camera::new(width, height, f));
        scene.crowd(count, &Artwork::annulus(10.0, 5.0), seed)?;
        if clutter {
            scene.scatter(count, seed.wrapping_add(1))?;
        }
        Ok(scene)
    }

    /// Adds `count` targets as in [`Scene::many`], with this artwork scaled by distance.
    ///
    /// # Errors
    /// When the camera is invalid or the frame cannot hold that many.
    pub fn crowd(&mut self, count: usize, artwork: &Artwork, seed: u64) -> Result<()> {
        self.camera.validate()?;
        artwork.validate()?;
        let mut places = Places::new(self, seed);
        let share = (places.size.x * places.size.y / count.max(1) as f64).sqrt();
        let (least, greatest, part) = TARGET_SIZES;
        let greatest = (part * share).clamp(least, greatest);
        let mut sizes: Vec<f64> =
            (0..count).map(|_| least * (greatest / least).powf(places.uniform(0.0, 1.0))).collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        for size in sizes {
            let Some((place, size)) = places.find(size, least) else {
                bail!(
                    "{count} targets do not fit in {} x {} px: fewer targets or a larger frame",
                    self.camera.width,
                    self.camera.height
                );
            };
            let frontal = Pose {
                x: place.x,
                y: place.y,
                distance: self.camera.f * artwork.reach() / size * self.camera.ray(place.x, place.y).length(),
                tilt: 0.0,
                azimuth: 0.0,
            };
            let mut tilted = || Pose {
                tilt: places.uniform(0.0, LARGEST_TILT),
                azimuth: places.uniform(0.0, 360.0),
                ..frontal
            };
            let pose =
                (0..TRIES).map(|_| tilted()).find(|pose| self.resolves(artwork, pose)).unwrap_or(frontal);
            self.targets.push(Target { artwork: artwork.clone(), pose, at: [0.0, 0.0] });
        }
        Ok(())
    }

    /// Whether the innermost circle and all gaps between circles are wide enough in the image, and the outer
    /// circle at least half as wide as long.
    fn resolves(&self, artwork: &Artwork, pose: &Pose) -> bool {
        let view = pose.view(&self.camera);
        let seen: Vec<_> = artwork.radii.iter().map(|r| view.ellipse(DVec2::ZERO, *r)).collect();
        let narrow = seen.windows(2).any(|pair| pair[0].b - pair[1].b < LEAST_GAP)
            || seen.last().is_some_and(|inner| inner.b < LEAST_GAP);
        !narrow && seen.first().is_some_and(|outer| outer.b >= 0.5 * outer.a)
    }

    /// Adds `count` decoys of all kinds in turn, 5 to 22 px in radius, in the free places.
    ///
    /// # Errors
    /// When the camera is invalid or the free places cannot hold that many.
    pub fn scatter(&mut self, count: usize, seed: u64) -> Result<()> {
        self.camera.validate()?;
        let mut places = Places::new(self, seed);
        for (i, kind) in DecoyKind::ALL.into_iter().cycle().take(count).enumerate() {
            let (least, greatest) = DECOY_SIZES;
            let size = places.uniform(least, greatest);
            let Some((place, size)) = places.find(size, least) else {
                bail!("only {i} of {count} decoys fit between the targets: fewer decoys or a larger frame");
            };
            let angle = places.uniform(0.0, 360.0);
            self.decoys.push(Decoy {
                kind,
                x: place.x,
                y: place.y,
                size,
                angle,
                seed: seed.wrapping_add(i as u64),
            });
        }
        Ok(())
    }
}

/// Middle and radius of the circle round each figure of the scene, px.
fn taken(scene: &Scene) -> Vec<(DVec2, f64)> {
    let targets = scene.targets.iter().map(|target| target.extent(&scene.camera));
    let decoys = scene.decoys.iter().map(|decoy| (DVec2::new(decoy.x, decoy.y), decoy.size));
    targets.chain(decoys).collect()
}

/// Free places of the frame.
struct Places {
    random: Pcg64,
    size: DVec2,
    taken: Vec<(DVec2, f64)>,
}

impl Places {
    fn new(scene: &Scene, seed: u64) -> Self {
        let size = DVec2::new(f64::from(scene.camera.width), f64::from(scene.camera.height));
        Self { random: Pcg64::seed_from_u64(seed), size, taken: taken(scene) }
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new_inclusive(low, high).map_or(low, |uniform| uniform.sample(&mut self.random))
    }

    /// A place for a figure of this size, made smaller down to `least` if there is none; takes it.
    fn find(&mut self, mut size: f64, least: f64) -> Option<(DVec2, f64)> {
        loop {
            // Perspective makes a target reach a little farther from its true centre than its semi-major
            // axis.
            let margin = size * 1.05 + QUIET;
            for _ in 0..TRIES {
                let x = self.uniform(margin, self.size.x - 1.0 - margin);
                let y = self.uniform(margin, self.size.y - 1.0 - margin);
                let place = DVec2::new(x, y);
                let inside = 2.0 * margin < self.size.min_element() - 1.0;
                if inside && self.taken.iter().all(|(other, r)| place.distance(*other) >= r + margin) {
                    self.taken.push((place, size * 1.05));
                    return Some((place, size));
                }
            }
            if size <= least {
                return None;
            }
            size = (size * 0.85).max(least);
        }
    }
}
