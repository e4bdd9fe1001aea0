//! Section 4.1: tables 1 and 2, figures 4 and 5; from the equations, and from rendered pictures.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use concentric::{
    Settings, TargetSpec,
    model::{Scene as Model, from_two},
};

use super::printed::{TABLE_1, TABLE_2};
use crate::{
    detect,
    measure::{distance, px},
    picture::Picture,
    render::{Camera, Scene},
};

/// Of the paper, mm.
pub const DISTANCE: f64 = 800.0;
/// Inner over outer radius.
pub const RATIO: f64 = 0.5;
/// Of the pictures: standard deviation of a pixel, grey levels.
pub const NOISES: [f64; 2] = [0.0, 2.0];
/// Pictures of each row and noise.
pub const PICTURES: u32 = 4;
/// A found centre farther from the true one, px, is none of it.
const NEAR: f64 = 20.0;

/// Radii of table 1 are said to be 0 to 60 mm in steps of 5. A circle of radius 0 has no ellipse; what was calculated is as
/// many equal steps from this, mm.
const LEAST_RADIUS: f64 = 1.0;
const LARGEST_RADIUS: f64 = 60.0;
/// Outer radius of table 2, mm.
const RADIUS: f64 = 24.0;

/// A row of a table.
#[derive(Clone, Debug)]
pub struct Row {
    /// The parameter as it is printed.
    pub label: &'static str,
    /// The error as it is printed, px.
    pub printed: &'static str,
    /// Outer radius, mm.
    pub radius: f64,
    /// omega = alpha, radians.
    pub tilt: f64,
    /// What eq. (7) leaves of centres by eq. (2), px.
    pub eq7: f64,
    /// The same where the label is taken at its word.
    pub at_label: f64,
    /// Eccentricity of the outer ellipse by eq. (3), px.
    pub outer: f64,
}

impl Row {
    fn new((label, printed): (&'static str, &'static str), radius: f64, tilt: f64) -> Result<Self> {
        let (eq7, outer) = predicted(radius, tilt)?;
        Ok(Self { label, printed, radius, tilt, eq7, at_label: eq7, outer })
    }

    /// The error rounded as the printed one.
    pub fn rounded(&self) -> String {
        format!("{:.1e}", self.eq7)
    }
}

/// The printed value as a number.
pub fn number(printed: &str) -> f64 {
    printed.parse().unwrap_or(f64::NAN)
}

/// |eq. (7) - eq. (1)| and |eq. (3)|, px, in the paper's camera with alpha = omega.
fn predicted(radius: f64, tilt: f64) -> Result<(f64, f64)> {
    let scene =
        Model::new(Camera::paper().f, 0.0, DISTANCE, tilt, tilt).context("a plane before the camera")?;
    let seen = |radius: f64| scene.ellipse_centre(radius).context("a circle before the camera");
    let centre = from_two(seen(radius)?, seen(RATIO * radius)?, RATIO).context("two circles")?;
    let (u, v) = scene.eccentricity(radius).context("a circle before the camera")?;
    let truth = scene.centre();
    Ok((distance([centre.0, centre.1], [truth.0, truth.1]), u.hypot(v)))
}

/// Table 1: over the radius at 45 degrees.
///
/// # Errors
/// None that a caller can cause.
pub fn table_1() -> Result<Vec<Row>> {
    let steps = TABLE_1.len() as f64;
    let step = (LARGEST_RADIUS - LEAST_RADIUS) / steps;
    let rows = (1..).zip(TABLE_1).map(|(i, printed)| {
        let mut row = Row::new(printed, LEAST_RADIUS + step * f64::from(i), PI / 4.0)?;
        row.at_label = predicted(number(row.label), PI / 4.0)?.0;
        Ok(row)
    });
    rows.collect()
}

/// Table 2: over the tilt, radii 24 and 12 mm.
///
/// # Errors
/// None that a caller can cause.
pub fn table_2() -> Result<Vec<Row>> {
    let rows = (1..).zip(TABLE_2).map(|(i, printed)| Row::new(printed, RADIUS, f64::from(i) * PI / 15.0));
    rows.collect()
}

/// What eq. (7) leaves for row `i` of table 2 if its angles were other than its labels: 0.7 + 11.48 i degrees, and the errors
/// 0.92 of what they are, for example by a radius 2 % smaller. Of all equal steps with a factor these come nearest to the
/// printed errors.
///
/// # Errors
/// None that a caller can cause.
pub fn other_grid(i: usize) -> Result<f64> {
    Ok(0.92 * predicted(RADIUS, (0.7 + 11.48 * i as f64).to_radians())?.0)
}

/// What the detector makes of pictures of a row.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Pictures in which the target was found.
    pub found: u32,
    /// RMS distance of the outer ellipse's centre from the true one, px.
    pub outer: f64,
    /// The same of the centre by eq. (7).
    pub eq7: f64,
}

/// Pictures of a row, for each of the [`NOISES`].
///
/// # Errors
/// A picture that the library refuses.
pub fn pictures(row: &Row) -> Result<[Seen; 2]> {
    let settings = Settings::new(TargetSpec::ring(RATIO as f32)?);
    let mut seen = [Seen::default(); 2];
    for picture in 0..PICTURES {
        // Azimuth and place within the pixel walk over their ranges without a pattern.
        let turn = |step: f64| (f64::from(picture) * step + row.radius * 0.37 + row.tilt * 6.3).fract();
        let phase = [turn(0.618_034) - 0.5, turn(0.754_878) - 0.5];
        let mut scene = Scene::single(row.radius, row.tilt.to_degrees(), 360.0 * turn(0.381_966), phase);
        let levels = scene.levels();
        let truth = scene.truth(0).targets.first().map(|target| [target.x, target.y]).context("a target")?;
        for (seen, noise) in seen.iter_mut().zip(NOISES) {
            scene.photometry.noise = noise;
            let pixels = scene.photometry.digitise(&levels.values, u64::from(picture));
            let picture = Picture::new("rendered", levels.width, levels.height, pixels)?;
            seen.add(&detect::run(&picture, settings)?, truth);
        }
    }
    Ok(seen.map(Seen::rooted))
}

impl Seen {
    /// Sums of squares until [`Self::rooted`].
    fn add(&mut self, outcome: &detect::Outcome, truth: [f64; 2]) {
        let off = |place| distance(px(place), truth);
        let near = outcome.targets.iter().find(|target| off(target.eq7) < NEAR);
        if let Some((target, outer)) = near.and_then(|target| Some((target, target.circles.first()?))) {
            self.found += 1;
            self.outer += off(outer.ellipse.centre).powi(2);
            self.eq7 += off(target.eq7).powi(2);
        }
    }

    fn rooted(self) -> Self {
        let root = |squares: f64| (squares / f64::from(self.found)).sqrt();
        Self { outer: root(self.outer), eq7: root(self.eq7), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All twelve, to their last digit; taken at their word the labels give other digits in most rows.
    #[test]
    fn table_1_is_the_printed_one() {
        let rows = table_1().unwrap();
        assert_eq!(rows.len(), 12);
        for row in &rows {
            assert_eq!(row.rounded(), row.printed, "{row:?}");
        }
        let at_label = rows.iter().filter(|row| format!("{:.1e}", row.at_label) == row.printed).count();
        assert!(at_label <= 4, "{at_label}");
        // Teeth: a per cent of the focal length.
        let other = rows.iter().filter(|row| format!("{:.1e}", 1.01 * row.eq7) == row.printed).count();
        assert!(other < 12, "{other}");
    }

    /// The law f rho^2 (R / f)^4 sin^3 cos, and the grid that comes near the printed digits.
    #[test]
    fn table_2_has_the_shape_of_the_printed_one() {
        for (i, row) in table_2().unwrap().iter().enumerate() {
            let f = Camera::paper().f;
            let (sin, cos) = row.tilt.sin_cos();
            let law = f * RATIO * RATIO * (RADIUS / DISTANCE).powi(4) * sin.powi(3) * cos;
            assert!((row.eq7 / law - 1.0).abs() < 2e-3, "{row:?} {law}");
            let near = other_grid(i + 1).unwrap() / number(row.printed);
            assert!((near - 1.0).abs() < 0.07, "{row:?} {near}");
            assert!((row.eq7 / number(row.printed) - 1.0).abs() < 0.35, "{row:?}");
        }
    }
}
