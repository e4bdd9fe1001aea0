//! A scene and its picture.

use super::camera::{Camera, Pose};
use super::decoy::{Decoy, DecoyKind};
use super::occluder::{Cover, Occluder};
use super::photometry::Photometry;
use super::raster::Coverage;
use super::target::{Artwork, Target, Tone};
use super::texture::{Clouds, Texture};
use super::truth::{TargetTruth, Truth};
use anyhow::{Context, Result, ensure};
use glam::DVec2;

/// Everything that makes a picture. The fields may be changed freely before rendering.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The camera.
    pub camera: Camera,
    /// Tone of the paper around the targets.
    pub paper: Tone,
    /// The targets. They must not overlap.
    pub targets: Vec<Target>,
    /// What is no target. Must not overlap targets or each other.
    pub decoys: Vec<Decoy>,
    /// Cloudy background; a square round each target is kept free.
    pub texture: Option<Texture>,
    /// What lies over all of that, in the order in which it is laid.
    pub occluders: Vec<Occluder>,
    /// Blur, light and sensor.
    pub photometry: Photometry,
}

/// Grey levels before noise, rounding and clipping.
#[derive(Clone, Debug)]
pub struct Levels {
    /// Width, px.
    pub width: usize,
    /// Height, px.
    pub height: usize,
    /// Row by row.
    pub values: Vec<f64>,
}

/// A picture and what it really shows.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width, px.
    pub width: usize,
    /// Height, px.
    pub height: usize,
    /// Row by row.
    pub pixels: Vec<u8>,
    /// What it shows.
    pub truth: Truth,
}

/// Size of the grains of a noise patch, px.
const GRAIN: f64 = 2.5;

impl Scene {
    /// White paper.
    pub fn empty(camera: Camera) -> Self {
        Self {
            camera,
            paper: Tone::Light,
            targets: Vec::new(),
            decoys: Vec::new(),
            texture: None,
            occluders: Vec::new(),
            photometry: Photometry::default(),
        }
    }

    /// One dark annulus of outer radius `radius` mm and ratio 0.5, 800 mm before [`Camera::paper`], its true
    /// centre `phase` px from the principal point; `tilt` and `azimuth` in degrees as in [`Pose`].
    pub fn single(radius: f64, tilt: f64, azimuth: f64, phase: [f64; 2]) -> Self {
        let camera = Camera::paper();
        let pose = Pose { x: camera.cx + phase[0], y: camera.cy + phase[1], distance: 800.0, tilt, azimuth };
        let mut scene = Self::empty(camera);
        scene.targets.push(Target { artwork: Artwork::annulus(radius, radius / 2.0), pose, at: [0.0, 0.0] });
        scene
    }

    /// A board of `columns` x `rows` targets, `spacing` mm apart, on one plane before [`Camera::paper`]; the
    /// board's middle is the origin of `pose`.
    pub fn board(columns: u32, rows: u32, spacing: f64, artwork: &Artwork, pose: Pose) -> Self {
        let mut scene = Self::empty(Camera::paper());
        let offset = |i: u32, count: u32| (f64::from(i) - (f64::from(count) - 1.0) / 2.0) * spacing;
        for row in 0..rows {
            for column in 0..columns {
                let at = [offset(column, columns), offset(row, rows)];
                scene.targets.push(Target { artwork: artwork.clone(), pose, at });
            }
        }
        scene
    }

    /// Hides a `share` of every circle of target `target` under a wedge whose middle lies in `direction` (degrees, in the
    /// image from +x towards +y); `tone` is its reflectance.
    pub fn hide(&mut self, target: usize, share: f64, direction: f64, tone: f64) {
        self.occluders.push(Occluder { cover: Cover::Wedge { target, share, direction }, tone });
    }

    /// # Errors
    /// When a value is out of its range, or a target cannot be seen by the camera; says which and what is
    /// allowed.
    pub fn validate(&self) -> Result<()> {
        self.camera.validate()?;
        self.photometry.validate()?;
        for (i, target) in self.targets.iter().enumerate() {
            target.validate(&self.camera).with_context(|| format!("target {i}"))?;
        }
        for (i, decoy) in self.decoys.iter().enumerate() {
            let finite = [decoy.x, decoy.y, decoy.angle].iter().all(|v| v.is_finite());
            ensure!(finite && (0.1..=1e4).contains(&decoy.size), "decoy {i}: size must be 0.1 to 10000 px");
        }
        for (i, occluder) in self.occluders.iter().enumerate() {
            occluder.validate(&self.targets).with_context(|| format!("occluder {i}"))?;
        }
        if let Some(Texture { amplitude, scale, .. }) = self.texture {
            ensure!((0.0..=1.0).contains(&amplitude), "texture {amplitude}: must be 0 to 1");
            ensure!((1.0..=1e4).contains(&scale), "texture scale {scale} px: must be 1 to 10000");
        }
        Ok(())
    }

    /// Grey levels before noise, rounding and clipping.
    ///
    /// # Panics
    /// When [`Scene::validate`] fails.
    pub fn levels(&self) -> Levels {
        if let Err(error) = self.validate() {
            panic!("{error:#}");
        }
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let mut field =
            Field { width, sigma: self.photometry.blur, values: vec![self.paper.value(); width * height] };
        if let Some(texture) = self.texture {
            self.paint_texture(&mut field, texture, height);
        }
        let contrast = self.paper.inverse().value() - self.paper.value();
        for decoy in &self.decoys {
            field.paint_decoy(decoy, &self.camera, contrast);
        }
        for target in &self.targets {
            let view = target.view(&self.camera);
            for (outline, change) in target.inks(self.paper) {
                field.paint(Coverage::new(&outline, &view, field.sigma), |_, _| change);
            }
        }
        for occluder in &self.occluders {
            field.cover(occluder, self);
        }
        let mut values = field.values;
        self.photometry.expose(&mut values, width);
        Levels { width, height, values }
    }

    /// The picture and the truth about it; `seed` is that of the noise.
    ///
    /// # Panics
    /// When [`Scene::validate`] fails.
    pub fn render(&self, seed: u64) -> Frame {
        let Levels { width, height, values } = self.levels();
        Frame { width, height, pixels: self.photometry.digitise(&values, seed), truth: self.truth(seed) }
    }

    /// The truth about the picture.
    pub fn truth(&self, seed: u64) -> Truth {
        Truth {
            width: self.camera.width,
            height: self.camera.height,
            seed,
            camera: self.camera,
            photometry: self.photometry,
            targets: self.targets.iter().map(|target| TargetTruth::new(target, self)).collect(),
            decoys: self.decoys.clone(),
            texture: self.texture,
            occluders: self.occluders.clone(),
        }
    }

    /// Darkens light paper, lightens dark paper, except under decoys and on a square round each target.
    fn paint_texture(&self, field: &mut Field, texture: Texture, height: usize) {
        let mut bare = vec![1.0; field.values.len()];
        let mut cover = |coverage: Option<Coverage>, factor: f64| {
            if let Some(coverage) = coverage {
                coverage.for_each(|x, y, covered| bare[y * field.width + x] -= factor * covered);
            }
        };
        for target in &self.targets {
            cover(Coverage::new(&target.card(), &target.view(&self.camera), field.sigma), 1.0);
        }
        for decoy in &self.decoys {
            let view = decoy.view(&self.camera);
            decoy.outlines().iter().for_each(|(outline, factor)| {
                cover(Coverage::new(outline, &view, field.sigma), *factor);
            });
        }
        let clouds = Clouds::new(texture.seed, texture.scale, field.width, height);
        let sign = self.paper.inverse().value() - self.paper.value();
        for (i, (value, bare)) in field.values.iter_mut().zip(&bare).enumerate() {
            let depth = 0.5 + 0.5 * clouds.at(i % field.width, i / field.width);
            *value += sign * texture.amplitude * depth * bare.max(0.0);
        }
    }
}

/// Reflectance of the frame.
struct Field {
    width: usize,
    sigma: f64,
    values: Vec<f64>,
}

impl Field {
    /// Adds the change at each covered pixel (column and row within the coverage) times the coverage.
    fn paint(&mut self, coverage: Option<Coverage>, change: impl Fn(usize, usize) -> f64) {
        if let Some(coverage) = coverage {
            let (x0, y0) = (coverage.x0, coverage.y0);
            coverage.for_each(|x, y, covered| {
                self.values[y * self.width + x] += covered * change(x - x0, y - y0)
            });
        }
    }

    /// Lays the occluder over what is painted so far.
    fn cover(&mut self, occluder: &Occluder, scene: &Scene) {
        let Some(view) = occluder.view(&scene.targets, &scene.camera) else { return };
        if let Some(outline) = occluder.outline(&scene.targets, &scene.camera) {
            if let Some(coverage) = Coverage::new(&outline, &view, self.sigma) {
                coverage.for_each(|x, y, covered| {
                    let value = &mut self.values[y * self.width + x];
                    *value += covered * (occluder.tone - *value);
                });
            }
        } else {
            for (i, value) in self.values.iter_mut().enumerate() {
                let place = DVec2::new((i % self.width) as f64, (i / self.width) as f64);
                *value += occluder.light(view.plane(place));
            }
        }
    }

    fn paint_decoy(&mut self, decoy: &Decoy, camera: &Camera, contrast: f64) {
        let view = decoy.view(camera);
        for (outline, factor) in decoy.outlines() {
            let coverage = Coverage::new(&outline, &view, self.sigma);
            match (decoy.kind, &coverage) {
                (DecoyKind::Noise, Some(patch)) => {
                    let clouds = Clouds::new(decoy.seed, GRAIN, patch.width, patch.height);
                    self.paint(coverage, |x, y| contrast * (0.5 + 0.5 * clouds.at(x, y)));
                }
                _ => self.paint(coverage, |_, _| contrast * factor),
            }
        }
    }
}
