//! The command `calibrate`.

use std::sync::OnceLock;

use concentric::report::{Detail, Report, max_len};
use concentric_host::{
    calibrate::input::Measuring,
    detect,
    picture::Picture,
    render::{Frame, Pose, Scene},
};
use serde_json::Value;

use super::common::boards::{coded_board, rendered, small_camera};
use super::support::{Folder, assert_error, text};

/// Pictures of the board.
fn views() -> &'static [Frame] {
    static VIEWS: OnceLock<Vec<Frame>> = OnceLock::new();
    VIEWS.get_or_init(|| rendered(8))
}

/// A folder with the layout.
fn with_board() -> Folder {
    let folder = Folder::new();
    coded_board().write(&folder.path("board.txt")).unwrap();
    folder
}

/// The same with the folder `views`, which has so many of the views.
fn with_views(count: usize) -> Folder {
    let folder = with_board();
    std::fs::create_dir(folder.path("views")).unwrap();
    for (index, frame) in views()[..count].iter().enumerate() {
        folder.picture(&format!("views/{index}.png"), frame);
    }
    folder
}

/// Of the parameters in a camera's file, in its standard deviation.
fn largest_error(file: &Value) -> f64 {
    let number = |name: &str, index: usize| file[name]["data"][index].as_f64().unwrap();
    let camera = small_camera();
    let d = camera.distortion;
    let errors = [
        ("fx", number("camera_matrix", 0) - camera.f),
        ("fy", number("camera_matrix", 4) - camera.f),
        ("cx", number("camera_matrix", 2) - camera.cx),
        ("cy", number("camera_matrix", 5) - camera.cy),
        ("k1", number("distortion_coefficients", 0) - d.k1),
        ("k2", number("distortion_coefficients", 1) - d.k2),
        ("p1", number("distortion_coefficients", 2) - d.p1),
        ("p2", number("distortion_coefficients", 3) - d.p2),
        ("k3", number("distortion_coefficients", 4)),
    ];
    let sigma = |name: &str| file["standard_deviations"][name].as_f64().unwrap();
    errors.into_iter().map(|(name, error)| error.abs() / sigma(name)).fold(0.0, f64::max)
}

#[test]
fn pictures_tell_the_camera() {
    let folder = with_views(8);
    let output = folder.run(&[
        "calibrate",
        "--layout",
        "board.txt",
        "--out",
        "camera.json",
        "--plot",
        "r.svg",
        "views",
    ]);
    let (table, notes) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success() && notes.is_empty(), "{notes}");
    assert!(table.contains("points in 8 views"), "{table}");
    // A few of the 504 may be not found or left out.
    let file = folder.read_json("camera.json");
    assert!(file["points"].as_u64().unwrap() >= 490, "{table}");
    let largest = largest_error(&file);
    assert!(largest < 3.0, "{largest} {table}");
    assert!(std::fs::read_to_string(folder.path("r.svg")).unwrap().contains("</svg>"));
    // What is written is what `detect` reads.
    let output = folder.run(&["detect", "--ratio", "0.5", "--camera", "camera.json", "views/0.png"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn centres_of_ellipses_need_their_correction() {
    let folder = with_views(8);
    let errors = ["eq7", "pose", "none"].map(|centre| {
        let output = folder.run(&[
            "calibrate",
            "--layout",
            "board.txt",
            "--out",
            "c.json",
            "--centre",
            centre,
            "views",
        ]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        largest_error(&folder.read_json("c.json"))
    });
    assert!(errors[0] < 3.0 && errors[1] < 3.0 && errors[2] > 5.0, "{errors:?}");
}

#[test]
fn a_recording_gives_what_its_pictures_give() {
    let folder = with_views(6);
    let settings = Measuring::new(coded_board()).unwrap().settings;
    let mut stream = Vec::new();
    for (seq, frame) in (0..).zip(&views()[..6]) {
        let picture = Picture::new("view", frame.width, frame.height, frame.pixels.clone()).unwrap();
        let outcome = detect::run(&picture, settings).unwrap();
        let mut report = Box::new(Report::<128>::new(Detail::Normal));
        report.begin(seq);
        outcome.targets.iter().for_each(|target| report.push(target));
        let mut buffer = vec![0; max_len(128, Detail::Normal)];
        stream.extend_from_slice(report.finish(&outcome.summary, &mut buffer).unwrap());
    }
    // The head begins in mid-message and sees the board no more in the end.
    let mut recording = stream[100..110].to_vec();
    recording.push(0);
    recording.append(&mut stream);
    let mut nothing = Box::new(Report::<128>::new(Detail::Normal));
    nothing.begin(6);
    let mut buffer = vec![0; max_len(128, Detail::Normal)];
    recording.extend_from_slice(nothing.finish(&Default::default(), &mut buffer).unwrap());
    std::fs::write(folder.path("record.bin"), &recording).unwrap();

    let output = folder.run(&["calibrate", "--layout", "board.txt", "record.bin"]);
    let table = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(table.contains("record.bin frame 5") && table.contains("1 frames were left out"), "{table}");
    let focal = |table: &str| -> f64 {
        let line = table.lines().find(|line| line.trim_start().starts_with("fx ")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let pictures = text(&folder.run(&["calibrate", "--layout", "board.txt", "views"]).stdout);
    // Standard deviations are rounded on the wire.
    assert!((focal(&table) - focal(&pictures)).abs() < 0.01, "{table}{pictures}");
}

#[test]
fn what_cannot_be_used_is_said() {
    let folder = with_views(5);
    let blank = Scene::empty(small_camera()).render(1);
    folder.picture("blank.png", &blank);
    let output = folder.run(&["calibrate", "--layout", "board.txt", "views", "blank.png"]);
    assert!(text(&output.stderr).contains("blank.png: no target was found"), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("in 5 views"));
    assert_eq!(output.status.code(), Some(2));

    let refused = |arguments: &[&str], parts: &[&str]| {
        let output = folder.run(&[&["calibrate", "--layout", "board.txt"], arguments].concat());
        assert_error(&output, parts);
        assert!(output.stdout.is_empty());
    };
    refused(&["views/0.png", "views/1.png", "views/2.png"], &["3 views;", "4 or more"]);
    refused(
        &["views/0.png", "blank.png"],
        &["blank.png: no target", "1 view;", "1 views were left out before"],
    );
    refused(&["nowhere.png"], &["nowhere.png: cannot be read", "0 views"]);
    refused(&["board.txt"], &["board.txt: neither a picture nor a recording"]);
    refused(&["views", "--radial", "4"], &["4 is not in 0..=3"]);
    refused(&["views", "--out", "no/camera.json"], &["cannot write no/camera.json"]);
    std::fs::create_dir(folder.path("empty")).unwrap();
    refused(&["empty"], &["empty: no pictures in this folder", "png, jpg, jpeg, pgm"]);

    let half = Frame { width: 960, height: 719, pixels: blank.pixels[960..].to_vec(), ..views()[0].clone() };
    folder.picture("views/9.png", &Frame { pixels: views()[0].pixels[960..].to_vec(), ..half });
    refused(&["views"], &["views/9.png is 960 x 719 px", "views/0.png 960 x 720 px"]);
}

#[test]
fn frontal_views_are_refused() {
    let folder = with_board();
    std::fs::create_dir(folder.path("views")).unwrap();
    for index in 0..5 {
        let distance = 410.0 + 20.0 * f64::from(index);
        let pose = Pose { x: 470.0 + 5.0 * f64::from(index), y: 355.0, distance, tilt: 0.0, azimuth: 0.0 };
        let scene = coded_board().scene(small_camera(), pose).unwrap();
        folder.picture(&format!("views/{index}.png"), &scene.render(index as u64));
    }
    let output = folder.run(&["calibrate", "--layout", "board.txt", "views"]);
    assert_error(&output, &["the views do not tell", "normals differ by at most"]);
}

#[test]
fn wrong_layouts_name_the_line() {
    let folder = with_views(1);
    let good = coded_board().text();
    let refused = |layout: &str, parts: &[&str]| {
        std::fs::write(folder.path("bad.txt"), layout).unwrap();
        let output = folder.run(&["calibrate", "--layout", "bad.txt", "views"]);
        assert_error(&output, &[&["bad.txt"], parts].concat());
    };
    refused(&good.replace("123,", "32,"), &["32", "line"]);
    refused(&good.replacen("6 3", "3 6", 1), &["line 4", "radi"]);
    let missing = folder.run(&["calibrate", "--layout", "none.txt", "views"]);
    assert!(text(&missing.stderr).contains("cannot read layout none.txt"));
    // A layout that cannot tell which is which.
    std::fs::write(
        folder.path("plain.txt"),
        "concentric-layout: 1\nid,x_mm,y_mm,z_mm,radii_mm\n,0,0,0,6 3\n",
    )
    .unwrap();
    let plain = text(&folder.run(&["calibrate", "--layout", "plain.txt", "views"]).stderr);
    assert!(plain.contains("the layout has 0 targets with ids"), "{plain}");
}
