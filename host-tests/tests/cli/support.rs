//! The program in a folder with pictures.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use concentric_host::render::{Frame, Scene};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::Value;
use tempfile::TempDir;

/// True centre of the target in [`photo`], px.
pub const CENTRE: [f64; 2] = [640.3, 511.8];

/// An annulus of ratio 0.5 at a tilt of 40 degrees before a camera of f 2580.65 px.
pub fn photo() -> Frame {
    Scene::single(30.0, 40.0, 20.0, [CENTRE[0] - 640.0, CENTRE[1] - 512.0]).render(7)
}

/// A folder in which the program runs.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// A frame as PNG; gives the file.
    pub fn picture(&self, name: &str, frame: &Frame) -> Vec<u8> {
        let file = png(&frame.pixels, frame.width as u32, frame.height as u32);
        self.write(name, &file);
        file
    }

    /// [`photo`] as PNG; gives the file.
    pub fn photo(&self, name: &str) -> Vec<u8> {
        self.picture(name, &photo())
    }

    pub fn read_json(&self, name: &str) -> Value {
        serde_json::from_str(&std::fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_concentric"));
        command.args(arguments).current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }
}

/// A grey PNG file.
pub fn png(pixels: &[u8], width: u32, height: u32) -> Vec<u8> {
    let mut file = Vec::new();
    PngEncoder::new(&mut file).write_image(pixels, width, height, ExtendedColorType::L8).unwrap();
    file
}

pub fn size(path: &Path) -> (u32, u32) {
    image::image_dimensions(path).unwrap()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The lines of the output.
pub fn json(output: &Output) -> Vec<Value> {
    text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Asserts that `output` is a refusal with one line that has all of `parts`.
pub fn assert_refused(output: &Output, parts: &[&str]) {
    assert_error(output, parts);
    assert_eq!(text(&output.stderr).trim_end().lines().count(), 1, "{}", text(&output.stderr));
}

/// Asserts that `output` is a refusal whose message has all of `parts`.
pub fn assert_error(output: &Output, parts: &[&str]) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for part in parts {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}
