//! From reflectance to grey levels.

use anyhow::{Result, ensure};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// Light that falls off linearly over the sensor, as in a vignette or an uneven response. It acts after the
/// lens's blur, so it moves no edge by itself. (Light uneven on the target itself would be blurred with the
/// target; that moves the whole image by g sigma^2 px towards the light for a relative gradient of g per px.)
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shading {
    /// Relative change of the light over `span`.
    pub fraction: f64,
    /// Length over which the light changes by `fraction`, px.
    pub span: f64,
    /// Direction towards the light, from +x towards +y, degrees.
    pub direction: f64,
    /// Column at which the light is 1, px.
    pub x: f64,
    /// Row at which the light is 1, px.
    pub y: f64,
}

impl Shading {
    /// Light at the pixel `(x, y)`, 1 at the origin of the field.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (sin, cos) = self.direction.to_radians().sin_cos();
        let slope = self.fraction / self.span;
        (1.0 + slope * ((x - self.x) * cos + (y - self.y) * sin)).max(0.0)
    }
}

/// Lens blur, light and sensor. Applied in the order of the fields; the last step rounds to 8 bits and clips
/// to
/// 0..=255, as the sensor's converter does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Photometry {
    /// Standard deviation of the Gaussian point spread function, px; 0 or 0.02 to 50.
    pub blur: f64,
    /// Grey level of dark ink.
    pub black: f64,
    /// Grey level of light paper.
    pub white: f64,
    /// Uneven light.
    pub shading: Option<Shading>,
    /// Exponent of the response: 255 (level / 255)^gamma.
    pub gamma: f64,
    /// Factor on the level.
    pub gain: f64,
    /// Standard deviation of the Gaussian noise, grey levels.
    pub noise: f64,
}

impl Default for Photometry {
    /// Blur 0.8 px, 30 to 220 grey levels, even light, linear response, noise 2.
    fn default() -> Self {
        Self { blur: 0.8, black: 30.0, white: 220.0, shading: None, gamma: 1.0, gain: 1.0, noise: 2.0 }
    }
}

impl Photometry {
    /// # Errors
    /// When a value is out of its range.
    pub fn validate(&self) -> Result<()> {
        let Self { blur, black, white, shading, gamma, gain, noise } = *self;
        ensure!(blur == 0.0 || (0.02..=50.0).contains(&blur), "blur {blur} px: must be 0, or 0.02 to 50");
        ensure!((0.0..=255.0).contains(&black), "black level {black}: must be 0 to 255");
        ensure!((0.0..=255.0).contains(&white), "white level {white}: must be 0 to 255");
        ensure!(black < white, "black level {black} and white level {white}: black must be below white");
        ensure!((0.05..=20.0).contains(&gamma), "gamma {gamma}: must be 0.05 to 20");
        ensure!((0.01..=100.0).contains(&gain), "gain {gain}: must be 0.01 to 100");
        ensure!((0.0..=200.0).contains(&noise), "noise {noise}: must be 0 to 200");
        if let Some(light) = shading {
            let finite = [light.fraction, light.direction, light.x, light.y].iter().all(|v| v.is_finite());
            ensure!(finite && light.span > 0.0, "shading {light:?}: must be finite, its span above 0");
        }
        Ok(())
    }

    /// Reflectance to grey level, before noise and rounding; in place, rows of `width`.
    pub fn expose(&self, reflectance: &mut [f64], width: usize) {
        for (y, row) in reflectance.chunks_exact_mut(width).enumerate() {
            for (x, value) in row.iter_mut().enumerate() {
                let light = self.shading.map_or(1.0, |shading| shading.at(x as f64, y as f64));
                *value = self.level(*value, light);
            }
        }
    }

    /// Grey level of `reflectance` (0 black, 1 white) in `light` (1 where it is even), before noise and rounding.
    pub fn level(&self, reflectance: f64, light: f64) -> f64 {
        let level = (self.black + (self.white - self.black) * reflectance).max(0.0) * light;
        let response = if self.gamma == 1.0 { level } else { 255.0 * (level / 255.0).powf(self.gamma) };
        response * self.gain
    }

    /// Adds noise, rounds and clips. The same seed gives the same bytes (PCG-64, ziggurat normals).
    pub fn digitise(&self, levels: &[f64], seed: u64) -> Vec<u8> {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut noise = || {
            let normal: f64 = if self.noise > 0.0 { StandardNormal.sample(&mut random) } else { 0.0 };
            self.noise * normal
        };
        // The cast saturates at 0 and 255.
        levels.iter().map(|level| (level + noise()).round() as u8).collect()
    }
}
