//! `Effort::Quick`: what is found is the same, nearly as good where nothing disturbs a target, and the same to the bit where
//! something does.

mod common;

use common::{detect_with, errors};
use concentric::{Camera, Code, Compensation, Effort, Settings, TargetSpec};
use concentric_host::render::{Frame, Scene, Shading};

fn both(frame: &Frame, settings: Settings) -> [Vec<concentric::Target>; 2] {
    [Effort::Full, Effort::Quick].map(|effort| detect_with(frame, settings.effort(effort)).0)
}

fn ring() -> Settings {
    Settings::new(TargetSpec::ring(0.5).expect("a ratio"))
}

/// RMS distance from the true centres, px, of both, with the number of targets that were measured in another way.
fn compare(scenes: impl Iterator<Item = Scene>, settings: Settings) -> ([f64; 2], usize) {
    let (mut squares, mut count, mut other) = ([0.0; 2], 0, 0);
    for (seed, scene) in scenes.enumerate() {
        let frame = scene.render(seed as u64);
        let targets = both(&frame, settings);
        let [full, quick] = targets.each_ref().map(|targets| errors(targets, &frame.truth));
        assert_eq!((full.0.len(), full.1), (frame.truth.targets.len(), 0), "scene {seed}");
        assert_eq!((quick.0.len(), quick.1), (full.0.len(), 0), "scene {seed}");
        for (full, quick) in full.0.iter().zip(&quick.0) {
            squares[0] += full.0 * full.0 + full.1 * full.1;
            squares[1] += quick.0 * quick.0 + quick.1 * quick.1;
            other += usize::from(full.2.centre != quick.2.centre);
            count += 1;
        }
    }
    (squares.map(|square| (square / count as f64).sqrt()), other)
}

#[test]
fn targets_are_found_with_a_little_more_error() {
    let scenes = (0..10).map(|seed| Scene::many(20, 1280, 1024, true, seed).expect("room"));
    let ([full, quick], other) = compare(scenes, ring());
    assert!(quick < 1.25 * full, "{quick} px, in full {full}");
    assert!(other > 150, "only {other} of 200 were quick");
}

/// A single target in the conditions that `change` makes.
fn singles(change: impl Fn(&mut Scene)) -> impl Iterator<Item = Scene> {
    (0..20).map(move |i| {
        let phase = [f64::from(i) * 0.618 % 1.0 - 0.5, f64::from(i) * 0.414 % 1.0 - 0.5];
        let mut scene = Scene::single(f64::from(20 + i), 45.0, 18.0 * f64::from(i), phase);
        change(&mut scene);
        scene
    })
}

#[test]
fn shaded_targets_are_measured_quickly() {
    let shading = |fraction: f64| {
        move |scene: &mut Scene| {
            let target = scene.truth(0).targets[0].circles[0].ellipse;
            let span = 2.0 * target.a;
            scene.photometry.shading =
                Some(Shading { fraction, span, direction: 70.0, x: target.x, y: target.y });
        }
    };
    for fraction in [0.1, 0.3] {
        let ([full, quick], other) = compare(singles(shading(fraction)), ring());
        assert!(other >= 18 && quick < 1.3 * full, "{fraction}: {quick} px, in full {full}, {other} quick");
    }
}

#[test]
fn what_is_disturbed_is_measured_in_full() {
    type Change = fn(&mut Scene);
    let conditions: [(&str, Change); 4] = [
        ("blurred", |scene| scene.photometry.blur = 2.0),
        ("noisy", |scene| scene.photometry.noise = 15.0),
        ("overexposed", |scene| scene.photometry.gain = 2.0),
        ("hidden", |scene| scene.hide(0, 0.2, 30.0, 0.5)),
    ];
    for (name, change) in conditions {
        let (_, quick) = compare(singles(change), ring());
        assert_eq!(quick, 0, "{name}");
    }
    let (_, quick) = compare(singles(|_| ()), ring());
    assert_eq!(quick, 20);
}

#[test]
fn coded_targets_and_any_form_are_measured_quickly() {
    let frame = singles(|_| ()).next().expect("a scene").render(1);
    for form in [Compensation::None, Compensation::Eq7, Compensation::Exact, Compensation::Auto] {
        let [full, quick] = both(&frame, ring().compensation(form));
        let (from, to) = (full[0].centre, quick[0].centre);
        let off = f64::hypot(f64::from(from.x - to.x), f64::from(from.y - to.y)) / 65536.0;
        let sigma = f64::from(full[0].covariance.xx + full[0].covariance.yy).sqrt();
        assert!(from != to && off < 3.0 * sigma, "{form:?}: {off} px, sigma {sigma}");
        assert_eq!(both(&frame, ring().compensation(form).code(Code::cct14()))[1], quick, "{form:?}");
    }
}

#[test]
fn a_known_camera_measures_in_full() {
    let frame = singles(|_| ()).next().expect("a scene").render(1);
    let camera = Camera::new(2581.0, 2581.0, 640.0, 512.0).expect("a camera");
    let [full, quick] = both(&frame, ring().compensation(Compensation::Known).camera(camera));
    assert_eq!(full, quick);
}
