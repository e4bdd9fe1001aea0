//! Reading photographs: a file of unknown kind in, 8-bit grey rows out.

use std::{
    io::{Cursor, Read},
    path::Path,
};

use anyhow::{Context, Result, bail, ensure};
use concentric::{MAX_HEIGHT, MAX_WIDTH, MIN_SIZE};
use image::{DynamicImage, ImageDecoder, ImageFormat, codecs::png::PngDecoder, codecs::pnm::PnmDecoder};
use zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};
use zune_jpeg::JpegDecoder;

const KINDS: &str = "PNG, PGM and JPEG can be read (told apart by content, not by name)";

/// A grey picture in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Name for messages and output: the path as it was given, `-` for standard input.
    pub name: String,
    /// Width, px, [`MIN_SIZE`] to [`MAX_WIDTH`].
    pub width: usize,
    /// Height, px, [`MIN_SIZE`] to [`MAX_HEIGHT`].
    pub height: usize,
    /// Grey levels, row after row from the top, `width` in each.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// A picture of `pixels`, row after row.
    ///
    /// # Errors
    /// A size outside the limits, or another number of pixels than `width * height`.
    pub fn new(name: impl Into<String>, width: usize, height: usize, pixels: Vec<u8>) -> Result<Self> {
        check_size(width, height)?;
        ensure!(
            pixels.len() == width * height,
            "{} pixels for a picture of {width} x {height} px; {} wanted",
            pixels.len(),
            width * height
        );
        Ok(Self { name: name.into(), width, height, pixels })
    }

    /// Reads the file `path`, or standard input where `path` is `-`.
    ///
    /// # Errors
    /// A file that cannot be read, or anything that [`Picture::decode`] refuses. The message does not repeat the
    /// name of the file.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.to_string_lossy();
        let bytes = if name == "-" {
            let mut bytes = Vec::new();
            std::io::stdin().lock().read_to_end(&mut bytes).context("cannot be read")?;
            bytes
        } else {
            ensure!(!path.is_dir(), "is a directory, not an image; {KINDS}");
            std::fs::read(path).context("cannot be read")?
        };
        Self::decode(name, &bytes)
    }

    /// Decodes a PNG, PGM (or other netpbm) or JPEG file. Colour becomes luma, 16 bit are rounded to 8, transparent
    /// parts are laid on white.
    ///
    /// # Errors
    /// Another kind of file, a damaged or cut-off one, or a size outside the limits.
    pub fn decode(name: impl Into<String>, bytes: &[u8]) -> Result<Self> {
        ensure!(!bytes.is_empty(), "is empty; {KINDS}");
        let (kind, decoded) = match image::guess_format(bytes) {
            Ok(ImageFormat::Png) => ("PNG", decode_png(bytes)),
            Ok(ImageFormat::Pnm) => ("PGM", decode_pnm(bytes)),
            Ok(ImageFormat::Jpeg) => ("JPEG", decode_jpeg(bytes)),
            Ok(other) => bail!("is a {other:?} file; {KINDS}"),
            Err(_) => bail!("is not an image; {KINDS}"),
        };
        let image = decoded.map_err(|fault| match fault {
            Fault::Size(error) => error,
            Fault::Damaged(why) => anyhow::anyhow!("damaged {kind} file: {why}"),
        })?;
        let (width, height) = (image.width() as usize, image.height() as usize);
        Self::new(name, width, height, to_grey(image))
    }

    /// The rows from the top.
    pub fn rows(&self) -> std::slice::ChunksExact<'_, u8> {
        self.pixels.chunks_exact(self.width)
    }
}

enum Fault {
    Size(anyhow::Error),
    Damaged(String),
}

impl Fault {
    fn damaged(error: impl std::fmt::Display) -> Self {
        let text = error.to_string();
        Self::Damaged(text.lines().map(str::trim).collect::<Vec<_>>().join(" "))
    }
}

fn check_size(width: usize, height: usize) -> Result<()> {
    let within = |side: usize, max: u16| (usize::from(MIN_SIZE)..=usize::from(max)).contains(&side);
    ensure!(
        within(width, MAX_WIDTH) && within(height, MAX_HEIGHT),
        "is {width} x {height} px; allowed are widths of {MIN_SIZE} to {MAX_WIDTH} px and heights of {MIN_SIZE} to \
         {MAX_HEIGHT} px"
    );
    Ok(())
}

fn decode_png(bytes: &[u8]) -> Result<DynamicImage, Fault> {
    decode(PngDecoder::new(Cursor::new(bytes)).map_err(Fault::damaged)?)
}

fn decode_pnm(bytes: &[u8]) -> Result<DynamicImage, Fault> {
    decode(PnmDecoder::new(Cursor::new(bytes)).map_err(Fault::damaged)?)
}

fn decode(decoder: impl ImageDecoder) -> Result<DynamicImage, Fault> {
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize).map_err(Fault::Size)?;
    DynamicImage::from_decoder(decoder).map_err(Fault::damaged)
}

/// A lenient JPEG decoder fills what is missing with grey, and a strict one still does so in the last row of blocks;
/// a file that ends early has no end marker behind its last scan.
fn decode_jpeg(bytes: &[u8]) -> Result<DynamicImage, Fault> {
    let options = DecoderOptions::default().set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(Fault::damaged)?;
    let (width, height) = decoder.dimensions().ok_or_else(|| Fault::damaged("no size in its header"))?;
    check_size(width, height).map_err(Fault::Size)?;
    if !ends_after_last_scan(bytes) {
        return Err(Fault::damaged("ends before the end of the picture"));
    }
    let grey = matches!(decoder.input_colorspace(), Some(ColorSpace::Luma | ColorSpace::YCbCr));
    let colour = if grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(colour));
    let pixels = decoder.decode().map_err(Fault::damaged)?;
    let (width, height) = (width as u32, height as u32);
    let image = if grey {
        image::GrayImage::from_raw(width, height, pixels).map(DynamicImage::ImageLuma8)
    } else {
        image::RgbImage::from_raw(width, height, pixels).map(DynamicImage::ImageRgb8)
    };
    image.ok_or_else(|| Fault::damaged("pixels are missing"))
}

fn ends_after_last_scan(jpeg: &[u8]) -> bool {
    const SCAN: [u8; 2] = [0xff, 0xda];
    const END: [u8; 2] = [0xff, 0xd9];
    jpeg.windows(2).rev().find(|pair| *pair == SCAN || *pair == END).is_some_and(|pair| pair == END)
}

fn to_grey(image: DynamicImage) -> Vec<u8> {
    if image.color().has_alpha() {
        let over_white = |[level, alpha]: [u16; 2]| {
            let (level, alpha) = (u32::from(level), u32::from(alpha));
            let sum = u64::from(level) * u64::from(alpha) + 65535 * u64::from(65535 - alpha);
            ((sum + 65535 * 257 / 2) / (65535 * 257)) as u8
        };
        image.into_luma_alpha16().pixels().map(|pixel| over_white(pixel.0)).collect()
    } else {
        image.into_luma8().into_raw()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ExtendedColorType, ImageEncoder};

    fn png(bytes: &[u8], width: u32, height: u32, colour: ExtendedColorType) -> Vec<u8> {
        let mut out = Vec::new();
        image::codecs::png::PngEncoder::new(&mut out).write_image(bytes, width, height, colour).unwrap();
        out
    }

    fn jpeg(width: u16, height: u16) -> Vec<u8> {
        let pixels: Vec<u8> =
            (0..usize::from(width) * usize::from(height)).map(|i| (i * 37 % 251) as u8).collect();
        let mut out = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, 90);
        encoder.write_image(&pixels, width.into(), height.into(), ExtendedColorType::L8).unwrap();
        out
    }

    fn message(bytes: &[u8]) -> String {
        format!("{:#}", Picture::decode("x", bytes).unwrap_err())
    }

    #[test]
    fn every_kind_gives_the_same_grey() {
        let levels: Vec<u8> = (0..64).map(|i| i * 4 + i / 22).collect();
        let each = |count: usize| levels.iter().flat_map(|&level| vec![level; count]).collect::<Vec<u8>>();
        let rgba: Vec<u8> = levels.iter().flat_map(|&level| [level, level, level, 255]).collect();
        let words: Vec<_> = levels.iter().map(u8::to_string).collect();
        let netpbm = |header: &str, body: &[u8]| [header.as_bytes(), body].concat();
        for file in [
            png(&levels, 8, 8, ExtendedColorType::L8),
            png(&each(2), 8, 8, ExtendedColorType::L16),
            png(&each(3), 8, 8, ExtendedColorType::Rgb8),
            png(&rgba, 8, 8, ExtendedColorType::Rgba8),
            netpbm("P2\n# comment\n8 8 255\n", words.join(" ").as_bytes()),
            netpbm("P5 8 8 255\n", &levels),
            netpbm("P5 8 8 65535\n", &each(2)),
        ] {
            assert_eq!(Picture::decode("x", &file).unwrap().pixels, levels);
        }
    }

    #[test]
    fn transparent_is_white() {
        let file = png(&[0, 0, 0, 255, 0, 128, 80, 255].repeat(16), 8, 8, ExtendedColorType::La8);
        assert_eq!(Picture::decode("x", &file).unwrap().pixels[..4], [255, 0, 127, 80]);
    }

    #[test]
    fn jpeg_is_read_whole_or_refused() {
        let file = jpeg(40, 24);
        assert_eq!(Picture::decode("x", &file).unwrap().pixels.len(), 40 * 24);
        for cut in (3..file.len()).step_by(7).chain([file.len() - 1, file.len() - 2]) {
            assert!(message(&file[..cut]).starts_with("damaged JPEG file: "), "{}", message(&file[..cut]));
        }
    }

    #[test]
    fn cut_png_is_refused() {
        let noise: Vec<u8> = (0..64 * 64u32).map(|i| (i.wrapping_mul(2654435761) >> 24) as u8).collect();
        let file = png(&noise, 64, 64, ExtendedColorType::L8);
        let end_chunks = 12 + 4;
        for cut in (8..file.len() - end_chunks).step_by(97) {
            assert!(
                message(&file[..cut]).starts_with("damaged PNG file: "),
                "{cut}: {}",
                message(&file[..cut])
            );
        }
    }

    #[test]
    fn sizes_are_named() {
        assert!(message(b"P5 0 5 255\n").contains("0 x 5 px"), "{}", message(b"P5 0 5 255\n"));
        let wide = message(&png(&[0; 4097 * 8], 4097, 8, ExtendedColorType::L8));
        assert!(wide.contains("4097 x 8 px") && wide.contains("8 to 4096 px"), "{wide}");
        assert!(message(b"").contains("is empty"));
        assert!(message(b"once upon a time").contains("is not an image"));
        assert!(message(b"P5 8 8 255\n\x00").starts_with("damaged PGM file: "));
    }
}
