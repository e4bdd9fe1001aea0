//! The conditions of the study: lines through its middle, one or two things varied at a time, and corners.

use super::cell::Cell;

/// Grey levels of noise at which what is systematic shows: it spreads the rounding evenly and moves little else.
const LITTLE_NOISE: f64 = 0.5;
/// Draws of each scene in which the rounding goes up and down by turns.
const MANY: u32 = 20;
/// Grey levels of noise that are as much as this: with the rounding itself a sixth of a level squared.
const DITHER: f64 = 0.29;
/// Longest focal length that the library takes, px.
const LONGEST: f64 = concentric::Camera::MAX_FOCAL as f64;
/// Scale of the pooled set, px per mm: focal length over distance.
const SCALE: f64 = 2580.0 / 800.0;

/// The slices in the order of the tables, with what is varied in each.
pub const SLICES: [(&str, &str); 15] = [
    ("size", "Outer semi-major axis R (px) and tilt w (degrees)"),
    ("blur", "Point spread function of the lens, standard deviation (px)"),
    ("noise", "Contrast and noise (grey levels)"),
    ("shading", "Change of the light across the target (relative)"),
    ("ratio", "Inner over outer radius"),
    ("place", "Place in the image (px from the principal point) and lens distortion"),
    ("corner", "Corners of the range"),
    ("gamma", "Response (exponent), uncorrected"),
    ("gain", "Overexposure: levels times this, clipped at 255"),
    ("bias", "What is systematic: no noise, levels twenty times finer than 8 bits"),
    ("phase", "Error against the place within the pixel, in little noise"),
    ("risk", "Eccentricity from nothing to ten standard deviations, by the focal length"),
    ("pooled", "The pooled set: outer radii 10 to 60 mm at 800 mm, contrast 190, blur 0.8 px"),
    ("hidden", "A wedge over a part of the perimeter, in any direction"),
    ("board", "58 targets on one plane"),
];
/// The slices over which the goals for a range of conditions are taken.
pub const RANGE: [&str; 7] = ["size", "blur", "noise", "shading", "ratio", "place", "corner"];

/// How much of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// A few cells of each slice.
    Quick,
    /// Everything.
    Full,
}

impl Extent {
    /// Frames of a cell where nothing else is said.
    pub fn frames(self) -> u32 {
        if self == Self::Full { 500 } else { 200 }
    }

    /// All values of a slice, or the few that stand for them.
    fn pick(self, all: &[f64], few: &[f64]) -> Vec<f64> {
        if self == Self::Full { all } else { few }.to_vec()
    }

    /// All cells.
    pub fn cells(self) -> Vec<Cell> {
        let mut cells = Vec::new();
        for (name, slice) in [
            ("size", self.size()),
            ("blur", self.blur()),
            ("noise", self.noise()),
            ("shading", self.shading()),
            ("ratio", self.ratio()),
            ("place", self.place()),
            ("corner", self.corner()),
            ("gamma", self.gamma()),
            ("gain", self.gain()),
            ("bias", self.bias()),
            ("phase", self.phase()),
            ("risk", self.risk()),
            ("pooled", self.pooled()),
            ("hidden", self.hidden()),
            ("board", self.board()),
        ] {
            cells.extend(slice.into_iter().map(|cell| Cell { slice: name, ..cell }));
        }
        cells
    }

    fn size(self) -> Vec<Cell> {
        let radii = self.pick(&[10.0, 15.0, 20.0, 30.0, 50.0, 100.0], &[10.0, 20.0, 50.0]);
        let tilts = self.pick(&[0.0, 15.0, 30.0, 45.0, 60.0], &[0.0, 45.0, 60.0]);
        pairs(&radii, &tilts, |radius, tilt| Cell { radius, tilt, ..Cell::default() })
    }

    fn blur(self) -> Vec<Cell> {
        let widths = self.pick(&[0.4, 0.5, 0.7, 1.0, 1.22, 1.5], &[0.4, 1.5]);
        pairs(&[15.0, 30.0], &widths, |radius, psf| Cell { radius, psf, ..Cell::default() })
    }

    fn noise(self) -> Vec<Cell> {
        let noises = self.pick(&[0.0, 1.0, 2.0, 3.0, 5.0, 10.0], &[0.0, 1.0, 5.0]);
        pairs(&self.pick(&[40.0, 80.0, 150.0], &[40.0, 150.0]), &noises, |contrast, noise| Cell {
            contrast,
            noise,
            ..Cell::default()
        })
    }

    fn shading(self) -> Vec<Cell> {
        pairs(
            &self.pick(&[15.0, 30.0, 60.0], &[30.0]),
            &self.pick(&[0.0, 0.1, 0.3], &[0.0, 0.3]),
            |radius, shading| Cell { radius, shading, ..Cell::default() },
        )
    }

    fn ratio(self) -> Vec<Cell> {
        let ratios = self.pick(&[0.3, 0.43, 0.5, 0.6, 0.8], &[0.3, 0.8]);
        ratios.into_iter().map(|ratio| Cell { ratio, ..Cell::default() }).collect()
    }

    fn place(self) -> Vec<Cell> {
        let distortions = self.pick(&[0.0, -0.3], &[-0.3]);
        let at = |place: [f64; 2]| {
            pairs(&self.pick(&[30.0, 60.0], &[30.0]), &distortions, move |radius, k1| Cell {
                place,
                k1,
                radius,
                ..Cell::default()
            })
        };
        [at([0.0, 0.0]), at([560.0, 430.0])].concat()
    }

    /// Small and large, steep and flat, sharp and blurred, dim and bright, evenly lit and not: all together.
    fn corner(self) -> Vec<Cell> {
        let mut cells = Vec::new();
        for (radius, tilt) in [(10.0, 0.0), (16.0, 60.0), (100.0, 60.0)] {
            for psf in [0.4, 1.5] {
                for (contrast, noise) in [(40.0, 3.0), (150.0, 1.0)] {
                    for shading in [0.0, 0.3] {
                        cells.push(Cell { radius, tilt, psf, contrast, noise, shading, ..Cell::default() });
                    }
                }
            }
        }
        let step = if self == Self::Full { 1 } else { 7 };
        cells.into_iter().step_by(step).collect()
    }

    fn gamma(self) -> Vec<Cell> {
        pairs(&[0.0, 0.3], &self.pick(&[0.6, 1.0, 1.8, 2.2], &[0.6, 2.2]), |shading, gamma| Cell {
            gamma,
            shading,
            ..Cell::default()
        })
    }

    fn gain(self) -> Vec<Cell> {
        pairs(&self.pick(&[0.0, 0.1, 0.3], &[0.0, 0.3]), &self.pick(&[1.5, 2.0], &[1.5]), |shading, gain| {
            Cell { gain, shading, ..Cell::default() }
        })
    }

    fn bias(self) -> Vec<Cell> {
        let radii = self.pick(&[15.0, 20.0, 30.0, 60.0], &[20.0]);
        let little = Cell { noise: DITHER, dithered: true, draws: MANY, ..Cell::default() };
        let mut cells = pairs(&radii, &self.pick(&[0.5, 0.7, 1.0], &[0.5, 1.0]), |radius, psf| Cell {
            radius,
            psf,
            ..little.clone()
        });
        cells.extend(pairs(&radii, &[0.3], |radius, shading| Cell { radius, shading, ..little.clone() }));
        cells.extend(pairs(&[30.0], &[0.6, 2.2], |radius, gamma| Cell { radius, gamma, ..little.clone() }));
        // Where a short lens distorts much.
        let aside = Cell { f: 1000.0, place: [-240.0, -190.0], ..little };
        cells.extend(pairs(&[30.0, 60.0], &[-0.3], |radius, k1| Cell { radius, k1, ..aside.clone() }));
        cells
    }

    fn phase(self) -> Vec<Cell> {
        let radii = self.pick(&[10.0, 15.0, 30.0], &[10.0]);
        pairs(&radii, &[0.0], |radius, tilt| Cell {
            radius,
            tilt,
            noise: LITTLE_NOISE,
            draws: 2,
            ..Cell::default()
        })
    }

    fn risk(self) -> Vec<Cell> {
        let (radius, tilt) = (20.0f64, 30.0f64);
        // Distance from the outer ellipse's centre to expect of an edge at the bound, px.
        let sigma = 4.1e-3;
        let multiples = self.pick(
            &[0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0],
            &[0.0, 1.0, 2.0, 3.0, 5.0, 10.0],
        );
        let cell = |multiple: f64| {
            let (sin, cos) = tilt.to_radians().sin_cos();
            // Eccentricity = R^2 sin cos / f; the longest focal length leaves next to none.
            let f = (radius * radius * sin * cos / (multiple * sigma)).min(LONGEST).round();
            // The worst of several ratios near one tells little where each is uncertain by a tenth.
            Cell { radius, tilt, f, frames: (10, 1), ..Cell::default() }
        };
        multiples.into_iter().map(cell).collect()
    }

    /// The same conditions in both extents, because a mean over fewer would be that of another set.
    fn pooled(self) -> Vec<Cell> {
        let frames = (1, if self == Self::Full { 10 } else { 40 });
        let cell = |radius: f64, tilt: f64, noise: f64| Cell {
            radius: radius * SCALE,
            tilt,
            noise,
            psf: 0.8,
            black: 30.0,
            contrast: 190.0,
            draws: 1,
            frames,
            ..Cell::default()
        };
        let set = |noise: f64| {
            pairs(
                &[10.0, 20.0, 30.0, 40.0, 50.0, 60.0],
                &[12.0, 24.0, 36.0, 48.0, 60.0, 72.0],
                |radius, tilt| cell(radius, tilt, noise),
            )
        };
        [0.0, 1.0, 2.0, 5.0].into_iter().flat_map(set).collect()
    }

    fn hidden(self) -> Vec<Cell> {
        let radii = self.pick(&[15.0, 20.0, 30.0, 60.0], &[30.0]);
        let cell = |radius: f64| Cell { radius, hidden: 0.4, draws: 1, ..Cell::default() };
        radii.into_iter().map(cell).collect()
    }

    fn board(self) -> Vec<Cell> {
        let tilts = self.pick(&[20.0, 40.0, 55.0], &[40.0]);
        let cell = |tilt: f64| Cell {
            radius: 26.0,
            tilt,
            targets: 58,
            draws: 1,
            frames: (1, 15),
            ..Cell::default()
        };
        tilts.into_iter().map(cell).collect()
    }
}

/// A cell for every pair of an element of `first` and one of `second`.
fn pairs(first: &[f64], second: &[f64], cell: impl Fn(f64, f64) -> Cell) -> Vec<Cell> {
    first.iter().flat_map(|&a| second.iter().map(move |&b| (a, b))).map(|(a, b)| cell(a, b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slice_has_a_title_and_cells() {
        for extent in [Extent::Quick, Extent::Full] {
            let cells = extent.cells();
            for (slice, _) in SLICES {
                assert!(cells.iter().any(|cell| cell.slice == slice), "{slice}");
            }
            assert!(cells.iter().all(|cell| SLICES.iter().any(|(slice, _)| *slice == cell.slice)));
            assert!(RANGE.iter().all(|name| SLICES.iter().any(|(slice, _)| slice == name)));
        }
    }

    #[test]
    fn quick_cells_are_cells_of_the_whole() {
        let whole = Extent::Full.cells();
        for cell in Extent::Quick.cells() {
            let same = |other: &&Cell| Cell { frames: cell.frames, ..(*other).clone() } == cell;
            assert!(whole.iter().find(same).is_some(), "{}", cell.name());
        }
    }

    #[test]
    fn every_cell_can_be_rendered_and_is_different_within_its_slice() {
        let cells = Extent::Full.cells();
        let mut names: Vec<_> = cells.iter().map(Cell::name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), cells.len());
        cells.iter().for_each(|cell| cell.scene(0).validate().expect("a scene"));
    }
}
