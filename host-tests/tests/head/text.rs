//! Reports as text say what the binary ones say.

use concentric::report::{Detail, Format, Report, max_text_len};
use concentric::{Circle, Covariance, Ellipse, Flags, Position, Summary, Target};
use proptest::prelude::*;

use crate::support::{BUFFER, Bench, CENTRE, PlayedLine, Sent, TestStorage, messages};

/// The fields of the lines; each has to have its frame and its checksum.
fn lines(text: &str) -> Vec<Vec<&str>> {
    let line = |line: &str| -> Option<_> {
        let (fields, check) = line.strip_prefix('$')?.split_once('*')?;
        let sum = fields.bytes().fold(0, |sum, byte| sum ^ byte);
        (check == format!("{sum:02X}")).then_some(())
    };
    assert!(text.ends_with("\r\n"), "{text:?}");
    text.split_terminator("\r\n")
        .map(|text| {
            line(text).unwrap_or_else(|| panic!("{text:?}"));
            text[1..].split('*').next().unwrap().split(',').collect()
        })
        .collect()
}

/// What a receiver of the binary report makes of a field.
fn field(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    // Without the sign of a zero.
    if text.trim_start_matches(['-', '0', '.']).is_empty() {
        text.trim_start_matches('-').to_owned()
    } else {
        text
    }
}

fn near(text: &str, value: f64, decimals: usize) {
    let unit = 10f64.powi(-(decimals as i32));
    let read: f64 = text.parse().unwrap();
    assert!((read - value).abs() <= 0.5001 * unit, "{text} for {value}");
    assert_eq!(text.len(), field(read, decimals).len(), "{text}: wrong number of digits");
}

#[test]
fn a_frame_as_text_says_what_the_binary_one_says() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    bench.frame().unwrap();
    bench.settle();
    let binary = messages(&bench.line.take());
    let Sent::Frame(_, targets) = &binary[1] else { panic!("{binary:?}") };
    bench.format(Format::Text);
    bench.frame().unwrap();
    bench.settle();
    let text = String::from_utf8(bench.line.take()).unwrap();
    let lines = lines(&text);
    assert_eq!(lines[0], ["CCF", "2", "96", "96", "1", "0", "0"]);
    let [name, seq, number, id, x, y, sigma_x, sigma_y, r, flags, a, b, theta, rms, track, age] =
        lines[1][..]
    else {
        panic!("{text}")
    };
    assert_eq!([name, seq, number, id], ["CCT", "2", "1", "0"]);
    let target = &targets[0];
    let concentric::report::Details::Normal(shape) = target.details else { panic!("{target:?}") };
    near(x, f64::from(target.centre.x) / 65536.0, 4);
    near(y, f64::from(target.centre.y) / 65536.0, 4);
    near(sigma_x, f64::from(target.sigma_x) / 65536.0, 5);
    near(sigma_y, f64::from(target.sigma_y) / 65536.0, 5);
    near(r, f64::from(target.correlation) / 127.0, 2);
    assert_eq!(flags, target.flags.0.to_string());
    near(a, f64::from(shape.a) / 4096.0, 4);
    near(b, f64::from(shape.b) / 4096.0, 4);
    near(theta, f64::from(shape.theta) * 180.0 / 32768.0, 2);
    near(rms, f64::from(shape.rms) / 65536.0, 5);
    // It was there in the frame before.
    assert_eq!([track, age], ["1", "1"]);
    // The target is where it was drawn.
    let off = |text: &str, drawn: f32| (text.parse::<f32>().unwrap() - drawn).abs();
    assert!(off(x, CENTRE[0]) < 0.02 && off(y, CENTRE[1]) < 0.02, "{text}");
}

#[test]
fn a_frame_without_targets_has_its_line() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    bench.format(Format::Text);
    bench.sensor.pixels.fill(200);
    bench.frame().unwrap();
    bench.settle();
    let text = String::from_utf8(bench.line.take()).unwrap();
    assert_eq!(lines(&text), [["CCF", "1", "96", "96", "0", "0", "0"]]);
}

#[test]
fn the_longest_report_fits_in_the_length_that_is_told() {
    let circle = Circle {
        ellipse: Ellipse { centre: Position::default(), a: 1e9, b: 1e9, theta: -4.0 },
        rms: 9.0,
        ..Circle::default()
    };
    let mut target = Target {
        centre: Position { x: i32::MIN, y: i32::MIN },
        covariance: Covariance { xx: 4.0, xy: -4.0, yy: 4.0 },
        flags: Flags(u16::MAX),
        ..Target::default()
    };
    target.circles.push(circle).unwrap();
    for detail in [Detail::Terse, Detail::Normal, Detail::Full] {
        let mut report = Report::<3>::new(detail);
        report.begin(u32::MAX);
        (0..5).for_each(|_| report.push(&target));
        let summary = Summary { width: u16::MAX, height: u16::MAX, ..Summary::default() };
        let mut buffer = vec![0; max_text_len(3, detail)];
        let text = String::from_utf8(report.finish_text(&summary, &mut buffer).unwrap().to_vec()).unwrap();
        assert_eq!(lines(&text).len(), 4);
        assert_eq!(lines(&text)[0][4..], ["3", "2", "0"]);
        // Numbers of targets and reports can have nine more digits each, ids, tracks and ages four.
        let slack = 3 * 9 + 3 * (9 + 4 + 4 + 4);
        assert!(
            text.len() + slack >= max_text_len(3, detail),
            "{} of {}",
            text.len(),
            max_text_len(3, detail)
        );
        let short = report.finish_text(&summary, &mut buffer[..text.len() - 1]).unwrap_err();
        assert_eq!(
            short.to_string(),
            format!("report takes {} bytes, buffer holds {}", text.len(), text.len() - 1)
        );
    }
}

proptest! {
    #[test]
    fn positions_are_rounded_to_the_nearest(x: i32, y in -200_000..200_000i32) {
        let mut report = Report::<1>::new(Detail::Terse);
        report.push(&Target { centre: Position { x, y }, ..Target::default() });
        let mut buffer = [0; max_text_len(1, Detail::Terse)];
        let text = report.finish_text(&Summary::default(), &mut buffer).unwrap();
        let lines = lines(std::str::from_utf8(text).unwrap());
        near(lines[1][4], f64::from(x) / 65536.0, 4);
        near(lines[1][5], f64::from(y) / 65536.0, 4);
    }
}
