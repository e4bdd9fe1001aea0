//! The order of the stages, and nothing else.

mod error;
mod image;
pub use error::{FrameError, RowError};
pub use image::{Detection, Image};

use crate::candidate::{self, Waiting};
use crate::log::log;
use crate::measure::measure;
use crate::region::{Region, Regions};
use crate::reject::{Observer, Reject, Rejected};
use crate::scan::{Run, Scanner};
use crate::settings::{Compensation, Polarity, Settings};
use crate::storage::Storage;
use crate::summary::{Summary, Used};
use crate::target::{Position, Target};

/// Widest frame, px.
pub const MAX_WIDTH: u16 = 4096;
/// Highest frame, px.
pub const MAX_HEIGHT: u16 = 16384;
/// Smallest width and height, px: less holds no target.
pub const MIN_SIZE: u16 = 8;

/// Finds targets in frames.
#[derive(Debug)]
pub struct Detector<'s> {
    scanner: Scanner<'s>,
    settings: Settings,
}

impl<'s> Detector<'s> {
    /// A detector that works in `storage`.
    pub fn new<const WIDTH: usize, const OUTLINES: usize, const CROSSINGS: usize>(
        settings: Settings,
        storage: &'s mut Storage<WIDTH, OUTLINES, CROSSINGS>,
    ) -> Self {
        Self { scanner: Scanner::new(storage.buffers()), settings }
    }

    /// What it looks for.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Widest frame that its storage can take, px.
    pub fn max_width(&self) -> u16 {
        self.scanner.capacity().min(usize::from(MAX_WIDTH)) as u16
    }

    /// Looks for something else from the next frame on.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Starts a frame; whatever was left of the one before is forgotten.
    ///
    /// # Errors
    /// [`FrameError`] for a size outside the limits or wider than the storage, and for settings without the camera that they
    /// need or with one whose distortion folds such a frame.
    pub fn begin(&mut self, width: u16, height: u16) -> Result<Scan<'_, 's, ()>, FrameError> {
        self.begin_observed(width, height, ())
    }

    /// The same; `observer` is told of every rejected candidate.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
    pub fn begin_observed<O: Observer>(
        &mut self,
        width: u16,
        height: u16,
        observer: O,
    ) -> Result<Scan<'_, 's, O>, FrameError> {
        let capacity = self.max_width();
        if width < MIN_SIZE || width > capacity {
            return Err(FrameError::Width { given: width, max: capacity });
        }
        if !(MIN_SIZE..=MAX_HEIGHT).contains(&height) {
            return Err(FrameError::Height { given: height });
        }
        match self.settings.known_camera() {
            None if self.settings.compensation == Compensation::Known => return Err(FrameError::NoCamera),
            Some(camera) if !camera.covers(width, height) => {
                return Err(FrameError::Folded { width, height });
            }
            _ => (),
        }
        log!(debug, "frame of {} x {} px", width, height);
        self.scanner.begin(width, height, &self.settings);
        let summary = Summary { width, height, ..Summary::default() };
        Ok(Scan {
            detector: self,
            regions: Regions::all(),
            waiting: Waiting::new(width, height),
            summary,
            observer,
        })
    }
}

/// A frame under way.
#[derive(Debug)]
pub struct Scan<'d, 's, O: Observer = ()> {
    detector: &'d mut Detector<'s>,
    regions: Regions<'d>,
    waiting: Waiting,
    summary: Summary,
    observer: O,
}

impl<'d, 's, O: Observer> Scan<'d, 's, O> {
    /// Limits the search to `regions`, sorted by their first rows; they may overlap. Call it before the first row.
    ///
    /// What lies in a region, with 24 columns and 12 rows of what surrounds it, is measured as in a search of the whole frame.
    /// Without noise that is bit for bit. With noise the local threshold may come from other samples of the same surroundings,
    /// so that now and then a pixel changes sides; the centre differs by less than a quarter of its standard deviation. What a
    /// region cuts is no target. The least contrast of an edge is that of the last frame that was searched as a whole.
    ///
    /// Rows two blocks of four away from all regions cost a comparison, columns outside of them a copy.
    ///
    /// # Errors
    /// [`FrameError::Region`], [`FrameError::LateRegions`].
    pub fn within(mut self, regions: &'d [Region]) -> Result<Self, FrameError> {
        let given = self.detector.scanner.pushed();
        if given > 0 {
            return Err(FrameError::LateRegions { given });
        }
        let Summary { width, height, .. } = self.summary;
        self.regions = Regions::new(regions, (width, height)).map_err(|at| FrameError::Region { at })?;
        Ok(self)
    }

    /// Whether the pixels of the next row are looked at. If not, [`skip_row`](Self::skip_row) does.
    pub fn needs_row(&self) -> bool {
        self.regions.need(self.detector.scanner.pushed())
    }

    /// Takes the next row without its pixels. Otherwise as [`push_row`](Self::push_row).
    ///
    /// # Errors
    /// [`RowError`], also for a row that [is needed](Self::needs_row).
    pub fn skip_row(&mut self) -> Result<Targets<'_, 'd, 's, O>, RowError> {
        let (row, height) = (self.detector.scanner.pushed(), self.summary.height);
        if row >= height {
            return Err(RowError::TooMany { height });
        }
        if self.needs_row() {
            return Err(RowError::Needed { row });
        }
        Ok(self.take_row(&[]))
    }

    fn take_row(&mut self, row: &[u8]) -> Targets<'_, 'd, 's, O> {
        self.detector.scanner.push_row(row, &mut self.regions);
        self.take_closed();
        Targets { scan: self }
    }

    /// Takes the next row, top down: one byte for each pixel. The iterator measures and gives the targets that are complete;
    /// those that are not taken from it come with the next row.
    ///
    /// # Errors
    /// [`RowError`]; the row is then ignored and the frame can go on.
    pub fn push_row(&mut self, row: &[u8]) -> Result<Targets<'_, 'd, 's, O>, RowError> {
        self.check_row(row)?;
        if self.detector.scanner.runs_are_given() {
            return Err(RowError::Mixed);
        }
        Ok(self.take_row(row))
    }

    /// The same where the dark runs of the row are known, from logic beside the processor that has the pixels first. The
    /// library then looks at pixels only beside the ends of the runs.
    ///
    /// `runs` are all of the row, from left to right, with a light pixel between them; what is outside the frame is light.
    /// No difference of grey levels below `min_contrast` was taken for an edge, from 2 on; the one given with the last row
    /// of a block of four holds for the block above. Which pixels are dark is up to the logic, but must change only where the
    /// grey level passes a threshold between the two sides: where it does not, edge profiles are refused. The runs and the
    /// contrast of the library's own threshold give the results of [`push_row`](Self::push_row), bit for bit.
    ///
    /// All rows of a frame come with their runs, or none; there are no regions then.
    ///
    /// # Errors
    /// [`RowError`]; the row is then ignored and the frame can go on.
    pub fn push_row_with_runs(
        &mut self,
        row: &[u8],
        runs: &[Run],
        min_contrast: u8,
    ) -> Result<Targets<'_, 'd, 's, O>, RowError> {
        self.check_row(row)?;
        let scanner = &mut self.detector.scanner;
        if !self.regions.are_all() || scanner.pushed() > 0 && !scanner.runs_are_given() {
            return Err(RowError::Mixed);
        }
        scanner
            .push_row_with_runs(row, runs, min_contrast)
            .map_err(|error| RowError::Run { at: error.at })?;
        self.take_closed();
        Ok(Targets { scan: self })
    }

    fn check_row(&self, row: &[u8]) -> Result<(), RowError> {
        let Summary { width, height, .. } = self.summary;
        if row.len() != usize::from(width) {
            return Err(RowError::Length { given: row.len(), width });
        }
        if self.detector.scanner.pushed() >= height {
            return Err(RowError::TooMany { height });
        }
        Ok(())
    }

    /// Ends the frame. The result gives the last targets and the summary.
    ///
    /// # Errors
    /// [`FrameError::TooFewRows`]: the targets given so far are right, what follows is lost.
    pub fn finish(mut self) -> Result<Rest<'d, 's, O>, FrameError> {
        let (given, height) = (self.detector.scanner.pushed(), self.summary.height);
        if given < height {
            return Err(FrameError::TooFewRows { given, height });
        }
        self.detector.scanner.finish(&mut self.regions);
        self.take_closed();
        Ok(Rest { scan: self })
    }

    /// Sorts the outlines that have closed.
    #[inline(always)]
    fn take_closed(&mut self) {
        while let Some(label) = self.detector.scanner.outlines.take_closed() {
            self.sort(label);
        }
    }

    #[inline(never)]
    fn sort(&mut self, label: u16) {
        if let Err(cause) = self.waiting.add(label, &mut self.detector.scanner) {
            self.reject(label, cause);
            self.detector.scanner.free(label);
        }
    }

    fn next_target(&mut self, rows: u16) -> Option<Target> {
        if self.waiting.is_empty() { None } else { self.measure_next(rows) }
    }

    #[inline(never)]
    fn measure_next(&mut self, rows: u16) -> Option<Target> {
        loop {
            let dark = self.detector.settings.spec.polarity() == Polarity::Dark;
            let head = self.waiting.take_ready(rows, dark, &mut self.detector.scanner)?;
            let Detector { scanner, settings } = &mut *self.detector;
            let alone = scanner.outlines.get(head).is_some_and(candidate::is_alone);
            let measured = if alone { Err(Reject::Alone) } else { measure(head, scanner, settings) };
            let target = measured.map_err(|cause| self.reject(head, cause));
            self.detector.scanner.free(head);
            let Ok(target) = target else { continue };
            log!(trace, "target at {}", target.centre);
            self.summary.targets = self.summary.targets.saturating_add(1);
            return Some(target);
        }
    }

    fn summary(&self) -> Summary {
        let Scanner { outlines, pool, dropped, .. } = &self.detector.scanner;
        let used = Used { outlines: outlines.used(), crossings: pool.used() };
        let (limited, unsearched) = (!self.regions.are_all(), self.waiting.unsearched);
        Summary { limited, dropped: *dropped, unsearched, used, ..self.summary }
    }

    fn reject(&mut self, label: u16, cause: Reject) {
        log!(trace, "outline {} is no target: {}", label, cause);
        self.summary.rejected.add(cause);
        if let Some(outline) = self.detector.scanner.outlines.get(label) {
            let (x, y) = candidate::origin(outline);
            self.observer.rejected(&Rejected {
                cause,
                centre: Position::from_origin(i32::from(x), i32::from(y), 0.0, 0.0),
                width: outline.width(),
                height: outline.height(),
            });
        }
    }
}

/// The targets that a row has completed.
#[derive(Debug)]
pub struct Targets<'a, 'd, 's, O: Observer = ()> {
    scan: &'a mut Scan<'d, 's, O>,
}

impl<O: Observer> Iterator for Targets<'_, '_, '_, O> {
    type Item = Target;

    fn next(&mut self) -> Option<Target> {
        self.scan.next_target(self.scan.detector.scanner.linked)
    }
}

/// The last targets of a frame.
#[derive(Debug)]
pub struct Rest<'d, 's, O: Observer = ()> {
    scan: Scan<'d, 's, O>,
}

impl<O: Observer> Iterator for Rest<'_, '_, O> {
    type Item = Target;

    fn next(&mut self) -> Option<Target> {
        self.scan.next_target(u16::MAX)
    }
}

impl<O: Observer> Rest<'_, '_, O> {
    /// What the frame came to. Targets that were not taken from the iterator are measured and counted, but lost.
    pub fn summary(mut self) -> Summary {
        while self.next().is_some() {}
        let summary = self.scan.summary();
        log!(debug, "frame done: {}", summary);
        summary
    }
}
