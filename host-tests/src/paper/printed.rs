//! What the paper prints.

/// Table 1: radius of the larger circle, mm, and error, px.
pub const TABLE_1: [(&str, &str); 12] = [
    ("5", "4.8e-7"),
    ("10", "5.4e-6"),
    ("15", "2.4e-5"),
    ("20", "7.2e-5"),
    ("25", "1.7e-4"),
    ("30", "3.4e-4"),
    ("35", "6.2e-4"),
    ("40", "1.0e-3"),
    ("45", "1.7e-3"),
    ("50", "2.5e-3"),
    ("55", "3.6e-3"),
    ("60", "5.1e-3"),
];

/// Table 2: angle, radians, and error, px. The fourth angle is 4 pi / 15.
pub const TABLE_2: [(&str, &str); 7] = [
    ("pi/15", "4.3e-6"),
    ("2pi/15", "2.9e-5"),
    ("3pi/15", "8.0e-5"),
    ("4pi/5", "1.2e-4"),
    ("5pi/15", "1.6e-4"),
    ("6pi/15", "1.3e-4"),
    ("7pi/15", "7.7e-5"),
];

/// Section 4.2: all deviations between the compared method and eq. (7) are below this, px.
pub const DEVIATION: f64 = 0.01;
/// Targets on the board, and views of it.
pub const TARGETS: usize = 58;
/// Views of the board.
pub const VIEWS: usize = 8;
