//! A sensor and a line that are played, and what was sent over it.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use concentric::head::{Absent, Exposure, FrameStart, Head, HeadError, Results, RowSource, Runs, buffer_len};
use concentric::report::{
    Answer, Decoder, Detail, Format, FrameHead, Hello, Message, TargetEntry, Version, max_len,
};
use concentric::{Detector, Run, Settings, Storage, Summary, TargetSpec};
use concentric_host::link;
use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};

/// Width and height of the played frames, px.
pub const SIZE: u16 = 96;
/// Radii of the target in them, px, and its centre.
pub const RADII: [f32; 2] = [30.0, 15.0];
pub const CENTRE: [f32; 2] = [47.3, 48.6];

pub const FIRMWARE: Version = Version { major: 1, minor: 4, patch: 0 };

/// What a line does and has done.
#[derive(Default)]
pub struct LineState {
    /// Bytes that it takes at once.
    pub room: usize,
    /// Bytes that it gets room for with every row of a frame.
    pub per_row: usize,
    /// Bytes that arrive with every row of a frame.
    pub arriving: VecDeque<u8>,
    /// Bytes that have arrived.
    pub arrived: VecDeque<u8>,
    /// What was sent.
    pub sent: Vec<u8>,
    /// Whether it fails.
    pub broken: bool,
}

/// A line that must be asked before it is used.
#[derive(Clone, Default)]
pub struct PlayedLine(pub Rc<RefCell<LineState>>);

impl PlayedLine {
    /// One that takes everything.
    pub fn fast() -> Self {
        let line = Self::default();
        line.0.borrow_mut().room = usize::MAX;
        line
    }

    /// A row's time passes.
    pub fn pass_time(&self) {
        let line = &mut *self.0.borrow_mut();
        line.room = line.room.saturating_add(line.per_row);
        line.arrived.extend(line.arriving.pop_front());
    }

    pub fn receive(&self, bytes: &[u8]) {
        self.0.borrow_mut().arrived.extend(bytes);
    }

    /// Takes what was sent.
    pub fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.borrow_mut().sent)
    }

    fn check(&self) -> Result<(), ErrorKind> {
        if self.0.borrow().broken { Err(ErrorKind::BrokenPipe) } else { Ok(()) }
    }
}

impl ErrorType for PlayedLine {
    type Error = ErrorKind;
}

impl WriteReady for PlayedLine {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        self.check().map(|()| self.0.borrow().room > 0)
    }
}

impl Write for PlayedLine {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        self.check()?;
        let line = &mut *self.0.borrow_mut();
        assert!(line.room > 0, "the head waits for its line");
        let taken = bytes.len().min(line.room);
        line.room -= taken;
        line.sent.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        self.check()
    }
}

impl ReadReady for PlayedLine {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        self.check().map(|()| !self.0.borrow().arrived.is_empty())
    }
}

impl Read for PlayedLine {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, ErrorKind> {
        self.check()?;
        bytes[0] = self.0.borrow_mut().arrived.pop_front().expect("the head waits for its line");
        Ok(1)
    }
}

/// Gives the rows of a picture with one target again and again.
pub struct Sensor {
    pub pixels: Vec<u8>,
    pub line: PlayedLine,
    pub seq: u32,
    row: usize,
    /// Row at which a frame fails.
    pub broken: Option<usize>,
    /// Its logic finds the runs.
    pub gives_runs: bool,
    /// And repeats the first of a row.
    pub spoiled_runs: bool,
    runs: Vec<Run>,
}

impl Sensor {
    pub fn new(line: &PlayedLine) -> Self {
        let pixels = vec![200; usize::from(SIZE) * usize::from(SIZE)];
        let line = line.clone();
        let mut sensor = Self {
            pixels,
            line,
            seq: 0,
            row: 0,
            broken: None,
            gives_runs: false,
            spoiled_runs: false,
            runs: Vec::new(),
        };
        sensor.draw(CENTRE, RADII);
        sensor
    }

    /// Draws a target.
    pub fn draw(&mut self, centre: [f32; 2], radii: [f32; 2]) {
        let size = usize::from(SIZE);
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            let r = f32::hypot((i % size) as f32 - centre[0], (i / size) as f32 - centre[1]);
            let within = |radius: f32| (radius - r + 0.5).clamp(0.0, 1.0);
            let ring = within(radii[0]) - within(radii[1]);
            *pixel = (f32::from(*pixel) - 160.0 * ring) as u8;
        }
    }

    pub fn next_frame(&mut self) -> FrameStart {
        self.seq += 1;
        self.row = 0;
        FrameStart { seq: self.seq, width: SIZE, height: SIZE }
    }

    pub fn next_row(&mut self, row: &mut [u8]) -> Result<(), &'static str> {
        self.line.pass_time();
        if self.broken == Some(self.row) {
            return Err("no line sync");
        }
        row.copy_from_slice(&self.pixels[self.row * usize::from(SIZE)..][..row.len()]);
        self.row += 1;
        self.runs = link::runs(row, 120);
        if self.spoiled_runs {
            self.runs.extend(self.runs.first().copied());
        }
        Ok(())
    }

    pub fn next_runs(&self) -> Option<Runs<'_>> {
        self.gives_runs.then_some(Runs { runs: &self.runs, min_contrast: 15 })
    }
}

impl RowSource for Sensor {
    type Error = &'static str;

    fn start(&mut self) -> Result<FrameStart, Self::Error> {
        Ok(self.next_frame())
    }

    fn read_row(&mut self, row: &mut [u8]) -> Result<(), Self::Error> {
        self.next_row(row)
    }

    fn runs(&self) -> Option<Runs<'_>> {
        self.next_runs()
    }
}

pub type TestStorage = Storage<{ SIZE as usize }, 16, 1024>;
pub type Outcome = Result<Summary, HeadError<&'static str, ErrorKind>>;

/// A head without pins, and all that it needs.
pub struct Bench<'b> {
    pub line: PlayedLine,
    pub sensor: Sensor,
    pub detector: Detector<'b>,
    pub results: Results<4>,
    pub head: Head<'b, PlayedLine>,
}

/// Room for one report at a time.
pub const BUFFER: usize = buffer_len(4, Detail::Full);

impl<'b> Bench<'b> {
    pub fn new(line: PlayedLine, storage: &'b mut TestStorage, buffer: &'b mut [u8]) -> Self {
        let sensor = Sensor::new(&line);
        let detector = Detector::new(Settings::new(TargetSpec::any()), storage);
        let results = Results::new(Detail::Normal);
        let head =
            Head::new(line.clone(), Exposure::<Absent, Absent, Absent>::free_running(), FIRMWARE, buffer);
        Self { line, sensor, detector, results, head }
    }

    pub fn frame(&mut self) -> Outcome {
        self.head.frame(&mut self.detector, &mut self.sensor, &mut [0; SIZE as usize], &mut self.results)
    }

    pub fn serve(&mut self) {
        self.head.serve(&mut self.detector, &mut self.results).unwrap();
    }

    /// Frames with a line that takes everything until nothing waits any more.
    pub fn settle(&mut self) {
        self.line.0.borrow_mut().room = usize::MAX;
        self.serve();
    }

    pub fn format(&mut self, format: Format) {
        self.head.set_format(format);
    }
}

/// A message, owned.
#[derive(Clone, Debug, PartialEq)]
pub enum Sent {
    Hello(Hello),
    Frame(FrameHead, Vec<TargetEntry>),
    Answer(Answer),
}

impl Sent {
    pub fn frame(&self) -> Option<&FrameHead> {
        if let Self::Frame(head, _) = self { Some(head) } else { None }
    }

    pub fn answer(&self) -> Option<&Answer> {
        if let Self::Answer(answer) = self { Some(answer) } else { None }
    }
}

/// The messages in a stream; there must be nothing else in it.
pub fn messages(stream: &[u8]) -> Vec<Sent> {
    let mut decoder = Decoder::<{ max_len(4, Detail::Full) }>::new();
    let mut sent = Vec::new();
    for &byte in stream {
        sent.extend(decoder.push(byte).map(|outcome| match outcome.expect("no damage") {
            Message::Hello(hello) => Sent::Hello(hello),
            Message::Frame(frame) => Sent::Frame(frame.head, frame.targets().collect()),
            Message::Answer(answer) => Sent::Answer(answer),
        }));
    }
    sent
}
