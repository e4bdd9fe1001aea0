//! An ideal library reaches every goal, and each goal sees what it is there for.

use concentric::Flags;
use glam::{DMat2, DVec2};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::{Pcg64, rand_core::SeedableRng};

use super::{Goal, goals};
use crate::accuracy::{
    cell::Cell,
    grid::Extent,
    method::{METHODS, QUICK, REFINED},
    run::{Estimate, Group, Outcome, Sample},
    study::Study,
};

/// What a library does wrong.
#[derive(Clone, Copy)]
struct Fault {
    /// Of every error.
    factor: f64,
    /// Of those of some methods once more.
    method: (&'static str, f64),
    /// Along the axis, px, where the cell is `concerned`.
    shift: f64,
    concerned: fn(&Cell) -> bool,
    /// Of the reported standard deviation.
    sigma: f64,
    missed: bool,
    flags: Flags,
}

const NONE: Fault = Fault {
    factor: 1.0,
    method: ("", 1.0),
    shift: 0.0,
    concerned: |_| true,
    sigma: 1.0,
    missed: false,
    flags: Flags(Flags::CLIPPED.0 | Flags::REFINED.0 | Flags::OCCLUDED.0),
};

/// Bound of every cell, px: small enough for all goals, and smaller still with little noise.
fn bound(cell: &Cell) -> f64 {
    if cell.noise < 1.0 { 1e-4 } else { 1e-3 }
}

/// Errors of a method as a share of those of the exact form.
fn ideal(method: &str) -> f64 {
    match method {
        "known" | "known-refined" => 0.43,
        "pooled" => 0.5,
        _ => 1.0,
    }
}

fn outcome(cell: Cell, fault: Fault) -> Outcome {
    let mut random = Pcg64::seed_from_u64(cell.label().len() as u64);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let sigma = bound(&cell);
    let shift = if (fault.concerned)(&cell) { fault.shift } else { 0.0 };
    let group = |index: u32, normal: &mut dyn FnMut() -> f64| {
        let axis = DVec2::from_angle(2.4 * f64::from(index));
        let sample = |_| {
            let error = sigma * fault.factor * DVec2::new(normal(), normal()) + axis * shift;
            let reported = (sigma * fault.sigma).powi(2);
            let estimate = Estimate {
                error,
                normalised: error.length_squared() / reported,
                reported,
                flags: fault.flags,
            };
            let found = !fault.missed || index > 0;
            let by_method = |name: &str| {
                let factor = ideal(name) * if name == fault.method.0 { fault.method.1 } else { 1.0 };
                Estimate { error: error * factor, ..estimate }
            };
            let estimates = METHODS.map(|method| found.then(|| by_method(method.name)));
            Sample { estimates, wrong: 0, control: 0.0 }
        };
        Group {
            bounds: [DMat2::IDENTITY * (sigma * sigma); METHODS.len()],
            eccentricity: 0.0,
            phase: DVec2::ZERO,
            axis,
            dithered: false,
            samples: (0..cell.draws).map(sample).collect(),
        }
    };
    let groups = (0..cell.scenes(500) * cell.targets).map(|index| group(index, &mut normal)).collect();
    Outcome { cell, groups }
}

fn goals_with(fault: Fault) -> Vec<Goal> {
    let cells = Extent::Full.cells();
    goals(&Study { frames: 500, outcomes: cells.into_iter().map(|cell| outcome(cell, fault)).collect() })
}

/// The goals that are not reached with this fault are those whose names hold one of `expected`.
fn assert_fails(fault: Fault, expected: &[&str]) {
    for goal in goals_with(fault) {
        let wanted = !expected.iter().any(|part| goal.figure.contains(part));
        assert_eq!(goal.reached, wanted, "{goal:?}");
    }
}

#[test]
fn an_ideal_library_reaches_all() {
    assert_eq!(goals_with(NONE).len(), 33);
    assert_fails(NONE, &[]);
}

#[test]
fn larger_errors_are_seen() {
    let fault = Fault { factor: 1.04, sigma: 1.04, ..NONE };
    assert_fails(fault, &["range, refined: RMS / bound, average"]);
    let fault = Fault { factor: 1.1, sigma: 1.1, ..NONE };
    let averages = ["range, streaming: RMS / bound, average", "range, refined: RMS / bound"];
    assert_fails(fault, &[&averages[..], &["known camera"]].concat());
    let fault = Fault { factor: 1.3, sigma: 1.3, ..NONE };
    assert_fails(
        fault,
        &[
            "average",
            "range, streaming: RMS / bound, worst",
            "range, refined: RMS / bound, worst",
            "range, quick: RMS / bound, worst",
            "known camera",
        ],
    );
    // The goals for the pooled set are in px.
    let fault = Fault { factor: 10.0, sigma: 10.0, ..NONE };
    let all = [
        "average",
        "RMS / bound, worst cell",
        "known camera",
        "hidden",
        "noise 0:",
        "noise 1:",
        "noise 2:",
        "noise 5:",
    ];
    assert_fails(fault, &all);
}

#[test]
fn each_method_is_seen() {
    let of = |method, factor| Fault { method: (method, factor), ..NONE };
    assert_fails(of("auto", 1.15), &["Auto"]);
    assert_fails(of(QUICK, 1.2), &["range, quick: RMS / bound, average"]);
    assert_fails(of("exact-any", 1.03), &["ratio not given"]);
    assert_fails(of("known", 1.1), &["known camera"]);
    assert_fails(of("known-refined", 1.1), &["known camera"]);
    assert_fails(of("pooled", 1.1), &["one plane"]);
    let spoilt = ["range, refined: RMS / bound", "overexposed, shading", "hidden"];
    assert_fails(of(REFINED, 1.6), &spoilt);
}

#[test]
fn wrong_uncertainties_are_seen() {
    assert_fails(Fault { sigma: 0.8, ..NONE }, &["reported"]);
    assert_fails(Fault { sigma: 1.25, ..NONE }, &["reported"]);
}

#[test]
fn shifts_are_seen() {
    let shifted = |concerned| Fault { shift: 1e-3, concerned, ..NONE };
    assert_fails(shifted(|cell| cell.slice == "bias" && cell.shading > 0.0), &["shading 30 %: "]);
    assert_fails(shifted(|cell| cell.slice == "bias" && cell.gamma != 1.0), &["gamma"]);
    assert_fails(shifted(|cell| cell.slice == "bias" && cell.k1 != 0.0), &["k1"]);
    let plain =
        |cell: &Cell| cell.slice == "bias" && cell.shading == 0.0 && cell.gamma == 1.0 && cell.k1 == 0.0;
    assert_fails(shifted(plain), &["noise-free"]);
    // A bias of a tenth of what the rows may leave.
    assert_fails(Fault { shift: 0.1e-3, concerned: plain, ..NONE }, &["refined, mean"]);
}

#[test]
fn missed_targets_and_flags_are_seen() {
    assert_fails(Fault { missed: true, ..NONE }, &["targets found", "pooled set"]);
    assert_fails(Fault { flags: Flags::default(), ..NONE }, &["clipped", "are refined", "hidden"]);
}
