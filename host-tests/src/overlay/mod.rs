//! Annotated pictures: what was found, what was rejected and why, and the centres enlarged until they part.

mod canvas;
mod inset;
mod legend;
mod marks;
mod photo;

pub use canvas::Canvas;

use anyhow::Result;
use concentric::Target;

use self::{
    canvas::LINE,
    legend::{Legend, Sign},
    marks::{GROUND, INK, Mark, View, visible_factor},
    photo::{Labels, SMALLEST_BOX},
};
use crate::{detect::Outcome, measure::axes, picture::Picture};

/// The longer side of the photograph is enlarged by a whole factor towards this, px.
const WANTED_SIDE: usize = 1280;
const LARGEST_FACTOR: usize = 8;
/// Semi-axis at which a middling error ellipse is drawn on the photograph, px.
const SIGMA_SIDE: f64 = 26.0;
const HEAD: usize = 30;
/// Largest number of enlarged targets.
const MOST_CARDS: usize = 6;

/// What to draw.
#[derive(Clone, Copy)]
pub struct Overlay<'a> {
    /// The photograph.
    pub picture: &'a Picture,
    /// What was found on it.
    pub outcome: &'a Outcome,
    /// Where the centres of the targets really are, px, in the order of the targets; empty for a photograph.
    pub truth: &'a [[f64; 2]],
}

impl Overlay<'_> {
    /// Draws the photograph with its annotations, enlarged targets beside it and a legend below.
    ///
    /// # Errors
    /// No memory for the picture.
    pub fn draw(&self) -> Result<Canvas> {
        let Self { picture, outcome, truth } = *self;
        let targets = &outcome.targets;
        let side = picture.width.max(picture.height);
        let enlarge = ((WANTED_SIDE + side / 2) / side).clamp(1, LARGEST_FACTOR);
        let factor = sigma_factor(targets, enlarge as f64);
        let photo = self.photo(enlarge, factor)?;
        let photo_size = photo.size().map(|side| side as usize);
        let shown = most_shifted(targets, (photo_size[1] / inset::HEIGHT).clamp(2, MOST_CARDS));
        let panel = if shown.is_empty() { 0 } else { inset::WIDTH };
        let width = (photo_size[0] + panel).max(640);
        let body = photo_size[1].max(shown.len() * inset::HEIGHT);
        let legend = self.legend(enlarge, factor, shown.len()).draw(width)?;
        let mut canvas = Canvas::new(width, HEAD + body + legend.size()[1] as usize, GROUND)?;
        canvas.text([12.0, (HEAD as f32 - LINE) / 2.0 + 1.0], &self.title(), INK, true);
        canvas.paste(&photo, [0.0, HEAD as f32]);
        for (row, &index) in shown.iter().enumerate() {
            let target = &targets[index];
            let card = inset::card(picture, target, &photo::name(target, index), truth.get(index).copied())?;
            canvas.paste(&card, [photo_size[0] as f32, (HEAD + row * inset::HEIGHT) as f32]);
        }
        canvas.paste(&legend, [0.0, (HEAD + body) as f32]);
        Ok(canvas)
    }

    fn photo(&self, enlarge: usize, factor: f64) -> Result<Canvas> {
        let Self { picture, outcome, truth } = *self;
        let view = View { scale: enlarge as f64, corner: [0.0, 0.0] };
        let mut canvas = Canvas::new(picture.width * enlarge, picture.height * enlarge, GROUND)?;
        photo::paint(&mut canvas, picture, &view);
        let boxes = photo::worth_a_box(&outcome.rejected);
        photo::boxes(&mut canvas, &boxes, &view);
        photo::targets(&mut canvas, &outcome.targets, &view, factor);
        photo::truth(&mut canvas, truth, &view);
        let mut labels = Labels::new(canvas.size(), &outcome.targets, &view);
        labels.targets(&mut canvas, &outcome.targets, &view);
        labels.rejected(&mut canvas, &boxes, &view);
        Ok(canvas)
    }

    fn title(&self) -> String {
        let Picture { name, width, height, .. } = self.picture;
        let found = match self.outcome.targets.len() {
            0 => "no target".to_owned(),
            1 => "1 target".to_owned(),
            many => format!("{many} targets"),
        };
        format!("{name}   {width} x {height} px   {found}")
    }

    fn legend(&self, enlarge: usize, factor: f64, cards: usize) -> Legend {
        let targets = self.outcome.targets.len();
        let mut entries = Vec::new();
        if targets > 0 {
            entries.extend([
                (Sign::Ellipse(Mark::Outer.colour()), "outer circle".to_owned()),
                (Sign::Ellipse(Mark::Inner.colour()), "innermost circle".to_owned()),
                (Sign::Mark(Mark::Outer), "B1 centre of the outer ellipse".to_owned()),
                (Sign::Mark(Mark::Inner), "B2 centre of the inner ellipse".to_owned()),
                (Sign::Mark(Mark::Eq7), "eq. (7), in the enlarged views".to_owned()),
                (Sign::Mark(Mark::Centre), "C true centre, as reported".to_owned()),
                (Sign::Sigma, format!("1 sigma of C, {factor} times as large")),
            ]);
        }
        if !self.truth.is_empty() {
            entries.push((Sign::Mark(Mark::Truth), "where the centre really is".to_owned()));
        }
        if cards > 0 && cards < targets {
            let words = format!("enlarged: the {cards} of {targets} targets whose B1 is farthest off C");
            entries.push((Sign::None, words));
        }
        if enlarge > 1 {
            entries.push((Sign::None, format!("photograph enlarged {enlarge} times")));
        }
        entries.extend(self.rejects());
        Legend::new(entries)
    }

    fn rejects(&self) -> Vec<(Sign, String)> {
        let total = self.outcome.rejected.len();
        let tiny =
            self.outcome.rejected.iter().filter(|one| one.width.max(one.height) < SMALLEST_BOX).count();
        let drawn = photo::worth_a_box(&self.outcome.rejected).len();
        if total == 0 {
            return vec![(Sign::None, "nothing rejected".to_owned())];
        }
        let sign = if drawn > 0 { Sign::Box } else { Sign::None };
        let mut entries = vec![(sign, format!("rejected, with the cause: {drawn} of {total} drawn"))];
        if tiny > 0 {
            entries.push((Sign::None, format!("{tiny} rejected below {SMALLEST_BOX} px left out")));
        }
        if total - tiny > drawn {
            entries.push((Sign::None, "of the others the ellipses, then the largest".to_owned()));
        }
        entries
    }
}

/// How many times as large error ellipses are drawn on a photograph enlarged `enlarge` times.
fn sigma_factor(targets: &[Target], enlarge: f64) -> f64 {
    let mut sigmas: Vec<f64> = targets.iter().map(|target| axes(&target.covariance)[0]).collect();
    sigmas.sort_by(f64::total_cmp);
    sigmas.get(sigmas.len() / 2).map_or(1.0, |sigma| visible_factor(sigma * enlarge, SIGMA_SIDE))
}

/// Indices, ascending, of the at most `count` targets whose centre was corrected most.
fn most_shifted(targets: &[Target], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..targets.len()).collect();
    order.sort_by(|&a, &b| targets[b].eccentricity().total_cmp(&targets[a].eccentricity()));
    order.truncate(count);
    order.sort_unstable();
    order
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use concentric::{Circle, Covariance, Ellipse, Position, Reject, Rejected, Summary};

    use super::{marks::REJECTED, *};

    fn at(x: f64, y: f64) -> Position {
        let unit = |value: f64| (value * f64::from(Position::SCALE)).round() as i32;
        Position { x: unit(x), y: unit(y) }
    }

    fn circle(x: f64, y: f64, a: f32, ratio: f32) -> Circle {
        let ellipse = Ellipse { centre: at(x, y), a, b: 0.7 * a, theta: 0.6 };
        Circle { ellipse, ratio, rms: 0.02, points: 200, ..Circle::default() }
    }

    fn target(x: f64, y: f64, a: f32) -> Target {
        let circles = [circle(x + 0.9, y - 0.5, a, 1.0), circle(x + 0.3, y - 0.2, a / 2.0, 0.5)];
        Target {
            centre: at(x, y),
            exact: at(x, y),
            eq7: at(x - 0.05, y + 0.03),
            covariance: Covariance { xx: 4e-4, xy: 1e-4, yy: 2e-4 },
            circles: circles.into_iter().collect(),
            ..Target::default()
        }
    }

    fn outcome(targets: Vec<Target>) -> Outcome {
        let rejected = [(60, 20, Reject::NotElliptic), (5, 4, Reject::TooSmall)]
            .map(|(width, height, cause)| Rejected { cause, centre: at(250.0, 30.0), width, height });
        Outcome {
            targets,
            rejected: rejected.to_vec(),
            plane: None,
            summary: Summary::default(),
            elapsed: Duration::ZERO,
        }
    }

    /// Draws `outcome` on an even grey picture of 320 x 240 px, which is enlarged 4 times.
    fn drawn(outcome: &Outcome) -> image::RgbImage {
        let picture = Picture::new("a", 320, 240, vec![200; 320 * 240]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drawn.png");
        Overlay { picture: &picture, outcome, truth: &[] }.draw().unwrap().save(&path).unwrap();
        image::open(path).unwrap().into_rgb8()
    }

    /// Whether a pixel next to the image place `(x, y)` is nearer to `colour` than to the dimmed photograph.
    fn shows(picture: &image::RgbImage, [x, y]: [f64; 2], colour: [u8; 3]) -> bool {
        let near = |pixel: &image::Rgb<u8>| pixel.0.into_iter().zip(colour).all(|(a, b)| a.abs_diff(b) < 60);
        let (left, top) = ((4.0 * (x + 0.5)) as u32 - 1, (4.0 * (y + 0.5)) as u32 - 1 + HEAD as u32);
        (left..left + 3).any(|x| (top..top + 3).any(|y| near(picture.get_pixel(x, y))))
    }

    #[test]
    fn marks_stand_where_the_numbers_say() {
        let picture = drawn(&outcome(vec![target(100.0, 120.0, 50.0)]));
        let centre = Mark::Centre.colour();
        assert!(shows(&picture, [100.0, 120.0], centre) && !shows(&picture, [104.0, 120.0], centre));
        let end = |along: f64| [100.9 + along * 0.6f64.cos(), 119.5 + along * 0.6f64.sin()];
        assert!(
            shows(&picture, end(50.0), Mark::Outer.colour())
                && !shows(&picture, end(46.0), Mark::Outer.colour())
        );
    }

    #[test]
    fn rejected_candidates_are_boxed_unless_tiny() {
        let picture = drawn(&outcome(vec![]));
        let box_side = |half_width: f64| [250.0 - half_width, 30.0];
        assert!(shows(&picture, box_side(30.0), REJECTED) && !shows(&picture, box_side(3.0), REJECTED));
    }

    #[test]
    fn a_crowd_is_drawn() {
        let crowd =
            (0..60).map(|i| target(f64::from(i % 10) * 32.0, f64::from(i / 10) * 40.0, 12.0)).collect();
        assert!(drawn(&outcome(crowd)).width() > 1280);
    }
}
