//! A slow, a stuck and a broken line: the sensor never waits, and what is not sent is counted.

use concentric::FrameError;
use concentric::head::HeadError;
use concentric::report::{ANSWER_MAX_LEN, Detail, HELLO_MAX_LEN, Hello};
use embedded_io::ErrorKind;
use proptest::prelude::*;

use crate::support::{BUFFER, Bench, FIRMWARE, PlayedLine, SIZE, Sent, TestStorage, messages};

#[test]
fn frames_become_reports_and_a_broken_frame_costs_only_itself() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    let mut results = vec![];
    for broken in [None, Some(50), None] {
        bench.sensor.broken = broken;
        results.push(bench.frame());
    }
    let too_short =
        bench.head.frame(&mut bench.detector, &mut bench.sensor, &mut [0; 40], &mut bench.results);
    bench.settle();

    assert_eq!(results[0].map(|summary| summary.targets), Ok(1));
    assert_eq!(results[1], Err(HeadError::Source("no line sync")));
    assert_eq!(results[0], results[2]);
    assert_eq!(too_short, Err(HeadError::Frame(FrameError::Width { given: SIZE, max: 40 })));
    let sent = messages(&bench.line.take());
    assert_eq!(sent[0], Sent::Hello(Hello::new(FIRMWARE, SIZE, Detail::Normal)));
    let frames: Vec<_> = sent[1..].iter().map(|sent| sent.frame().unwrap().seq).collect();
    assert_eq!(frames, [1, 3], "the gap tells of the lost frame");
    // Frames that the sensor lost are not reports that the line lost.
    assert_eq!(sent[2].frame().unwrap().dropped_reports, 0);
}

#[test]
fn a_stuck_line_stops_nothing_and_what_it_cost_is_told_later() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::default(), &mut storage, &mut buffer);
    for _ in 0..50 {
        assert_eq!(bench.frame().map(|summary| summary.targets), Ok(1));
    }
    assert!(bench.line.take().is_empty());
    bench.settle();
    let waited = messages(&bench.line.take()).iter().filter_map(Sent::frame).count() as u32;
    assert!((1..50).contains(&waited), "{waited} reports waited");
    bench.frame().unwrap();
    bench.settle();
    let last = messages(&bench.line.take());
    let head = last[0].frame().unwrap();
    assert_eq!((head.seq, head.dropped_reports), (51, 50 - waited));
}

#[test]
fn a_line_that_is_fast_enough_loses_nothing() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::default(), &mut storage, &mut buffer);
    // A byte a row: 96 a frame. A report of one target takes 58, the hello 24.
    bench.line.0.borrow_mut().per_row = 1;
    for _ in 0..20 {
        bench.frame().unwrap();
    }
    bench.settle();
    let sent = messages(&bench.line.take());
    assert_eq!(
        sent.iter().filter_map(Sent::frame).map(|head| head.seq).collect::<Vec<_>>(),
        Vec::from_iter(1..=20)
    );
    assert_eq!(sent.last().unwrap().frame().unwrap().dropped_reports, 0);
}

#[test]
fn a_broken_line_is_told_and_the_frame_is_measured() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    bench.frame().unwrap();
    bench.line.0.borrow_mut().broken = true;
    assert_eq!(bench.frame(), Err(HeadError::Line(ErrorKind::BrokenPipe)));
    bench.line.0.borrow_mut().broken = false;
    bench.frame().unwrap();
    bench.settle();
    assert_eq!(bench.head.flush(), Ok(()));
    let frames: Vec<_> =
        messages(&bench.line.take()).iter().filter_map(Sent::frame).map(|head| head.seq).collect();
    assert_eq!(frames, [1, 2], "the line was broken before the sensor was asked for a frame");
}

#[test]
fn a_buffer_that_never_holds_a_report_is_an_error() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; 100]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    let error = bench.frame().unwrap_err();
    assert!(matches!(error, HeadError::Report(_)), "{error:?}");
    let left = 100 - HELLO_MAX_LEN - ANSWER_MAX_LEN;
    assert_eq!(error.to_string(), format!("report: report takes 57 bytes, buffer holds {left}"));
}

#[test]
fn flush_sends_all_that_waits() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::default(), &mut storage, &mut buffer);
    bench.frame().unwrap();
    assert!(bench.line.take().is_empty());
    bench.line.0.borrow_mut().room = usize::MAX;
    bench.head.flush().unwrap();
    assert_eq!(messages(&bench.line.take()).len(), 2);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever the line does: only whole messages arrive, in order, and each says how many are missing before it.
    #[test]
    fn reports_are_sent_whole_or_counted(rooms in prop::collection::vec((0..3usize, 0..200usize), 1..25), reports in 1..4usize) {
        let (mut storage, mut buffer) = (TestStorage::new(), vec![0; 64 * reports + 110]);
        let mut bench = Bench::new(PlayedLine::default(), &mut storage, &mut buffer);
        for (per_row, burst) in rooms {
            let line = bench.line.clone();
            line.0.borrow_mut().per_row = per_row * burst % 2;
            line.0.borrow_mut().room += burst;
            prop_assert_eq!(bench.frame().map(|summary| summary.targets), Ok(1));
        }
        bench.settle();
        bench.frame().unwrap();
        bench.settle();
        let sent = messages(&bench.line.take());
        let frames: Vec<_> = sent.iter().filter_map(Sent::frame).collect();
        for (before, frame) in frames.iter().enumerate() {
            prop_assert_eq!(frame.dropped_reports as usize, frame.seq as usize - 1 - before);
        }
        prop_assert_eq!(frames.last().unwrap().seq, bench.sensor.seq);
    }
}
