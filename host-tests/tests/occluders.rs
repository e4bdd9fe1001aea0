//! What lies over the targets: the picture and the truth agree.

use concentric_host::render::{Cover, Ellipse, Occluder, Scene, Truth};
use glam::DVec2;
use std::f64::consts::PI;

/// Radius mm, tilt and azimuth in degrees, phase px.
const POSES: [(f64, f64, f64, [f64; 2]); 4] = [
    (24.0, 0.0, 0.0, [0.0, 0.0]),
    (60.0, 45.0, 0.0, [0.37, -0.21]),
    (20.0, 72.0, 33.0, [0.5, 0.5]),
    (40.0, 60.0, 117.0, [200.3, -100.8]),
];

/// A wedge hides the same share of every circle, whatever the pose, and what the truth says is seen can be seen.
#[test]
fn hidden_arcs_are_what_the_picture_hides() {
    let mut checked = 0;
    for (radius, tilt, azimuth, phase) in POSES {
        for (share, direction) in [(0.1, 0.0), (0.4, 77.0), (0.75, 271.0)] {
            let mut scene = Scene::single(radius, tilt, azimuth, phase);
            (scene.photometry.noise, scene.photometry.blur) = (0.0, 0.3);
            let bare = scene.levels();
            scene.hide(0, share, direction, 0.5);
            let covered = scene.levels();
            for circle in &scene.truth(1).targets[0].circles {
                assert!((circle.hidden - share).abs() < 1e-6, "{} of {share}", circle.hidden);
                let [[from, to]] = circle.visible[..] else { panic!("{:?}", circle.visible) };
                assert!((0.0..360.0).contains(&from) && to > from && to < from + 360.0);
                // Just inside either end the picture is untouched, just outside it is not.
                let margin = (5.0 / circle.ellipse.b).to_degrees();
                if margin > 90.0 * share {
                    continue;
                }
                for (at, seen) in
                    [(from + margin, true), (to - margin, true), (from - margin, false), (to + margin, false)]
                {
                    let place = towards(&circle.ellipse, at.to_radians());
                    let pixel = place.y.round() as usize * bare.width + place.x.round() as usize;
                    let around = [0, 1, bare.width, bare.width + 1].map(|i| pixel + i);
                    let change = around.map(|i| (covered.values[i] - bare.values[i]).abs());
                    let same = change.iter().all(|change| *change < 1.0);
                    assert_eq!(same, seen, "{radius} {tilt} {share} {direction}: {at}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 60, "{checked}");
}

/// The point of the ellipse in this direction from its centre.
fn towards(e: &Ellipse, direction: f64) -> DVec2 {
    let local = DVec2::from_angle(direction - e.theta);
    let reach = 1.0 / DVec2::new(local.x / e.a, local.y / e.b).length();
    DVec2::new(e.x, e.y) + reach * DVec2::from_angle(direction)
}

#[test]
fn strips_discs_glare_and_the_frame_hide_what_they_cover() {
    let mut scene = Scene::single(24.0, 0.0, 0.0, [0.0, 0.0]);
    let (x, y) = (scene.camera.cx, scene.camera.cy);
    let hidden =
        |scene: &Scene| scene.truth(1).targets[0].circles.iter().map(|c| c.hidden).collect::<Vec<_>>();
    assert_eq!(hidden(&scene), [0.0, 0.0]);
    let [large, small] = [0, 1].map(|i| scene.truth(1).targets[0].circles[i].ellipse.a);
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-4, "{found} for {wanted}");
    let one = |cover: Cover| {
        let mut scene = scene.clone();
        scene.occluders = vec![Occluder { cover, tone: 0.0 }];
        scene
    };
    // A strip through the middle: two arcs of each circle.
    let strip = one(Cover::Strip { x, y, width: 10.0, length: 1e4, direction: 33.0 });
    for (found, radius) in hidden(&strip).iter().zip([large, small]) {
        near(*found, 2.0 * (5.0 / radius).asin() / PI);
    }
    assert_eq!(strip.truth(1).targets[0].circles[0].visible.len(), 2);
    // A bite on the outer rim.
    let bite = one(Cover::Disc { x: x + large, y, radius: 12.0 });
    near(hidden(&bite)[0], 2.0 * (6.0 / large).asin() / PI);
    near(hidden(&bite)[1], 0.0);
    let glare = one(Cover::Glare { x: x + small, y, radius: 6.0, strength: 2.0 });
    assert!(hidden(&glare)[1] > 0.02 && hidden(&glare)[0] == 0.0);
    let frame = glare.render(3);
    assert_eq!(frame.pixels[512 * frame.width + 640 + small as usize], 255);
    let dark = strip.render(3).pixels[512 * frame.width + 640];
    assert!(dark.abs_diff(30) < 10, "{dark}");
    // Half a target beyond the border.
    scene.targets[0].pose.x = -0.5;
    near(hidden(&scene)[0], 0.5);
    let seen = &scene.truth(1).targets[0].circles[0].visible;
    near(seen[0][0], 270.0);
    near(seen[0][1], 450.0);
    let text = serde_json::to_string(&glare.truth(1)).unwrap();
    let truth: Truth = serde_json::from_str(&text).unwrap();
    assert_eq!(truth.occluders, glare.occluders);
    near(truth.targets[0].circles[1].hidden, hidden(&glare)[1]);
}
