//! The demonstration: a rendered board under perspective, measured, compared with the truth.

use std::{io::Write, path::PathBuf};

use anyhow::{Context, Result};
use clap::Args as ClapArgs;
use concentric::{Settings, Target, TargetSpec};

use crate::{
    detect::{self, Outcome, command::parse_png_path},
    measure::{distance, px},
    overlay::Overlay,
    picture::Picture,
    render::{Artwork, Frame, Pose, Scene},
    table::{BOLD, FAINT, Table, paint},
};

const SEED: u64 = 1;
const RATIO: f64 = 0.5;
/// Of the board, degrees.
const TILT: f64 = 62.0;
/// A found centre farther from every true one, px, is none of them.
const NEAR: f64 = 5.0;
const HEADER: [&str; 7] = ["#", "true x", "true y", "ellipse centre", "eq. (7)", "exact", "sigma"];

/// Render a board of targets under perspective, measure it, and compare with the truth.
#[derive(Clone, Debug, ClapArgs)]
pub struct Args {
    /// Annotated picture to write
    #[arg(
        long,
        value_name = "FILE.png",
        default_value = "concentric-demo.png",
        value_parser = parse_png_path
    )]
    out: PathBuf,
}

impl Default for Args {
    fn default() -> Self {
        Self { out: PathBuf::from("concentric-demo.png") }
    }
}

/// A target of the board as it was found. All in px.
struct Found {
    /// As on the picture.
    number: usize,
    truth: [f64; 2],
    /// Distances from the truth: of the outer ellipse's centre, of eq. (7), of the exact form; then the distance that
    /// the library itself expects.
    errors: [f64; 4],
}

/// Runs the demonstration: a table on `out`, a picture in a file.
///
/// # Errors
/// Output that cannot be written.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<()> {
    let Frame { width, height, pixels, truth } = board().render(SEED);
    let picture = Picture::new("rendered board", width, height, pixels)?;
    let settings = Settings::new(TargetSpec::ring(RATIO as f32)?);
    let outcome = detect::run(&picture, settings).context("the rendered board")?;
    let centres: Vec<_> = truth.targets.iter().map(|target| [target.x, target.y]).collect();
    let found: Vec<_> = centres.iter().map(|&centre| compare(centre, &outcome)).collect();
    let shown: Vec<_> = found.iter().flatten().map(|found| found.truth).collect();
    Overlay { picture: &picture, outcome: &outcome, truth: &shown }.draw()?.save(&args.out)?;
    out.write_all(report(&centres, &found, &outcome).as_bytes())?;
    writeln!(out, "\npicture: {}", args.out.display())?;
    writeln!(out, "your own: concentric detect PHOTO --overlay marked.png")?;
    Ok(())
}

/// Annuli on a plane before a 12 mm lens, its upper side farther away.
fn board() -> Scene {
    let pose = Pose { x: 645.0, y: 530.0, distance: 395.0, tilt: TILT, azimuth: 192.0 };
    let radius = 16.0;
    Scene::board(4, 4, 40.0, &Artwork::annulus(radius, radius * RATIO), pose)
}

fn compare(truth: [f64; 2], outcome: &Outcome) -> Option<Found> {
    let off = |target: &Target| distance(px(target.exact), truth);
    let numbered = (1..).zip(&outcome.targets);
    let (number, target) = numbered.min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)))?;
    let outer = target.circles.first()?;
    let places = [outer.ellipse.centre, target.eq7, target.exact];
    let [ellipse, eq7, exact] = places.map(|place| distance(px(place), truth));
    let sigma = f64::from(target.covariance.xx + target.covariance.yy).max(0.0).sqrt();
    (exact < NEAR).then_some(Found { number, truth, errors: [ellipse, eq7, exact, sigma] })
}

fn report(centres: &[[f64; 2]], found: &[Option<Found>], outcome: &Outcome) -> String {
    let count = found.iter().flatten().count();
    let wrong = outcome.targets.len().saturating_sub(count);
    let ms = outcome.elapsed.as_secs_f64() * 1e3;
    let rms = rms(found);
    let [ellipse, _, exact, _] = rms;
    [
        paint(BOLD, &format!("Where do the centres of circles project, seen at {TILT} degrees?")),
        format!("A rendered board of {} targets, each two concentric circles:", centres.len()),
        format!("{count} found, {wrong} false, in {ms:.2} ms. All in px:\n"),
        table(centres, found, rms).to_string(),
        paint(FAINT, "The true centre; how far off it are the ellipse's centre, eq. (7), the exact form;"),
        paint(FAINT, "how far off the library itself expects the last to be (1 sigma)."),
        String::new(),
        format!("The centre of the ellipse is {ellipse:.3} px off."),
        format!("The exact centre is {exact:.4} px off, {:.0} times less.\n", ellipse / exact),
    ]
    .join("\n")
}

fn table(centres: &[[f64; 2]], found: &[Option<Found>], rms: [f64; 4]) -> Table {
    let digits = |errors: [f64; 4]| errors.map(|error| format!("{error:.4}"));
    let mut table = Table::new(&HEADER);
    for (centre, found) in centres.iter().zip(found) {
        let number = found.as_ref().map_or("-".to_owned(), |found| found.number.to_string());
        let mut cells = vec![number, format!("{:.3}", centre[0]), format!("{:.3}", centre[1])];
        match found {
            Some(found) => cells.extend(digits(found.errors)),
            None => cells.extend(["not found", "", "", ""].map(str::to_owned)),
        }
        table.row(cells);
    }
    let mut cells = ["RMS", "", ""].map(str::to_owned).to_vec();
    cells.extend(digits(rms));
    table.row(cells);
    table
}

/// Root mean square of each column.
fn rms(found: &[Option<Found>]) -> [f64; 4] {
    std::array::from_fn(|column| {
        let squares: Vec<_> = found.iter().flatten().map(|found| found.errors[column].powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    })
}
