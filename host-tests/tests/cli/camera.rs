//! The options `--camera` and `--coplanar`.

use concentric_host::render::{Artwork, Pose, Scene, TargetTruth};

use super::support::{CENTRE, Folder, assert_error, json, photo, text};

#[test]
fn a_camera_gives_normals_and_is_checked() {
    let folder = Folder::new();
    folder.picture("a.png", &photo());
    folder.write("camera.json", br#"{"fx": 2580.65, "fy": 2580.65, "cx": 640, "cy": 512}"#);
    folder.write("bad.json", br#"{"fx": 2580.65, "fy": 2580.65, "cx": 640}"#);
    folder.write("folded.json", br#"{"fx": 600, "fy": 600, "cx": 640, "cy": 512, "k1": -0.3}"#);
    for camera in ["f=2580.65", "camera.json"] {
        let output = folder.run(&["detect", "--json", "--ratio", "0.5", "--camera", camera, "a.png"]);
        let target = &json(&output)[0]["targets"][0];
        let off =
            (target["x"].as_f64().unwrap() - CENTRE[0]).hypot(target["y"].as_f64().unwrap() - CENTRE[1]);
        // The photo shows the target at a tilt of 40 degrees.
        let z = target["normal"][2].as_f64().unwrap();
        assert!(off < 0.01 && (z + 40f64.to_radians().cos()).abs() < 0.002, "{target}");
    }
    let plain = json(&folder.run(&["detect", "--json", "a.png"]));
    assert!(plain[0]["targets"][0].get("normal").is_none());
    let refused = |arguments: &[&str], parts: &[&str]| {
        assert_error(&folder.run(&[&["detect", "a.png"], arguments].concat()), parts);
    };
    refused(&["--camera", "bad.json"], &["bad.json", "missing field `cy`"]);
    refused(&["--camera", "f=abc"], &["`abc` is no number"]);
    refused(&["--camera", "f=0"], &["fx = 0 px is outside 1..=1000000"]);
    refused(
        &["--camera", "folded.json"],
        &["a.png", "distortion folds the image within a frame of 1280 x 1024"],
    );
    refused(&["--compensation", "known"], &["--compensation known needs --camera"]);
}

#[test]
fn coplanar_targets_are_told_apart_from_others() {
    let folder = Folder::new();
    let pose = Pose { x: 640.0, y: 512.0, distance: 800.0, tilt: 40.0, azimuth: 30.0 };
    let mut scene = Scene::board(4, 3, 60.0, &Artwork::annulus(20.0, 10.0), pose);
    // One of them leans the other way.
    let TargetTruth { x, y, .. } = scene.truth(0).targets[5];
    scene.targets[5].pose = Pose { x, y, tilt: 50.0, azimuth: 200.0, ..pose };
    scene.targets[5].at = [0.0, 0.0];
    let frame = scene.render(3);
    folder.picture("board.png", &frame);
    folder.picture("one.png", &photo());
    let output = folder.run(&["detect", "--json", "--ratio", "0.5", "--coplanar", "board.png"]);
    let lines = json(&output);
    let targets = lines[0]["targets"].as_array().unwrap();
    let on = targets.iter().filter(|target| target["coplanar"] == true).count();
    assert_eq!((targets.len(), on), (12, 11), "{}", text(&output.stderr));
    let table = text(&folder.run(&["detect", "--ratio", "0.5", "--coplanar", "board.png"]).stdout);
    assert!(table.contains("one plane: 11 targets share the correction, 1 do not fit"), "{table}");
    let output = folder.run(&["detect", "--json", "--coplanar", "one.png"]);
    assert!(text(&output.stderr).contains("one.png: --coplanar: a plane takes two targets or more: 1 given"));
    assert_eq!(json(&output)[0]["targets"].as_array().unwrap().len(), 1);
    assert!(output.status.success());
}
