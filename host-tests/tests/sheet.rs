//! Sheets: true millimetres in the files, and every target of a sheet found and identified in a picture of it.

mod common;

use std::path::Path;
use std::process::Command;

use common::detect_with;
use concentric::{Image, Settings, TargetSpec, code};
use concentric_host::{
    layout::Layout,
    render::{Camera, Frame, Pose},
};

/// Every kind of sheet.
const SHEETS: [(&str, &[&str]); 5] = [
    ("board", &["board"]),
    ("board-a3", &["board", "--page", "a3"]),
    ("single", &["single", "--code", "cct14", "--ids", "77"]),
    ("grid14", &["grid", "--code", "cct14"]),
    ("grid12", &["grid", "--code", "cct12", "--grid", "3x4", "--light"]),
];

/// The sheet's text as SVG and as PDF, and its layout.
fn sheet(folder: &Path, (name, arguments): (&str, &[&str])) -> (String, Vec<u8>, Layout) {
    let out = folder.join(name);
    let mut command = Command::new(env!("CARGO_BIN_EXE_concentric"));
    let status =
        command.arg("sheet").args(arguments).arg("--out").arg(&out).output().expect("the program runs");
    assert!(status.status.success(), "{name}: {}", String::from_utf8_lossy(&status.stderr));
    let svg = std::fs::read_to_string(out.with_extension("svg")).expect("an SVG");
    let pdf = std::fs::read(out.with_extension("pdf")).expect("a PDF");
    (svg, pdf, Layout::read(&out.with_extension("layout")).expect("a layout"))
}

fn attribute(element: &str, name: &str) -> Option<f64> {
    element.split(&format!(" {name}=\"")).nth(1)?.split('"').next()?.trim_end_matches("mm").parse().ok()
}

/// Centre and radius of every circle of an SVG whose unit is the millimetre.
fn circles(svg: &str) -> Vec<[f64; 3]> {
    let elements = svg.lines().filter(|line| line.starts_with("<circle"));
    let circle = |line| Some([attribute(line, "cx")?, attribute(line, "cy")?, attribute(line, "r")?]);
    elements.filter_map(circle).collect()
}

/// Largest difference between the circles of a file and those of the layout with its origin at (x, y), mm.
fn off(circles: &[[f64; 3]], layout: &Layout, [x, y]: [f64; 2]) -> f64 {
    let wanted = layout.targets.iter().flat_map(|target| {
        let [at_x, at_y, _] = target.position;
        target.radii.iter().map(move |radius| [x + at_x, y + at_y, *radius])
    });
    let apart = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    wanted
        .map(|wanted| circles.iter().map(|circle| apart(circle, &wanted)).fold(f64::INFINITY, f64::min))
        .fold(0.0, f64::max)
}

#[test]
fn files_are_in_true_millimetres() {
    let folder = tempfile::tempdir().expect("a folder");
    for kind in SHEETS {
        let (svg, pdf, layout) = sheet(folder.path(), kind);
        let head = svg.lines().next().expect("a head");
        let [width, height] = ["width", "height"].map(|name| attribute(head, name).expect("a size"));
        assert!(head.contains(&format!("viewBox=\"0 0 {width} {height}\"")), "{}: {head}", kind.0);
        let circles = circles(&svg);
        // Where the layout has its origin follows from its first target.
        let first = &layout.targets[0];
        let origin = [circles[0][0] - first.position[0], circles[0][1] - first.position[1]];
        let wrong = off(&circles, &layout, origin);
        assert!(wrong <= 0.01, "{}: {wrong} mm", kind.0);
        // Teeth: a sheet that is printed at 99.5 %.
        let small: Vec<_> = circles.iter().map(|circle| circle.map(|length| 0.995 * length)).collect();
        assert!(off(&small, &layout, origin.map(|at| 0.995 * at)) > 0.01, "{}", kind.0);
        // The page of the PDF, and its unit: 72 points are 25.4 mm.
        let pdf = String::from_utf8_lossy(&pdf);
        let page =
            pdf.split("/MediaBox [0 0 ").nth(1).and_then(|rest| rest.split(']').next()).expect("a page");
        let size: Vec<f64> = page.split(' ').map(|number| number.parse().expect("a number")).collect();
        for (points, millimetres) in size.into_iter().zip([width, height]) {
            assert!((points * 25.4 / 72.0 - millimetres).abs() < 0.01, "{}: {points}", kind.0);
        }
        assert!(pdf.contains("2.8346457 0 0 -2.8346457 0 "), "{}", kind.0);
    }
}

/// A picture of the layout, so large that its smallest circle is 5 px or more in radius.
fn picture(layout: &Layout, tilt: f64) -> Frame {
    let reach = layout.targets.iter().fold(0.0, |most: f64, target| {
        most.max(target.position[0].hypot(target.position[1]) + 2.5 * target.reach())
    });
    let camera = Camera::new(1600, 1600, 2000.0);
    let pose = Pose { x: 800.0, y: 800.0, distance: 2000.0 * reach / 600.0, tilt, azimuth: 25.0 };
    let mut scene = layout.scene(camera, pose).expect("a plane layout");
    scene.photometry.noise = 2.0;
    scene.render(tilt as u64)
}

#[test]
fn every_target_of_a_sheet_is_found_and_identified() {
    let folder = tempfile::tempdir().expect("a folder");
    for kind in SHEETS {
        let (.., layout) = sheet(folder.path(), kind);
        for tilt in [0.0, 30.0] {
            let frame = picture(&layout, tilt);
            let spec = TargetSpec::ring(0.5).expect("a ratio");
            let spec = if layout.light { spec.light() } else { spec };
            let mut settings = Settings::new(spec);
            settings.code = layout.settings_code().expect("ids of the code");
            let (mut found, _) = detect_with(&frame, settings);
            let image = Image::new(&frame.pixels, frame.width as u16, frame.height as u16).expect("a size");
            found.iter_mut().for_each(|target| _ = code::read(&image, &settings, target));
            assert_eq!(found.len(), layout.targets.len(), "{} at {tilt}", kind.0);
            for (truth, wanted) in frame.truth.targets.iter().zip(&layout.targets) {
                let near = found.iter().find(|target| {
                    let (x, y) = target.centre.to_px();
                    (f64::from(x) - truth.x).hypot(f64::from(y) - truth.y) < 0.1
                });
                let id = near.map(|target| target.code.map(|code| code.id));
                assert_eq!(id, Some(wanted.id), "{} at {tilt}: {:?}", kind.0, wanted.position);
            }
        }
    }
}
