//! Seeded value noise: cloudy backgrounds and noise patches.

use glam::DVec2;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// A cloudy background.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Texture {
    /// Largest change of reflectance, 0 to 1.
    pub amplitude: f64,
    /// Size of the clouds, px.
    pub scale: f64,
    /// Seed of the pattern.
    pub seed: u64,
}

/// Parts of the amplitude in octaves of falling scale, and the ratio of their scales. Not a whole number, so
/// that the lattices do not fall on each other.
const OCTAVES: [f64; 3] = [0.5, 0.3, 0.2];
const LACUNARITY: f64 = 2.3;

/// Random values, -1 to 1, on lattices, smoothly interpolated. They belong to the pixels: the lens's blur
/// does not act.
pub struct Clouds {
    octaves: Vec<Lattice>,
}

struct Lattice {
    amplitude: f64,
    scale: f64,
    columns: usize,
    values: Vec<f64>,
}

impl Clouds {
    /// Over `width` x `height` px with a coarsest lattice of `scale` px.
    pub fn new(seed: u64, scale: f64, width: usize, height: usize) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut scale = scale * LACUNARITY;
        let octave = |amplitude: f64| {
            scale /= LACUNARITY;
            let nodes = |size: usize| (size as f64 / scale).ceil() as usize + 2;
            let (columns, rows) = (nodes(width), nodes(height));
            let values: Vec<f64> = match Uniform::new_inclusive(-1.0, 1.0) {
                Ok(uniform) => uniform.sample_iter(&mut random).take(columns * rows).collect(),
                Err(_) => vec![0.0; columns * rows],
            };
            Lattice { amplitude, scale, columns, values }
        };
        Self { octaves: OCTAVES.into_iter().map(octave).collect() }
    }

    /// The value at a pixel of the rectangle.
    pub fn at(&self, column: usize, row: usize) -> f64 {
        self.octaves.iter().map(|lattice| lattice.amplitude * lattice.at(column, row)).sum()
    }
}

impl Lattice {
    fn at(&self, column: usize, row: usize) -> f64 {
        let place = DVec2::new(column as f64, row as f64) / self.scale;
        let cell = place.floor();
        let t = place - cell;
        let t = t * t * (3.0 - 2.0 * t);
        let corner = cell.y as usize * self.columns + cell.x as usize;
        let lerp = |i: usize| self.values[i] + (self.values[i + 1] - self.values[i]) * t.x;
        let (upper, lower) = (lerp(corner), lerp(corner + self.columns));
        upper + (lower - upper) * t.y
    }
}
