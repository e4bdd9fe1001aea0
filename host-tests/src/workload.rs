//! The frames on which the cost of the library is measured, on the desktop and on five processors.

use anyhow::Result;

use crate::picture::Picture;
use crate::render::{Artwork, Camera, Pose, Scene, Target};

/// Sizes of the frames, px.
pub const SIZES: [(u32, u32); 3] = [(320, 240), (640, 480), (1280, 1024)];
/// Radii of lone targets, px.
pub const RADII: [u32; 3] = [10, 30, 100];

/// Targets in a full frame, in columns and rows.
const TARGETS: usize = 60;
const COLUMNS: u32 = 10;
/// Outer radius of these, in widths of the frame.
const RADIUS: f64 = 9.0 / 320.0;
/// Focal length, in widths of the frame.
const FOCAL_LENGTH: f64 = 1.5;
const SEED: u64 = 0;

/// Frames whose cost is given for each pixel: empty, full, cluttered, and the worst that there is.
///
/// # Errors
/// None that these sizes can have.
pub fn crowds(width: u32, height: u32) -> Result<Vec<Picture>> {
    let paper = Camera::new(width, height, f64::from(width) * FOCAL_LENGTH);
    // As many targets as the frame has columns of them, so that there is room between them at every size.
    let clutter = Scene::many(TARGETS * width as usize / 1280, width, height, true, SEED)?;
    let side = |cell: usize| {
        let level = move |x: usize, y: usize| if (x / cell + y / cell).is_multiple_of(2) { 30 } else { 220 };
        (0..height as usize).flat_map(move |y| (0..width as usize).map(move |x| level(x, y))).collect()
    };
    let mut state = 1u32;
    let noise = std::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    });
    let pictures = [
        ("empty", Scene::empty(paper).render(SEED).pixels),
        ("60 targets", board(paper).render(SEED).pixels),
        ("clutter", clutter.render(SEED).pixels),
        ("noise", noise.take((width * height) as usize).collect()),
        ("checkerboard 1 px", side(1)),
        ("checkerboard 4 px", side(4)),
        ("checkerboard 6 px", side(6)),
    ];
    let picture =
        |(scene, pixels): (&str, Vec<u8>)| Picture::new(scene, width as usize, height as usize, pixels);
    pictures.into_iter().map(picture).collect()
}

/// Targets in columns and rows; they cover the same share of the frame whatever its size.
fn board(camera: Camera) -> Scene {
    let mut scene = Scene::empty(camera);
    let radius = RADIUS * f64::from(camera.width);
    let rows = TARGETS as u32 / COLUMNS;
    for number in 0..TARGETS as u32 {
        let (column, row) = (number % COLUMNS, number / COLUMNS);
        let place =
            |at: u32, count: u32, size: u32| (f64::from(at) + 0.5) / f64::from(count) * f64::from(size);
        // Every target lies differently on the pixels.
        let shift = |step: f64| (f64::from(number) * step).fract();
        let centre = [
            place(column, COLUMNS, camera.width) + shift(0.618),
            place(row, rows, camera.height) + shift(0.414),
        ];
        scene.targets.push(annulus(&camera, centre, radius));
    }
    scene
}

/// One target of this outer radius, px, up to 100.
///
/// # Errors
/// None that these radii can have.
pub fn lone(radius: u32) -> Result<Picture> {
    let mut scene = Scene::empty(Camera::new(320, 240, 320.0 * FOCAL_LENGTH));
    let target = annulus(&scene.camera, [160.3, 120.7], radius.into());
    scene.targets.push(target);
    Picture::new(format!("radius {radius}"), 320, 240, scene.render(SEED).pixels)
}

/// An annulus of ratio 0.5 seen at 30 degrees, its centre and outer radius in px.
fn annulus(camera: &Camera, [x, y]: [f64; 2], radius: f64) -> Target {
    let distance = 800.0;
    let outer = radius * distance / camera.f;
    let pose = Pose { x, y, distance, tilt: 30.0, azimuth: 30.0 };
    Target { artwork: Artwork::annulus(outer, outer / 2.0), pose, at: [0.0, 0.0] }
}
