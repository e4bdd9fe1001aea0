//! An ideal library reaches every goal, and each goal sees what it is there for.

use concentric::Flags;
use glam::{DMat2, DVec2};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::{Pcg64, rand_core::SeedableRng};

use super::{Goal, goals};
use crate::accuracy::{
    cell::Cell,
    grid::Extent,
    method::METHODS,
    run::{Estimate, Group, Outcome, Sample},
    study::Study,
};

/// What a library does wrong.
#[derive(Clone, Copy)]
struct Fault {
    /// Of every error.
    factor: f64,
    /// Of those of `Auto` once more.
    auto: f64,
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
    auto: 1.0,
    shift: 0.0,
    concerned: |_| true,
    sigma: 1.0,
    missed: false,
    flags: Flags::CLIPPED,
};

/// Bound of every cell, px: small enough for all goals, and smaller still with little noise.
fn bound(cell: &Cell) -> f64 {
    if cell.noise < 1.0 { 1e-4 } else { 1e-3 }
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
            let estimate = Estimate { error, normalised: error.length_squared() / reported, reported };
            let auto = Estimate { error: error * fault.auto, ..estimate };
            let found = !fault.missed || index > 0;
            let estimates =
                METHODS.map(|method| found.then_some(if method.name == "auto" { auto } else { estimate }));
            Sample { estimates, flags: fault.flags, wrong: 0 }
        };
        Group {
            bounds: [DMat2::IDENTITY * (sigma * sigma); METHODS.len()],
            eccentricity: 0.0,
            phase: DVec2::ZERO,
            axis,
            samples: (0..cell.draws).map(sample).collect(),
        }
    };
    let groups = (0..cell.scenes(500)).map(|index| group(index, &mut normal)).collect();
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
    assert_eq!(goals_with(NONE).len(), 18);
    assert_fails(NONE, &[]);
}

#[test]
fn larger_errors_are_seen() {
    let fault = Fault { factor: 1.1, sigma: 1.1, ..NONE };
    assert_fails(fault, &["average"]);
    let fault = Fault { factor: 1.3, sigma: 1.3, ..NONE };
    assert_fails(fault, &["average", "worst cell"]);
    // The goals for the pooled set are in px.
    let fault = Fault { factor: 10.0, sigma: 10.0, ..NONE };
    assert_fails(fault, &["average", "worst cell", "noise 0:", "noise 1:", "noise 2:", "noise 5:"]);
}

#[test]
fn a_bad_choice_is_seen() {
    assert_fails(Fault { auto: 1.15, ..NONE }, &["Auto"]);
}

#[test]
fn wrong_uncertainties_are_seen() {
    assert_fails(Fault { sigma: 0.8, ..NONE }, &["reported"]);
    assert_fails(Fault { sigma: 1.25, ..NONE }, &["reported"]);
}

#[test]
fn shifts_are_seen() {
    let shifted = |concerned| Fault { shift: 1e-3, concerned, ..NONE };
    assert_fails(shifted(|cell| cell.slice == "bias" && cell.shading > 0.0), &["shading"]);
    assert_fails(shifted(|cell| cell.slice == "bias" && cell.gamma != 1.0), &["gamma"]);
    assert_fails(shifted(|cell| cell.slice == "bias" && cell.k1 != 0.0), &["k1"]);
    let plain =
        |cell: &Cell| cell.slice == "bias" && cell.shading == 0.0 && cell.gamma == 1.0 && cell.k1 == 0.0;
    assert_fails(shifted(plain), &["noise-free"]);
}

#[test]
fn missed_targets_and_flags_are_seen() {
    assert_fails(Fault { missed: true, ..NONE }, &["found", "pooled"]);
    assert_fails(Fault { flags: Flags::default(), ..NONE }, &["clipped"]);
}
