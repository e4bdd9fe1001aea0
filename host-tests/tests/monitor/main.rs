//! `concentric monitor` on streams from files, TCP and a serial line; whole, damaged, cut and silent.

mod commands;
mod sources;
mod support;

use std::fs;

use concentric::report::{Detail, Report};
use concentric::{Covariance, Summary, Target};
use serde_json::{Value, json};
use support::{file, folder, frame, hello, monitor, name, refusal, stream};

#[test]
fn a_line_for_each_message() {
    let folder = folder();
    let bytes = [hello(), frame(7, Detail::Terse, 0), frame(8, Detail::Terse, 5)].concat();
    let outcome = monitor(&[&file(&folder, &bytes)]);
    let entry = |track| json!({"track": track, "age": 0, "x": 1.25, "y": 1.5, "cov": null, "flags": ["small", "light"]});
    let frame = |seq: u32, targets: usize, dropped: usize| {
        json!({"kind": "frame", "seq": seq, "width": 640, "height": 480, "limited": true,
            "targets": (1..=targets).map(entry).collect::<Vec<_>>(),
            "rejected": {"alone": 3}, "dropped": {"runs": 1, "outlines": 2, "crossings": 3,
                "targets": dropped, "reports": 0}, "unsearched": 6})
    };
    let expected = [
        json!({"kind": "hello", "firmware": "3.2.1", "library": env!("CARGO_PKG_VERSION"), "max_width": 1280,
            "pixels": "centres_at_integers", "position_scale": 65536, "detail": "terse"}),
        frame(7, 0, 0),
        frame(8, 4, 1),
        json!({"kind": "summary", "bytes": bytes.len(), "hellos": 1, "frames": 2, "lost": 0, "restarts": 0,
            "damaged": 0, "truncated": 0}),
    ];
    assert_eq!(outcome.lines, expected);
    assert_eq!((outcome.notes.as_str(), outcome.error), ("", None));
}

#[test]
fn each_level_of_detail_in_px_and_radians() {
    let folder = folder();
    let of = |detail| monitor(&[&file(&folder, &frame(1, detail, 1))]).lines[0]["targets"][0].clone();
    let normal = of(Detail::Normal);
    let theta = 0.49998188;
    assert_eq!(normal["circles"], json!([{"a": 64.25, "b": 32.5, "theta": theta, "rms": 0.03125}]));
    assert_eq!((&normal["eq7"], &normal["blur"]), (&Value::Null, &Value::Null));

    let full = of(Detail::Full);
    let ratio = 0.5000076;
    assert_eq!(
        full["circles"],
        json!([
            {"x": 1.0078125, "y": 2.0, "a": 64.25, "b": 32.5, "theta": theta, "rms": 0.03125, "points": 77,
                "gap": 33.75, "ratio": 1.0, "measured_ratio": 0.7499962},
            {"x": 1.0078125, "y": 2.0, "a": 32.125, "b": 16.25, "theta": theta, "rms": 0.03125, "points": 77,
                "gap": 33.75, "ratio": ratio, "measured_ratio": 0.37500572},
        ])
    );
    assert_eq!((&full["eq7"], &full["exact"]), (&json!({"x": 1.0, "y": 1.0}), &json!({"x": -1.0, "y": 0.0})));
    assert_eq!((&full["contrast"], &full["blur"]), (&json!(180.5), &json!(0.75)));
    assert_eq!((&full["noise"], &full["residual"]), (&json!(2.25), &json!(0.03125)));
    assert_eq!((&full["gap"], &full["model_difference"]), (&json!(33.75), &json!(2.236068)));
}

#[test]
fn covariance_is_made_of_sigmas_and_correlation() {
    let folder = folder();
    let covariance = Covariance { xx: 1.0 / 16384.0, xy: -1.0 / 65536.0, yy: 1.0 / 65536.0 };
    let mut report = Report::<1>::new(Detail::Terse);
    report.push(&Target { covariance, ..Target::default() });
    let bytes = report.finish(&Summary::default(), &mut [0; 100]).unwrap().to_vec();
    let line = monitor(&[&file(&folder, &bytes)]).lines[0].clone();
    for (index, wanted) in [4.0, -2.0 * 64.0 / 127.0, 1.0].into_iter().enumerate() {
        let found = line["targets"][0]["cov"][index].as_f64().unwrap() * 65536.0;
        assert!((found - wanted).abs() < 1e-6, "{index}: {found}, not {wanted}");
    }
}

#[test]
fn gaps_are_lost_frames_and_going_back_is_a_restart() {
    let folder = folder();
    let counts = |seqs: &[u32]| {
        let outcome = monitor(&[&file(&folder, &stream(seqs.iter().copied()))]);
        assert_eq!(outcome.seqs().len(), seqs.len());
        (outcome.summary()["lost"].as_u64().unwrap(), outcome.summary()["restarts"].as_u64().unwrap())
    };
    assert_eq!(counts(&[5, 6, 7]), (0, 0));
    assert_eq!(counts(&[5, 7, 11]), (4, 0));
    assert_eq!(counts(&[u32::MAX - 1, u32::MAX, 0, 1, 3]), (1, 0));
    assert_eq!(counts(&[100, 101, 0, 1, 3]), (1, 1));
    assert_eq!(counts(&[4, 4]), (0, 1));
}

#[test]
fn damage_is_told_and_counted_and_the_rest_decoded() {
    let folder = folder();
    let (first, second) = (stream([0, 1]), frame(2, Detail::Normal, 1));
    let mut damaged = second.clone();
    let checksum = damaged.len() - 3;
    damaged[checksum] ^= 0x40;
    let bytes = [first.as_slice(), &damaged, &stream([3])].concat();
    let path = file(&folder, &bytes);
    let outcome = monitor(&[&path]);
    assert_eq!(outcome.seqs(), [0, 1, 3]);
    let summary = outcome.summary();
    assert_eq!(
        (&summary["damaged"], &summary["lost"], &summary["truncated"]),
        (&json!(1), &json!(1), &json!(0))
    );
    let (len, at) = (second.len() - 1, first.len());
    let note = format!("concentric: {path}: {len} bytes at byte {at}: checksum does not match\n");
    assert_eq!((outcome.notes, outcome.error), (note, None));
}

#[test]
fn a_stream_cut_in_mid_message_says_so() {
    let folder = folder();
    let whole = stream([0, 1, 2]);
    let last = frame(2, Detail::Normal, 1).len();
    for cut in 1..last {
        let path = file(&folder, &whole[..whole.len() - cut]);
        let outcome = monitor(&[&path]);
        let pending = last - cut;
        assert_eq!(outcome.seqs(), [0, 1]);
        assert_eq!((&outcome.summary()["truncated"], &outcome.summary()["damaged"]), (&json!(1), &json!(0)));
        let note = format!("the stream ends in mid-message: {pending} bytes after the last separator");
        assert_eq!(outcome.notes, format!("concentric: {path}: {note}\n"));
        assert_eq!(outcome.error, None);
    }
}

#[test]
fn what_is_no_stream_of_reports_is_an_error() {
    let folder = folder();
    let path = file(&folder, b"");
    assert_eq!(monitor(&[&path]).error.unwrap(), format!("{path}: empty; wanted a stream of reports"));
    let path = file(&folder, b"Dear Sir or Madam");
    let outcome = monitor(&[&path]);
    let wanted = "no report in 17 bytes; wanted the stream of a camera head";
    assert_eq!(outcome.summary()["bytes"], 17);
    assert_eq!(outcome.error.unwrap(), format!("{path}: {wanted}"));
}

#[test]
fn a_source_that_cannot_be_read_is_named_with_the_cause() {
    let folder = folder();
    let missing = name(&folder.path().join("missing"));
    let here = name(folder.path());
    for source in [&missing, &here, "tcp:127.0.0.1:1", "/dev/tty_of_nobody"] {
        let error = monitor(&[source]).error.unwrap();
        assert!(error.starts_with(&format!("{source}: ")) && error.len() > source.len() + 10, "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn arguments_out_of_range_are_refused_with_what_is_allowed() {
    for source in ["tcp:", "tcp:host", "tcp::5000", "tcp:host:0", "tcp:host:70000", "tcp:host:http"] {
        assert!(refusal(&[source]).contains("wanted tcp:HOST:PORT with a port of 1 to 65535"), "{source}");
    }
    for seconds in ["0", "-1", "soon", "nan", "inf", "1e300"] {
        let refusal = refusal(&["-", &format!("--timeout={seconds}")]);
        assert!(refusal.contains("wanted a number of seconds above 0"), "{refusal}");
    }
    refusal(&["-", "--count=0"]);
    refusal(&["-", "--baud=0"]);
    refusal(&[]);
}

#[test]
fn count_stops_and_raw_has_what_was_taken() {
    let folder = folder();
    let path = file(&folder, &stream(0..10));
    let raw = name(&folder.path().join("raw"));
    let outcome = monitor(&[&path, "--count", "4", "--raw", &raw]);
    assert_eq!(outcome.seqs(), [0, 1, 2, 3]);
    assert_eq!((&outcome.summary()["frames"], &outcome.summary()["truncated"]), (&json!(4), &json!(0)));
    assert_eq!(fs::read(&raw).unwrap(), stream(0..4));

    monitor(&[&path, "--raw", &raw]);
    assert_eq!(fs::read(&raw).unwrap(), stream(0..10));
}

#[test]
fn raw_spares_its_own_source_and_names_a_file_that_cannot_be_written() {
    let folder = folder();
    let path = file(&folder, &stream(0..3));
    let error = monitor(&[&path, "--raw", &path]).error.unwrap();
    assert_eq!(error, format!("{path}: cannot be read and recorded over at once"));
    assert_eq!(fs::read(&path).unwrap(), stream(0..3));
    let nowhere = name(&folder.path().join("no/such/folder"));
    let error = monitor(&[&path, "--raw", &nowhere]).error.unwrap();
    assert!(error.starts_with(&format!("{nowhere}: ")), "{error}");
}

#[test]
fn quiet_prints_the_counts_only() {
    let folder = folder();
    let outcome = monitor(&["--quiet", &file(&folder, &stream([1, 2, 5]))]);
    assert_eq!(outcome.lines.len(), 1);
    assert_eq!((&outcome.summary()["frames"], &outcome.summary()["lost"]), (&json!(3), &json!(2)));
}
