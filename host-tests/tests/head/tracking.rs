//! Targets that are followed from frame to frame, and rows that come with their runs.

use concentric::RowError;
use concentric::head::HeadError;
use concentric::report::{COMMAND_MAX_LEN, Command, FrameHead, Request, TargetEntry};

use crate::support::{BUFFER, Bench, CENTRE, PlayedLine, RADII, Sent, TestStorage, messages};

/// Frames of a head that searches one in `period` as a whole; `draw` draws each on light paper.
fn frames(
    (count, period): (u32, u16),
    mut draw: impl FnMut(&mut Bench<'_>, u32),
) -> Vec<(FrameHead, Vec<TargetEntry>)> {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    let command = Command { tag: 1, request: Request::WholeEvery(period) };
    bench.line.receive(command.encode(&mut [0; COMMAND_MAX_LEN]).unwrap());
    bench.settle();
    for frame in 0..count {
        bench.sensor.pixels.fill(200);
        draw(&mut bench, frame);
        bench.frame().unwrap();
    }
    bench.settle();
    let sent = messages(&bench.line.take());
    sent.into_iter()
        .filter_map(|sent| if let Sent::Frame(head, targets) = sent { Some((head, targets)) } else { None })
        .collect()
}

/// Drifts to the right and down.
fn place(frame: u32) -> [f32; 2] {
    [30.4 + 1.5 * frame as f32, 35.2 + 0.8 * frame as f32]
}

const SMALL: [f32; 2] = [16.0, 8.0];

#[test]
fn a_target_is_followed_and_looked_for_where_it_is_expected() {
    let frames = frames((9, 4), |bench, frame| bench.sensor.draw(place(frame), SMALL));
    let limited: Vec<_> = frames.iter().map(|(head, _)| head.limited).collect();
    // The first is a whole one, and so is one in four from the first with something to follow on.
    assert_eq!(limited.iter().filter(|limited| !**limited).count(), 3, "{limited:?}");
    assert_eq!(limited[..4], [false, true, true, true], "{limited:?}");
    for ((age, _), (head, targets)) in (0..).zip(0..9).zip(&frames) {
        let [target] = &targets[..] else { panic!("frame {}: {targets:?}", head.seq) };
        assert_eq!((target.track, target.age), (1, age));
        let [x, y] = place(age.into()).map(|at| at * 65536.0);
        let off = f32::hypot(target.centre.x as f32 - x, target.centre.y as f32 - y) / 65536.0;
        assert!(off < 0.03, "frame {}: {off} px", head.seq);
    }
}

#[test]
fn what_appears_elsewhere_is_found_by_the_next_whole_frame() {
    let frames = frames((6, 4), |bench, frame| {
        bench.sensor.draw([22.0, 22.0], SMALL);
        if frame > 0 {
            bench.sensor.draw([72.0, 72.0], SMALL);
        }
    });
    let found: Vec<_> = frames.iter().map(|(head, targets)| (head.limited, targets.len())).collect();
    assert_eq!(found, [(false, 1), (true, 1), (true, 1), (true, 1), (false, 2), (true, 2)]);
    let tracks: Vec<_> = frames[5].1.iter().map(|target| (target.track, target.age)).collect();
    assert_eq!(tracks, [(1, 5), (2, 1)]);
}

#[test]
fn without_a_period_all_frames_are_searched_as_a_whole_and_targets_are_followed_all_the_same() {
    for period in [0, 1] {
        let frames = frames((3, period), |bench, frame| bench.sensor.draw(place(frame), SMALL));
        assert!(frames.iter().all(|(head, _)| !head.limited));
        assert_eq!((frames[2].1[0].track, frames[2].1[0].age), (1, 2));
    }
}

#[test]
fn rows_with_their_runs_give_the_same_target_in_whole_frames() {
    let mut entries = [false, true].map(|gives_runs| {
        let frames = frames((4, 3), |bench, _| {
            bench.sensor.gives_runs = gives_runs;
            bench.sensor.draw(CENTRE, RADII);
        });
        assert_eq!(frames.iter().any(|(head, _)| head.limited), !gives_runs);
        frames.into_iter().flat_map(|(_, targets)| targets).collect::<Vec<_>>()
    });
    let [by_itself, given] = &mut entries;
    assert_eq!((by_itself.len(), given.len()), (4, 4));
    for (one, other) in by_itself.iter().zip(given) {
        let apart = (one.centre.x - other.centre.x).abs().max((one.centre.y - other.centre.y).abs());
        assert!(apart < 65536 / 200, "{apart} / 65536 px");
        assert_eq!((one.track, one.age), (other.track, other.age));
    }
}

#[test]
fn runs_that_cannot_be_cost_their_frame() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    bench.sensor.gives_runs = true;
    bench.sensor.spoiled_runs = true;
    assert_eq!(bench.frame(), Err(HeadError::Row(RowError::Run { at: 1 })));
    bench.sensor.spoiled_runs = false;
    assert_eq!(bench.frame().map(|summary| summary.targets), Ok(1));
}
