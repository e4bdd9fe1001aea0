//! One target enlarged: the target as a whole, and the surroundings of its centre magnified until the centres part.

use anyhow::Result;
use concentric::{Circle, Target};

use super::{
    canvas::{Area, Canvas, LINE, text_width},
    marks::{FAINT, GROUND, INK, Mark, SIGMA, View, round_down, visible_factor},
};
use crate::{
    measure::{axes, distance, px},
    picture::Picture,
};

/// Side of each of the two windows, px.
pub const SIDE: usize = 236;
/// Width of a card, px.
pub const WIDTH: usize = 2 * SIDE + 3 * GAP;
/// Height of a card, px.
pub const HEIGHT: usize = SIDE + 2 * LINE as usize + 2 * GAP;
const GAP: usize = 10;
/// Height of the magnified window above its scale, px.
const PLOT: usize = SIDE - 26;
/// Semi-axis at which the error ellipse is drawn at least, px, or nearly so.
const SIGMA_SIDE: f64 = 30.0;

/// Draws the card of a target of this name; `truth` is where its centre really is, if known.
///
/// # Errors
/// No memory for it.
pub fn card(picture: &Picture, target: &Target, name: &str, truth: Option<[f64; 2]>) -> Result<Canvas> {
    let mut card = Canvas::new(WIDTH, HEIGHT, GROUND)?;
    let [x, y] = px(target.centre);
    let gap = GAP as f32;
    let [sigma, ..] = axes(&target.covariance);
    card.text([gap, 4.0], &format!("{name}: C = ({x:.4}, {y:.4}) px"), INK, true);
    let shift = target.circles.first().map_or(0.0, |outer| distance(px(outer.ellipse.centre), [x, y]));
    let residual = target.residual();
    let words = format!("sigma {sigma:.4} px, B1 off by {shift:.4} px, rms of the edges {residual:.3} px");
    card.text([gap, 4.0 + LINE], &words, FAINT, false);
    let top = 2.0 * LINE + gap;
    card.paste(&whole(picture, target)?, [gap, top]);
    card.paste(&middle(picture, target, truth)?, [2.0 * gap + SIDE as f32, top]);
    Ok(card)
}

fn whole(picture: &Picture, target: &Target) -> Result<Canvas> {
    let mut canvas = Canvas::new(SIDE, SIDE, GROUND)?;
    let outer = target.circles.first().map(|circle| circle.ellipse).unwrap_or_default();
    let view = View::around(px(outer.centre), 1.2 * f64::from(outer.a).max(2.0), [SIDE as f64; 2]);
    view.paint(&mut canvas, picture, |level| level);
    view.ellipses(&mut canvas, target, 1.5);
    Mark::Centre.draw(&mut canvas, view.place(px(target.centre)), 6.0);
    Ok(canvas)
}

fn middle(picture: &Picture, target: &Target, truth: Option<[f64; 2]>) -> Result<Canvas> {
    let mut plot = Canvas::new(SIDE, PLOT, GROUND)?;
    let view = around_centres(target, truth);
    view.paint(&mut plot, picture, |level| 24 + level / 6);
    if let Some(outer) = target.circles.first() {
        let ends = [view.place(px(outer.ellipse.centre)), view.place(px(target.centre))];
        plot.line(&ends, FAINT, 1.0);
    }
    let sigma = axes(&target.covariance)[0] * view.scale;
    let factor = visible_factor(sigma, SIGMA_SIDE);
    view.sigma(&mut plot, target, factor);
    view.centres(&mut plot, target, 6.0, true);
    if let Some(truth) = truth {
        Mark::Truth.draw(&mut plot, view.place(truth), 10.0);
    }
    name_centres(&mut plot, target, &view, (sigma * factor) as f32);
    let mut canvas = Canvas::new(SIDE, SIDE, GROUND)?;
    canvas.paste(&plot, [0.0, 0.0]);
    let baseline = (SIDE - 21) as f32;
    canvas.text([2.0, baseline], &format!("sigma x {factor}"), SIGMA, false);
    scale_bar(&mut canvas, view.scale, baseline);
    Ok(canvas)
}

/// Writes C, B1 and B2 beside their marks, on the side away from the window's rim and outside the error ellipse, which
/// is drawn `sigma` px wide; of names that would meet only the first.
fn name_centres(canvas: &mut Canvas, target: &Target, view: &View, sigma: f32) {
    let centre = |circle: Option<&Circle>| circle.map(|circle| circle.ellipse.centre);
    let names = [
        ("C", Some(target.centre), Mark::Centre),
        ("B1", centre(target.circles.first()), Mark::Outer),
        ("B2", centre(target.circles.last()), Mark::Inner),
    ];
    let mut taken: Vec<Area> = Vec::new();
    for (name, position, mark) in names {
        let Some([x, y]) = position.map(|position| view.place(px(position))) else { continue };
        let width = text_width(name, true);
        let off = if mark == Mark::Centre { sigma.max(10.0) + 5.0 } else { 11.0 };
        let left = if x > SIDE as f32 / 2.0 { x - off - width } else { x + off };
        let area = Area { x: left, y: y - LINE / 2.0, width, height: LINE };
        if !taken.iter().any(|other| other.meets(&area)) {
            canvas.text([area.x, area.y], name, mark.colour(), true);
            taken.push(area);
        }
    }
}

/// A window that shows all centres of `target` and its error ellipse.
fn around_centres(target: &Target, truth: Option<[f64; 2]>) -> View {
    let ellipses = [target.circles.first(), target.circles.last()];
    let mut places = vec![px(target.centre), px(target.eq7)];
    places.extend(ellipses.into_iter().flatten().map(|circle| px(circle.ellipse.centre)));
    places.extend(truth);
    let extent = |axis: usize| {
        let values = places.iter().map(|place| place[axis]);
        values.fold([f64::MAX, f64::MIN], |[low, high], value| [low.min(value), high.max(value)])
    };
    let ranges = [extent(0), extent(1)];
    let middle = ranges.map(|[low, high]| (low + high) / 2.0);
    let half = ranges.iter().fold(0.0, |half: f64, [low, high]| half.max((high - low) / 2.0));
    let [sigma, ..] = axes(&target.covariance);
    View::around(middle, (1.35 * half).max(half + 1.5 * sigma).max(0.004), [SIDE as f64, PLOT as f64])
}

/// A bar of a round length with that length before it, at the right end of the line of text at `top`.
fn scale_bar(canvas: &mut Canvas, scale: f64, top: f32) {
    let side = SIDE as f32;
    let length = round_down(SIDE as f64 / 2.8 / scale);
    let drawn = (length * scale) as f32;
    let (left, right, y) = (side - 4.0 - drawn, side - 4.0, top + 10.0);
    canvas.line(&[[left, y - 5.0], [left, y], [right, y], [right, y - 5.0]], INK, 1.5);
    let text = format!("{length} px");
    canvas.text([left - 8.0 - text_width(&text, false), top], &text, INK, false);
}
