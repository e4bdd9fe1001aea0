//! What the library is to reach, and what it does.

use super::processor::{ALL, Class};
use super::results::{Measured, Results};

/// How the scenes end that are measured with `Settings::BOUNDED_PX_PER_RUN`.
const BOUNDED: &str = ", 144 px a run";

/// The classes with goals of their own.
pub const CLASSES: [(Class, &str); 3] =
    [(Class::Dsp, "M4F, M33 with DSP, M7"), (Class::Small, "M0+"), (Class::Riscv, "RV32IMC")];

/// Takes a figure from the results; `None` where it was not measured.
type Measure = Box<dyn Fn(&Measured) -> Option<f64>>;

/// A figure with a limit for each class.
pub struct Goal {
    /// What it is.
    pub name: String,
    /// Most that it may be, in the order of [`CLASSES`].
    pub limits: [f64; 3],
    /// Digits after the point.
    pub digits: usize,
    measure: Measure,
}

impl Goal {
    fn new(
        name: impl Into<String>,
        limits: [f64; 3],
        digits: usize,
        measure: impl Fn(&Measured) -> Option<f64> + 'static,
    ) -> Self {
        Self { name: name.into(), limits, digits, measure: Box::new(measure) }
    }

    /// The worst figure of the processors of a class.
    pub fn measured(&self, results: &Results, class: Class) -> Option<f64> {
        let ids = ALL.iter().filter(|processor| processor.class == class).map(|processor| processor.id);
        ids.filter_map(|id| (self.measure)(results.of(id)?)).reduce(f64::max)
    }
}

/// Instructions per pixel up to the finished candidates.
fn scan(measured: &Measured, scene: &str, width: u32) -> Option<f64> {
    let frame = measured.frame(scene, width)?;
    Some(frame.scan.instructions as f64 / frame.pixels())
}

/// All of them.
pub fn all() -> Vec<Goal> {
    let empty =
        |m: &Measured| [640, 1280].iter().filter_map(|&width| scan(m, "empty", width)).reduce(f64::max);
    let mut goals =
        vec![Goal::new("empty frame, 640 px wide or more, instructions per px", [0.9, 1.2, 1.4], 2, empty)];
    for (width, limits) in [(1280, [1.8, 3.2, 2.7]), (640, [2.6, 5.0, 3.8]), (320, [3.8, 6.5, 5.0])] {
        let name = format!("60 targets, {width} px wide, up to the candidates, instructions per px");
        goals.push(Goal::new(name, limits, 2, move |m| scan(m, "60 targets", width)));
    }
    goals.push(Goal::new(
        "any image (noise, checkerboards, clutter), bounded work, instructions per px",
        [15.0, 25.0, 20.0],
        1,
        |m| {
            let worst = m.frames.iter().filter(|f| f.scene.ends_with(BOUNDED));
            worst.map(|f| f.scan.instructions as f64 / f.pixels()).reduce(f64::max)
        },
    ));
    goals.push(Goal::new("one target of radius 30 px, instructions", [40e3, 250e3, 130e3], 0, |m| {
        m.frame("radius 30", 320).map(|frame| frame.target.instructions as f64)
    }));
    goals.push(Goal::new("the same, quick", [40e3, 250e3, 130e3], 0, |m| {
        m.frame("radius 30, quick", 320).map(|frame| frame.target.instructions as f64)
    }));
    for (width, kib) in [(320, 12.0), (640, 24.0), (1280, 48.0)] {
        let name = format!("storage for 60 targets, {width} px wide, bytes");
        goals.push(Goal::new(name, [kib * 1024.0; 3], 0, move |m| {
            m.frame("60 targets", width).filter(|f| f.dropped == 0).map(|f| f.storage as f64)
        }));
    }
    goals.push(Goal::new("flash of the library, bytes", [24.0 * 1024.0; 3], 0, |m| {
        m.library_flash.map(|bytes| bytes as f64)
    }));
    goals.push(Goal::new("the same compiled for size", [24.0 * 1024.0; 3], 0, |m| {
        m.library_flash_small.map(|bytes| bytes as f64)
    }));
    goals.push(Goal::new("stack, measured, bytes", [1536.0; 3], 0, |m| Some(m.stack.measured as f64)));
    goals.push(Goal::new("stack, bound, bytes", [1536.0; 3], 0, |m| m.stack.bound.map(|bytes| bytes as f64)));
    goals.push(Goal::new("symbols of panics, heap, f64", [0.0; 3], 0, |m| {
        Some((m.forbidden.panic + m.forbidden.heap + m.forbidden.f64) as f64)
    }));
    goals.push(Goal::new("recursive functions", [0.0; 3], 0, |m| {
        (!m.stack.chain.is_empty()).then_some(m.stack.recursion.len() as f64)
    }));
    goals.push(Goal::new("reports or counts that differ", [0.0; 3], 0, |m| {
        Some(f64::from(!m.reports_are_equal) + f64::from(!m.runs_are_equal))
    }));
    goals
}
