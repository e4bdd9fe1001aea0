//! The results as a page of Markdown.

use std::fmt::Write as _;

use super::features;
use super::goals::{self, CLASSES};
use super::processor::{ALL, Processor};
use super::results::{Counts, Frame, Measured, Results};

/// Parts whose frames per second are modelled: processor, clock, and how much more it does in a cycle than the model.
const PARTS: [(&str, &str, f64, f64); 6] = [
    ("RP2040", "m0plus", 133e6, 1.0),
    ("STM32F405", "m4f", 168e6, 1.0),
    ("RP2350", "m33-dsp", 150e6, 1.0),
    ("STM32H743", "m7", 480e6, M7_OVER_M4),
    ("i.MX RT1062", "m7", 600e6, M7_OVER_M4),
    ("soft core like Ibex", "rv32imc", 100e6, 1.0),
];
/// CoreMark/MHz of the Cortex-M7 and the M4, 5.01 and 3.40: there is no table of the M7's cycles.
const M7_OVER_M4: f64 = 5.01 / 3.40;

const ASSUMPTIONS: &str = "\
Cycles are a model, not measured on silicon: the makers' tables of cycles per instruction, memory without wait states for
code and data, and no camera that competes for it. Of the M33 and the M7 there are no tables: the M33 is priced as an M4;
the M7 as 1.47 times an M4, the ratio of their CoreMark/MHz, which takes data in TCM or cache. `xtask/counter/src/cost.rs`
has the sources.";

/// The page.
pub fn page(results: &Results) -> String {
    let measured: Vec<(&Processor, &Measured)> =
        ALL.iter().filter_map(|processor| Some((processor, results.of(processor.id)?))).collect();
    let mut page = "# Instructions and bytes\n".to_owned();
    let mut section = |title: &str, note: &str, table: String| {
        // Writing to a string does not fail.
        _ = write!(page, "\n## {title}\n\n{note}{}{table}", if note.is_empty() { "" } else { "\n\n" });
    };
    section("Goals", "", goals(results));
    section(
        "Rows up to the finished candidates, instructions per pixel",
        "",
        frames(&measured, |frame| per_pixel(frame, frame.scan.instructions)),
    );
    section(
        "Whole frame with its report, instructions per pixel",
        "",
        frames(&measured, |frame| per_pixel(frame, frame.total().instructions)),
    );
    section(
        "A candidate to a target, instructions",
        "Edges, fits, exact centre, covariance. In the other frames: the mean, refused candidates included.",
        targets(&measured),
    );
    section(
        "Whole frame, cycles per pixel",
        ASSUMPTIONS,
        frames(&measured, |f| per_pixel(f, f.total().cycles)),
    );
    section("Whole frames per second", "The same model, times the clock.", parts(results));
    section("Bytes and proofs", "", bytes(&measured));
    if measured.iter().any(|(_, m)| !m.features.is_empty()) {
        let note = "What the library is smaller by without each of its features, compiled for size.";
        section("Bytes of the features", note, features::table(&measured));
    }
    let lean: Vec<(&Processor, &Measured)> =
        measured.iter().filter_map(|(p, m)| Some((*p, m.lean.as_deref()?))).collect();
    if !lean.is_empty() {
        section("Without features", "`default-features = false`.", lean_figures(&lean));
    }
    section("Where the instructions go", "The functions' own, of all frames together.", functions(&measured));
    section("How it was measured", "", how(results, &measured));
    page
}

/// What a look at some frames shows: the instructions of each up to the candidates, from these to targets, and for the report; then
/// those of the functions in all of them.
pub fn scene(results: &Results) -> String {
    let measured: Vec<(&Processor, &Measured)> =
        ALL.iter().filter_map(|processor| Some((processor, results.of(processor.id)?))).collect();
    let look = |title: &str, measured: &[(&Processor, &Measured)]| {
        let Some((_, first)) = measured.first() else { return String::new() };
        let rows = first.frames.iter().map(|frame| {
            let figure =
                |f: &Frame| [f.scan, f.target, f.report].map(|c| c.instructions.to_string()).join(" ");
            let figures =
                measured.iter().map(|(_, m)| m.frame(&frame.scene, frame.width).map_or("".into(), figure));
            [frame.name(), frame.targets.to_string()].into_iter().chain(figures).collect()
        });
        let frames = table(&head(&["frame", "targets"], measured), rows);
        format!("## {title}\n\n{frames}\n{}", functions(measured))
    };
    let lean: Vec<(&Processor, &Measured)> =
        measured.iter().filter_map(|(p, m)| Some((*p, m.lean.as_deref()?))).collect();
    look("With all features", &measured) + &look("Without features", &lean)
}

/// A table of Markdown.
pub fn table(head: &[String], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut table = line(head) + &line(&head.iter().map(|_| "---".to_owned()).collect::<Vec<_>>());
    table.extend(rows.into_iter().map(|row| line(&row)));
    table
}

pub fn head(first: &[&str], measured: &[(&Processor, &Measured)]) -> Vec<String> {
    let names = measured.iter().map(|(processor, _)| processor.name);
    first.iter().copied().chain(names).map(str::to_owned).collect()
}

fn per_pixel(frame: &Frame, count: u64) -> String {
    format!("{:.2}", count as f64 / frame.pixels())
}

/// The frames that are no lone target.
fn frames(measured: &[(&Processor, &Measured)], figure: impl Fn(&Frame) -> String) -> String {
    let Some((_, first)) = measured.first() else { return String::new() };
    let shown = first.frames.iter().filter(|frame| !frame.scene.starts_with("radius"));
    let rows = shown.map(|frame| {
        let figures =
            measured.iter().map(|(_, m)| m.frame(&frame.scene, frame.width).map_or("".into(), &figure));
        let name = [frame.name(), frame.targets.to_string(), frame.dropped.to_string()];
        name.into_iter().chain(figures).collect()
    });
    table(&head(&["frame", "targets", "dropped"], measured), rows)
}

fn targets(measured: &[(&Processor, &Measured)]) -> String {
    let Some((_, first)) = measured.first() else { return String::new() };
    let rows = first.frames.iter().filter(|frame| frame.targets > 0).map(|frame| {
        let figure = |f: &Frame| (f.target.instructions / u64::from(f.targets.max(1))).to_string();
        let figures =
            measured.iter().map(|(_, m)| m.frame(&frame.scene, frame.width).map_or("".into(), figure));
        [frame.name()].into_iter().chain(figures).collect()
    });
    table(&head(&["frame"], measured), rows)
}

fn parts(results: &Results) -> String {
    let scenes = ["empty", "60 targets", "60 targets, quick", "clutter", "noise"];
    let widths: Vec<u32> = [320, 640, 1280]
        .into_iter()
        .filter(|&width| results.processors.iter().any(|m| m.frame("empty", width).is_some()))
        .collect();
    let mut head = vec!["part".to_owned(), "clock, MHz".to_owned()];
    head.extend(widths.iter().map(|width| format!("{width} px wide: {}", scenes.join(" / "))));
    let rows = PARTS.iter().filter_map(|&(part, id, clock, ratio)| {
        let measured = results.of(id)?;
        let rate = |scene: &&str, width| {
            let Counts { cycles, .. } = measured.frame(scene, width)?.total();
            Some(format!("{:.1}", clock * ratio / cycles as f64))
        };
        let cells = widths.iter().map(|&width| {
            let rates: Vec<String> = scenes.iter().filter_map(|scene| rate(scene, width)).collect();
            rates.join(" / ")
        });
        Some([part.to_owned(), format!("{:.0}", clock / 1e6)].into_iter().chain(cells).collect())
    });
    table(&head, rows)
}

fn bytes(measured: &[(&Processor, &Measured)]) -> String {
    type Figure<'f> = &'f dyn Fn(&Measured) -> String;
    let optional = |bytes: Option<u64>| bytes.map_or("not determined".to_owned(), |bytes| bytes.to_string());
    let storage = |m: &Measured, width| optional(m.frame("60 targets", width).map(|frame| frame.storage));
    let yes = |yes: bool| if yes { "yes" } else { "NO" }.to_owned();
    let rows: [(&str, Figure); 14] = [
        ("storage, 320 px wide", &|m| storage(m, 320)),
        ("storage, 640 px wide", &|m| storage(m, 640)),
        ("storage, 1280 px wide", &|m| storage(m, 1280)),
        ("flash of the library, for speed", &|m| optional(m.library_flash)),
        ("flash of the library, for size (panics not proved away)", &|m| optional(m.library_flash_small)),
        ("flash of the image", &|m| m.flash.to_string()),
        ("stack, measured", &|m| m.stack.measured.to_string()),
        ("stack, bound", &|m| optional(m.stack.bound)),
        ("panic symbols", &|m| m.forbidden.panic.to_string()),
        ("heap symbols", &|m| m.forbidden.heap.to_string()),
        ("f64 symbols", &|m| m.forbidden.f64.to_string()),
        ("recursive functions", &|m| m.stack.recursion.len().to_string()),
        ("reports as on the desktop", &|m| yes(m.reports_are_equal)),
        ("two runs equal", &|m| yes(m.runs_are_equal)),
    ];
    let rows = rows.iter().map(|(name, figure)| {
        [(*name).to_owned()].into_iter().chain(measured.iter().map(|(_, m)| figure(m))).collect()
    });
    table(&head(&["bytes, or number"], measured), rows)
}

fn lean_figures(measured: &[(&Processor, &Measured)]) -> String {
    let instructions = |m: &Measured| m.frame("radius 30", 320).map(|frame| frame.target.instructions);
    let scan = |m: &Measured| m.frame("60 targets", 320).map(|f| per_pixel(f, f.scan.instructions));
    let row = |name: &str, figure: &dyn Fn(&Measured) -> Option<String>| {
        let figures = measured.iter().map(|(_, m)| figure(m).unwrap_or_default());
        [name.to_owned()].into_iter().chain(figures).collect()
    };
    let quick = |m: &Measured| m.frame("radius 30, quick", 320).map(|frame| frame.target.instructions);
    let rows: [Vec<String>; 4] = [
        row("60 targets, 320 px wide, up to the candidates, instructions per px", &scan),
        row("one target of radius 30 px, instructions", &|m| Some(instructions(m)?.to_string())),
        row("the same, quick", &|m| Some(quick(m)?.to_string())),
        row("60 targets, 320 px wide: found", &|m| Some(m.frame("60 targets", 320)?.targets.to_string())),
    ];
    let rest = bytes(measured);
    let figures = table(&head(&["figure"], measured), rows);
    figures
        + &rest
            .lines()
            .skip(2)
            .filter(|line| !line.ends_with("not determined |"))
            .fold(String::new(), |all, line| all + line + "\n")
}

fn functions(measured: &[(&Processor, &Measured)]) -> String {
    measured
        .iter()
        .map(|(processor, m)| {
            let sum: u64 = m.frames.iter().map(Frame::total).sum::<Counts>().instructions;
            let rows = m.functions.iter().map(|(name, instructions)| {
                let share = 100.0 * *instructions as f64 / sum as f64;
                vec![format!("`{name}`"), instructions.to_string(), format!("{share:.1} %")]
            });
            let head = ["function", "instructions", "share"].map(str::to_owned);
            format!("{}:\n\n{}\n", processor.name, table(&head, rows))
        })
        .collect()
}

fn goals(results: &Results) -> String {
    let mut head = vec!["figure".to_owned()];
    head.extend(CLASSES.iter().map(|(_, name)| format!("{name}: goal, measured, reached")));
    let rows = goals::all().into_iter().map(|goal| {
        let cells = CLASSES.iter().zip(goal.limits).map(|(&(class, _), limit)| {
            let digits = goal.digits;
            match goal.measured(results, class) {
                Some(figure) => {
                    let verdict = if figure <= limit { "yes" } else { "NO" };
                    format!("{limit:.digits$}, {figure:.digits$}, {verdict}")
                }
                None => format!("{limit:.digits$}, not determined"),
            }
        });
        [goal.name.clone()].into_iter().chain(cells).collect()
    });
    table(&head, rows)
}

fn how(results: &Results, measured: &[(&Processor, &Measured)]) -> String {
    let rows = measured.iter().map(|(processor, m)| {
        let Processor { package, machine, .. } = processor;
        let target = package.target.triple();
        let flags = package.cpu.map_or(String::new(), |cpu| format!("-C target-cpu={cpu}"));
        vec![
            processor.name.to_owned(),
            format!("`{target}`"),
            flags,
            machine[1].to_owned(),
            m.compiler.clone(),
        ]
    });
    let head = ["processor", "target", "flags", "machine of QEMU", "compiler"].map(str::to_owned);
    format!("{}. `cargo xtask bench`.\n\n{}", results.emulator, table(&head, rows))
}
