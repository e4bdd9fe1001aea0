//! Images in memory, row by row through the detector.

use super::{Detector, FrameError, Scan};
use crate::summary::Summary;
use crate::target::Target;

impl<'s> Detector<'s> {
    /// Finds the targets of an image in memory. The rest of the image is not looked at if the iterator is dropped early.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
    pub fn detect<'d, 'i>(&'d mut self, image: &Image<'i>) -> Result<Detection<'d, 's, 'i>, FrameError> {
        let scan = self.begin(image.width, image.height)?;
        Ok(Detection { scan, rows: image.pixels.chunks_exact(usize::from(image.width)) })
    }
}

/// A grey image in memory, row by row without gaps.
#[derive(Clone, Copy, Debug)]
pub struct Image<'i> {
    pixels: &'i [u8],
    width: u16,
    height: u16,
}

impl<'i> Image<'i> {
    /// # Errors
    /// [`FrameError::Pixels`] unless there are `width * height` pixels.
    pub const fn new(pixels: &'i [u8], width: u16, height: u16) -> Result<Self, FrameError> {
        if pixels.len() != width as usize * height as usize {
            return Err(FrameError::Pixels { given: pixels.len(), width, height });
        }
        Ok(Self { pixels, width, height })
    }

    /// Width and height, px.
    pub const fn size(&self) -> (u16, u16) {
        (self.width, self.height)
    }

    /// Level of the pixel `(x, y)`; `None` outside the image.
    pub fn level(&self, x: i32, y: i32) -> Option<u8> {
        let (width, height) = (usize::from(self.width), usize::from(self.height));
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < width && y < height).then(|| self.pixels.get(y * width + x).copied())?
    }
}

/// The targets of an image in memory.
#[derive(Debug)]
pub struct Detection<'d, 's, 'i> {
    scan: Scan<'d, 's>,
    rows: core::slice::ChunksExact<'i, u8>,
}

impl Iterator for Detection<'_, '_, '_> {
    type Item = Target;

    fn next(&mut self) -> Option<Target> {
        loop {
            let scanner = &self.scan.detector.scanner;
            let rows = if scanner.linked > scanner.height() { u16::MAX } else { scanner.linked };
            if let Some(target) = self.scan.next_target(rows) {
                return Some(target);
            }
            if rows == u16::MAX {
                return None;
            }
            match self.rows.next() {
                Some(row) => self.scan.detector.scanner.push_row(row, &mut self.scan.regions),
                None => self.scan.detector.scanner.finish(&mut self.scan.regions),
            }
            self.scan.take_closed();
        }
    }
}

impl Detection<'_, '_, '_> {
    /// What the image came to; what was not looked at yet is looked at first.
    pub fn summary(mut self) -> Summary {
        self.by_ref().for_each(drop);
        self.scan.summary()
    }
}
