//! Refinement on the pixels, against the bound and against the edge points that it starts from.
//!
//! `cargo test --release -p concentric-host --test refine -- --nocapture` prints the figures; `CONCENTRIC_TRIALS=500` takes
//! that many frames a cell instead of a few.

mod common;

use common::{detect_with, errors};
use concentric::{
    Camera, Compensation, Distortion, Flags, Image, Settings, Target, TargetSpec, refine::polish,
};
use concentric_host::accuracy::bound::{Bounds, per_coordinate};
use concentric_host::render::{Frame, Scene, Shading};

fn trials(few: u32) -> u32 {
    std::env::var("CONCENTRIC_TRIALS").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

fn settings() -> Settings {
    Settings::new(TargetSpec::ring(0.5).expect("0.5 is a ratio"))
}

fn image(frame: &Frame) -> Image<'_> {
    Image::new(&frame.pixels, frame.width as u16, frame.height as u16).expect("size of a frame")
}

/// Root of the mean square error of one coordinate, px, for the edge points and for the pixels, and the bound.
#[derive(Default)]
struct Figures {
    edges: f64,
    pixels: f64,
    normalised: f64,
    bound: f64,
    frames: f64,
    refined: u32,
}

impl Figures {
    fn of(radius: f64, tilt: f64, frames: u32, mut change: impl FnMut(&mut Scene)) -> Self {
        let mut figures = Self::default();
        for trial in 0..frames {
            let turn = |step: f64| (f64::from(trial) * step + radius * 0.37 + tilt * 0.11).fract();
            let phase = [turn(0.618_034) - 0.5, turn(0.754_878) - 0.5];
            let mut scene = Scene::single(radius * 800.0 / 2580.645, tilt, 360.0 * turn(0.381_966), phase);
            (scene.photometry.black, scene.photometry.white) = (40.37, 190.21);
            scene.photometry.blur = 0.7;
            change(&mut scene);
            figures.add(&scene, u64::from(trial));
        }
        for sum in [&mut figures.edges, &mut figures.pixels] {
            *sum = (*sum / figures.frames / 2.0).sqrt();
        }
        figures.bound = (figures.bound / figures.frames).sqrt();
        figures.normalised = (figures.normalised / figures.frames / 2.0).sqrt();
        figures
    }

    fn add(&mut self, scene: &Scene, seed: u64) {
        let frame = scene.render(seed);
        let (targets, _) = detect_with(&frame, settings());
        let (found, false_targets) = errors(&targets, &frame.truth);
        assert_eq!((found.len(), false_targets), (1, 0));
        let (dx, dy, target) = found[0];
        self.edges += dx * dx + dy * dy;
        let mut better = target.clone();
        self.refined += u32::from(polish(&image(&frame), &settings(), &mut better));
        let (mx, my) = better.centre.offset_from(target.centre);
        let (dx, dy) = (dx - f64::from(mx), dy - f64::from(my));
        self.pixels += dx * dx + dy * dy;
        let c = better.covariance;
        let (xx, xy, yy) = (f64::from(c.xx), f64::from(c.xy), f64::from(c.yy));
        self.normalised += (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy);
        let bounds = Bounds::new(&frame.truth.targets[0], &scene.camera, &scene.photometry, &|_| true)
            .expect("visible");
        self.bound += per_coordinate(bounds.centre).powi(2);
        self.frames += 1.0;
    }
}

/// Cells of all kinds: radius, tilt, blur, noise, shading over the target.
const CELLS: [(f64, f64, f64, f64, f64); 8] = [
    (10.0, 0.0, 0.7, 2.0, 0.0),
    (20.0, 45.0, 0.7, 2.0, 0.3),
    (30.0, 45.0, 0.4, 2.0, 0.0),
    (30.0, 45.0, 0.7, 5.0, 0.1),
    (30.0, 60.0, 1.5, 2.0, 0.0),
    (50.0, 30.0, 1.0, 1.0, 0.1),
    (100.0, 15.0, 0.7, 2.0, 0.0),
    (20.0, 60.0, 1.0, 0.5, 0.0),
];

#[test]
fn pixels_reach_the_bound() {
    let (mut ratios, mut sigmas) = (0.0, 0.0);
    for (radius, tilt, blur, noise, shading) in CELLS {
        let figures = Figures::of(radius, tilt, trials(30), |scene| {
            (scene.photometry.blur, scene.photometry.noise) = (blur, noise);
            let (x, y) = (scene.camera.cx, scene.camera.cy);
            scene.photometry.shading =
                Some(Shading { fraction: shading, span: 2.0 * radius, direction: 30.0, x, y });
        });
        let Figures { edges, pixels, bound, normalised, .. } = figures;
        println!(
            "R {radius} tilt {tilt} blur {blur} noise {noise} shading {shading}: edge points {:.3}, pixels {:.3} of the bound, \
             {normalised:.2} sigma",
            edges / bound,
            pixels / bound
        );
        assert_eq!(f64::from(figures.refined), figures.frames);
        assert!(pixels < 1.3 * bound, "{pixels} of {bound}");
        ratios += pixels / bound / CELLS.len() as f64;
        sigmas += normalised / CELLS.len() as f64;
    }
    println!("mean of the cells: {ratios:.3} of the bound, {sigmas:.3} sigma");
    // Edge points alone stand at 1.06 and more: without a gain from the pixels this fails.
    assert!((0.93..1.045).contains(&ratios), "{ratios}");
    assert!((0.93..1.05).contains(&sigmas), "{sigmas}");
}

/// A bright side that is clipped, under light that changes by 30 % over the target: both stages leave the clipped levels out.
/// With them the centre would be off by a tenth of a pixel and more.
#[test]
fn clipped_pixels_are_left_out() {
    let (mut worst, mut flagged) = (0.0f64, 0);
    let frames = trials(20);
    let mut normalised = 0.0;
    let figures = Figures::of(30.0, 45.0, frames, |scene| {
        let (x, y) = (scene.camera.cx, scene.camera.cy);
        scene.photometry.gain = 1.5;
        scene.photometry.shading = Some(Shading { fraction: 0.3, span: 60.0, direction: 30.0, x, y });
        let frame = scene.render(1);
        let (targets, _) = detect_with(&frame, settings());
        let (found, _) = errors(&targets, &frame.truth);
        let (dx, dy, target) = found[0];
        flagged += u32::from(target.flags.contains(Flags::CLIPPED));
        worst = worst.max(dx.hypot(dy));
        normalised += (dx * dx + dy * dy) / f64::from(target.covariance.xx + target.covariance.yy);
    });
    normalised = (normalised / f64::from(frames)).sqrt();
    println!(
        "clipped: edge points {:.1} of the bound and {normalised:.1} of their sigma, pixels {:.2} and {:.2}",
        figures.edges / figures.bound,
        figures.pixels / figures.bound,
        figures.normalised
    );
    assert_eq!(flagged, frames);
    assert!(worst < 0.03 && normalised < 2.0, "{worst} px, {normalised} sigma");
    assert!(figures.edges < 1.7 * figures.bound, "{}", figures.edges / figures.bound);
    assert!(figures.pixels < 1.7 * figures.bound, "{}", figures.pixels / figures.bound);
}

/// The same frame shifted by some pixels, or another one, is not what was measured.
#[test]
fn another_image_leaves_the_target_alone() {
    let scene = Scene::single(10.0, 30.0, 20.0, [0.2, 0.3]);
    let frame = scene.render(1);
    let (targets, _) = detect_with(&frame, settings());
    let mut target = targets[0].clone();
    let mut shifted = frame.clone();
    shifted.pixels.rotate_right(6);
    for other in [&shifted, &Scene::empty(scene.camera).render(1)] {
        assert!(!polish(&image(other), &settings(), &mut target));
        assert_eq!(target, targets[0]);
    }
    assert!(polish(&image(&frame), &settings(), &mut target));
    assert!(target.flags.contains(Flags::REFINED) && !targets[0].flags.contains(Flags::REFINED));
    let nothing = Target::default();
    let mut empty = nothing.clone();
    assert!(!polish(&image(&frame), &settings(), &mut empty) && empty == nothing);
}

/// With a camera the model is bent as the lens bends the image.
#[test]
fn a_lens_is_part_of_the_model() {
    let mut scene = Scene::single(20.0, 45.0, 60.0, [450.3, 330.6]);
    scene.camera.f = 1000.0;
    scene.camera.distortion.k1 = -0.2;
    scene.targets[0].pose.distance = 350.0;
    scene.photometry.noise = 0.5;
    let frame = scene.render(1);
    let error = |settings: &Settings| {
        let (targets, _) = detect_with(&frame, *settings);
        let mut target = targets[0].clone();
        assert!(polish(&image(&frame), settings, &mut target));
        let (found, _) = errors(core::slice::from_ref(&target), &frame.truth);
        found[0].0.hypot(found[0].1)
    };
    let (f, cx, cy) = (scene.camera.f as f32, scene.camera.cx as f32, scene.camera.cy as f32);
    let lens = Distortion { k1: -0.2, ..Distortion::default() };
    let camera = Camera::new(f, f, cx, cy).and_then(|camera| camera.distortion(lens)).expect("a camera");
    let exact = settings().camera(camera);
    let known = exact.compensation(Compensation::Known);
    let (plain, undistorted, known) = (error(&settings()), error(&exact), error(&known));
    println!(
        "k1 -0.2, R 57: as it is {plain:.4}, undistorted {undistorted:.4}, with the known camera {known:.4} px"
    );
    assert!(undistorted < 0.003 && known < 0.002, "{undistorted} {known}");
}
