//! `concentric render`: a frame or a sweep of frames, with the truth beside each.

use super::camera::Pose;
use super::coded::CodeRing;
use super::options::{CameraOptions, Over, PhotometryOptions, TargetOptions};
use super::scene::{Frame, Scene};
use super::target::Target;
use super::texture::Texture;
use anyhow::{Context, Result, bail, ensure};
use image::GrayImage;
use indicatif::{ProgressBar, ProgressStyle};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Render frames of concentric-circle targets, and the truth about them as JSON beside each.
///
/// Coverage of every pixel is exact to 1e-6 of the contrast. Tilt, azimuth, distance, blur and noise take a
/// number or a range start:stop:steps; with ranges, every combination gives a frame, OUT-0000.png,
/// OUT-0001.png, ..., the last of the ranges in this order changing fastest, each with the next seed.
///
/// The truth, OUT.json, gives for each target the true centre x, y (px, pixel centres at integers), and for
/// each of its outlines, outermost first, the exact ellipse x, y, a, b (px), theta (radians), without lens
/// distortion, the share of its circumference that is hidden, and the arcs that are seen (degrees, as seen
/// from the ellipse's centre, from +x towards +y).
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Picture to write, .png or .pgm; - writes a PGM to standard output (and no truth)
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Seed of all that is random; the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    #[command(flatten)]
    camera: CameraOptions,
    #[command(flatten)]
    targets: TargetOptions,
    #[command(flatten)]
    photometry: PhotometryOptions,
}

/// Most frames of a sweep: the files have four digits.
const MOST_FRAMES: usize = 10_000;
/// Most targets of a board.
const MOST_ON_BOARD: u64 = 10_000;
/// Size of the clouds of a textured background, px.
const CLOUDS: f64 = 24.0;

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug)]
struct Step {
    tilt: f64,
    azimuth: f64,
    distance: f64,
    blur: f64,
    noise: f64,
    seed: u64,
}

/// Renders and writes the frames.
///
/// # Errors
/// When an option or a combination of options is not possible (says which and what is allowed), or a file
/// cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let steps = steps(args)?;
    let to_stdout = args.out.as_os_str() == "-";
    ensure!(!to_stdout || steps.len() == 1, "--out -: a sweep of {} frames needs a file name", steps.len());
    let scenes = steps.iter().map(|step| Ok((scene(args, *step)?, step.seed))).collect::<Result<Vec<_>>>()?;
    if let (true, Some((scene, seed))) = (to_stdout, scenes.first()) {
        let picture = pgm(&scene.render(*seed));
        return std::io::stdout().lock().write_all(&picture).context("cannot write to standard output");
    }
    let extension = args.out.extension().and_then(|extension| extension.to_str()).unwrap_or("");
    ensure!(matches!(extension, "png" | "pgm"), "--out {}: must end in .png or .pgm", args.out.display());

    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left")?;
    let bar = if scenes.len() > 1 { ProgressBar::new(scenes.len() as u64) } else { ProgressBar::hidden() };
    let bar = bar.with_style(style);
    for (i, (scene, seed)) in scenes.iter().enumerate() {
        let path = if scenes.len() > 1 { numbered(&args.out, i) } else { args.out.clone() };
        let frame = scene.render(*seed);
        write(&frame, &path).with_context(|| format!("cannot write {}", path.display()))?;
        frame.truth.write(&path.with_extension("json"))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

/// All combinations of the ranges.
fn steps(args: &Args) -> Result<Vec<Step>> {
    let (targets, light) = (&args.targets, &args.photometry);
    let ranges = [&targets.tilt, &targets.azimuth, &targets.distance, &light.blur, &light.noise];
    let count = ranges.iter().fold(1_usize, |count, range| count.saturating_mul(range.values().len()));
    ensure!(count <= MOST_FRAMES, "{count} frames: a sweep has at most {MOST_FRAMES}");
    let mut combinations = vec![Vec::new()];
    for range in ranges {
        let extended =
            |head: &Vec<f64>| range.values().iter().map(|v| [&head[..], &[*v]].concat()).collect::<Vec<_>>();
        combinations = combinations.iter().flat_map(extended).collect();
    }
    let step = |(i, values): (usize, &Vec<f64>)| match values[..] {
        [tilt, azimuth, distance, blur, noise] => {
            Ok(Step { tilt, azimuth, distance, blur, noise, seed: args.seed.wrapping_add(i as u64) })
        }
        _ => bail!("{} ranges", values.len()),
    };
    combinations.iter().enumerate().map(step).collect()
}

fn scene(args: &Args, step: Step) -> Result<Scene> {
    let options = &args.targets;
    let artwork = options.artwork()?;
    let mut scene = match (options.many, options.board) {
        (Some(_), _) => Scene::empty(args.camera.camera()?),
        (None, Some((columns, rows))) => {
            let count = u64::from(columns) * u64::from(rows);
            ensure!(
                (1..=MOST_ON_BOARD).contains(&count),
                "--board {columns}x{rows}: must have 1 to {MOST_ON_BOARD} targets"
            );
            let spacing = options.spacing.unwrap_or(2.5 * artwork.reach());
            ensure!(
                spacing > 2.0 * artwork.reach(),
                "--spacing {spacing} mm: must be above {} mm, the targets' diameter",
                2.0 * artwork.reach()
            );
            Scene::board(columns, rows, spacing, &artwork, pose(args, step)?)
        }
        (None, None) => {
            let mut scene = Scene::empty(args.camera.camera()?);
            scene.targets.push(Target { artwork: artwork.clone(), pose: pose(args, step)?, at: [0.0, 0.0] });
            scene
        }
    };
    scene.camera = args.camera.camera()?;
    scene.paper = options.paper();
    if let Some(count) = options.many {
        scene.crowd(count as usize, &artwork, args.seed)?;
    }
    number(&mut scene.targets)?;
    scene.validate()?;
    if options.texture > 0.0 {
        scene.texture =
            Some(Texture { amplitude: options.texture, scale: CLOUDS, seed: args.seed.wrapping_add(2) });
    }
    scene.scatter(options.decoys as usize, args.seed.wrapping_add(1))?;
    options.occlude.iter().for_each(|occlude| occlude.apply(&mut scene));
    let (middle, span) = light(args, &scene);
    scene.photometry = args.photometry.photometry(step.blur, step.noise, middle, span);
    scene.validate()?;
    Ok(scene)
}

/// Gives the targets the ids of their code in turn, from that of the first one on.
fn number(targets: &mut [Target]) -> Result<()> {
    let Some(first) = targets.first().and_then(|target| target.artwork.code) else { return Ok(()) };
    let code = first.code.code();
    let mut ids = code.ids().filter(|&id| id >= first.id);
    let count = targets.len();
    for target in targets {
        let id = ids.next().with_context(|| {
            format!("--code {}: fewer than {count} ids from --id {} on", first.code.name(), first.id)
        })?;
        target.artwork.code = Some(CodeRing { id, ..first });
    }
    Ok(())
}

fn pose(args: &Args, step: Step) -> Result<Pose> {
    let camera = args.camera.camera()?;
    let (x, y) = args.targets.position.unwrap_or((camera.cx, camera.cy));
    let jitter = Uniform::new_inclusive(-args.targets.jitter, args.targets.jitter)?;
    let mut random = Pcg64::seed_from_u64(step.seed);
    let (dx, dy) = (jitter.sample(&mut random), jitter.sample(&mut random));
    Ok(Pose { x: x + dx, y: y + dy, distance: step.distance, tilt: step.tilt, azimuth: step.azimuth })
}

/// Where the light is 1, and the length over which it changes.
fn light(args: &Args, scene: &Scene) -> ([f64; 2], f64) {
    let (width, height) = (f64::from(scene.camera.width), f64::from(scene.camera.height));
    match (args.photometry.shading_over, scene.targets.first()) {
        (Over::Target, Some(target)) => {
            let (centre, radius) = target.extent(&scene.camera);
            (centre.into(), 2.0 * radius)
        }
        _ => ([(width - 1.0) / 2.0, (height - 1.0) / 2.0], width),
    }
}

/// `frame.png` becomes `frame-0007.png`.
fn numbered(path: &Path, index: usize) -> PathBuf {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(format!("{}-{index:04}.{}", part(path.file_stem()), part(path.extension())))
}

fn write(frame: &Frame, path: &Path) -> Result<()> {
    if path.extension().is_some_and(|extension| extension == "pgm") {
        return Ok(fs::write(path, pgm(frame))?);
    }
    let (width, height) = (frame.width as u32, frame.height as u32);
    let picture = GrayImage::from_raw(width, height, frame.pixels.clone()).context("frame size")?;
    Ok(picture.save(path)?)
}

/// Binary PGM.
fn pgm(frame: &Frame) -> Vec<u8> {
    let mut bytes = format!("P5\n{} {}\n255\n", frame.width, frame.height).into_bytes();
    bytes.extend_from_slice(&frame.pixels);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Truth;
    use clap::Parser;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        render: Args,
    }

    fn execute(out: &Path, options: &str) -> Result<(), String> {
        let out = ["concentric", "--out", out.to_str().unwrap()];
        let cli = Cli::try_parse_from(out.into_iter().chain(options.split_whitespace()));
        cli.map_err(|error| error.to_string()).and_then(|cli| run(&cli.render).map_err(|e| format!("{e:#}")))
    }

    #[test]
    fn a_sweep_writes_frames_and_truths() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("f.pgm");
        execute(&out, "--size 200x150 --tilt 10:50:3 --noise 0:2:2").unwrap();
        for i in 0..6 {
            let truth = Truth::read(&folder.path().join(format!("f-{i:04}.json"))).unwrap();
            let expected = ([10.0, 30.0, 50.0][i / 2], [0.0, 2.0][i % 2], 1 + i as u64);
            assert_eq!((truth.targets[0].tilt, truth.photometry.noise, truth.seed), expected);
            let bytes = fs::read(folder.path().join(format!("f-{i:04}.pgm"))).unwrap();
            assert!(bytes.starts_with(b"P5\n200 150\n255\n") && bytes.len() == 15 + 200 * 150);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 12);
    }

    #[test]
    fn wrong_options_say_what_is_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("f.png");
        for (options, message) in [
            ("--tilt 95", "must be from -89 to 89"),
            ("--radii 10,20", "must fall, outermost first"),
            ("--mark abcde", "must be plus, dot, or 1 to 4 digits"),
            ("--code five --id 33", "--id 33 is not in the code five"),
            ("--code five", "--id <ID>"),
            ("--code five --id 366 --board 3x1", "fewer than 3 ids from --id 366 on"),
            ("--many 5 --tilt 3", "cannot be used with"),
            ("--many 900 --size 200x150", "900 targets do not fit in 200 x 150 px"),
            ("--board 3x3 --spacing 40", "must be above 48 mm"),
            ("--size 0x10", "each side must be 1 to 8192"),
            ("--black 220 --white 30", "black must be below white"),
            ("--blur 0.01", "must be 0, or 0.02 to 50"),
            ("--distance 800:20:3 --tilt 80", "reaches behind the camera"),
            ("--distance 0.1 --tilt 0", "at most 16384 px"),
            ("--occlude wedge:1,0,0", "occluder 0: share 1: must be above 0 and below 1"),
            ("--occlude disc:9,9,0,0", "radius 0 px: must be 0.1"),
            ("--occlude strip:9,9,3,0,2", "tone 2: must be 0 (black) to 1 (white)"),
            ("--occlude glare:1,2,3", "must be one of wedge:SHARE,DEG,TONE; strip"),
            ("--tilt 0:80:200 --blur 0:2:200", "40000 frames"),
        ] {
            let error = execute(&out, options).unwrap_err();
            assert!(error.contains(message), "{options}: {error}");
        }
        let error = execute(&folder.path().join("f.jpg"), "").unwrap_err();
        assert!(error.contains("must end in .png or .pgm"), "{error}");
        let error = execute(Path::new("-"), "--blur 0:1:2").unwrap_err();
        assert!(error.contains("a sweep of 2 frames"), "{error}");
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            0,
            "nothing is written when an option is wrong"
        );
    }
}
