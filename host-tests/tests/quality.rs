//! What a target says of its own quality, on rendered frames: each value is right, each flag goes on and off.

mod common;

use common::detect;
use concentric::{Flags, Target, TargetSpec};
use concentric_host::render::{Artwork, Camera, Frame, Pose, Scene, Target as Printed};

/// One annulus of ratio 0.5 and this outer semi-axis, px, in the middle of 320 x 240 px, seen from the front.
fn scene(radius: f64) -> Scene {
    let camera = Camera::new(320, 240, 1000.0);
    let pose = Pose { x: 160.3, y: 120.4, distance: 1000.0, tilt: 0.0, azimuth: 20.0 };
    let mut scene = Scene::empty(camera);
    let artwork = Artwork::annulus(radius, radius / 2.0);
    scene.targets.push(Printed { artwork, pose, at: [0.0, 0.0] });
    scene
}

fn measured(frame: &Frame, spec: TargetSpec) -> Target {
    let (mut targets, summary) = detect(frame, spec);
    assert_eq!(targets.len(), 1, "{summary:?}");
    targets.remove(0)
}

fn target(radius: f64, change: impl Fn(&mut Scene)) -> Target {
    let mut scene = scene(radius);
    change(&mut scene);
    measured(&scene.render(5), TargetSpec::any())
}

fn has(target: &Target, flag: Flags) -> bool {
    target.flags.contains(flag)
}

/// A shadow on the rim of the outer circle of 60 px, within `half` degrees of the direction of +x, with a border of `soft`
/// degrees: the paper there is less than half as light as elsewhere, so that no edge point can be placed.
fn shadowed(half: f64, soft: f64) -> Frame {
    let mut frame = scene(60.0).render(5);
    for (i, pixel) in frame.pixels.iter_mut().enumerate() {
        let (x, y) = ((i % frame.width) as f64 - 160.3, (i / frame.width) as f64 - 120.4);
        if x.hypot(y) > 50.0 {
            // Half of the depth at `half`; the shadow's own border must be no edge.
            let depth = 1.0 / (1.0 + ((y.atan2(x).abs().to_degrees() - half) / soft).exp());
            *pixel = 30 + ((1.0 - 0.7 * depth) * (f64::from(*pixel) - 30.0)) as u8;
        }
    }
    frame
}

#[test]
fn noise_is_that_of_the_sensor_and_of_rounding() {
    for noise in [1.0, 2.0, 5.0, 10.0] {
        let found = f64::from(target(40.0, |scene| scene.photometry.noise = noise).noise);
        let wanted = f64::sqrt(noise * noise + 1.0 / 12.0);
        println!("noise {noise}: {found:.3} for {wanted:.3}");
        // The means of stretches are whole levels, in which a noise of one level is partly lost.
        assert!((found / wanted - 1.0).abs() < 0.16, "noise {noise}: {found} for {wanted}");
    }
}

#[test]
fn contrast_and_blur_are_those_of_the_scene() {
    for (black, white, blur) in [(30.0, 220.0, 0.5), (60.0, 130.0, 0.8), (20.0, 120.0, 1.5)] {
        let target = target(40.0, |scene| {
            (scene.photometry.black, scene.photometry.white, scene.photometry.blur) = (black, white, blur);
        });
        // The pixel's box adds 1/12 px^2.
        let total = f64::sqrt(blur * blur + 1.0 / 12.0);
        println!("contrast {:.2}, blur {:.3} for {total:.3}", target.contrast, target.blur);
        assert!((f64::from(target.contrast) - (white - black)).abs() < 1.0, "{}", target.contrast);
        assert!((f64::from(target.blur) / total - 1.0).abs() < 0.05, "{} for {total}", target.blur);
    }
}

#[test]
fn residual_follows_the_noise_and_the_flag_what_it_does_not_explain() {
    for (noise, contrast) in [(0.0, 190.0), (2.0, 190.0), (5.0, 190.0), (3.0, 40.0)] {
        let target = target(40.0, |scene| {
            scene.photometry.noise = noise;
            scene.photometry.white = scene.photometry.black + contrast;
        });
        let s = f64::from(target.blur);
        let wanted = f64::sqrt(3.545 * s * (noise * noise + 1.0 / 12.0)) / contrast;
        println!("noise {noise}: residual {:.4} for {wanted:.4}", target.residual());
        assert!((0.7..1.3).contains(&(f64::from(target.residual()) / wanted)), "{}", target.residual());
        assert!(!has(&target, Flags::RESIDUAL), "noise {noise}");
        let rms = target.circles.iter().map(|circle| circle.rms);
        assert!(
            rms.clone().any(|rms| rms <= target.residual())
                && rms.clone().any(|rms| rms >= target.residual())
        );
    }
    // A printer that stretches one side: the outline is no ellipse by a third of a pixel.
    let mut frame = scene(60.0).render(5);
    let shift = |frame: &mut Frame, row: usize| {
        let pixels = &mut frame.pixels[row * 320..][..320];
        for x in (1..320).rev() {
            let [left, here] = [pixels[x - 1], pixels[x]].map(f64::from);
            pixels[x] = (here + 0.35 * (left - here)).round() as u8;
        }
    };
    (0..120).for_each(|row| shift(&mut frame, row));
    let target = measured(&frame, TargetSpec::any());
    println!("sheared: residual {:.4}", target.residual());
    assert!(has(&target, Flags::RESIDUAL), "{}", target.residual());
}

#[test]
fn gap_is_the_angle_of_the_missing_arc() {
    let whole = target(60.0, |_| ());
    assert_eq!(whole.gap(), 0.0);
    assert!(!has(&whole, Flags::OCCLUDED));
    let small = measured(&shadowed(3.0, 2.0), TargetSpec::any());
    let large = measured(&shadowed(35.0, 6.0), TargetSpec::any());
    // To where the light differs by 6 % of the contrast: less moves the edge by a tenth of a pixel at most.
    let reach = |half: f64, soft: f64| 2.0 * (half + soft * (0.7 / 0.06_f64 - 1.0).ln());
    for (target, degrees) in [(&small, reach(3.0, 2.0)), (&large, reach(35.0, 6.0))] {
        println!(
            "{degrees} degrees in shadow: gaps {:?}",
            target.circles.iter().map(|c| c.gap).collect::<Vec<_>>()
        );
        assert!((f64::from(target.gap()) - degrees).abs() <= 14.0, "{} for {degrees}", target.gap());
        assert_eq!(target.gap(), target.circles[0].gap);
        assert_eq!(target.circles[1].gap, 0.0);
    }
    assert!(!has(&small, Flags::OCCLUDED) && has(&large, Flags::OCCLUDED));
}

#[test]
fn ratios_are_measured_also_where_they_are_given() {
    let mut scene = scene(40.0);
    scene.targets[0].artwork = Artwork::annulus(40.0, 20.12);
    let frame = scene.render(5);
    let any = measured(&frame, TargetSpec::any());
    let known = measured(&frame, TargetSpec::ring(0.5).unwrap());
    for target in [&any, &known] {
        assert!(
            (target.circles[1].measured_ratio - 0.503).abs() < 5e-4,
            "{}",
            target.circles[1].measured_ratio
        );
        assert_eq!(target.circles[0].measured_ratio, 1.0);
    }
    assert_eq!(any.circles[1].ratio, any.circles[1].measured_ratio);
    assert_eq!(known.circles[1].ratio, 0.5);
    assert!(has(&any, Flags::MEASURED_RATIO) && !has(&known, Flags::MEASURED_RATIO));
}

/// f rho^2 (R / f)^4 sin^3 cos for the ratio 0.5.
#[test]
fn model_difference_is_what_eq7_leaves() {
    let tilted = |radius: f64| {
        target(radius, |scene| {
            scene.targets[0].pose.tilt = 60.0;
            scene.photometry.noise = 0.0;
        })
    };
    let wanted = |radius: f64| 1000.0 * 0.25 * (radius / 1000.0).powi(4) * 0.6495 * 0.5;
    for radius in [50.0, 100.0] {
        let (found, wanted) = (f64::from(tilted(radius).model_difference()), wanted(radius));
        println!("R {radius}: model difference {found:.5} for {wanted:.5}");
        assert!((found - wanted).abs() < 0.06 * wanted + 2e-5, "R {radius}: {found} for {wanted}");
    }
}

#[test]
fn clipped_is_told_at_either_end() {
    let lit = |black: f64, white: f64| {
        target(40.0, |scene| (scene.photometry.black, scene.photometry.white) = (black, white))
    };
    for (black, white, clipped) in
        [(30.0, 220.0, false), (30.0, 246.0, false), (30.0, 255.0, true), (0.0, 200.0, true)]
    {
        assert_eq!(has(&lit(black, white), Flags::CLIPPED), clipped, "{black} to {white}");
    }
    let over = target(40.0, |scene| scene.photometry.gain = 1.4);
    assert!(has(&over, Flags::CLIPPED));
}

#[test]
fn low_contrast_is_below_40_levels() {
    for (contrast, low) in [(30.0, true), (37.0, true), (43.0, false), (190.0, false)] {
        let target = target(40.0, |scene| {
            scene.photometry.noise = 1.0;
            scene.photometry.white = scene.photometry.black + contrast;
        });
        assert_eq!(has(&target, Flags::LOW_CONTRAST), low, "{contrast}: {}", target.contrast);
    }
}

#[test]
fn small_is_a_hole_or_a_gap_below_4_px() {
    for (outer, inner, small) in
        [(7.4, 3.7, true), (8.6, 4.3, false), (20.0, 16.4, true), (20.0, 15.5, false), (40.0, 20.0, false)]
    {
        let target = target(outer, |scene| scene.targets[0].artwork = Artwork::annulus(outer, inner));
        assert_eq!(has(&target, Flags::SMALL), small, "{outer} {inner}");
    }
}

#[test]
fn light_is_the_polarity() {
    let frame = scene(40.0).render(5);
    assert!(!has(&measured(&frame, TargetSpec::any()), Flags::LIGHT));
    let pixels = frame.pixels.iter().map(|grey| 255 - grey).collect();
    let inverse = Frame { pixels, ..frame };
    assert!(has(&measured(&inverse, TargetSpec::any().light()), Flags::LIGHT));
}
