//! The command `detect`.

use std::{io::Write, process::Stdio};

use concentric::{Settings, TargetSpec};
use concentric_host::{detect, measure::px, picture::Picture};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::Value;

use super::support::{CENTRE, Folder, assert_error, assert_refused, json, png, size, text};

#[test]
fn bad_ratios_name_the_range() {
    let folder = Folder::new();
    folder.photo("a.png");
    for (ratio, parts) in [
        ("1.2", ["1.2", "0.1..=0.95"]),
        ("0", ["ratio 0 ", "0.1..=0.95"]),
        ("-0.5", ["-0.5", "0.1..=0.95"]),
        ("abc", ["`abc` is no number", "0.1 to 0.95"]),
        ("0.5,0.6", ["0.6", "descending"]),
        ("0.9,0.8,0.7,0.6", ["4 ratios", "1..=3"]),
    ] {
        let output = folder.run(&["detect", "--ratio", ratio, "a.png"]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{ratio}");
        assert!(parts.iter().all(|part| message.contains(part)), "{ratio}: {message}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn bad_files_are_named_with_the_cause() {
    let folder = Folder::new();
    let photo = folder.photo("a.png");
    folder.write("text.png", b"once upon a time");
    folder.write("cut.png", &photo[..photo.len() / 2]);
    folder.write("zero.pgm", b"P5 0 0 255\n");
    folder.write("empty.jpg", b"");
    folder.write("wide.png", &png(&vec![9; 4097 * 8], 4097, 8));
    std::fs::create_dir(folder.path("folder")).unwrap();
    for (name, parts) in [
        ("text.png", ["is not an image", "PNG, PGM and JPEG"]),
        ("cut.png", ["damaged PNG file", ""]),
        ("zero.pgm", ["is 0 x 0 px", "8 to 4096 px"]),
        ("empty.jpg", ["is empty", "PNG, PGM and JPEG"]),
        ("wide.png", ["is 4097 x 8 px", "8 to 4096 px"]),
        ("missing.png", ["cannot be read", "No such file"]),
        ("folder", ["is a directory", "PNG, PGM and JPEG"]),
    ] {
        let output = folder.run(&["detect", name]);
        assert_refused(&output, &[name, parts[0], parts[1]]);
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn cut_jpeg_is_refused() {
    let folder = Folder::new();
    let pixels: Vec<u8> = (0..64 * 64).map(|i| (i * 7 % 256) as u8).collect();
    let mut file = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new(&mut file);
    encoder.write_image(&pixels, 64, 64, ExtendedColorType::L8).unwrap();
    folder.write("whole.jpg", &file);
    folder.write("cut.jpg", &file[..file.len() - 40]);
    assert_eq!(folder.run(&["detect", "whole.jpg"]).status.code(), Some(0));
    assert_refused(&folder.run(&["detect", "cut.jpg"]), &["cut.jpg: damaged JPEG file"]);
}

#[test]
fn the_others_are_done_when_one_is_bad() {
    let folder = Folder::new();
    folder.photo("a.png");
    folder.photo("c.png");
    folder.write("b.png", b"P5");
    let output = folder.run(&["detect", "--json", "a.png", "b.png", "c.png"]);
    assert_refused(&output, &["b.png: damaged PGM file"]);
    let images: Vec<_> = json(&output).iter().map(|line| line["image"].clone()).collect();
    assert_eq!(images, ["a.png", "c.png"]);
}

#[test]
fn no_target_is_no_failure() {
    let folder = Folder::new();
    folder.write("grey.png", &png(&[128; 64 * 48], 64, 48));
    let output = folder.run(&["detect", "grey.png"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).contains("grey.png: no target (64 x 48 px)"));
    assert!(output.stderr.is_empty());
}

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

/// Every number in `value` is a number, which JSON has no infinite ones of; NaN and infinity are written as null.
fn assert_no_null(value: &Value) {
    match value {
        Value::Null => panic!("null"),
        Value::Array(values) => values.iter().for_each(assert_no_null),
        Value::Object(entries) => entries.values().for_each(assert_no_null),
        _ => {}
    }
}

#[test]
fn json_has_the_documented_shape() {
    let folder = Folder::new();
    folder.photo("a.png");
    let output = folder.run(&["detect", "--ratio", "0.5", "--json", "a.png"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let lines = json(&output);
    let [line] = &lines[..] else { panic!("{lines:?}") };
    assert_no_null(line);
    assert_eq!(
        keys(line),
        ["dropped", "height", "image", "ms", "rejected", "targets", "unsearched", "width"]
    );
    assert_eq!(
        (&line["image"], &line["width"], &line["height"]),
        (&"a.png".into(), &1280.into(), &1024.into())
    );
    assert_eq!(keys(&line["dropped"]), ["crossings", "outlines", "runs"]);
    assert!(keys(&line["rejected"]).contains(&"not_elliptic") && line["rejected"]["ratio"].is_u64());
    let targets = line["targets"].as_array().unwrap();
    let [target] = &targets[..] else { panic!("{targets:?}") };
    assert_eq!(
        keys(target),
        [
            "blur",
            "circles",
            "contrast",
            "cov",
            "eccentricity",
            "eq7",
            "flags",
            "gap",
            "model_difference",
            "noise",
            "residual",
            "x",
            "y"
        ]
    );
    assert_eq!(target["cov"].as_array().unwrap().len(), 3);
    assert_eq!(keys(&target["eq7"]), ["x", "y"]);
    let circles = target["circles"].as_array().unwrap();
    assert_eq!(circles.len(), 2);
    for circle in circles {
        assert_eq!(
            keys(circle),
            ["a", "b", "gap", "measured_ratio", "points", "ratio", "rms", "theta", "x", "y"]
        );
    }
    assert!(circles[0]["a"].as_f64() > circles[1]["a"].as_f64(), "outermost first");
    assert!(target["flags"].as_array().unwrap().iter().all(Value::is_string));
    for (axis, truth) in ["x", "y"].into_iter().zip(CENTRE) {
        let value = target[axis].as_f64().unwrap();
        assert!((value - truth).abs() < 0.05, "{axis}: {value}, true {truth}");
    }
}

/// Every digit of a place is printed: `f32` would keep 6e-5 px.
#[test]
fn json_is_as_exact_as_the_library() {
    let folder = Folder::new();
    let photo = folder.photo("a.png");
    let settings = Settings::new(TargetSpec::ring(0.5).unwrap());
    let found = detect::run(&Picture::decode("a.png", &photo).unwrap(), settings).unwrap().targets;
    let printed = &json(&folder.run(&["detect", "--ratio", "0.5", "--json", "a.png"]))[0]["targets"][0];
    let circles = found[0].circles.iter().zip(printed["circles"].as_array().unwrap());
    let ellipses = circles.map(|(circle, printed)| (circle.ellipse.centre, printed));
    for (place, printed) in ellipses.chain([(found[0].centre, printed), (found[0].eq7, &printed["eq7"])]) {
        for (axis, value) in ["x", "y"].into_iter().zip(px(place)) {
            assert!(
                (printed[axis].as_f64().unwrap() - value).abs() < 1e-9,
                "{axis}: {printed}, found {value}"
            );
        }
    }
}

#[test]
fn compensation_changes_the_centre_only() {
    let folder = Folder::new();
    folder.photo("a.png");
    let target = |mode: &str| {
        let output = folder.run(&["detect", "--ratio", "0.5", "--json", "--compensation", mode, "a.png"]);
        json(&output)[0]["targets"][0].clone()
    };
    let [none, eq7, exact, auto] = ["none", "eq7", "exact", "auto"].map(target);
    assert_eq!(none["x"], none["circles"][0]["x"]);
    assert_eq!(none["eccentricity"], 0.0);
    assert_eq!((&eq7["x"], &eq7["y"]), (&eq7["eq7"]["x"], &eq7["eq7"]["y"]));
    assert!(exact["eccentricity"].as_f64().unwrap() > 0.1);
    // Here the eccentricity is a hundred times its sigma, so nearly all of it is corrected.
    let [from_exact, from_none] = [&exact, &none].map(|other| {
        let axis = |name: &str| auto[name].as_f64().unwrap() - other[name].as_f64().unwrap();
        axis("x").hypot(axis("y"))
    });
    assert!(from_exact < 0.003 * from_none, "{from_exact} {from_none}");
    assert_eq!(none["circles"], exact["circles"]);
}

#[test]
fn polarity_is_heeded() {
    let folder = Folder::new();
    folder.photo("a.png");
    let count = |arguments: &[&str]| {
        json(&folder.run(&[&["detect", "--json", "a.png"], arguments].concat()))[0]["targets"]
            .as_array()
            .unwrap()
            .len()
    };
    assert_eq!(count(&["--ratio", "0.5"]), 1);
    assert_eq!(count(&["--ratio", "0.5", "--light"]), 0);
}

#[test]
fn csv_has_one_header_and_a_line_per_target() {
    let folder = Folder::new();
    folder.photo("a.png");
    folder.photo("b, c.png");
    let output = folder.run(&["detect", "--ratio", "0.5", "--csv", "a.png", "b, c.png"]);
    let printed = text(&output.stdout);
    let lines: Vec<_> = printed.lines().collect();
    assert_eq!(lines.len(), 3, "{printed}");
    assert!(lines[0].starts_with("image,number,x,y,xx,xy,yy,eq7_x,eq7_y,"), "{}", lines[0]);
    assert!(lines[1].starts_with("a.png,1,640.") && lines[2].starts_with("\"b, c.png\",1,640."), "{printed}");
    let columns = lines[0].split(',').count();
    assert_eq!(lines[1].split(',').count(), columns);
    assert!(
        lines[1]
            .split(',')
            .skip(2)
            .take(columns - 4)
            .all(|cell| cell.parse::<f64>().is_ok_and(f64::is_finite))
    );
}

#[test]
fn standard_input_is_read() {
    let folder = Folder::new();
    let photo = folder.photo("a.png");
    let mut command = folder.command(&["detect", "--ratio", "0.5", "--json", "-"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(&photo).unwrap();
    let lines = json(&child.wait_with_output().unwrap());
    assert_eq!(lines[0]["image"], "-");
    assert_eq!(lines[0]["targets"].as_array().unwrap().len(), 1);
}

#[test]
fn the_table_is_plain_in_a_pipe() {
    let folder = Folder::new();
    folder.photo("a.png");
    let output = folder.run(&["detect", "--ratio", "0.5", "a.png"]);
    let printed = text(&output.stdout);
    assert!(printed.starts_with("a.png: 1 target (1280 x 1024 px)\n"), "{printed}");
    assert!(printed.contains("  1  640.") && printed.contains("rejected: "), "{printed}");
    assert!(!printed.contains('\u{1b}') && output.stderr.is_empty());
}

#[test]
fn runs_beyond_the_bound_are_dropped_and_told() {
    let folder = Folder::new();
    folder.photo("a.png");
    let told = |bound: &str| {
        let output = folder.run(&["detect", "--json", "--px-per-run", bound, "a.png"]);
        let line = &json(&output)[0];
        (line["targets"].as_array().unwrap().len(), line["dropped"]["runs"].as_u64().unwrap())
    };
    assert_eq!([told("0"), told("8")], [(1, 0), (1, 0)]);
    assert!(told("65535").1 > 0);
    assert_error(&folder.run(&["detect", "--px-per-run", "70000", "a.png"]), &["px-per-run", "65535"]);
}

#[test]
fn less_effort_gives_nearly_the_same() {
    let folder = Folder::new();
    folder.photo("a.png");
    let centre = |more: &[&str]| {
        let output = folder.run(&[&["detect", "--json", "a.png"], more].concat());
        let target = &json(&output)[0]["targets"][0];
        ["x", "y"].map(|axis| target[axis].as_f64().unwrap())
    };
    let ([x, y], [quick_x, quick_y]) = (centre(&[]), centre(&["--quick"]));
    let off = (x - quick_x).hypot(y - quick_y);
    assert!(off > 0.0 && off < 0.05, "{off}");
    assert_error(&folder.run(&["detect", "--quick", "--refine", "a.png"]), &["--quick", "--refine"]);
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let folder = Folder::new();
    folder.photo("a.png");
    let mut command = folder.command(&["detect", "a.png"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
}

#[test]
fn overlays_are_written_beside_each_other() {
    let folder = Folder::new();
    let photo = folder.photo("a.png");
    folder.photo("b.png");
    assert_eq!(folder.run(&["detect", "--overlay", "one.png", "a.png"]).status.code(), Some(0));
    assert_eq!(folder.run(&["detect", "--overlay", "two.png", "a.png", "b.png"]).status.code(), Some(0));
    let (width, height) = size(&folder.path("one.png"));
    assert!(width > 1280 && height > 1024, "{width} x {height}");
    assert_eq!(size(&folder.path("two-a.png")), size(&folder.path("two-b.png")));
    assert_refused(&folder.run(&["detect", "--overlay", "a.png", "a.png"]), &["a.png", "overwrite"]);
    assert_eq!(std::fs::read(folder.path("a.png")).unwrap(), photo);
    assert_refused(
        &folder.run(&["detect", "--overlay", "none/x.png", "a.png"]),
        &["none/x.png", "cannot be written"],
    );
}
