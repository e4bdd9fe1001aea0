//! How accurate, how many found.

use concentric::{Position, Target, TargetSpec};
use concentric_host::{
    measure::{distance, px},
    render::{Artwork, Camera, Frame, Mark, Photometry, Pose, Scene, Shading, Style, Target as Drawn},
};

use crate::{
    common::{detect, errors},
    document::{rounded, table},
};

/// Camera constant, px, and distance, mm, of the accuracy figures and of most frames here.
const F: f64 = 2580.0;
const DISTANCE: f64 = 800.0;

fn ring() -> TargetSpec {
    TargetSpec::ring(0.5).expect("a ratio")
}

/// `work` on every item, on all processors.
pub fn parallel<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = items.len().div_ceil(threads).max(1);
    let run = |part: &[T]| part.iter().map(&work).collect::<Vec<_>>();
    std::thread::scope(|scope| {
        let threads: Vec<_> = items.chunks(share).map(|part| scope.spawn(|| run(part))).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("no panic")).collect()
    })
}

pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) =
        values.into_iter().fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count)).sqrt()
}

/// An annulus of outer semi-axis `size` px and this ratio in the middle of a small frame.
pub fn small(size: f64, ratio: f64, tilt: f64, trial: u32) -> Scene {
    let [turn, x, y] = walk(f64::from(trial) + size + tilt);
    let camera = Camera::new(320, 240, F);
    let pose = Pose { x: 160.0 + x, y: 120.0 + y, distance: DISTANCE, tilt, azimuth: 360.0 * turn };
    let radius = size * DISTANCE / F;
    let mut scene = Scene::empty(camera);
    scene.targets.push(Drawn { artwork: Artwork::annulus(radius, radius * ratio), pose, at: [0.0, 0.0] });
    scene
}

/// A direction in turns and a place within a pixel, px, that go over their ranges without a pattern.
fn walk(step: f64) -> [f64; 3] {
    [0.381_966, 0.618_034, 0.754_878].map(|part| (step * part).fract())
}

const RADII: [f64; 6] = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
const TILTS: [f64; 6] = [12.0, 24.0, 36.0, 48.0, 60.0, 72.0];
const TRIALS: u32 = 2;

/// Distances from the truth, px, and what the library expects.
#[derive(Clone, Copy)]
struct Errors {
    ellipse: f64,
    eq7: f64,
    exact: f64,
    known: f64,
    sigma: f64,
}

fn only(targets: &[Target]) -> &Target {
    assert_eq!(targets.len(), 1, "one target");
    &targets[0]
}

fn compare(frame: &Frame) -> Errors {
    let truth = [frame.truth.targets[0].x, frame.truth.targets[0].y];
    let off = |place: Position| distance(px(place), truth);
    let (any, _) = detect(frame, TargetSpec::any());
    let (known, _) = detect(frame, ring());
    let any = only(&any);
    Errors {
        ellipse: off(any.circles[0].ellipse.centre),
        eq7: off(any.eq7),
        exact: off(any.exact),
        known: off(only(&known).centre),
        sigma: f64::from(any.covariance.xx + any.covariance.yy).sqrt(),
    }
}

fn errors_with_noise(noise: f64) -> Vec<Errors> {
    let cells: Vec<_> = RADII.iter().flat_map(|&r| TILTS.map(|tilt| (r, tilt))).collect();
    let cells: Vec<_> = cells.iter().flat_map(|&cell| (0..TRIALS).map(move |trial| (cell, trial))).collect();
    parallel(&cells, |&((radius, tilt), trial)| {
        let [turn, x, y] = walk(f64::from(trial) + radius + tilt);
        let mut scene = Scene::single(radius, tilt, 360.0 * turn, [x - 0.5, y - 0.5]);
        scene.photometry.noise = noise;
        compare(&scene.render(u64::from(trial) + (radius * 1000.0 + tilt) as u64))
    })
}

pub fn accuracy() -> String {
    let [clean, noisy] = [0.0, 2.0].map(errors_with_noise);
    let row = |name: &str, pick: fn(&Errors) -> f64| {
        vec![name.to_owned(), rounded(rms(clean.iter().map(pick))), rounded(rms(noisy.iter().map(pick)))]
    };
    let frames = clean.len();
    let [radii, tilts] =
        [RADII, TILTS].map(|values| format!("{} to {}", values[0], values[values.len() - 1]));
    let Camera { width, height, f, .. } = Camera::paper();
    let caption = format!(
        "One annulus, ratio 0.5, outer radii {radii} mm, {DISTANCE} mm before a camera of {width} x {height} px with a focal \
         length of {f:.0} px,\ntilted by {tilts} degrees; blur {}.\n\n",
        Photometry::default().blur
    );
    caption
        + &table(
            &[
                "RMS distance from the true centre, px",
                &format!("no noise, {frames} frames"),
                &format!("noise of 2 grey levels, {frames} frames"),
            ],
            &[
                row("centre of the outer ellipse", |e| e.ellipse),
                row("eq. (7), ratio not given", |e| e.eq7),
                row("exact form, ratio not given", |e| e.exact),
                row("exact form, ratio given", |e| e.known),
                row("what the reported covariances say, ratio not given", |e| e.sigma),
            ],
        )
}

/// Frames of one kind.
struct Kind {
    name: String,
    scenes: Vec<Scene>,
}

fn crowds(name: &str, width: u32, height: u32, count: u64, photometry: Photometry) -> Kind {
    let scene = |seed| {
        let scene = Scene::many(60, width, height, true, seed).expect("sixty targets fit");
        Scene { photometry, ..scene }
    };
    Kind { name: name.to_owned(), scenes: (0..count).map(scene).collect() }
}

/// Single targets of several sizes and tilts.
fn singles(name: &str, change: impl Fn(&mut Scene, u32)) -> Kind {
    let mut scenes = Vec::new();
    for size in [32.0, 64.0, 96.0] {
        for tilt in [0.0, 20.0, 40.0, 60.0] {
            let mut scene = small(size, 0.5, tilt, scenes.len() as u32);
            change(&mut scene, scenes.len() as u32);
            scenes.push(scene);
        }
    }
    Kind { name: name.to_owned(), scenes }
}

fn kinds() -> Vec<Kind> {
    let light = Photometry::default();
    let [dim, bright] =
        [(20.0, 60.0), (190.0, 240.0)].map(|(black, white)| Photometry { black, white, ..light });
    let marks = [Mark::Plus, Mark::Dot, Mark::Digits("58".into())];
    vec![
        crowds("60 targets among 60 decoys, 640 x 480", 640, 480, 10, light),
        crowds("60 targets among 60 decoys, 1280 x 1024", 1280, 1024, 4, light),
        crowds("the same, 640 x 480, black 20 and white 60", 640, 480, 4, dim),
        crowds("the same, 640 x 480, black 190 and white 240", 640, 480, 4, bright),
        singles("30 % less light at one end of the target than at the other", |scene, _| {
            let target = &scene.targets[0];
            let [x, y, span] = [target.pose.x, target.pose.y, 2.0 * target.artwork.reach() * F / DISTANCE];
            scene.photometry.shading = Some(Shading { fraction: 0.3, direction: 30.0, x, y, span });
        }),
        singles("a '+', a dot, digits in the middle", |scene, i| {
            scene.targets[0].artwork.mark = Some(marks[i as usize % marks.len()].clone());
        }),
        singles("drawn as two lines 5 px wide", |scene, _| {
            scene.targets[0].artwork.style = Style::Lines(5.0 * DISTANCE / F);
        }),
    ]
}

pub fn found() -> String {
    let rows = kinds().into_iter().map(|kind| {
        let counts = parallel(&kind.scenes, |scene| {
            let frame = scene.render(kind.scenes.len() as u64);
            let count = |spec| {
                let (targets, _) = detect(&frame, spec);
                let (found, wrong) = errors(&targets, &frame.truth);
                [found.len(), wrong]
            };
            let [[any, any_wrong], [known, known_wrong]] = [count(TargetSpec::any()), count(ring())];
            [frame.truth.targets.len(), any, known, any_wrong + known_wrong]
        });
        let sum = |column: usize| counts.iter().map(|count| count[column]).sum::<usize>().to_string();
        let mut row = vec![kind.name, kind.scenes.len().to_string()];
        row.extend((0..4).map(sum));
        row
    });
    let header = ["frames of", "frames", "targets", "found, ratio not given", "found, ratio given", "false"];
    let Photometry { black, white, noise, blur, .. } = Photometry::default();
    let caption = format!(
        "Targets with ratio 0.5, tilted by up to 60 degrees; where nothing else is said, black is {black}, white {white}, the \
         noise {noise}\ngrey levels, the blur {blur} px.\n\n"
    );
    caption + &table(&header, &rows.collect::<Vec<_>>())
}
