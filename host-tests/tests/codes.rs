//! Coded targets: found as plain ones are, and identified.

mod common;

use common::detect_with;
use concentric::{Code, Image, Settings, Target, TargetSpec, code};
use concentric_host::{
    layout::CodeName,
    measure::px,
    render::{Artwork, Camera, CodeRing, Frame, Pose, Scene, Target as Printed, Tone},
};

/// A dark annulus of ratio 0.5 and this outer semi-major axis, px, in the middle of a frame around it.
fn scene(radius: f64, tilt: f64, azimuth: f64) -> Scene {
    let side = (2.0 * 2.3 * radius + 16.0) as u32;
    let camera = Camera::new(side, side, 1000.0);
    let middle = f64::from(side - 1) / 2.0;
    let pose = Pose { x: middle + 0.3, y: middle - 0.2, distance: 1000.0, tilt, azimuth };
    let mut scene = Scene::empty(camera);
    scene.targets.push(Printed { artwork: Artwork::annulus(radius, radius / 2.0), pose, at: [0.0, 0.0] });
    scene
}

fn coded(mut scene: Scene, code: CodeName, id: u16, angle: f64) -> Scene {
    scene.targets[0].artwork.code = Some(CodeRing { code, id, angle });
    scene
}

fn spec() -> TargetSpec {
    TargetSpec::ring(0.5).unwrap()
}

/// The targets of a frame, read with the code of the settings.
fn read(frame: &Frame, settings: Settings) -> Vec<Target> {
    let (mut targets, _) = detect_with(frame, settings);
    let image = Image::new(&frame.pixels, frame.width as u16, frame.height as u16).unwrap();
    targets.iter_mut().for_each(|target| {
        code::read(&image, &settings, target);
    });
    targets
}

/// Every id of both codes at a large size and some tilt: one target, its id, its direction.
#[test]
fn every_id_is_read() {
    let mut failures = Vec::new();
    for (name, code) in [(CodeName::Cct14, Code::cct14()), (CodeName::Cct12, Code::cct12())] {
        for id in code.ids() {
            let (angle, azimuth) = (f64::from(id) * 7.3, f64::from(id) * 31.0);
            let mut scene = coded(scene(24.0, 40.0, azimuth), name, id, angle);
            scene.photometry.noise = 5.0;
            let frame = scene.render(id.into());
            for spec in [spec(), TargetSpec::any()] {
                let targets = read(&frame, Settings::new(spec).code(code));
                let circles: Vec<_> = targets.iter().map(|target| target.circles.len()).collect();
                let read = targets.first().and_then(|target| target.code);
                if circles != [2] || !read.is_some_and(|read| (read.id, read.wrong) == (id, 0)) {
                    failures
                        .push(format!("{name:?} {id} {:?}: {circles:?} circles, {read:?}", spec.ratios()));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}
