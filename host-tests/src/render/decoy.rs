//! Decoys: figures that are no targets.

use super::camera::{Camera, View};
use super::glyphs;
use super::outline::Outline;
use glam::DVec2;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// Kinds of decoy. Each fits in the circle of the decoy's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DecoyKind {
    /// A filled disc, alone.
    Disc,
    /// A filled square.
    Square,
    /// Three concentric squares.
    Squares,
    /// A checkerboard of 4 x 4 fields.
    Checker,
    /// A triangle.
    Triangle,
    /// Four parallel bars.
    Bars,
    /// Three digits.
    Text,
    /// A disc with a round hole beside its centre.
    EccentricRing,
    /// A ring with a gap of 70 degrees, a letter C.
    OpenRing,
    /// A square of random grey.
    Noise,
}

impl DecoyKind {
    /// Every kind.
    pub const ALL: [DecoyKind; 10] = [
        DecoyKind::Disc,
        DecoyKind::Square,
        DecoyKind::Squares,
        DecoyKind::Checker,
        DecoyKind::Triangle,
        DecoyKind::Bars,
        DecoyKind::Text,
        DecoyKind::EccentricRing,
        DecoyKind::OpenRing,
        DecoyKind::Noise,
    ];
}

/// A figure that is no target, parallel to the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decoy {
    /// Kind.
    pub kind: DecoyKind,
    /// Column of its middle, px.
    pub x: f64,
    /// Row of its middle, px.
    pub y: f64,
    /// Radius of the circle in which it fits, px (before lens distortion).
    pub size: f64,
    /// Rotation from +x towards +y, degrees.
    pub angle: f64,
    /// Seed of the digits of a text and the pattern of a noise patch.
    pub seed: u64,
}

impl Decoy {
    /// Its plane, on which 1 mm is 1 px.
    pub fn view(&self, camera: &Camera) -> View {
        View::flat(camera, self.x, self.y)
    }

    /// Outlines on that plane. They do not overlap; each that lies in another takes its ink away again: the
    /// factor is 1 or -1.
    pub fn outlines(&self) -> Vec<(Outline, f64)> {
        let place = |(outline, factor): (Outline, f64)| {
            (outline.placed(DVec2::ZERO, self.angle.to_radians(), self.size), factor)
        };
        self.figure().into_iter().map(place).collect()
    }

    fn figure(&self) -> Vec<(Outline, f64)> {
        let solid = |outlines: Vec<Outline>| outlines.into_iter().map(|outline| (outline, 1.0)).collect();
        let square = |half: f64| Outline::rectangle(DVec2::ZERO, half, half);
        match self.kind {
            DecoyKind::Disc => solid(vec![Outline::circle(DVec2::ZERO, 1.0)]),
            DecoyKind::Square | DecoyKind::Noise => solid(vec![square(0.7)]),
            DecoyKind::Squares => vec![(square(0.7), 1.0), (square(0.47), -1.0), (square(0.24), 1.0)],
            DecoyKind::Checker => solid(checker()),
            DecoyKind::Triangle => {
                let corner = |i: u32| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 3.0);
                solid(vec![Outline::polygon(&[corner(0), corner(1), corner(2)])])
            }
            DecoyKind::Bars => {
                let bar = |i: u32| Outline::rectangle(DVec2::new(0.0, f64::from(i) * 0.4 - 0.6), 0.7, 0.1);
                solid((0..4).map(bar).collect())
            }
            DecoyKind::Text => solid(glyphs::digits(&self.text())),
            DecoyKind::EccentricRing => vec![
                (Outline::circle(DVec2::ZERO, 1.0), 1.0),
                (Outline::circle(DVec2::new(0.3, 0.0), 0.5), -1.0),
            ],
            DecoyKind::OpenRing => solid(vec![Outline::open_ring(1.0, 0.55, 70_f64.to_radians())]),
        }
    }

    fn text(&self) -> String {
        let mut random = Pcg64::seed_from_u64(self.seed);
        let number = Uniform::new_inclusive(100, 999).map_or(100, |uniform| uniform.sample(&mut random));
        number.to_string()
    }
}

/// The dark fields of a checkerboard.
fn checker() -> Vec<Outline> {
    let field = 0.7 / 4.0;
    let middle = |i: u32| (f64::from(i) * 2.0 - 3.0) * field;
    (0..16)
        .map(|i| (i % 4, i / 4))
        .filter(|(column, row)| (column + row) % 2 == 0)
        .map(|(column, row)| Outline::rectangle(DVec2::new(middle(column), middle(row)), field, field))
        .collect()
}
