//! Correspondence between measured targets and a layout.

mod common;

use common::boards::{Draw, SIZE, WIDE, board, tilted};
use concentric_host::{
    calibrate::{Intrinsics, Placed, Pose},
    layout::{Layout, LayoutTarget},
    matching::{Correspondence, MatchError, Measured, correspond},
};
use nalgebra::Vector3;

/// Radius of the circles, mm.
const RADIUS: f64 = 8.0;
/// Where the coded targets are among the 63 of the board.
const CODED: [(usize, u16); 5] = [(10, 32), (16, 123), (32, 336), (46, 366), (52, 515)];

fn layout(objects: &[[f64; 3]], coded: &[(usize, u16)]) -> Layout {
    let target = |(index, &position): (usize, &[f64; 3])| {
        let id = coded.iter().find(|(at, _)| *at == index).map(|(_, id)| *id);
        LayoutTarget { id, position, radii: vec![RADIUS, RADIUS / 2.0] }
    };
    Layout { targets: objects.iter().enumerate().map(target).collect(), ..Layout::default() }
}

/// The targets in the frame, in random order, and which of the layout each is.
fn shown(draw: &mut Draw, layout: &Layout, camera: &Intrinsics, pose: &Pose) -> (Vec<Measured>, Vec<usize>) {
    let placed = Placed::new(pose, Vector3::z());
    let mut shown = Vec::new();
    for (index, target) in layout.targets.iter().enumerate() {
        let point = placed.point(&target.position.into());
        let place = camera.project(&point);
        let inside = (20.0..SIZE[0] as f64 - 21.0).contains(&place.x)
            && (20.0..SIZE[1] as f64 - 21.0).contains(&place.y);
        if inside {
            let centre = [place.x + 0.01 * draw.normal(), place.y + 0.01 * draw.normal()];
            let size = 0.8 * camera.fx * RADIUS / point.z;
            shown.push((
                draw.between(0f64, 1.0),
                index,
                Measured { centre, covariance: [1e-4, 0.0, 1e-4], id: target.id, size },
            ));
        }
    }
    shown.sort_by(|a, b| a.0.total_cmp(&b.0));
    shown.into_iter().map(|(_, index, measured)| (measured, index)).unzip()
}

/// Pairs that are right and pairs that are wrong.
fn score(found: &Correspondence, truth: &[usize]) -> (usize, usize) {
    let right = found.pairs.iter().filter(|pair| truth.get(pair.measured) == Some(&pair.target)).count();
    (right, found.pairs.len() - right)
}

#[test]
fn a_wide_lens_loses_no_target() {
    let (mut all, mut right, mut wrong) = (0, 0, 0);
    for seed in 0..200 {
        let mut draw = Draw::new(seed);
        // Five coded targets, four, and four of which three lie on a line.
        let on_line = [CODED[1], (31, 336), CODED[3], CODED[4]];
        let coded = [&CODED[..], &CODED[1..], &on_line][seed as usize % 3];
        let layout = layout(&board(), coded);
        let (mut measured, truth) =
            shown(&mut draw, &layout, &Intrinsics::from_array(WIDE), &tilted(&mut Draw::new(1000 + seed)));
        if measured.iter().filter(|one| one.id.is_some()).count() < 4 {
            continue;
        }
        // Clutter.
        for _ in 0..10 {
            let centre = [draw.between(0.0, 1280.0), draw.between(0.0, 960.0)];
            if measured.iter().all(|one| (one.centre[0] - centre[0]).hypot(one.centre[1] - centre[1]) > 20.0)
            {
                measured.push(Measured {
                    centre,
                    covariance: [1e-4, 0.0, 1e-4],
                    id: None,
                    size: draw.between(5.0, 40.0),
                });
            }
        }
        let found = correspond(&measured, &layout, SIZE).unwrap();
        let score = score(&found, &truth);
        all += truth.len();
        right += score.0;
        wrong += score.1;
        assert!(found.contradicting.is_empty(), "{seed}");
    }
    assert!(all > 8000 && right == all && wrong == 0, "{right} of {all} right, {wrong} wrong");
}

#[test]
fn targets_in_space() {
    let objects: Vec<[f64; 3]> =
        board().into_iter().enumerate().map(|(i, [x, y, _])| [x, y, ((i * 7) % 5) as f64 * 20.0]).collect();
    let coded = [CODED[0], CODED[1], CODED[2], CODED[3], CODED[4], (4, 4)];
    for seed in 0..20 {
        let mut draw = Draw::new(seed);
        // With four of them for every other one.
        let layout = layout(&objects, &coded[..if seed % 2 == 0 { 6 } else { 4 }]);
        let lens = Intrinsics { k1: -0.1, k2: 0.0, ..Intrinsics::from_array(WIDE) };
        let pose = tilted(&mut draw);
        let far = Pose { tvec: pose.tvec * 1.6, ..pose };
        let (measured, truth) = shown(&mut draw, &layout, &lens, &far);
        let found = correspond(&measured, &layout, SIZE).unwrap();
        assert_eq!(score(&found, &truth), (truth.len(), 0), "{seed}: {}", found.rms);
    }
}

/// The board as a usual lens sees it.
fn scene() -> (Layout, Vec<Measured>, Vec<usize>) {
    let mut draw = Draw::new(77);
    let layout = layout(&board(), &CODED);
    let pose = Pose { rvec: Vector3::new(0.5, 0.2, 0.1), tvec: Vector3::new(0.0, 0.0, 420.0) };
    let lens = Intrinsics { k1: -0.1, k2: 0.0, ..Intrinsics::from_array(WIDE) };
    let (measured, truth) = shown(&mut draw, &layout, &lens, &pose);
    assert_eq!(measured.len(), 63);
    (layout, measured, truth)
}

#[test]
fn what_does_not_fit_is_reported() {
    let (layout, measured, truth) = scene();
    let found = correspond(&measured, &layout, SIZE).unwrap();
    assert!(found.missing.is_empty() && found.unmatched.is_empty() && found.ambiguous.is_empty());
    assert_eq!((found.pairs.len(), found.foreign.len(), found.duplicates.len()), (63, 0, 0));
    assert!(found.rms < 0.5, "{}", found.rms);

    let at = |target: usize| truth.iter().position(|&one| one == target).unwrap();
    let mut changed = measured.clone();
    // A second one beside a plain target, an id that is not on the layout, an id twice, and one target less.
    let twin = measured[at(3)];
    changed.push(Measured { centre: [twin.centre[0] + 3.0, twin.centre[1]], ..twin });
    changed[at(20)].id = Some(99);
    changed[at(40)].id = Some(515);
    changed.remove(at(50));
    let mut truth = truth.clone();
    truth.remove(at(50));
    let found = correspond(&changed, &layout, SIZE).unwrap();
    assert_eq!((found.ambiguous, found.missing), (vec![3], vec![20, 40, 50]));
    assert_eq!((found.foreign, found.duplicates), (vec![99], vec![515]));
    assert_eq!((found.pairs.len(), found.unmatched.len()), (59, 4));
    // The place tells the right one of the two.
    let right = found.pairs.iter().find(|pair| pair.target == 52).unwrap();
    assert_eq!(truth[right.measured], 52);

    // Two ids that were read as each other's are found out, if one of them can be left out.
    let mut wrong = measured;
    wrong[at(10)].id = Some(4);
    let mut more = layout.clone();
    more.targets[60].id = Some(4);
    let found = correspond(&wrong, &more, SIZE).unwrap();
    assert_eq!(found.contradicting, vec![4]);
}

#[test]
fn what_is_missing_is_said() {
    let (layout, measured, truth) = scene();
    let at = |target: usize| truth.iter().position(|&one| one == target).unwrap();
    let refused = |measured: &[Measured], layout: &Layout, parts: &[&str]| {
        let message = correspond(measured, layout, SIZE).map(|found| found.rms).unwrap_err().to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    };
    refused(&[], &layout, &["no target was found"]);
    let plain: Vec<_> = measured.iter().map(|one| Measured { id: None, ..*one }).collect();
    refused(&plain, &layout, &["63 targets were found, 0 of them with ids", "4 or more"]);
    let mut few = measured.clone();
    few[at(10)].id = Some(7);
    few[at(16)].id = Some(336);
    refused(&few, &layout, &["2 of them", "(366, 515)", "more than once: 336", "not on the layout: 7"]);
    refused(&measured, &self::layout(&board(), &CODED[..3]), &["the layout has 3 targets with ids"]);

    let line = [(0, 32), (1, 123), (2, 336), (8, 366)];
    let on_line = self::layout(&board(), &line);
    let coded = |ids: &[(usize, u16)]| {
        let id = |index: usize| ids.iter().find(|(at, _)| *at == truth[index]).map(|(_, id)| *id);
        (0..63).map(|index| Measured { id: id(index), ..measured[index] }).collect::<Vec<_>>()
    };
    refused(&coded(&line), &on_line, &["32, 123, 336, 366", "lie on a line"]);
    let swapped = [(10, 123), (16, 32), (46, 366), (52, 515)];
    refused(&coded(&swapped), &layout, &["do not lie as on the layout"]);
    let error = correspond(&[], &layout, SIZE).map(|found| found.rms);
    assert_eq!(error, Err(MatchError::NoTargets));
}
