//! Instructions and bytes, from the baseline that `cargo xtask bench --check` compares with what it measures.

use concentric::Settings;
use serde_json::Value;

use crate::{document, read};

/// The baseline.
const BASELINE: &str = "xtask/bench/baseline.json";
/// The processors of the table, as the baseline and as the table name them.
const PROCESSORS: [(&str, &str); 4] =
    [("m0plus", "Cortex-M0+"), ("m4f", "Cortex-M4F"), ("m7", "Cortex-M7"), ("rv32imc", "RV32IMC")];

/// Frames with a name.
fn frames<'a>(processor: &'a Value, scene: &'a str) -> impl Iterator<Item = (f64, &'a Value)> {
    let frames = processor["frames"].as_array().expect("frames").iter();
    frames.filter(move |frame| frame["scene"] == scene).map(|frame| {
        let pixels = number(&frame["width"]) * number(&frame["height"]);
        (pixels, frame)
    })
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{BASELINE}: {value} is no number"))
}

/// Instructions per pixel up to the candidates, at 320, 640 and 1280 px of width.
fn scan(processor: &Value, scene: &str) -> String {
    let figures = frames(processor, scene)
        .map(|(pixels, frame)| format!("{:.1}", number(&frame["scan"]["instructions"]) / pixels));
    figures.collect::<Vec<_>>().join(", ")
}

/// The most of all frames with the tightest bound of the work.
fn bounded(processor: &Value) -> String {
    let bound = format!(", {} px a run", Settings::BOUNDED_PX_PER_RUN);
    let all = || processor["frames"].as_array().expect("frames").iter();
    let figures = [320.0, 640.0, 1280.0].map(|width| {
        let frames =
            all().filter(|frame| frame["scene"].as_str().is_some_and(|scene| scene.ends_with(&bound)));
        let frames = frames.filter(|frame| number(&frame["width"]) == width);
        let figures = frames.map(|f| number(&f["scan"]["instructions"]) / number(&f["height"]) / width);
        format!("{:.1}", figures.reduce(f64::max).expect("bounded frames"))
    });
    figures.join(", ")
}

/// Instructions of a lone target, in thousands.
fn target(processor: &Value, scene: &str) -> String {
    let (_, frame) = frames(processor, scene).next().expect("a target");
    format!("{:.0}", number(&frame["target"]["instructions"]) / 1e3)
}

/// The same processor with the library's features off.
fn lean(processor: &Value) -> &Value {
    &processor["lean"]
}

pub fn table() -> String {
    let baseline: Value = serde_json::from_str(&read(BASELINE)).expect("JSON");
    let of = |name: &str| {
        let all = baseline["processors"].as_array().expect("processors");
        all.iter().find(|one| one["processor"] == name).unwrap_or_else(|| panic!("{BASELINE} lacks {name}"))
    };
    type Figure = fn(&Value) -> String;
    let rows: [(&str, Figure); 17] = [
        ("scan, empty frame, a pixel", |p| scan(p, "empty")),
        ("scan, 60 targets, a pixel", |p| scan(p, "60 targets")),
        ("scan, noise, a pixel", |p| scan(p, "noise")),
        ("scan, clutter, a pixel", |p| scan(p, "clutter")),
        ("scan, checkerboard of 6 px, a pixel", |p| scan(p, "checkerboard 6 px")),
        ("scan, the most of any frame with `px_per_run` 144, a pixel", bounded),
        ("target of radius 10 px, thousands", |p| target(p, "radius 10")),
        ("target of radius 30 px, thousands", |p| target(p, "radius 30")),
        ("target of radius 100 px, thousands", |p| target(p, "radius 100")),
        ("the same, quick: radius 10 px", |p| target(p, "radius 10, quick")),
        ("the same, quick: radius 30 px", |p| target(p, "radius 30, quick")),
        ("the same, quick: radius 100 px", |p| target(p, "radius 100, quick")),
        ("stack, measured, bytes", |p| p["stack"]["measured"].to_string()),
        ("flash of the library, bytes", |p| p["library_flash"].to_string()),
        ("the same, compiled for size", |p| p["library_flash_small"].to_string()),
        ("flash for size, without `arcs`, `camera`, `joint`, bytes", |p| {
            lean(p)["library_flash_small"].to_string()
        }),
        ("stack without them, measured, bytes", |p| lean(p)["stack"]["measured"].to_string()),
    ];
    let rows = rows.map(|(what, figure)| {
        [what.to_owned()].into_iter().chain(PROCESSORS.iter().map(|(name, _)| figure(of(name)))).collect()
    });
    let head: Vec<_> = ["instructions; bytes"].into_iter().chain(PROCESSORS.map(|(_, name)| name)).collect();
    document::table(&head, &rows)
}
