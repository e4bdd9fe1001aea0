//! Arguments of `calibrate`, and its loop over the views.

use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, anyhow, ensure};
use clap::{Args as ClapArgs, ValueEnum};
use concentric::Compensation;

use super::{
    Options, calibrate, file,
    input::{Input, Measuring, Seen, files},
    listing, plots,
};
use crate::{cli::complain, detect::command::progress, layout::Layout};

/// Most views. The time grows with their cube.
const MAX_VIEWS: usize = 150;

const EXAMPLES: &str = "\
Examples:
  concentric calibrate --layout board.txt views/                  a folder of pictures
  concentric calibrate --layout board.txt --out camera.json --plot residuals.svg *.png
  concentric calibrate --layout board.txt --every 10 record.bin   every tenth frame that `monitor --raw` recorded
  concentric detect --camera camera.json photo.png                what it is good for

Four views or more are wanted, better eight, of one camera with fixed focus and zoom: the board turned, tilted by 20 to 50
degrees in different directions, and once in each corner of the frame.";

/// Calibrate a camera from pictures or recorded reports of a board with coded targets.
///
/// Focal lengths, principal point and lens distortion in OpenCV's terms, with standard deviations. Coordinates are px; the
/// centre of the top-left pixel is (0, 0)
#[derive(Clone, Debug, ClapArgs)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// PNG, PGM or JPEG files, folders of them, or recordings of a head's reports
    #[arg(required = true, value_name = "VIEW")]
    views: Vec<PathBuf>,

    /// The targets on the board: places, radii and ids
    #[arg(long, value_name = "FILE")]
    layout: PathBuf,

    /// Write the camera as JSON, as `detect --camera` and OpenCV read it
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,

    /// Draw the residuals
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,

    /// Where the centre of a target is taken to be; recordings have the centre that the head sent
    #[arg(long, value_enum, default_value = "exact")]
    centre: Centre,

    /// Measure the targets again on the pixels: slower, at the limit of what the noise allows
    #[arg(long)]
    refine: bool,

    /// One focal length: fx = fy
    #[arg(long)]
    square: bool,

    /// Radial terms of the lens: none, k1, k1 and k2, or k1 to k3
    #[arg(long, value_name = "0..3", default_value_t = 3, value_parser = clap::value_parser!(u8).range(0..=3))]
    radial: u8,

    /// A lens without tangential terms: p1 = p2 = 0
    #[arg(long)]
    no_tangential: bool,

    /// All targets count alike, whatever their covariances say
    #[arg(long)]
    unweighted: bool,

    /// Take every Nth frame of a recording only
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Centre {
    /// The true centre, by the form that holds under any perspective
    Exact,
    /// The true centre by eq. (7) of Huo et al. 2013
    Eq7,
    /// The centre of the outer ellipse, corrected with the camera, the pose and the radius of the moment (Heikkila and
    /// Silven 1997)
    Pose,
    /// The centre of the outer ellipse as it is, for comparison
    None,
}

impl Args {
    fn options(&self) -> Options {
        Options {
            same_focal: self.square,
            radial: self.radial,
            tangential: !self.no_tangential,
            weighted: !self.unweighted,
            ..Options::default()
        }
    }

    fn measuring(&self) -> Result<Measuring> {
        let compensation = match self.centre {
            Centre::Exact => Compensation::Exact,
            Centre::Eq7 => Compensation::Eq7,
            Centre::Pose | Centre::None => Compensation::None,
        };
        let measuring = Measuring::new(Layout::read(&self.layout)?)?.compensation(compensation);
        Ok(Measuring { ellipses: self.centre == Centre::Pose, refine: self.refine, ..measuring })
    }
}

/// Runs `calibrate`. Says on standard error which views are left out and why; whether all pictures could be used in the
/// result.
///
/// # Errors
/// A layout that is none, views that do not tell the camera, a file that cannot be written.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<bool> {
    let measuring = args.measuring()?;
    let files = files(&args.views)?;
    let (seen, left_out) = gather(args, &measuring, &files)?;
    ensure!(
        seen.len() <= MAX_VIEWS,
        "{} views; at most {MAX_VIEWS} are taken: give fewer, or --every {} for a recording",
        seen.len(),
        args.every as usize * seen.len().div_ceil(MAX_VIEWS)
    );
    let views: Vec<_> = seen.iter().map(|seen| seen.view.clone()).collect();
    let found = calibrate(&views, &args.options())
        .map_err(|error| anyhow!(listing::refusal(&error, left_out.pictures + left_out.frames)))?;
    for (path, text) in [(&args.out, file::json(&found)?), (&args.plot, plots::residuals(&found)?.svg)] {
        if let Some(path) = path {
            fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    write!(out, "{}{}", listing::text(&found), listing::matches(&seen, left_out.frames))?;
    Ok(left_out.pictures == 0)
}

/// What could not be used.
#[derive(Default)]
struct LeftOut {
    pictures: usize,
    frames: usize,
}

fn gather(args: &Args, measuring: &Measuring, files: &[PathBuf]) -> Result<(Vec<Seen>, LeftOut)> {
    let bar = progress(files.len());
    let (mut seen, mut left_out) = (Vec::new(), LeftOut::default());
    for path in files {
        bar.set_message(path.display().to_string());
        match one(args, measuring, path) {
            Ok(views) => {
                left_out.frames += views.iter().filter(|view| view.is_none()).count();
                seen.extend(views.into_iter().flatten());
            }
            Err(error) => {
                left_out.pictures += 1;
                bar.suspend(|| complain(&format!("{}: {error:#}", path.display())));
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok((seen, left_out))
}

/// The views of a file; `None` for a frame of a recording in which too few targets are seen.
fn one(args: &Args, measuring: &Measuring, path: &Path) -> Result<Vec<Option<Seen>>> {
    match Input::read(path)? {
        Input::Picture(picture) => Ok(vec![Some(measuring.picture(&picture)?)]),
        Input::Recording(bytes) => {
            let views = measuring.recording(&path.to_string_lossy(), &bytes)?;
            ensure!(
                matches!(args.centre, Centre::Exact),
                "a recording has the centres that the head sent: --centre is for pictures"
            );
            Ok(views.into_iter().step_by(args.every as usize).map(Result::ok).collect())
        }
    }
}
