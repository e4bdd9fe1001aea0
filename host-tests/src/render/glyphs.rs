//! Small shapes for marks and clutter, within the unit circle about the origin.

use super::outline::Outline;
use glam::DVec2;

/// A cross of two thin strokes.
pub fn plus() -> Outline {
    let (long, half) = (1.0, 0.13);
    let quarter = [DVec2::new(half, half), DVec2::new(half, long), DVec2::new(-half, long)];
    let corners: Vec<DVec2> = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y]
        .iter()
        .flat_map(|turn| quarter.map(|p| turn.rotate(p)))
        .collect();
    Outline::polygon(&corners)
}

/// Segments of the seven-segment digits 0 to 9: top, upper right, lower right, bottom, lower left, upper
/// left, middle from the lowest bit.
const SEGMENTS: [u8; 10] = [0x3f, 0x06, 0x5b, 0x4f, 0x66, 0x6d, 0x7d, 0x07, 0x7f, 0x6f];
/// Half the width of a digit's skeleton; its half height is twice that.
const HALF: f64 = 0.5;
/// Half the width of a stroke.
const STROKE: f64 = 0.13;
/// Distance of two digits' middles.
const ADVANCE: f64 = 1.55;

/// A line of text in seven-segment digits; other characters leave a gap. The strokes' mitred ends touch
/// without overlap, so that their coverages add up.
pub fn digits(text: &str) -> Vec<Outline> {
    let count = text.len() as f64;
    let half_width = (count - 1.0) * ADVANCE / 2.0 + HALF + STROKE;
    let scale = 1.0 / half_width.hypot(2.0 * HALF + STROKE);
    let mut strokes = Vec::new();
    for (i, digit) in text.bytes().enumerate() {
        let middle = DVec2::new((i as f64 - (count - 1.0) / 2.0) * ADVANCE, 0.0);
        let set = SEGMENTS.get(usize::from(digit.wrapping_sub(b'0'))).copied().unwrap_or(0);
        let ends = |bit: u8| -> [(f64, f64); 2] {
            match bit {
                0 => [(-1.0, -2.0), (1.0, -2.0)],
                1 => [(1.0, -2.0), (1.0, 0.0)],
                2 => [(1.0, 0.0), (1.0, 2.0)],
                3 => [(-1.0, 2.0), (1.0, 2.0)],
                4 => [(-1.0, 0.0), (-1.0, 2.0)],
                5 => [(-1.0, -2.0), (-1.0, 0.0)],
                _ => [(-1.0, 0.0), (1.0, 0.0)],
            }
        };
        for bit in (0..7).filter(|bit| set & (1 << bit) != 0) {
            let [from, to] = ends(bit).map(|(x, y)| (middle + DVec2::new(x, y) * HALF) * scale);
            strokes.push(stroke(from, to, STROKE * scale));
        }
    }
    strokes
}

/// A bar with pointed ends.
fn stroke(from: DVec2, to: DVec2, half: f64) -> Outline {
    let along = (to - from).normalize() * half;
    let across = along.perp();
    Outline::polygon(&[
        from,
        from + along + across,
        to - along + across,
        to,
        to - along - across,
        from + along - across,
    ])
}
