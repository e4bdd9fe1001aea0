//! The option `--camera`.

use std::{fs, path::Path};

use anyhow::{Context, Result, anyhow, bail, ensure};
use concentric::{Camera, Distortion};
use serde::Deserialize;

use crate::picture::Picture;

/// What was given of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Given {
    /// Focal length, px; the rest is the picture's middle and no distortion.
    FocalLength(f32),
    /// Everything, and the size of its pictures, px, where that is known.
    Whole(Camera, Option<[usize; 2]>),
}

/// The flat form of a camera's file, under OpenCV's names.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Flat {
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

/// The form that `calibrate` and OpenCV write. What else is in the file does not matter.
#[derive(Deserialize)]
struct Matrices {
    image_width: Option<usize>,
    image_height: Option<usize>,
    camera_matrix: Numbers,
    #[serde(alias = "dist_coeffs", alias = "distortion")]
    distortion_coefficients: Numbers,
}

/// A matrix: OpenCV's own form, rows, or one row.
#[derive(Deserialize)]
#[serde(untagged)]
enum Numbers {
    Matrix { data: Vec<f32> },
    Rows(Vec<Vec<f32>>),
    Row(Vec<f32>),
}

impl Numbers {
    fn all(self) -> Vec<f32> {
        match self {
            Self::Matrix { data } | Self::Row(data) => data,
            Self::Rows(rows) => rows.concat(),
        }
    }
}

impl Matrices {
    fn flat(self) -> Result<Flat> {
        let matrix = self.camera_matrix.all();
        let &[fx, skew, cx, 0.0, fy, cy, 0.0, 0.0, 1.0] = matrix.as_slice() else {
            bail!("camera_matrix is {matrix:?}; wanted are nine numbers: fx 0 cx, 0 fy cy, 0 0 1");
        };
        ensure!(skew == 0.0, "camera_matrix has a skew of {skew}; it must be 0");
        let mut terms = self.distortion_coefficients.all();
        let count = terms.len();
        while terms.len() > 5 && terms.last() == Some(&0.0) {
            terms.pop();
        }
        ensure!(
            terms.len() <= 5,
            "distortion_coefficients are {count}; at most five are known: k1, k2, p1, p2, k3"
        );
        terms.resize(5, 0.0);
        let &[k1, k2, p1, p2, k3] = terms.as_slice() else { bail!("distortion_coefficients are {count}") };
        Ok(Flat { fx, fy, cx, cy, k1, k2, p1, p2, k3 })
    }
}

/// `f=NUMBER`, or the name of a JSON file.
///
/// # Errors
/// A number or a file that is none of a camera; names the field.
pub fn parse(text: &str) -> Result<Given> {
    let Some(number) = text.strip_prefix("f=") else {
        // The command line shows the outermost message only.
        return read(Path::new(text)).map_err(|error| anyhow!("{error:#}"));
    };
    let focal_length = number
        .trim()
        .parse()
        .map_err(|_| anyhow!("`{number}` is no number; f is the focal length in px, as in f=2580"))?;
    Camera::new(focal_length, focal_length, 0.0, 0.0)?;
    Ok(Given::FocalLength(focal_length))
}

fn read(path: &Path) -> Result<Given> {
    let name = path.display();
    let text = fs::read_to_string(path).with_context(|| {
        format!("cannot read {name}: give f=PX or a JSON file with fx, fy, cx, cy, k1, k2, p1, p2, k3")
    })?;
    let (Flat { fx, fy, cx, cy, k1, k2, p1, p2, k3 }, size) =
        decode(&text).with_context(|| format!("{name} is no camera"))?;
    let camera =
        Camera::new(fx, fy, cx, cy).and_then(|camera| camera.distortion(Distortion { k1, k2, p1, p2, k3 }));
    Ok(Given::Whole(camera.with_context(|| name.to_string())?, size))
}

fn decode(text: &str) -> Result<(Flat, Option<[usize; 2]>)> {
    // From the text, not from the value, so that errors have a place.
    let matrices = serde_json::from_str::<serde_json::Value>(text)?.get("camera_matrix").is_some();
    if !matrices {
        return Ok((serde_json::from_str(text)?, None));
    }
    let file: Matrices = serde_json::from_str(text)?;
    let size = file.image_width.zip(file.image_height).map(<[usize; 2]>::from);
    Ok((file.flat()?, size))
}

impl Given {
    /// The camera that took `picture`.
    ///
    /// # Errors
    /// A picture of another size than the camera's.
    pub fn of(&self, picture: &Picture) -> Result<Camera> {
        let middle = |size: usize| 0.5 * (size as f32 - 1.0);
        ensure!(picture.width > 0 && picture.height > 0, "the picture is empty");
        Ok(match *self {
            Self::FocalLength(f) => Camera::new(f, f, middle(picture.width), middle(picture.height))?,
            Self::Whole(camera, size) => {
                if let Some([width, height]) = size {
                    ensure!(
                        [picture.width, picture.height] == [width, height],
                        "is {} x {} px; the camera is calibrated for {width} x {height} px",
                        picture.width,
                        picture.height
                    );
                }
                camera
            }
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
        let Given::Whole(camera, None) = parse(&good).unwrap() else {
            panic!("a file is a whole camera of any size")
        };
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
            (r#"{"camera_matrix": [[9, 0, 1], [0, 9, 1]], "dist_coeffs": []}"#, "wanted are nine numbers"),
            (r#"{"camera_matrix": [9, 0.1, 1, 0, 9, 1, 0, 0, 1], "dist_coeffs": []}"#, "skew of 0.1"),
            (r#"{"camera_matrix": [9, 0, 1, 0, 9, 1, 0, 0, 1]}"#, "missing field `distortion_coefficients`"),
            (
                r#"{"camera_matrix": [9, 0, 1, 0, 9, 1, 0, 0, 1], "dist_coeffs": [0, 0, 0, 0, 0, 1, 0, 0]}"#,
                "coefficients are 8; at most five",
            ),
        ] {
            let name = file(text);
            assert!(
                message(&name).contains(part) && message(&name).contains("camera.json"),
                "{}",
                message(&name)
            );
        }
        let row = r#"{"image_width": 640, "image_height": 480, "camera_matrix": [[900, 0, 320], [0, 910, 240], [0, 0, 1]],
                      "dist_coeffs": [[-0.2, 0.1, 0.001, 0.002, 0, 0, 0, 0]], "rms": 1}"#;
        let Given::Whole(camera, size) = parse(&file(row)).unwrap() else { panic!("a whole camera") };
        assert_eq!((camera.focal_lengths(), camera.principal_point()), ((900.0, 910.0), (320.0, 240.0)));
        assert_eq!(size, Some([640, 480]));
        let other = Picture::new("x", 64, 48, vec![0; 64 * 48]).unwrap();
        let error = Given::Whole(camera, size).of(&other).unwrap_err().to_string();
        assert!(error.contains("is 64 x 48 px; the camera is calibrated for 640 x 480 px"), "{error}");
        assert!(message("nowhere.json").contains("cannot read nowhere.json"));
    }
}
