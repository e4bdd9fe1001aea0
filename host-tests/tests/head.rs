//! The loop of a camera head with a sensor, a light and a line that are only played.

use std::convert::Infallible;

use concentric::head::{FrameStart, Head, HeadError, RowSource};
use concentric::report::{Decoder, Detail, Message, Report, max_len};
use concentric::{Detector, FrameError, Settings, Storage, TargetSpec};
use concentric_host::render::{Frame, Scene};
use embedded_hal::digital::{ErrorType, OutputPin};

const LEN: usize = max_len(8, Detail::Normal);

/// Gives the rows of a picture again and again; fails at row `broken` of a frame.
struct Pictures {
    frame: Frame,
    seq: u32,
    row: usize,
    broken: Option<usize>,
}

impl RowSource for Pictures {
    type Error = &'static str;

    fn start(&mut self) -> Result<FrameStart, Self::Error> {
        self.seq += 1;
        self.row = 0;
        Ok(FrameStart { seq: self.seq, width: self.frame.width as u16, height: self.frame.height as u16 })
    }

    fn read_row(&mut self, row: &mut [u8]) -> Result<(), Self::Error> {
        if self.broken == Some(self.row) {
            return Err("no line sync");
        }
        row.copy_from_slice(&self.frame.pixels[self.row * self.frame.width..][..row.len()]);
        self.row += 1;
        Ok(())
    }
}

/// Notes what the pin was set to.
#[derive(Default)]
struct Light(Vec<bool>);

impl ErrorType for Light {
    type Error = Infallible;
}

impl OutputPin for Light {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.push(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.push(true);
        Ok(())
    }
}

#[test]
fn frames_become_reports_and_a_broken_frame_costs_only_itself() {
    let mut sensor =
        Pictures { frame: Scene::single(10.0, 30.0, 0.0, [0.0; 2]).render(1), seq: 0, row: 0, broken: None };
    let mut storage = Box::new(Storage::<1280, 64, 4000>::new());
    let mut detector = Detector::new(Settings::new(TargetSpec::any()), &mut storage);
    let mut report = Report::<8>::new(Detail::Normal);
    let (mut row, mut bytes) = ([0; 1280], [0; LEN]);
    let mut line = Vec::new();
    let mut head = Head::new(&mut line, Light::default());

    let mut results = vec![];
    for broken in [None, Some(500), None] {
        sensor.broken = broken;
        results.push(head.frame(&mut detector, &mut sensor, &mut report, (&mut row, &mut bytes)));
    }
    let too_short = head.frame(&mut detector, &mut sensor, &mut report, (&mut row[..100], &mut bytes));
    let (_, light) = head.release();

    assert_eq!(results[0].as_ref().map(|summary| summary.targets).ok(), Some(1));
    assert_eq!(results[1], Err(HeadError::Source("no line sync")));
    assert_eq!(results[0], results[2]);
    assert_eq!(too_short, Err(HeadError::Frame(FrameError::Width { given: 1280, max: 100 })));
    // On while a frame is read, off afterwards whatever happened.
    assert_eq!(light.0, [true, false].repeat(4));

    let mut decoder = Decoder::<LEN>::new();
    let mut frames = vec![];
    for byte in line {
        if let Some(Ok(Message::Frame(frame))) = decoder.push(byte) {
            frames.push((frame.head.seq, frame.targets().count()));
        }
    }
    assert_eq!(frames, [(1, 1), (3, 1)], "the gap tells of the lost frame");
}
