//! The option `--camera`.

use std::{fs, path::Path};

use anyhow::{Context, Result, anyhow, ensure};
use concentric::{Camera, Distortion};
use serde::Deserialize;

use crate::picture::Picture;

/// What was given of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Given {
    /// Focal length, px; the rest is the picture's middle and no distortion.
    FocalLength(f32),
    /// Everything.
    Whole(Camera),
}

/// A camera in a file, under OpenCV's names.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    fx: f32,
    fy: f32,
    cx: f32,
    cy: f32,
    #[serde(default)]
    k1: f32,
    #[serde(default)]
    k2: f32,
    #[serde(default)]
    p1: f32,
    #[serde(default)]
    p2: f32,
    #[serde(default)]
    k3: f32,
}

/// `f=NUMBER`, or the name of a JSON file.
///
/// # Errors
/// A number or a file that is none of a camera; names the field.
pub fn parse(text: &str) -> Result<Given> {
    let Some(number) = text.strip_prefix("f=") else {
        // The command line shows the outermost message only.
        return read(Path::new(text)).map(Given::Whole).map_err(|error| anyhow!("{error:#}"));
    };
    let focal_length = number
        .trim()
        .parse()
        .map_err(|_| anyhow!("`{number}` is no number; f is the focal length in px, as in f=2580"))?;
    Camera::new(focal_length, focal_length, 0.0, 0.0)?;
    Ok(Given::FocalLength(focal_length))
}

fn read(path: &Path) -> Result<Camera> {
    let name = path.display();
    let text = fs::read_to_string(path).with_context(|| {
        format!("cannot read {name}: give f=PX or a JSON file with fx, fy, cx, cy, k1, k2, p1, p2, k3")
    })?;
    let File { fx, fy, cx, cy, k1, k2, p1, p2, k3 } =
        serde_json::from_str(&text).with_context(|| format!("{name} is no camera"))?;
    let camera =
        Camera::new(fx, fy, cx, cy).and_then(|camera| camera.distortion(Distortion { k1, k2, p1, p2, k3 }));
    camera.with_context(|| name.to_string())
}

impl Given {
    /// The camera that took `picture`.
    ///
    /// # Errors
    /// None that [`parse`] lets through.
    pub fn of(&self, picture: &Picture) -> Result<Camera> {
        let middle = |size: usize| 0.5 * (size as f32 - 1.0);
        ensure!(picture.width > 0 && picture.height > 0, "the picture is empty");
        Ok(match *self {
            Self::FocalLength(f) => Camera::new(f, f, middle(picture.width), middle(picture.height))?,
            Self::Whole(camera) => camera,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        format!("{:#}", parse(text).unwrap_err())
    }

    #[test]
    fn focal_length_alone() {
        assert_eq!(parse("f=2580").unwrap(), Given::FocalLength(2580.0));
        assert!(message("f=abc").contains("`abc` is no number"), "{}", message("f=abc"));
        assert_eq!(message("f=0"), "camera: fx = 0 px is outside 1..=1000000");
        assert_eq!(message("f=nan"), "camera: fx = NaN px is outside 1..=1000000");
    }

    #[test]
    fn files_are_checked_field_by_field() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.json");
        let file = |text: &str| {
            fs::write(&path, text).unwrap();
            path.to_str().unwrap().to_owned()
        };
        let good = file(r#"{"fx": 1000, "fy": 990, "cx": 640, "cy": 512, "k1": -0.1}"#);
        let Given::Whole(camera) = parse(&good).unwrap() else { panic!("a file is a whole camera") };
        assert_eq!((camera.focal_lengths(), camera.principal_point()), ((1000.0, 990.0), (640.0, 512.0)));
        for (text, part) in [
            (r#"{"fx": 1000, "cx": 640, "cy": 512}"#, "missing field `fy`"),
            (r#"{"fx": 1, "fy": 1, "cx": 6, "cy": 5, "kl": 1}"#, "unknown field `kl`"),
            (r#"{"fx": "long", "fy": 1, "cx": 6, "cy": 5}"#, "invalid type"),
            (r#"{"fx": 1000, "fy": -3, "cx": 640, "cy": 512}"#, "fy = -3 px is outside"),
            (
                r#"{"fx": 1000, "fy": 1000, "cx": 640, "cy": 512, "k2": 4000}"#,
                "k2 = 4000 is outside -1000..=1000",
            ),
            ("fx 1000", "is no camera"),
        ] {
            let name = file(text);
            assert!(
                message(&name).contains(part) && message(&name).contains("camera.json"),
                "{}",
                message(&name)
            );
        }
        assert!(message("nowhere.json").contains("cannot read nowhere.json"));
    }
}
