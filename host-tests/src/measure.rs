//! The library's numbers in `f64`.

use concentric::{Covariance, Position};
use serde::Serialize;

/// A place in the image, px, as the JSON lines have it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Place {
    /// Column.
    pub x: f64,
    /// Row.
    pub y: f64,
}

impl From<Position> for Place {
    fn from(position: Position) -> Self {
        let [x, y] = px(position);
        Self { x, y }
    }
}

/// `position` in px, exactly.
pub fn px(position: Position) -> [f64; 2] {
    [position.x, position.y].map(|axis| f64::from(axis) / f64::from(Position::SCALE))
}

/// Distance between two places.
pub fn distance([x, y]: [f64; 2], [u, v]: [f64; 2]) -> f64 {
    (x - u).hypot(y - v)
}

/// Semi-axes of the one-sigma ellipse, px, the larger one first, and the direction of that, radians from +x towards +y.
pub fn axes(covariance: &Covariance) -> [f64; 3] {
    let [xx, xy, yy] = [covariance.xx, covariance.xy, covariance.yy].map(f64::from);
    let (middle, half) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    let root = |variance: f64| variance.max(0.0).sqrt();
    [root(middle + half), root(middle - half), xy.atan2((xx - yy) / 2.0) / 2.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_ellipse_of_a_turned_covariance() {
        let (sin, cos) = 0.5f32.sin_cos();
        let (a2, b2) = (9.0, 1.0);
        let covariance = Covariance {
            xx: a2 * cos * cos + b2 * sin * sin,
            xy: (a2 - b2) * sin * cos,
            yy: a2 * sin * sin + b2 * cos * cos,
        };
        for (found, truth) in axes(&covariance).into_iter().zip([3.0, 1.0, 0.5]) {
            assert!((found - truth).abs() < 1e-5, "{found} {truth}");
        }
    }
}
