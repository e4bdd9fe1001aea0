//! Arguments of `detect`, and its loop over the images.

use std::{
    collections::HashSet,
    io::Write,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, anyhow, bail, ensure};
use clap::{Args as ClapArgs, ValueEnum};
use concentric::{
    Code, Compensation, Effort, Image, Settings, Target, TargetSpec, coplanar::pool, refine::polish,
};
use indicatif::{ProgressBar, ProgressStyle};

use super::{Outcome, camera, csv, json, listing, run};
use crate::{layout::CodeName, overlay::Overlay, picture::Picture};

/// Find targets in images and print their true centres.
///
/// Coordinates are px; the centre of the top-left pixel is (0, 0), x runs right, y down.
#[derive(Clone, Debug, ClapArgs)]
pub struct Args {
    /// PNG, PGM or JPEG files, `-` for standard input
    ///
    /// 8 or 16 bit, grey or colour, told apart by content, not by name
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,

    /// Inner radii over the outer radius, or `any`
    ///
    /// One to three numbers of 0.1 to 0.95, descending, as in 0.5 or 0.75,0.5. With `any`, targets are two or more
    /// concentric circles of whatever ratios, which are measured
    #[arg(
        long,
        value_name = "R,R..|any",
        default_value = "any",
        value_parser = parse_spec,
        allow_negative_numbers = true
    )]
    ratio: TargetSpec,

    /// Look for light circles on a dark ground
    #[arg(long)]
    light: bool,

    /// Read the code of targets with a ring of segments around them
    ///
    /// A target without one is found all the same, without an id
    #[arg(long, value_enum, value_name = "CODE")]
    code: Option<CodeName>,

    /// The ids that occur, the strongest guard against wrong ones [default: all of the code]
    #[arg(long, value_name = "ID,ID..", value_delimiter = ',', requires = "code")]
    ids: Vec<u16>,

    /// How the true centre is made from the ellipses [default: exact, or known with --camera]
    #[arg(long, value_enum)]
    compensation: Option<Mode>,

    /// The camera: its focal length in px, or a JSON file with its parameters under OpenCV's names
    ///
    /// With `f=PX` the principal point is the middle of the picture. A file has fx, fy, cx, cy (px) and, where the lens
    /// distorts, k1, k2, p1, p2, k3. Edges are then freed from distortion, targets have a normal, and true centres less
    /// than half the noise
    #[arg(long, value_name = "f=PX|FILE.json", value_parser = camera::parse)]
    camera: Option<camera::Given>,

    /// All targets of an image lie on one plane: share the correction
    ///
    /// Needs no camera, but a lens that distorts does. Targets that do not fit on the plane keep their own centres
    #[arg(long)]
    coplanar: bool,

    /// Measure the targets again on the pixels: slower, at the limit of what the noise allows
    ///
    /// Targets that were measured so have the flag `refined`
    #[arg(long)]
    refine: bool,

    /// Measure each target with less effort, as a camera head may: less time, about a tenth more error
    #[arg(long, conflicts_with = "refine")]
    quick: bool,

    /// Follow at most one dark run for N pixels of the picture, as a camera head does to bound its time; 0: no bound
    ///
    /// What is dropped is told with each picture
    #[arg(long, value_name = "N", default_value_t = Settings::DEFAULT_PX_PER_RUN)]
    px_per_run: u16,

    /// Print one JSON object per image and line
    #[arg(long, conflicts_with = "csv")]
    json: bool,

    /// Print one line of comma-separated values per target
    #[arg(long)]
    csv: bool,

    /// Write an annotated picture; with several images FILE-IMAGE.png for each
    ///
    /// It shows the ellipses, their centres B1 and B2, the true centre C with its error, and rejected candidates with
    /// the cause
    #[arg(long, value_name = "FILE.png", value_parser = parse_png_path)]
    overlay: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Mode {
    /// The form of eq. (7) that holds under any perspective
    Exact,
    /// `exact` as far as the correction is significant against its noise
    Auto,
    /// With a known camera: the shapes of the ellipses tell the plane
    Known,
    /// Eq. (7) of Huo et al. 2013
    Eq7,
    /// The centre of the outer ellipse
    None,
}

impl From<Mode> for Compensation {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Exact => Self::Exact,
            Mode::Auto => Self::Auto,
            Mode::Known => Self::Known,
            Mode::Eq7 => Self::Eq7,
            Mode::None => Self::None,
        }
    }
}

/// `any`, or ratios.
///
/// # Errors
/// What is no number, or no ratio that a target can have.
pub fn parse_spec(text: &str) -> Result<TargetSpec> {
    if text == "any" {
        return Ok(TargetSpec::any());
    }
    let number = |part: &str| {
        part.trim().parse::<f32>().map_err(|_| {
            anyhow!(
                "`{part}` is no number; allowed are `any` or one to three ratios of 0.1 to 0.95, \
                 descending, as in 0.75,0.5"
            )
        })
    };
    let ratios = text.split(',').map(number).collect::<Result<Vec<_>>>()?;
    Ok(TargetSpec::circles(&ratios)?)
}

/// A path for a picture that will be written.
///
/// # Errors
/// A name that does not end in `.png`.
pub fn parse_png_path(text: &str) -> Result<PathBuf> {
    let path = PathBuf::from(text);
    let png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    ensure!(png, "the picture is written as PNG: the name must end in .png");
    Ok(path)
}

/// Runs `detect`. Says on standard error which images failed, and whether all went well in the result.
///
/// # Errors
/// Output that cannot be written.
pub fn execute(args: &Args, out: &mut dyn Write) -> Result<bool> {
    let spec = if args.light { args.ratio.light() } else { args.ratio };
    let usual = if args.camera.is_some() { Mode::Known } else { Mode::Exact };
    let mut settings = Settings::new(spec)
        .compensation(args.compensation.unwrap_or(usual).into())
        .px_per_run(args.px_per_run)
        .effort(if args.quick { Effort::Quick } else { Effort::Full });
    settings.code = code(args)?;
    ensure!(
        args.camera.is_some() || settings.compensation != Compensation::Known,
        "--compensation known needs --camera"
    );
    let overlays = overlay_paths(args)?;
    if args.csv {
        out.write_all(csv::HEADER.as_bytes())?;
    }
    let bar = progress(args.images.len());
    let mut all_well = true;
    for (image, overlay) in args.images.iter().zip(overlays) {
        bar.set_message(image.display().to_string());
        match one(image, settings, args, overlay.as_deref()) {
            Ok((picture, outcome)) => {
                let text = if args.json {
                    json::line(&picture, &outcome)?
                } else if args.csv {
                    csv::lines(&picture, &outcome)?
                } else {
                    listing::text(&picture, &outcome)
                };
                bar.suspend(|| out.write_all(text.as_bytes()).and_then(|()| out.flush()))?;
            }
            Err(error) => {
                all_well = false;
                let name = image.display();
                bar.suspend(|| crate::cli::complain(&format!("{name}: {error:#}")));
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all_well)
}

fn code(args: &Args) -> Result<Option<Code>> {
    let Some(name) = args.code else { return Ok(None) };
    let code = name.code();
    if args.ids.is_empty() {
        return Ok(Some(code));
    }
    if let Some(id) = args.ids.iter().find(|&&id| name == CodeName::Five && !code.has(id)) {
        bail!("--ids: {id} is none of the code five: 32, 123, 336, 366, 515");
    }
    Ok(Some(code.only(&args.ids).context("--ids")?))
}

fn one(
    image: &Path,
    mut settings: Settings,
    args: &Args,
    overlay: Option<&Path>,
) -> Result<(Picture, Outcome)> {
    let picture = Picture::read(image)?;
    settings.camera = args.camera.map(|given| given.of(&picture)).transpose()?;
    let mut outcome = run(&picture, settings)?;
    if args.refine {
        let left = refine(&picture, &settings, &mut outcome.targets)?;
        if left > 0 {
            let count = outcome.targets.len();
            let name = image.display();
            crate::cli::complain(&format!(
                "{name}: --refine: {left} of {count} targets are left as they were found"
            ));
        }
    }
    if args.coplanar {
        match pool(&mut outcome.targets, settings.camera.as_ref()) {
            Ok(plane) => outcome.plane = Some(plane),
            // The centres are still right, each by itself.
            Err(error) => crate::cli::complain(&format!("{}: --coplanar: {error}", image.display())),
        }
    }
    if let Some(path) = overlay {
        Overlay { picture: &picture, outcome: &outcome, truth: &[] }.draw()?.save(path)?;
    }
    Ok((picture, outcome))
}

/// Returns how many targets could not be refined.
pub(crate) fn refine(picture: &Picture, settings: &Settings, targets: &mut [Target]) -> Result<usize> {
    let size = (u16::try_from(picture.width)?, u16::try_from(picture.height)?);
    let image = Image::new(&picture.pixels, size.0, size.1)?;
    Ok(targets.iter_mut().filter_map(|target| (!polish(&image, settings, target)).then_some(())).count())
}

/// A bar over images, for two or more of them.
pub(crate) fn progress(images: usize) -> ProgressBar {
    if images < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(images as u64).with_style(style)
}

/// Where the annotated picture of each image goes.
fn overlay_paths(args: &Args) -> Result<Vec<Option<PathBuf>>> {
    let Some(base) = &args.overlay else {
        return Ok(vec![None; args.images.len()]);
    };
    let mut taken = HashSet::new();
    let several = args.images.len() > 1;
    let named = |image: &PathBuf| {
        let mut path = if several { with_suffix(base, &stem(image)) } else { base.clone() };
        for number in 2.. {
            if taken.insert(path.clone()) {
                break;
            }
            path = with_suffix(base, &format!("{}-{number}", stem(image)));
        }
        path
    };
    let paths: Vec<PathBuf> = args.images.iter().map(named).collect();
    let inputs: HashSet<_> = args.images.iter().filter_map(|image| image.canonicalize().ok()).collect();
    for path in &paths {
        if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
            bail!("--overlay would overwrite the image {}; give another name", path.display());
        }
    }
    Ok(paths.into_iter().map(Some).collect())
}

fn stem(image: &Path) -> String {
    match image.file_stem() {
        Some(stem) if image.as_os_str() != "-" => stem.to_string_lossy().into_owned(),
        _ => "stdin".to_owned(),
    }
}

fn with_suffix(base: &Path, suffix: &str) -> PathBuf {
    base.with_file_name(format!("{}-{suffix}.png", base.file_stem().unwrap_or_default().to_string_lossy()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        format!("{:#}", parse_spec(text).unwrap_err())
    }

    #[test]
    fn ratios() {
        assert_eq!(parse_spec("any").unwrap(), TargetSpec::any());
        assert_eq!(parse_spec("0.75, 0.5").unwrap().ratios(), [0.75, 0.5]);
        for bad in ["1.2", "0", "0.5,0.6", "-1", "nan"] {
            assert!(message(bad).contains("0.1..="), "{}", message(bad));
        }
        for bad in ["abc", "", "0.5,"] {
            assert!(
                message(bad).contains("is no number") && message(bad).contains("0.1 to 0.95"),
                "{}",
                message(bad)
            );
        }
        assert!(message("0.9,0.8,0.7,0.6").contains("4 ratios given"));
    }

    fn paths(images: &[&str]) -> Vec<String> {
        let args = Args {
            images: images.iter().map(PathBuf::from).collect(),
            ratio: TargetSpec::any(),
            light: false,
            quick: false,
            px_per_run: Settings::DEFAULT_PX_PER_RUN,
            compensation: None,
            camera: None,
            coplanar: false,
            refine: false,
            json: false,
            csv: false,
            overlay: Some("out/o.png".into()),
            code: None,
            ids: Vec::new(),
        };
        overlay_paths(&args).unwrap().into_iter().flatten().map(|path| path.display().to_string()).collect()
    }

    #[test]
    fn each_image_has_its_own_overlay() {
        assert_eq!(paths(&["a.jpg"]), ["out/o.png"]);
        assert_eq!(paths(&["x/a.jpg", "-", "y/a.png"]), ["out/o-a.png", "out/o-stdin.png", "out/o-a-2.png"]);
    }
}
