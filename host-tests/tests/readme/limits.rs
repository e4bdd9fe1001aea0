//! How far one thing can be driven until targets are missed.

use concentric::{MAX_HEIGHT, MAX_WIDTH, MIN_SIZE, TargetSpec};
use concentric_host::render::{Frame, Scene};

use crate::{
    common::{detect, errors},
    document::{self, rounded},
    figures::{parallel, rms, small},
};

const TRIALS: u32 = 8;
/// Outer semi-axis, px, ratio, and tilt, degrees, where they do not matter.
const SIZE: f64 = 40.0;
const RATIO: f64 = 0.5;
const TILT: f64 = 30.0;
/// Outer semi-axis, px, where an inner circle, a gap or a minor axis would otherwise be too small.
const LARGE: f64 = 80.0;

/// One thing to drive.
struct Ladder {
    name: &'static str,
    unit: &'static str,
    /// From easy to hard.
    steps: &'static [f64],
    /// The frame of a step and a trial.
    frame: fn(f64, u32) -> Frame,
}

const GEOMETRY: [Ladder; 5] = [
    Ladder {
        name: "smallest outer semi-axis, seen from the front",
        unit: "px",
        steps: &[16.0, 14.0, 12.0, 11.0, 10.0, 9.0, 8.0, 7.0, 6.0, 5.0],
        frame: |size, trial| small(size, RATIO, 0.0, trial).render(trial.into()),
    },
    Ladder {
        name: "largest tilt, outer semi-axis 80 px",
        unit: "degrees",
        steps: &[60.0, 65.0, 70.0, 75.0, 78.0, 80.0, 82.0, 84.0, 86.0, 88.0],
        frame: |tilt, trial| small(LARGE, RATIO, tilt, trial).render(trial.into()),
    },
    Ladder {
        name: "largest ratio of the radii, outer semi-axis 80 px",
        unit: "",
        steps: &[0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95],
        frame: |ratio, trial| small(LARGE, ratio, TILT, trial).render(trial.into()),
    },
    Ladder {
        name: "smallest ratio of the radii, outer semi-axis 80 px",
        unit: "",
        steps: &[0.5, 0.4, 0.3, 0.25, 0.2, 0.15, 0.1],
        frame: |ratio, trial| small(LARGE, ratio, TILT, trial).render(trial.into()),
    },
    Ladder {
        name: "widest strip across all circles that may be hidden",
        unit: "px",
        steps: &[0.0, 1.0, 2.0, 3.0, 5.0, 10.0],
        frame: strip,
    },
];

const LIGHT: [Ladder; 4] = [
    Ladder {
        name: "largest blur, standard deviation",
        unit: "px",
        steps: &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0],
        frame: |blur, trial| usual(trial, |scene| scene.photometry.blur = blur),
    },
    Ladder {
        name: "largest noise, standard deviation at a contrast of 190",
        unit: "grey levels",
        steps: &[2.0, 5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0],
        frame: |noise, trial| usual(trial, |scene| scene.photometry.noise = noise),
    },
    Ladder {
        name: "smallest contrast, noise of 1 grey level",
        unit: "grey levels",
        steps: &[60.0, 40.0, 30.0, 25.0, 20.0, 15.0, 12.0, 10.0, 8.0],
        frame: |contrast, trial| {
            usual(trial, |scene| {
                scene.photometry.noise = 1.0;
                scene.photometry.white = scene.photometry.black + contrast;
            })
        },
    },
    Ladder {
        name: "most light on the paper, the end of the grey scale being 1",
        unit: "",
        steps: &[1.0, 1.1, 1.2, 1.3, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 8.2, 8.4],
        frame: |light, trial| {
            usual(trial, |scene| {
                scene.photometry.white = 255.0;
                scene.photometry.gain = light;
            })
        },
    },
];

fn usual(trial: u32, change: impl Fn(&mut Scene)) -> Frame {
    let mut scene = small(SIZE, RATIO, TILT, trial);
    change(&mut scene);
    scene.render(u64::from(trial))
}

/// Paper over the frame from the middle to the right, `width` px high.
fn strip(width: f64, trial: u32) -> Frame {
    let mut frame = usual(trial, |_| ());
    let (middle, half) = (frame.height as f64 / 2.0, width / 2.0);
    let paper = frame.truth.photometry.white as u8;
    for (y, row) in frame.pixels.chunks_exact_mut(frame.width).enumerate() {
        if (y as f64 - middle).abs() < half {
            let start = row.len() / 2;
            row[start..].fill(paper);
        }
    }
    frame
}

impl Ladder {
    /// RMS error at a step, px; `None` where a target is missed or a false one found.
    fn error(&self, step: f64) -> Option<f64> {
        let trials: Vec<_> = (0..TRIALS).collect();
        let errors = parallel(&trials, |&trial| {
            let frame = (self.frame)(step, trial);
            let (targets, _) = detect(&frame, TargetSpec::any());
            match errors(&targets, &frame.truth) {
                (found, 0) if found.len() == 1 => Some(found[0].0.hypot(found[0].1)),
                _ => None,
            }
        });
        errors.into_iter().collect::<Option<Vec<_>>>().map(rms)
    }

    /// The last step before the first at which a target is missed.
    fn row(&self) -> Vec<String> {
        let passed = self.steps.iter().map_while(|&step| self.error(step).map(|error| (step, error)));
        let [limit, error] = match passed.last() {
            Some((step, error)) => [format!("{step} {}", self.unit).trim_end().to_owned(), rounded(error)],
            None => ["none".to_owned(), String::new()],
        };
        vec![self.name.to_owned(), limit, error]
    }
}

pub fn table() -> String {
    let size = format!("{MIN_SIZE} x {MIN_SIZE} to {MAX_WIDTH} x {MAX_HEIGHT} px, 8 bit");
    let mut rows = vec![vec!["frame".to_owned(), size, String::new()]];
    rows.extend(GEOMETRY.iter().chain(&LIGHT).map(Ladder::row));
    let caption = format!(
        "One thing at a time is driven until a target is missed, ratio not given; outer semi-axis {SIZE} px, ratio {RATIO} and \
         tilt {TILT} degrees\nwhere nothing else is said.\n\n"
    );
    let limit = format!("limit: {TRIALS} of {TRIALS} found");
    caption + &document::table(&["", &limit, "RMS error there, px"], &rows)
}
