//! Coded targets: found as plain ones are, and identified.

mod common;

use common::detect_with;
use concentric::{Code, Flags, Image, Settings, Target, TargetSpec, code};
use concentric_host::{
    layout::CodeName,
    measure::{distance, px},
    render::{
        Artwork, Camera, CodeRing, Cover, Frame, Occluder, Pose, Scene, Target as Printed, Texture, Tone,
    },
};
use rand_distr::{Distribution, Uniform};
use rand_pcg::{Pcg64, rand_core::SeedableRng};
use rayon::prelude::*;

/// Coded targets of a test.
const FEW_CODED: u64 = 3000;
/// Least side of a frame that holds more than the target, px.
const ROOMY: f64 = 128.0;

/// What a coded target of this outer radius takes up, px from its centre.
fn code_reach(radius: f64) -> f64 {
    2.3 * radius
}

/// A dark annulus of ratio 0.5 and this outer semi-major axis, px, in the middle of a frame that is as small as can be, or has at least this side.
fn scene_in(side: f64, radius: f64, tilt: f64, azimuth: f64) -> Scene {
    let side = (2.0 * code_reach(radius) + 16.0).max(side) as u32;
    let camera = Camera::new(side, side, 1000.0);
    let middle = f64::from(side - 1) / 2.0;
    let pose = Pose { x: middle + 0.3, y: middle - 0.2, distance: 1000.0, tilt, azimuth };
    let mut scene = Scene::empty(camera);
    scene.targets.push(Printed { artwork: Artwork::annulus(radius, radius / 2.0), pose, at: [0.0, 0.0] });
    scene
}

fn scene(radius: f64, tilt: f64, azimuth: f64) -> Scene {
    scene_in(ROOMY, radius, tilt, azimuth)
}

fn coded(mut scene: Scene, code: CodeName, id: u16, angle: f64) -> Scene {
    scene.targets[0].artwork.code = Some(CodeRing { code, id, angle });
    scene
}

fn spec() -> TargetSpec {
    TargetSpec::ring(0.5).unwrap()
}

/// The targets of a frame, read with the code of the settings.
fn read(frame: &Frame, settings: Settings) -> Vec<Target> {
    let (mut targets, _) = detect_with(frame, settings);
    let image = Image::new(&frame.pixels, frame.width as u16, frame.height as u16).unwrap();
    targets.iter_mut().for_each(|target| {
        code::read(&image, &settings, target);
    });
    targets
}

/// Every id of both codes at a large size and some tilt: one target, its id, its direction.
#[test]
fn every_id_is_read() {
    let mut failures = Vec::new();
    for (name, code) in [(CodeName::Cct14, Code::cct14()), (CodeName::Cct12, Code::cct12())] {
        for id in code.ids() {
            let (angle, azimuth) = (f64::from(id) * 7.3, f64::from(id) * 31.0);
            let mut scene = coded(scene(24.0, 40.0, azimuth), name, id, angle);
            scene.photometry.noise = 5.0;
            let frame = scene.render(id.into());
            for spec in [spec(), TargetSpec::any()] {
                let targets = read(&frame, Settings::new(spec).code(code));
                let circles: Vec<_> = targets.iter().map(|target| target.circles.len()).collect();
                let read = targets.first().and_then(|target| target.code);
                if circles != [2] || read.is_none_or(|read| (read.id, read.wrong) != (id, 0)) {
                    failures
                        .push(format!("{name:?} {id} {:?}: {circles:?} circles, {read:?}", spec.ratios()));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}

/// Frames of a test: the number in this variable, or few.
fn frames(variable: &str, few: u64) -> u64 {
    std::env::var(variable).ok().map_or(few, |text| text.parse().expect("a number of frames"))
}

struct Random(Pcg64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).unwrap().sample(&mut self.0)
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.within(0.0, choices.len() as f64) as usize]
    }
}

/// A coded target of a random id, tilt up to 60 degrees, with segments from 3 px on, under noise 5; and its id.
fn random_coded(seed: u64, side: f64) -> (Scene, CodeName, u16) {
    let mut random = Random::new(seed);
    let name = random.of(&[CodeName::Cct14, CodeName::Cct12, CodeName::Five]);
    let ids: Vec<u16> = name.code().ids().collect();
    let id = random.of(&ids);
    let tilt = random.within(0.0, 60.0);
    // The least side of a segment is its width across the ring, seen at the tilt.
    let least = 3.0 / f64::from(code::OUTER - code::INNER) / tilt.to_radians().cos();
    let radius = least * random.within(1.0, 2.0);
    let mut scene =
        coded(scene_in(side, radius, tilt, random.within(0.0, 360.0)), name, id, random.within(0.0, 360.0));
    scene.photometry.noise = 5.0;
    if random.within(0.0, 1.0) < 0.5 {
        scene.paper = Tone::Dark;
        scene.targets[0].artwork.ink = Tone::Light;
    }
    // As far off the middle as the frame leaves room.
    let room = f64::from(scene.camera.width) / 2.0 - code_reach(radius) - 7.0;
    let pose = &mut scene.targets[0].pose;
    (pose.x, pose.y) = (pose.x + random.within(-room, room), pose.y + random.within(-room, room));
    (scene, name, id)
}

/// Failures among `count` random targets in frames of this side or more, a line each.
fn failures(count: u64, side: f64) -> Vec<String> {
    (0..count)
        .into_par_iter()
        .filter_map(|seed| {
            let (scene, name, id) = random_coded(seed, side);
            let spec = if scene.paper == Tone::Dark { spec().light() } else { spec() };
            let targets = read(&scene.render(seed), Settings::new(spec).code(name.code()));
            let found: Vec<_> = targets.iter().map(|target| target.code.map(|code| code.id)).collect();
            let Pose { tilt, .. } = scene.targets[0].pose;
            let radius = scene.targets[0].artwork.radii[0];
            (found != [Some(id)])
                .then(|| format!("{seed}: {name:?} {id}, tilt {tilt:.1}, radius {radius:.1}: {found:?}"))
        })
        .collect()
}

/// A radius of 7.6 px in noise of 5 grey levels: too few points of its outer circle lie in what passes for even light.
const LEFT_OUT: &str = "1943: Cct12 131,";

/// No id is wrong, and no target is left out but that one; of many more frames than these one in a thousand may be.
/// `CONCENTRIC_CODED=100000` for many.
#[test]
fn ids_are_right_at_any_tilt() {
    let count = frames("CONCENTRIC_CODED", FEW_CODED);
    for (what, side) in [("with room about", ROOMY), ("that fill the frame", 0.0)] {
        let failures = failures(count, side);
        println!("{what}: {} of {count} coded targets identified", count as usize - failures.len());
        let (unfound, wrong): (Vec<_>, Vec<_>) = failures
            .iter()
            .filter(|line| !(line.starts_with(LEFT_OUT) && line.ends_with(": []")))
            .partition(|line| line.ends_with(": []"));
        assert!(wrong.is_empty(), "{what}: {wrong:#?}");
        assert!(unfound.len() as u64 <= count.saturating_sub(FEW_CODED) / 1000, "{what}: {unfound:#?}");
    }
}

/// Clutter and uncoded rings; in every other frame spots and strips of ink lie where the segments of a code would be.
fn random_clutter(seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::many(2, 200, 150, false, seed).expect("two targets fit");
    scene.photometry.noise = random.within(0.0, 5.0);
    if seed.is_multiple_of(2) {
        for _ in 0..7 {
            // As many as there is room for.
            let _ = scene.scatter(1, random.within(0.0, 1e15) as u64);
        }
    } else {
        for target in 0..scene.targets.len() {
            let (centre, radius) = scene.targets[target].extent(&scene.camera);
            for _ in 0..random.within(2.0, 12.0) as u32 {
                let (turn, out) = (random.within(0.0, std::f64::consts::TAU), random.within(1.3, 1.9));
                let (x, y) = (centre.x + out * radius * turn.cos(), centre.y + out * radius * turn.sin());
                let size = radius * random.within(0.1, 0.4);
                let direction = random.within(0.0, 180.0);
                let cover = if random.within(0.0, 1.0) < 0.5 {
                    Cover::Disc { x, y, radius: size }
                } else {
                    Cover::Strip { x, y, width: size, length: 3.0 * size, direction }
                };
                scene.occluders.push(Occluder { cover, tone: 0.0 });
            }
        }
    }
    if random.within(0.0, 1.0) < 0.5 {
        let amplitude = random.within(0.1, 0.9);
        scene.texture = Some(Texture { amplitude, scale: random.within(4.0, 30.0), seed });
    }
    scene
}

/// `CONCENTRIC_CLUTTER=100000` for many.
#[test]
fn nothing_without_a_code_has_an_id() {
    let count = frames("CONCENTRIC_CLUTTER", 3000);
    let codes = [CodeName::Cct14, CodeName::Cct12, CodeName::Five];
    let (wrong, targets) = (0..count)
        .into_par_iter()
        .map(|seed| {
            let frame = random_clutter(seed).render(seed);
            let name = codes[(seed / 2 % 3) as usize];
            let found = read(&frame, Settings::new(TargetSpec::any()).code(name.code()));
            let ids = found.iter().filter_map(|target| target.code);
            let wrong: Vec<_> = ids.map(|code| format!("{seed}: {name:?} {code:?}")).collect();
            (wrong, found.len())
        })
        .reduce(|| (Vec::new(), 0), |(a, n), (b, m)| ([a, b].concat(), n + m));
    println!("{} ids in {count} frames with {targets} targets, none of them coded", wrong.len());
    assert!(
        targets as u64 > count,
        "most rings must be found for this to mean anything: {targets} in {count}"
    );
    assert!(wrong.is_empty(), "{} wrong ids\n{}", wrong.len(), wrong.join("\n"));
}

/// The id that the middles of the segments make, taken by themselves: dark is what is nearer to the ink than to the paper.
fn careless(frame: &Frame, code: &Code, target: &Target) -> Option<u16> {
    let ellipse = &target.circles[0].ellipse;
    let [x, y] = px(ellipse.centre);
    let (sin, cos) = f64::from(ellipse.theta).sin_cos();
    let level = |radius: f64, turn: f64| {
        let (u, v) = (radius * f64::from(ellipse.a) * turn.cos(), radius * f64::from(ellipse.b) * turn.sin());
        let (column, row) = ((x + u * cos - v * sin).round(), (y + u * sin + v * cos).round());
        frame.pixels.get(row as usize * frame.width + column as usize).map_or(0.0, |&level| level.into())
    };
    let middle = level(0.0, 0.0) - f64::from(target.contrast) / 2.0;
    let radius = f64::from(0.5 * (code::INNER + code::OUTER));
    (0..16).find_map(|phase| {
        let turn = |segment: u32| (f64::from(segment) + f64::from(phase) / 16.0) / f64::from(code.segments());
        let bit = |segment| u16::from(level(radius, std::f64::consts::TAU * turn(segment)) < middle);
        code.decode((0..code.segments()).fold(0, |word, segment| word << 1 | bit(segment)))
            .map(|read| read.id)
    })
}

/// Seeds of clutter, and the codes that a reader that only looks at the middle of the segments finds there.
const LOOKALIKES: [(u64, CodeName); 12] = [
    (1005209, CodeName::Cct12),
    (1007233, CodeName::Cct12),
    (1007233, CodeName::Cct14),
    (1013055, CodeName::Cct14),
    (1020049, CodeName::Cct12),
    (1028869, CodeName::Cct12),
    (1028869, CodeName::Cct14),
    (1029247, CodeName::Cct14),
    (1032061, CodeName::Cct12),
    (1039163, CodeName::Cct14),
    (1000389, CodeName::Five),
    (1000727, CodeName::Five),
];

/// Frames in which spots and strips lie where the middles of an id's segments would be. None of them has the shape of a segment.
#[test]
fn what_only_resembles_a_code_has_no_id() {
    for (seed, name) in LOOKALIKES {
        let frame = random_clutter(seed).render(seed);
        let found = read(&frame, Settings::new(TargetSpec::any()).code(name.code()));
        let careless: Vec<_> =
            found.iter().filter_map(|target| careless(&frame, &name.code(), target)).collect();
        assert!(!careless.is_empty(), "{seed}: not even a careless reader takes this for a code");
        assert!(found.iter().all(|target| target.code.is_none()), "{seed}: read, as {careless:?} carelessly");
    }
}

/// RMS error of the centre, px, and what the covariances say, over 300 frames with or without a code.
fn errors(radius: f64, tilt: f64, with: bool) -> (f64, f64) {
    let count = 300;
    let error = |seed: u64| {
        let mut one = scene(radius, tilt, 13.0 * seed as f64);
        one.targets[0].pose.x += (seed as f64 * 0.618).fract();
        one.targets[0].pose.y += (seed as f64 * 0.414).fract();
        if with {
            one = coded(one, CodeName::Cct14, (seed % 516 + 1) as u16, 29.0 * seed as f64);
        }
        let frame = one.render(seed);
        let targets = read(&frame, Settings::new(spec()).code(Code::cct14()));
        let [target] = targets.as_slice() else { return None };
        // One that is taken for partly hidden counts as not found.
        if target.flags.contains(Flags::OCCLUDED) {
            return None;
        }
        let truth = &frame.truth.targets[0];
        let variance = target.covariance.xx + target.covariance.yy;
        Some((distance(px(target.centre), [truth.x, truth.y]), f64::from(variance)))
    };
    let errors: Vec<_> = (0..count).into_par_iter().filter_map(error).collect();
    assert!(100 * errors.len() >= 99 * count as usize, "radius {radius} tilt {tilt}: {} found", errors.len());
    let mean =
        |f: &dyn Fn(&(f64, f64)) -> f64| (errors.iter().map(f).sum::<f64>() / errors.len() as f64).sqrt();
    let (rms, sigma) = (mean(&|(error, _)| error * error), mean(&|(_, variance)| *variance));
    let what = if with { "coded" } else { "plain" };
    println!("radius {radius} px, tilt {tilt}, {what}: {rms:.4} px (sigma {sigma:.4})");
    (rms, sigma)
}

/// Where 4 px or more are between circle and code. Outside of the outer circle only what is next to it tells the level of the
/// paper.
#[test]
fn a_code_costs_hardly_any_accuracy() {
    for (radius, tilt) in [(12.0, 20.0), (15.0, 45.0), (21.0, 60.0), (24.0, 40.0)] {
        let (plain, coded) = (errors(radius, tilt, false), errors(radius, tilt, true));
        assert!(coded.0 < 1.1 * plain.0 && coded.1 < 1.1 * plain.1, "radius {radius} tilt {tilt}");
    }
}

/// Where they are nearer it does cost accuracy, and the covariance says so.
#[test]
fn a_code_too_near_makes_the_centre_less_sure() {
    for (radius, tilt) in [(10.0, 20.0), (15.0, 60.0)] {
        let (plain, coded) = (errors(radius, tilt, false), errors(radius, tilt, true));
        assert!(coded.0 < 3.0 * plain.0 && coded.0 < 1.3 * coded.1, "radius {radius} tilt {tilt}");
    }
}
