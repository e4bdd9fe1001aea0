//! Lengths, and every capacity at nothing, exactly full and one over.

use concentric::report::{
    ANSWER_MAX_LEN, Answer, COMMAND_MAX_LEN, Command, Format, HeadSettings, Outcome as Answered, Ratios,
    Request,
};
use concentric::report::{CircleEntry, Details, FullEntry, Shape};
use concentric::report::{
    Decoder, Detail, EncodeError, FrameHead, HELLO_MAX_LEN, Hello, Report, TargetEntry, Version, max_len,
};
use concentric::{
    Circle, Compensation, Covariance, Dropped, Effort, Ellipse, Flags, MAX_CIRCLES, Polarity, Position,
    Reject, Summary, Target,
};

use crate::support::{DETAILS, LEN, Outcome, annulus, encode, outcomes, summary};

/// Every number of a report at the value that takes most bytes, as far as a `Target` can say it.
fn largest() -> Target {
    let place = Position { x: i32::MIN, y: i32::MIN };
    let circle = Circle {
        ellipse: Ellipse { centre: place, a: f32::MAX, b: f32::MAX, theta: 3.1 },
        covariance: Covariance::default(),
        rms: 1.0,
        points: u16::MAX,
        gap: 5000.0,
        ratio: 1.0,
        measured_ratio: 1.0,
    };
    let mut target = Target {
        centre: place,
        covariance: Covariance { xx: 1.0, xy: 1.0, yy: 1.0 },
        eq7: place,
        exact: place,
        contrast: 5000.0,
        noise: 300.0,
        blur: 300.0,
        flags: Flags(u16::MAX),
        ..Target::default()
    };
    while target.circles.push(circle).is_ok() {}
    target
}

fn largest_summary() -> Summary {
    Summary {
        width: u16::MAX,
        height: u16::MAX,
        targets: u32::MAX,
        rejected: Reject::ALL.iter().map(|&(cause, _)| (cause, u32::MAX)).collect(),
        dropped: Dropped { runs: u32::MAX, outlines: u32::MAX, crossings: u32::MAX },
        unsearched: u32::MAX,
        limited: true,
        ..Summary::default()
    }
}

fn packed<T: serde::Serialize>(value: &T) -> usize {
    postcard::to_slice(value, &mut [0; 1024]).unwrap().len()
}

/// Length on the wire, by other code than the encoder's.
fn framed(plain: usize) -> usize {
    cobs::max_encoding_length(plain) + 1
}

#[test]
fn max_len_is_the_length_of_the_largest_fields() {
    let place = Position { x: i32::MIN, y: i32::MIN };
    let shape = Shape { a: u32::MAX, b: u32::MAX, theta: i16::MIN, rms: u16::MAX };
    let circle = CircleEntry {
        centre: place,
        shape,
        points: u16::MAX,
        gap: u16::MAX,
        ratio: u16::MAX,
        measured_ratio: u16::MAX,
    };
    let mut full = FullEntry {
        eq7: place,
        exact: place,
        contrast: u16::MAX,
        noise: u16::MAX,
        blur: u16::MAX,
        ..Default::default()
    };
    while full.circles.push(circle).is_ok() {}
    assert_eq!(full.circles.len(), MAX_CIRCLES);
    let entry = |details| TargetEntry {
        id: u16::MAX,
        track: u16::MAX,
        age: u16::MAX,
        centre: place,
        sigma_x: u16::MAX,
        sigma_y: u16::MAX,
        correlation: i8::MIN,
        flags: Flags(u16::MAX),
        details,
    };
    let head = FrameHead {
        seq: u32::MAX,
        width: u16::MAX,
        height: u16::MAX,
        limited: true,
        rejected: largest_summary().rejected,
        dropped: largest_summary().dropped,
        unsearched: u32::MAX,
        dropped_targets: u32::MAX,
        dropped_reports: u32::MAX,
        detail: Detail::Full,
    };
    for (detail, details) in [
        (Detail::Terse, Details::Terse),
        (Detail::Normal, Details::Normal(shape)),
        (Detail::Full, Details::Full(full)),
    ] {
        let target = packed(&entry(details));
        for targets in [0, 1, 60, 127, 128, 5000] {
            let plain = 6 + packed(&head) + packed(&targets) + targets * target;
            assert_eq!(max_len(targets, detail), framed(plain), "{targets} {detail:?}");
        }
    }
    let firmware = Version { major: u16::MAX, minor: u16::MAX, patch: u16::MAX };
    let hello =
        Hello { library: firmware, position_scale: u32::MAX, ..Hello::new(firmware, u16::MAX, Detail::Full) };
    assert_eq!(HELLO_MAX_LEN, 1 + framed(6 + packed(&hello)));
    assert_eq!(hello.encode(&mut [0; HELLO_MAX_LEN]).unwrap().len(), HELLO_MAX_LEN);
}

#[test]
fn the_largest_report_fits_in_max_len_and_nearly_fills_it() {
    const TARGETS: usize = 60;
    for detail in DETAILS {
        let mut report = Report::<TARGETS>::new(detail);
        report.begin(u32::MAX);
        // Some more, so that the count of those left out is a long number.
        (0..TARGETS + 300).for_each(|_| report.push(&largest()));
        let mut buffer = vec![0; max_len(TARGETS, detail)];
        let bytes = report.finish(&largest_summary(), &mut buffer).unwrap();
        assert!(detail != Detail::Full || bytes.windows(255).any(|run| run[0] == 0xFF && !run.contains(&0)));
        assert_eq!(frame(bytes).1, report.targets());
        let sent = bytes.len();
        // A target without number and track has six bytes less, the count of those left out three, that of reports given
        // up four, and zeros cost no code byte.
        let spare = 6 * TARGETS + 3 + 4 + max_len(TARGETS, detail) / 200;
        assert!(sent + spare >= max_len(TARGETS, detail), "{sent} of {}", max_len(TARGETS, detail));
    }
}

/// The table "Length" of the specification.
#[test]
fn usual_lengths() {
    let specification = include_str!("../../../src/report/SPECIFICATION.md");
    let rows = [0, 1, 60].map(|count| {
        let targets: Vec<Target> = (0..count).map(annulus).collect();
        let [terse, normal, full] = DETAILS.map(|detail| encode(100_000, detail, &targets).len());
        format!("| {count} | {terse} | {normal} | {full} |\n")
    });
    assert!(specification.contains(&rows.concat()), "\n{}", rows.concat());
}

#[test]
fn size_of_a_target_in_memory_is_as_documented() {
    assert!((250..=300).contains(&size_of::<TargetEntry>()), "{}", size_of::<TargetEntry>());
}

fn frame(bytes: &[u8]) -> (FrameHead, Vec<TargetEntry>) {
    match outcomes::<LEN>(bytes).as_slice() {
        [Outcome::Frame(head, targets)] => (*head, targets.clone()),
        other => panic!("{other:?}"),
    }
}

fn targets_in_a_report_for<const N: usize>() {
    for pushed in [0, 1, N, N + 1, N + 5] {
        let mut report = Report::<N>::new(Detail::Normal);
        for seq in [7, 8] {
            report.begin(seq);
            (0..pushed).for_each(|i| report.push(&annulus(i as u32)));
            let (head, targets) = frame(report.finish(&summary(), &mut vec![0; LEN]).unwrap());
            assert_eq!((head.seq, head.detail), (seq, Detail::Normal));
            assert_eq!(
                (targets.len(), head.dropped_targets as usize),
                (pushed.min(N), pushed.saturating_sub(N))
            );
            assert_eq!(targets, report.targets());
        }
        report.begin(9);
        let (head, targets) = frame(report.finish(&summary(), &mut vec![0; LEN]).unwrap());
        assert_eq!((head.dropped_targets, targets.len()), (0, 0), "one frame must not reach into the next");
    }
}

#[test]
fn targets_in_a_report() {
    targets_in_a_report_for::<0>();
    targets_in_a_report_for::<1>();
    targets_in_a_report_for::<60>();
}

#[test]
fn buffer_of_the_caller() {
    for detail in DETAILS {
        for count in [0, 1, 3, 20] {
            let mut report = Report::<20>::new(detail);
            (0..count).for_each(|i| report.push(&annulus(i)));
            let whole = report.finish(&summary(), &mut vec![0; LEN]).unwrap().to_vec();
            let needed = whole.len();
            for available in (0..needed).step_by(7).chain([needed - 1]) {
                let error = report.finish(&summary(), &mut vec![0; available]).unwrap_err();
                assert_eq!(error, EncodeError::BufferTooSmall { needed, available });
                assert_eq!(
                    error.to_string(),
                    format!("report takes {needed} bytes, buffer holds {available}")
                );
            }
            assert_eq!(report.finish(&summary(), &mut vec![0xAA; needed]).unwrap(), whole);
        }
    }
}

#[test]
fn memory_of_the_decoder() {
    const PLAIN: usize = 30;
    let empty = encode(300, Detail::Terse, &[]);
    let [ok, short, none] =
        [outcomes::<PLAIN>(&empty), outcomes::<{ PLAIN - 1 }>(&empty), outcomes::<0>(&empty)];
    assert!(matches!(ok.as_slice(), [Outcome::Frame(..)]), "{ok:?}");
    for too_long in [short, none] {
        assert_eq!(too_long, [Outcome::Damaged(concentric::report::DecodeError::TooLong)]);
    }
}

#[test]
fn pending_is_the_length_of_the_piece_since_the_last_separator() {
    let bytes = encode(1, Detail::Full, &[annulus(0)]);
    let mut decoder = Decoder::<16>::new();
    for (taken, &byte) in bytes.iter().enumerate() {
        assert_eq!(decoder.pending(), taken);
        decoder.push(byte);
    }
    assert_eq!(decoder.pending(), 0);
}

#[test]
fn commands_and_answers_of_the_largest_fields_have_the_length_that_is_told() {
    let ratios = Ratios::from_slice(&[u16::MAX; 8]).unwrap();
    let settings = HeadSettings {
        ratios: ratios.clone(),
        polarity: Polarity::Light,
        compensation: Compensation::Known,
        detail: Detail::Full,
        format: Format::Text,
        whole_every: u16::MAX,
        px_per_run: u16::MAX,
        effort: Effort::Quick,
    };
    let outcome = Answered::Ratio { value: u16::MAX, min: u16::MAX, max: u16::MAX };
    let answer = Answer { tag: u16::MAX, outcome, settings };
    assert_eq!(answer.encode(&mut [0; 100]).unwrap().len(), ANSWER_MAX_LEN);
    let command = Command { tag: u16::MAX, request: Request::Ratios(ratios) };
    assert_eq!(command.encode(&mut [0; 100]).unwrap().len(), COMMAND_MAX_LEN);
}
