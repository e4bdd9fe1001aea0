//! Figure 7: the views in one picture, with what was identified on them.

use anyhow::{Context, Result};
use image::{GrayImage, Rgb, RgbImage, imageops};

use super::{
    USUAL,
    level::shots,
    scene::Stage,
    shot::{Shot, Told},
};
use crate::measure::px;

/// Views side by side, and size of each, px.
const COLUMNS: usize = 4;
const SIZE: [u32; 2] = [640, 480];
/// Half side of a mark, px.
const MARK: i64 = 4;
/// Colours of targets and of coded markers.
const COLOURS: [Rgb<u8>; 2] = [Rgb([213, 94, 0]), Rgb([0, 158, 115])];

/// Draws it.
///
/// # Errors
/// What [`Shot::new`] refuses.
pub fn draw(stages: &[Stage]) -> Result<RgbImage> {
    let rows = stages.len().div_ceil(COLUMNS);
    let [width, height] = SIZE;
    let mut picture = RgbImage::new(width * COLUMNS as u32, height * rows as u32);
    let shots = shots(stages, USUAL, Told::Ratio)?;
    for (i, (stage, shot)) in stages.iter().zip(&shots).enumerate() {
        let corner = [i % COLUMNS * width as usize, i / COLUMNS * height as usize].map(|side| side as i64);
        paste(&mut picture, corner, stage, shot, (i + 1) as u64)?;
    }
    Ok(picture)
}

fn paste(picture: &mut RgbImage, corner: [i64; 2], stage: &Stage, shot: &Shot, seed: u64) -> Result<()> {
    let [width, height] = SIZE;
    let [wide, high] = stage.size.map(|side| side as u32);
    let pixels = stage.picture(USUAL, seed)?.pixels;
    let view = GrayImage::from_raw(wide, high, pixels).context("a picture of the view's size")?;
    let view = image::DynamicImage::ImageLuma8(imageops::thumbnail(&view, width, height)).into_rgb8();
    imageops::replace(picture, &view, corner[0], corner[1]);
    for found in &shot.found {
        let colour = COLOURS[usize::from(found.target.code.is_some())];
        let [x, y] = px(found.target.centre);
        let place = [x * f64::from(width) / f64::from(wide), y * f64::from(height) / f64::from(high)];
        let at = [0, 1].map(|axis| corner[axis] + place[axis].round() as i64);
        for along in -MARK..=MARK {
            for [x, y] in [[at[0] + along, at[1]], [at[0], at[1] + along]] {
                if let Some(pixel) = u32::try_from(x)
                    .ok()
                    .zip(u32::try_from(y).ok())
                    .and_then(|(x, y)| picture.get_pixel_mut_checked(x, y))
                {
                    *pixel = colour;
                }
            }
        }
    }
    Ok(())
}
