//! Targets to report, and the stream taken apart into owned messages.

use concentric::report::{
    Answer, DecodeError, Decoder, Detail, FrameHead, Hello, Message, Report, TargetEntry, max_len,
};
use concentric::{Circle, Covariance, Ellipse, Flags, Position, Summary, Target};

/// What came out between two separators.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    Hello(Hello),
    Frame(FrameHead, Vec<TargetEntry>),
    Answer(Answer),
    Damaged(DecodeError),
}

impl Outcome {
    pub fn of(result: Result<Message<'_>, DecodeError>) -> Self {
        match result {
            Ok(Message::Hello(hello)) => Self::Hello(hello),
            Ok(Message::Frame(frame)) => Self::Frame(frame.head, frame.targets().collect()),
            Ok(Message::Answer(answer)) => Self::Answer(answer),
            Err(error) => Self::Damaged(error),
        }
    }
}

/// Every outcome of `bytes` in a decoder for `N` bytes.
pub fn outcomes<const N: usize>(bytes: &[u8]) -> Vec<Outcome> {
    let mut decoder = Decoder::<N>::new();
    bytes.iter().filter_map(|&byte| decoder.push(byte).map(Outcome::of)).collect()
}

/// Room for the reports of these tests.
pub const LEN: usize = max_len(64, Detail::Full);

/// The report of a frame of [`summary`]'s size.
pub fn encode(seq: u32, detail: Detail, targets: &[Target]) -> Vec<u8> {
    let mut report = Report::<64>::new(detail);
    report.begin(seq);
    targets.iter().for_each(|target| report.push(target));
    report.finish(&summary(), &mut vec![0; LEN]).unwrap().to_vec()
}

pub const DETAILS: [Detail; 3] = [Detail::Terse, Detail::Normal, Detail::Full];

/// Nothing rejected, nothing dropped.
pub fn summary() -> Summary {
    Summary { width: 1280, height: 1024, ..Summary::default() }
}

pub fn at(x: f64, y: f64) -> Position {
    let scale = f64::from(Position::SCALE);
    Position { x: (x * scale).round() as i32, y: (y * scale).round() as i32 }
}

/// An annulus with radii ratio 0.5, the `i`-th of some that are all over a 1280 x 1024 frame.
pub fn annulus(i: u32) -> Target {
    let (x, y) = (70.3 + 127.7 * f64::from(i % 10), 80.6 + 170.9 * f64::from(i / 10));
    let a = 60.0 - 0.4 * i as f32;
    let circle = |scale: f32, shift: f64| Circle {
        ellipse: Ellipse { centre: at(x + shift, y), a: a * scale, b: a * scale * 0.8, theta: 0.7 },
        covariance: Covariance { xx: 2.5e-5, xy: 0.0, yy: 2.5e-5 },
        rms: 0.021,
        points: (190.0 * scale) as u16,
        gap: 0.0,
        ratio: scale,
        measured_ratio: scale * 1.001,
    };
    let mut target = Target {
        centre: at(x - 0.15, y),
        covariance: Covariance { xx: 3.1e-5, xy: -4.0e-6, yy: 2.7e-5 },
        eq7: at(x - 0.1499, y),
        exact: at(x - 0.15, y),
        contrast: 181.4,
        noise: 2.1,
        blur: 0.83,
        flags: Flags::MEASURED_RATIO,
        ..Target::default()
    };
    target.circles.push(circle(1.0, 0.0)).unwrap();
    target.circles.push(circle(0.5, -0.11)).unwrap();
    target
}
