//! Errors of many frames to figures.

use glam::DVec2;

use super::{
    bound::per_coordinate,
    run::{Estimate, Group, Sample},
};

/// Squared error, in units of the covariance, that 95 of 100 stay below: chi square with two degrees of freedom.
pub const IN_95: f64 = 5.991_464_547_107_98;
/// Half width of a 95 % confidence interval in standard deviations.
const CONFIDENCE: f64 = 1.96;

/// A normal value is larger by so many standard deviations in 5 of 100 cases.
const ONE_SIDED: f64 = 1.645;

/// The figures of one method in one condition. Lengths in px, root mean squares of one coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// Frames shown.
    pub frames: usize,
    /// Frames in which the target was found.
    pub found: usize,
    /// Scenes in which it was.
    pub scenes: usize,
    /// The Cramer-Rao bound.
    pub bound: f64,
    /// Root mean square error.
    pub rms: f64,
    /// Half width of the 95 % confidence interval of `rms`.
    pub spread: f64,
    /// Root mean square error to expect: what the noise of these frames makes of any good estimate is taken off, as far as that is
    /// known. With half the width of its 95 % confidence interval.
    pub expected: (f64, f64),
    /// Length of the mean error in the image.
    pub bias: f64,
    /// Length of the mean error in the directions of the light, or else of the tilt.
    pub drift: f64,
    /// Length of the mean error that chance alone leaves in 95 of 100 studies.
    pub mean_spread: f64,
    /// What noise alone makes of `systematic` in 95 of 100 studies at most. `None` where each scene is seen once.
    pub feigned: Option<f64>,
    /// The part of the error that is the same whatever the noise: it depends on place, direction and light. `None`
    /// where each scene is seen once.
    pub systematic: Option<f64>,
    /// Reported standard deviation.
    pub reported: f64,
    /// The same in units of the reported standard deviation.
    pub over_sigma: (f64, f64),
    /// Share of the errors inside the reported 95 % ellipse.
    pub within: f64,
}

/// A scene in which the target was found.
struct Scene<'a> {
    group: &'a Group,
    found: Vec<Estimate>,
    /// [`Sample::control`](super::run::Sample::control) of the same frames.
    controls: Vec<f64>,
    mean: DVec2,
}

/// A value of a frame.
type Value<'v> = &'v dyn Fn(&Scene, &Estimate) -> f64;

impl Figures {
    /// Of the method with this index over all of `groups`. `None` when the target was found in no frame.
    pub fn new(groups: &[&Group], method: usize) -> Option<Self> {
        let scene = |group: &&'_ Group| {
            let found = |sample: &Sample| sample.estimates[method].map(|estimate| (estimate, sample.control));
            let (found, controls): (Vec<_>, Vec<_>) = group.samples.iter().filter_map(found).unzip();
            let mean = found.iter().map(|e| e.error).sum::<DVec2>() / found.len() as f64;
            (!found.is_empty()).then_some((found, controls, mean))
        };
        let scenes: Vec<_> = groups
            .iter()
            .filter_map(|group| {
                scene(group).map(|(found, controls, mean)| Scene { group, found, controls, mean })
            })
            .collect();
        let count = scenes.iter().map(|scene| scene.found.len()).sum::<usize>();
        if count == 0 {
            return None;
        }
        let average = |value: Value| {
            let sums = scenes.iter().map(|scene| scene.found.iter().map(|e| value(scene, e)).sum::<f64>());
            sums.sum::<f64>() / count as f64
        };
        let length = |axes: [Value; 2]| axes.map(average).map(|a| a * a).iter().sum::<f64>().sqrt();
        let square = |e: &Estimate| e.error.length_squared() / 2.0;
        let rms = average(&|_, e| square(e)).sqrt();
        Some(Self {
            frames: groups.iter().map(|group| group.samples.len()).sum(),
            found: count,
            bound: average(&|scene, _| per_coordinate(scene.group.bounds[method]).powi(2)).sqrt(),
            rms,
            spread: CONFIDENCE * mean_square(&scenes, square, 0.0).1 / (2.0 * rms),
            expected: expected(&scenes, square),
            bias: length([&|_, e| e.error.x, &|_, e| e.error.y]),
            drift: length([&|s, e| s.group.axis.dot(e.error), &|s, e| s.group.axis.perp_dot(e.error)]),
            mean_spread: (IN_95 * scenes.iter().map(|scene| scene.mean.length_squared() / 2.0).sum::<f64>())
                .sqrt()
                / scenes.len() as f64,
            systematic: systematic(&scenes),
            feigned: feigned(&scenes),
            scenes: scenes.len(),
            reported: average(&|_, e| e.reported).sqrt(),
            over_sigma: expected(&scenes, |e| e.normalised / 2.0),
            within: average(&|_, e| f64::from(e.normalised <= IN_95)),
        })
    }

    /// Root mean square error to expect over the bound.
    pub fn ratio(&self) -> f64 {
        self.expected.0 / self.bound
    }

    /// Half width of the 95 % confidence interval of [`Figures::ratio`].
    pub fn ratio_spread(&self) -> f64 {
        self.expected.1 / self.bound
    }
}

/// Root of the mean of a square that each frame has without what chance makes of any good estimate, and half the width of its 95 %
/// confidence interval.
fn expected(scenes: &[Scene], square: impl Fn(&Estimate) -> f64) -> (f64, f64) {
    let frames: Vec<_> =
        scenes.iter().flat_map(|scene| scene.found.iter().map(&square).zip(&scene.controls)).collect();
    let middle = frames.iter().map(|(_, control)| *control).sum::<f64>() / frames.len() as f64;
    let (both, controls) = frames.iter().fold((0.0, 0.0), |(both, controls), (square, control)| {
        let control = *control - middle;
        (both + square * control, controls + control * control)
    });
    let (mean, deviation) = mean_square(scenes, square, if controls > 0.0 { both / controls } else { 0.0 });
    // Less than nothing is left by chance alone.
    let root = mean.max(0.0).sqrt();
    (root, CONFIDENCE * deviation / (2.0 * root))
}

/// Mean of a square that each frame has less `share` of its control, and the standard deviation of that. Draws of a scene share what
/// is systematic, so scenes are what is independent.
fn mean_square(scenes: &[Scene], square: impl Fn(&Estimate) -> f64, share: f64) -> (f64, f64) {
    let sum = |scene: &Scene| {
        scene.found.iter().zip(&scene.controls).map(|(e, control)| square(e) - share * control).sum::<f64>()
    };
    let frames = scenes.iter().map(|scene| scene.found.len()).sum::<usize>();
    let mean = scenes.iter().map(sum).sum::<f64>() / frames as f64;
    let squares: Vec<_> = scenes.iter().map(|scene| sum(scene) / scene.found.len() as f64).collect();
    let count = squares.len() as f64;
    let middle = squares.iter().sum::<f64>() / count;
    let variance =
        squares.iter().map(|square| (square - middle).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    (mean, (variance / count).sqrt())
}

impl Scene<'_> {
    /// Variance of a coordinate that noise leaves in the mean. `None` where it is seen once.
    fn noise(&self) -> Option<f64> {
        let count = self.found.len() as f64;
        let within = self.found.iter().map(|e| (e.error - self.mean).length_squared()).sum::<f64>() / 2.0;
        let mean = if self.group.dithered { count * count } else { count };
        (count > 1.0).then(|| within / (count - 1.0) / mean)
    }
}

/// Mean over the scenes that are seen more than once.
fn over_many(scenes: &[Scene], value: impl Fn(&Scene, f64) -> f64) -> Option<f64> {
    let many: Vec<_> =
        scenes.iter().filter_map(|scene| scene.noise().map(|noise| value(scene, noise))).collect();
    (!many.is_empty()).then(|| many.iter().sum::<f64>() / many.len() as f64)
}

/// Root of the variance between the scenes beyond what the noise of the draws explains.
fn systematic(scenes: &[Scene]) -> Option<f64> {
    Some(over_many(scenes, |scene, noise| scene.mean.length_squared() / 2.0 - noise)?.max(0.0).sqrt())
}

/// What noise alone makes of that in 95 of 100 studies at most: the mean square of two coordinates of the scenes' means spreads by
/// `1 / sqrt(scenes)`, relative.
fn feigned(scenes: &[Scene]) -> Option<f64> {
    Some((ONE_SIDED * over_many(scenes, |_, noise| noise)? / (scenes.len() as f64).sqrt()).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::method::METHODS;
    use concentric::Flags;
    use glam::DMat2;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::{Pcg64, rand_core::SeedableRng};

    /// Scenes of errors: noise of 1 px in each coordinate, plus `shift` px along the axis of each scene and a part of
    /// `own` px that each scene has to itself.
    fn groups(shift: f64, own: f64) -> Vec<Group> {
        let mut random = Pcg64::seed_from_u64(5);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut groups = Vec::new();
        for i in 0..400 {
            let axis = DVec2::from_angle(f64::from(i) * 2.4);
            let fixed = axis * shift + own * DVec2::new(normal(), normal());
            let samples = (0..10).map(|_| {
                let error = fixed + DVec2::new(normal(), normal());
                let estimate = Estimate {
                    error,
                    normalised: error.length_squared(),
                    reported: 1.0,
                    flags: Flags::default(),
                };
                Sample { estimates: [Some(estimate); METHODS.len()], wrong: 0, control: 0.0 }
            });
            let bounds = [DMat2::IDENTITY * 0.25; METHODS.len()];
            groups.push(Group {
                bounds,
                eccentricity: 0.0,
                phase: DVec2::ZERO,
                axis,
                dithered: false,
                samples: samples.collect(),
            });
        }
        groups
    }

    fn figures(shift: f64, own: f64) -> Figures {
        let groups = groups(shift, own);
        Figures::new(&groups.iter().collect::<Vec<_>>(), 0).expect("all are found")
    }

    #[test]
    fn pure_noise_is_told_as_such() {
        let figures = figures(0.0, 0.0);
        assert!(figures.systematic < figures.feigned && figures.feigned < Some(0.1), "{figures:?}");
        assert_eq!((figures.frames, figures.found), (4000, 4000));
        assert!((figures.rms - 1.0).abs() < figures.spread && figures.spread < 0.025, "{figures:?}");
        assert!((figures.ratio() - 2.0 * figures.rms).abs() < 1e-12);
        assert!(
            (figures.over_sigma.0 - 1.0).abs() < 0.03 && (figures.within - 0.95).abs() < 0.012,
            "{figures:?}"
        );
        assert!(
            figures.bias < 0.05 && figures.drift < 0.05 && figures.systematic < Some(0.15),
            "{figures:?}"
        );
    }

    /// Chance that a good estimate shares with the control is no part of its error; what it has by itself is.
    #[test]
    fn chance_that_is_known_is_taken_off() {
        let mut groups = groups(0.0, 0.0);
        groups.truncate(20);
        for sample in groups.iter_mut().flat_map(|group| &mut group.samples) {
            sample.control = sample.estimates[0].expect("found").error.length_squared() / 2.0 - 1.0;
        }
        let figures =
            |groups: &[Group]| Figures::new(&groups.iter().collect::<Vec<_>>(), 0).expect("all are found");
        let same = figures(&groups);
        assert!((same.rms - 1.0).abs() > 1e-3 && same.spread > 0.05, "{same:?}");
        assert!((same.expected.0 - 1.0).abs() < 1e-9 && same.expected.1 < 1e-9, "{same:?}");
        assert!((same.over_sigma.0 - 1.0).abs() < 1e-9, "{same:?}");
        for (i, estimate) in groups
            .iter_mut()
            .flat_map(|g| &mut g.samples)
            .flat_map(|s| &mut s.estimates)
            .flatten()
            .enumerate()
        {
            estimate.error += DVec2::from_angle(i as f64 * 2.4) * 0.5;
        }
        let worse = figures(&groups);
        assert!((worse.expected.0 - 1.125f64.sqrt()).abs() < 1.5 * worse.expected.1, "{worse:?}");
        assert!(worse.expected.1 < 0.7 * worse.spread, "{worse:?}");
    }

    #[test]
    fn a_shift_along_the_axis_is_a_drift_and_no_bias() {
        let figures = figures(0.5, 0.0);
        assert!(figures.bias < 0.05 && (figures.drift - 0.5).abs() < 0.05, "{figures:?}");
        assert!((figures.systematic.expect("ten draws") - 0.5 / 2f64.sqrt()).abs() < 0.05, "{figures:?}");
    }

    #[test]
    fn what_a_scene_has_to_itself_is_systematic() {
        let figures = figures(0.0, 0.7);
        assert!(
            (figures.systematic.expect("ten draws") - 0.7).abs() < 0.05 && figures.over_sigma.0 > 1.15,
            "{figures:?}"
        );
        assert!(figures.within < 0.9, "{figures:?}");
    }

    /// Draws whose noise cancels leave nothing of it in the mean of a scene: that must not be taken off what is systematic.
    #[test]
    fn draws_that_cancel_show_what_is_systematic_better() {
        let mut groups = groups(0.0, 0.0);
        for group in &mut groups {
            let mean: DVec2 =
                group.samples.iter().filter_map(|s| s.estimates[0]).map(|e| e.error).sum::<DVec2>()
                    / group.samples.len() as f64;
            let own = 0.3 * DVec2::from_angle(mean.x * 1e3);
            let errors = group.samples.iter_mut().flat_map(|s| &mut s.estimates).flatten();
            errors.for_each(|estimate| estimate.error += own - mean);
        }
        let all: Vec<_> = groups.iter().collect();
        let taken_off = Figures::new(&all, 0).expect("all are found");
        assert!(taken_off.systematic < Some(0.1), "{taken_off:?}");
        groups.iter_mut().for_each(|group| group.dithered = true);
        let figures = Figures::new(&groups.iter().collect::<Vec<_>>(), 0).expect("all are found");
        // That is by the root of two less in a coordinate; of the noise a tenth is left for chance.
        let wanted = (0.3f64.powi(2) / 2.0 - 0.1f64.powi(2)).sqrt();
        assert!((figures.systematic.expect("ten draws") - wanted).abs() < 0.02, "{figures:?}");
        assert!(figures.feigned < taken_off.feigned && figures.mean_spread < 0.04, "{figures:?}");
    }

    #[test]
    fn nothing_found_gives_no_figures() {
        let mut groups = groups(0.0, 0.0);
        groups.iter_mut().flat_map(|g| &mut g.samples).for_each(|s| s.estimates = [None; METHODS.len()]);
        assert!(Figures::new(&groups.iter().collect::<Vec<_>>(), 0).is_none());
    }
}
