//! A condition of the study, and the scenes that show it.

use crate::render::{Artwork, Camera, Photometry, Pose, Scene, Shading, Target};

/// Distance of every target, mm.
const DISTANCE: f64 = 800.0;
/// Targets in a row of a board.
const COLUMNS: u32 = 10;
/// From target to target on a board, in outer radii.
const SPACING: f64 = 3.2;
/// Free paper around a target, px.
const MARGIN: f64 = 48.0;
/// How often each scene is seen in other noise: the mean of these shows what is systematic.
const DRAWS: u32 = 5;

/// A condition: one annulus, its picture. [`Cell::default`] is the middle of the study; every cell differs from it in a few
/// fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// What is varied with this cell.
    pub slice: &'static str,
    /// Semi-major axis of the outer ellipse on the optical axis, px.
    pub radius: f64,
    /// Angle between the target's normal and the optical axis, degrees.
    pub tilt: f64,
    /// Inner radius over outer radius.
    pub ratio: f64,
    /// Standard deviation of the lens's point spread function, px.
    pub psf: f64,
    /// Grey level of the ink.
    pub black: f64,
    /// White minus black, grey levels.
    pub contrast: f64,
    /// Standard deviation of the noise, grey levels.
    pub noise: f64,
    /// Relative change of the light across the target.
    pub shading: f64,
    /// Exponent of the response.
    pub gamma: f64,
    /// Factor on the level.
    pub gain: f64,
    /// Focal length, px.
    pub f: f64,
    /// Where the target appears, px from the principal point.
    pub place: [f64; 2],
    /// Radial lens distortion.
    pub k1: f64,
    /// Share of the perimeter that is hidden, at any place.
    pub hidden: f64,
    /// Targets on the plane: one, or a board of them.
    pub targets: u32,
    /// How often each scene is seen in other noise.
    pub draws: u32,
    /// Instead of noise, the rounding goes up and down by turns over the draws: their mean is that of a picture with so many times
    /// finer levels.
    pub dithered: bool,
    /// How many frames it gets, for how many of other cells.
    pub frames: (u32, u32),
}

impl Default for Cell {
    fn default() -> Self {
        Self {
            slice: "base",
            radius: 30.0,
            tilt: 45.0,
            ratio: 0.5,
            psf: 0.7,
            black: 40.0,
            contrast: 150.0,
            noise: 2.0,
            shading: 0.0,
            gamma: 1.0,
            gain: 1.0,
            f: 2580.0,
            place: [0.0, 0.0],
            k1: 0.0,
            hidden: 0.0,
            targets: 1,
            draws: DRAWS,
            dithered: false,
            frames: (1, 1),
        }
    }
}

impl Cell {
    /// Size and tilt, and whatever else is not as in the middle of the study.
    pub fn label(&self) -> String {
        let base = Self::default();
        let mut label = format!("R{} w{}", (self.radius * 100.0).round() / 100.0, self.tilt);
        let mut add = |name: &str, value: f64, usual: f64| {
            if value != usual {
                label += &format!(" {name} {value}");
            }
        };
        add("psf", self.psf, base.psf);
        add("black", self.black, base.black);
        add("contrast", self.contrast, base.contrast);
        add("noise", self.noise, base.noise);
        add("shading", self.shading, base.shading);
        add("gamma", self.gamma, base.gamma);
        add("gain", self.gain, base.gain);
        add("ratio", self.ratio, base.ratio);
        add("f", self.f, base.f);
        add("x", self.place[0], base.place[0]);
        add("y", self.place[1], base.place[1]);
        add("k1", self.k1, base.k1);
        add("hidden", self.hidden, base.hidden);
        add("targets", f64::from(self.targets), f64::from(base.targets));
        label
    }

    /// With its slice: what `--cell` looks in.
    pub fn name(&self) -> String {
        format!("{}: {}", self.slice, self.label())
    }

    /// Smaller of the inner semi-minor axis and the narrowest gap between the ellipses, px.
    pub fn narrowest(&self) -> f64 {
        self.radius * self.tilt.to_radians().cos() * self.ratio.min(1.0 - self.ratio)
    }

    /// Whether it lies in the range for which the goals are set.
    pub fn in_range(&self) -> bool {
        self.radius >= 10.0
            && self.tilt <= 60.0
            && self.narrowest() >= 4.0
            && (0.4..=1.5).contains(&self.psf)
            && self.contrast >= 40.0
            && self.noise >= 1.0
            && self.contrast >= 13.0 * self.noise
            && self.shading <= 0.3
            && self.gamma == 1.0
            && self.gain == 1.0
            && self.k1 == 0.0
            && self.hidden == 0.0
            && self.targets == 1
    }

    /// Scenes that show it in at least `frames` frames, or its own number for these.
    pub fn scenes(&self, frames: u32) -> u32 {
        let (own, other) = self.frames;
        (frames * own).div_ceil(self.draws * other)
    }

    /// A number of its own for this cell.
    fn seed(&self) -> u64 {
        // FNV-1a (Fowler, Noll, Vo): the same on every machine and in every release of the compiler.
        self.label()
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    /// Seed of the noise of a draw of a scene.
    pub fn noise_seed(&self, scene: u32, draw: u32) -> u64 {
        self.seed() ^ (u64::from(scene) << 32 | u64::from(draw))
    }

    /// One of the scenes: direction of the tilt, place within the pixel and direction of the light go over their ranges
    /// without a pattern (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"). The frame is cut
    /// out round the target, or the board.
    pub fn scene(&self, index: u32) -> Scene {
        let start = (self.seed() >> 40) as f64 / f64::from(1 << 24);
        let turn = |power: i32| (start + f64::from(index) * 1.167_303_978_261_418_7f64.powi(-power)).fract();
        let rows = self.targets.div_ceil(COLUMNS);
        let offset =
            |i: u32, count: u32| (f64::from(i) - (f64::from(count.min(self.targets)) - 1.0) / 2.0) * SPACING;
        let farthest = offset(0, COLUMNS).hypot(offset(0, rows));
        let half = ((1.2 + farthest) * self.radius + MARGIN).ceil();
        let mut camera = Camera::new(2 * half as u32, 2 * half as u32, self.f);
        let [x, y] = [half + turn(1) - 0.5, half + turn(2) - 0.5];
        (camera.cx, camera.cy) = (half - self.place[0], half - self.place[1]);
        camera.distortion.k1 = self.k1;
        let pose = Pose { x, y, distance: DISTANCE, tilt: self.tilt, azimuth: 360.0 * turn(3) };
        let radius = self.radius * DISTANCE / self.f;
        let mut scene = Scene::empty(camera);
        let artwork = Artwork::annulus(radius, radius * self.ratio);
        let at = |i: u32| [offset(i % COLUMNS, COLUMNS) * radius, offset(i / COLUMNS, rows) * radius];
        scene.targets =
            (0..self.targets).map(|i| Target { artwork: artwork.clone(), pose, at: at(i) }).collect();
        scene.photometry = Photometry {
            blur: self.psf,
            black: self.black,
            white: self.black + self.contrast,
            shading: (self.shading > 0.0).then(|| Shading {
                fraction: self.shading,
                span: 2.0 * self.radius,
                direction: 360.0 * turn(4),
                x,
                y,
            }),
            gamma: self.gamma,
            gain: self.gain,
            noise: self.noise,
        };
        if self.hidden > 0.0 {
            // From the tone of the ink to that of the paper.
            scene.hide(0, self.hidden, 360.0 * turn(5), turn(6));
        }
        scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_name_what_differs() {
        assert_eq!(Cell::default().name(), "base: R30 w45");
        let cell =
            Cell { slice: "light", radius: 12.5, shading: 0.3, place: [500.0, 0.0], ..Cell::default() };
        assert_eq!(cell.name(), "light: R12.5 w45 shading 0.3 x 500");
    }

    /// The goals are for targets that can be measured well at all: each limit leaves out what is just beyond it.
    #[test]
    fn the_range_ends_where_it_should() {
        let base = Cell::default();
        let edge = [
            Cell { radius: 16.0, tilt: 60.0, ..base.clone() },
            Cell { ratio: 0.8, ..base.clone() },
            Cell { psf: 0.4, ..base.clone() },
            Cell { psf: 1.5, ..base.clone() },
            Cell { contrast: 40.0, noise: 3.0, ..base.clone() },
            Cell { shading: 0.3, ..base.clone() },
        ];
        assert!(edge.iter().all(Cell::in_range));
        let beyond = [
            Cell { radius: 9.0, tilt: 0.0, ..base.clone() },
            // Inner semi-minor axis, and gap, below 4 px.
            Cell { radius: 15.0, tilt: 60.0, ..base.clone() },
            Cell { ratio: 0.85, ..base.clone() },
            Cell { tilt: 61.0, ..base.clone() },
            Cell { psf: 0.39, ..base.clone() },
            Cell { psf: 1.6, ..base.clone() },
            Cell { contrast: 39.0, ..base.clone() },
            Cell { contrast: 40.0, noise: 3.1, ..base.clone() },
            Cell { noise: 12.0, ..base.clone() },
            Cell { shading: 0.31, ..base.clone() },
            Cell { gain: 1.5, ..base.clone() },
            Cell { gamma: 1.8, ..base.clone() },
            Cell { k1: -0.3, ..base.clone() },
            Cell { hidden: 0.1, ..base.clone() },
        ];
        assert!(beyond.iter().all(|cell| !cell.in_range()));
    }

    #[test]
    fn boards_lie_inside_their_frames() {
        let cell = Cell { radius: 26.0, targets: 58, ..Cell::default() };
        for index in 0..8 {
            let targets = cell.scene(index).truth(0).targets;
            assert_eq!(targets.len(), 58);
            assert!(targets.iter().all(|target| target.complete));
        }
    }

    #[test]
    fn the_target_lies_where_it_was_asked_for() {
        for place in [[0.0, 0.0], [500.0, -300.0]] {
            let cell = Cell { place, radius: 20.0, k1: -0.2, ..Cell::default() };
            let scene = cell.scene(7);
            let truth = scene.truth(0).targets.remove(0);
            assert!(truth.complete);
            let camera = scene.camera;
            assert!(
                (truth.x - camera.cx - place[0]).abs() <= 0.5
                    && (truth.y - camera.cy - place[1]).abs() <= 0.5
            );
            assert!((truth.x - f64::from(camera.width) / 2.0).abs() <= 0.5);
        }
    }

    #[test]
    fn phases_and_directions_cover_their_ranges() {
        let scenes: Vec<_> = (0..64).map(|i| Cell::default().scene(i)).collect();
        let phases: Vec<_> = scenes.iter().map(|s| s.targets[0].pose.x.fract()).collect();
        let turns: Vec<_> = scenes.iter().map(|s| s.targets[0].pose.azimuth / 360.0).collect();
        for values in [phases, turns] {
            for eighth in 0..8 {
                let low = f64::from(eighth) / 8.0;
                let count = values.iter().filter(|v| (low..low + 0.125).contains(*v)).count();
                assert!((4..=12).contains(&count), "{count} in eighth {eighth}");
            }
        }
    }
}
