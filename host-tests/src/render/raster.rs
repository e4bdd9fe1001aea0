//! How much of every pixel an outline covers, seen through the lens's blur.
//!
//! The value of a pixel is the integral, over the outline's inside, of the point spread function (a Gaussian)
//! convolved with the pixel's square. Green's theorem turns it into an integral along the outline, `C(x, y) =
//! -loop integral of F(x - u) H(y - v) dv`, where `H` is the convolved profile of one axis and `F` its
//! integral, both closed forms of erf and exp. No polygon, no supersampling:
//!
//! * with blur the integrand is smooth, and Gauss-Legendre quadrature along the true curve leaves an error below 1e-6
//!   of the contrast;
//! * without blur it is the exact area of the polygon whose sagitta against the true curve is below 1e-6 px.
//!
//! Both ways keep, for every row, only the steps from one pixel to the next and sum them up once at the end.

use super::camera::View;
use super::outline::{Outline, Piece};
use glam::DVec2;
use std::ops::Range;

/// Coverage of the pixels in a rectangle of the frame, 0 to 1.
#[derive(Clone, Debug)]
pub struct Coverage {
    /// First column.
    pub x0: usize,
    /// First row.
    pub y0: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row.
    pub values: Vec<f64>,
}

/// Where the Gaussian is cut off, in standard deviations: 2e-8 lies outside.
const TAIL: f64 = 5.5;
/// Distance of the polygon from the curve, px.
const SAGITTA: f64 = 1e-6;
/// Length of a quadrature panel in standard deviations of the blur.
const PANEL: f64 = 2.0;
/// Most radians of an arc in a quadrature panel.
const PANEL_TURN: f64 = 0.4;
/// Gauss-Legendre nodes and weights on [0, 1], order 5.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_095),
    (0.230_765_344_947_158, 0.239_314_335_249_683),
    (0.5, 0.284_444_444_444_444),
    (0.769_234_655_052_842, 0.239_314_335_249_683),
    (0.953_089_922_969_332, 0.118_463_442_528_095),
];

impl Coverage {
    /// Coverage by the inside of `outline` on the plane of `view`, blurred by a Gaussian of `sigma` px (0:
    /// none). `None` when it does not reach into the frame.
    pub fn new(outline: &Outline, view: &View, sigma: f64) -> Option<Self> {
        let path = if sigma > 0.0 { quadrature(outline, view, sigma) } else { polygon(outline, view) };
        let mut steps = Steps::around(&path, view, 1.0 + TAIL * sigma)?;
        if sigma > 0.0 {
            let mut kernel = Kernel { sigma, rows: Vec::new(), columns: Vec::new() };
            path.iter().for_each(|node| kernel.spread(&mut steps, node));
        } else {
            let next = path.iter().cycle().skip(1);
            path.iter().zip(next).for_each(|(from, to)| steps.edge(from.place, to.place));
        }
        Some(steps.sum_up(area(&path, sigma).signum()))
    }

    /// Calls `paint` with column, row and coverage of every pixel.
    pub fn for_each(&self, mut paint: impl FnMut(usize, usize, f64)) {
        for (row, values) in self.values.chunks_exact(self.width).enumerate() {
            for (column, &value) in values.iter().enumerate() {
                paint(self.x0 + column, self.y0 + row, value);
            }
        }
    }
}

/// A point of the outline in the image, and (for quadrature) its weight times dv.
struct Node {
    place: DVec2,
    rise: f64,
}

/// Point and derivative by the piece's parameter in the image.
fn seen(piece: &Piece, view: &View, t: f64) -> (DVec2, DVec2) {
    let (point, velocity) = piece.at(t);
    let (place, slope) = view.at(point);
    (place, slope * velocity)
}

fn quadrature(outline: &Outline, view: &View, sigma: f64) -> Vec<Node> {
    let mut nodes = Vec::new();
    for piece in outline.pieces() {
        let speed = (0..=32).map(|i| seen(piece, view, f64::from(i) / 32.0).1.length()).fold(0.0, f64::max);
        let panels = (speed * 1.05 / (PANEL * sigma)).max(piece.turn() / PANEL_TURN).ceil().max(1.0);
        for panel in 0..panels as usize {
            for (at, weight) in GAUSS {
                let (place, velocity) = seen(piece, view, (panel as f64 + at) / panels);
                nodes.push(Node { place, rise: velocity.y * weight / panels });
            }
        }
    }
    nodes
}

fn polygon(outline: &Outline, view: &View) -> Vec<Node> {
    let mut corners = Vec::new();
    for piece in outline.pieces() {
        let probe: Vec<DVec2> = (0..=32).map(|i| seen(piece, view, f64::from(i) / 32.0).0).collect();
        let bend = probe.windows(3).map(|p| (p[0] - 2.0 * p[1] + p[2]).length()).fold(0.0, f64::max) * 1024.0;
        let parts = (bend * 1.1 / (8.0 * SAGITTA)).sqrt().ceil().max(1.0);
        corners.extend(
            (0..parts as usize).map(|i| Node { place: seen(piece, view, i as f64 / parts).0, rise: 0.0 }),
        );
    }
    corners
}

/// Signed area inside the path, about its first point.
fn area(path: &[Node], sigma: f64) -> f64 {
    let origin = path.first().map_or(DVec2::ZERO, |node| node.place);
    if sigma > 0.0 {
        return path.iter().map(|node| (node.place.x - origin.x) * node.rise).sum();
    }
    let next = path.iter().cycle().skip(1);
    path.iter().zip(next).map(|(p, q)| (p.place - origin).perp_dot(q.place - origin) / 2.0).sum()
}

/// Differences of neighbouring pixels of a row, for a rectangle of the frame.
struct Steps {
    columns: Range<i64>,
    rows: Range<i64>,
    values: Vec<f64>,
}

impl Steps {
    /// For the pixels within `margin` px of the path; `None` when there are none.
    fn around(path: &[Node], view: &View, margin: f64) -> Option<Self> {
        let (mut low, mut high) = (DVec2::MAX, DVec2::MIN);
        for node in path {
            low = low.min(node.place);
            high = high.max(node.place);
        }
        let span = |low: f64, high: f64, size: u32| {
            ((low - margin).floor() as i64).max(0)..((high + margin).ceil() as i64 + 1).min(i64::from(size))
        };
        let columns = span(low.x, high.x, view.camera.width);
        let rows = span(low.y, high.y, view.camera.height);
        if columns.is_empty() || rows.is_empty() {
            return None;
        }
        let pixels = (columns.end - columns.start) as usize * (rows.end - rows.start) as usize;
        Some(Self { columns, rows, values: vec![0.0; pixels] })
    }

    /// Raises every pixel of `row` from `column` rightwards.
    fn add(&mut self, column: i64, row: i64, value: f64) {
        if self.rows.contains(&row) && column < self.columns.end {
            let width = self.columns.end - self.columns.start;
            let index = (row - self.rows.start) * width + (column - self.columns.start).max(0);
            self.values[index as usize] += value;
        }
    }

    /// Adds the exact area to the right of the line from `p` to `q`, signed by its direction.
    fn edge(&mut self, p: DVec2, q: DVec2) {
        // From here on pixel i spans [i, i + 1].
        let (p, q) = (p + 0.5, q + 0.5);
        let first = (p.y.min(q.y).floor() as i64).max(self.rows.start);
        let last = (p.y.max(q.y).floor() as i64).min(self.rows.end - 1);
        for row in first..=last {
            let y0 = p.y.clamp(row as f64, row as f64 + 1.0);
            let y1 = q.y.clamp(row as f64, row as f64 + 1.0);
            if y0 != y1 {
                let x = |y: f64| p.x + (y - p.y) * (q.x - p.x) / (q.y - p.y);
                self.edge_in_row(row, x(y0), x(y1), y1 - y0);
            }
        }
    }

    fn edge_in_row(&mut self, row: i64, x0: f64, x1: f64, rise: f64) {
        let first = (x0.min(x1).floor() as i64).max(self.columns.start - 1);
        let last = (x0.max(x1).floor() as i64).min(self.columns.end).max(first);
        for column in first..=last {
            let left = if column == first { f64::MIN } else { column as f64 };
            let right = if column == last { f64::MAX } else { column as f64 + 1.0 };
            let (a, b) = (x0.clamp(left, right), x1.clamp(left, right));
            let part = if x0 == x1 { rise } else { rise * (b - a) / (x1 - x0) };
            let covered = 1.0 - ((a + b) / 2.0 - column as f64).clamp(0.0, 1.0);
            self.add(column, row, -part * covered);
            self.add(column + 1, row, -part * (1.0 - covered));
        }
    }

    fn sum_up(mut self, sign: f64) -> Coverage {
        let width = (self.columns.end - self.columns.start) as usize;
        for row in self.values.chunks_exact_mut(width) {
            let mut sum = 0.0;
            for value in row {
                sum += sign * *value;
                *value = sum;
            }
        }
        Coverage {
            x0: self.columns.start as usize,
            y0: self.rows.start as usize,
            width,
            height: (self.rows.end - self.rows.start) as usize,
            values: self.values,
        }
    }
}

/// The blurred pixel: profiles of one node on the rows and columns around it.
struct Kernel {
    sigma: f64,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl Kernel {
    fn spread(&mut self, steps: &mut Steps, node: &Node) {
        let reach = 0.5 + TAIL * self.sigma;
        let pixels = |centre: f64| (centre - reach).ceil() as i64..(centre + reach).floor() as i64 + 1;
        let (rows, columns) = (pixels(node.place.y), pixels(node.place.x));
        if rows.end <= steps.rows.start || rows.start >= steps.rows.end || columns.start >= steps.columns.end
        {
            return;
        }
        let sigma = self.sigma;
        differences(&mut self.rows, &rows, |t| integral(t - node.place.y, sigma));
        differences(&mut self.columns, &columns, |t| double_integral(t - node.place.x, sigma));
        for (row, height) in rows.zip(&self.rows) {
            let weight = -node.rise * height;
            let mut before = 0.0;
            for (column, value) in columns.clone().zip(&self.columns) {
                steps.add(column, row, weight * (value - before));
                before = *value;
            }
            steps.add(columns.end, row, weight * (1.0 - before));
        }
    }
}

/// Differences of `function` over every pixel of `range`.
fn differences(into: &mut Vec<f64>, range: &Range<i64>, function: impl Fn(f64) -> f64) {
    into.clear();
    let mut before = function(range.start as f64 - 0.5);
    for pixel in range.clone() {
        let after = function(pixel as f64 + 0.5);
        into.push(after - before);
        before = after;
    }
}

/// Integral of a Gaussian up to `t`.
fn integral(t: f64, sigma: f64) -> f64 {
    0.5 * (1.0 + libm::erf(t / sigma * std::f64::consts::FRAC_1_SQRT_2))
}

/// Integral of [`integral`] up to `t`.
fn double_integral(t: f64, sigma: f64) -> f64 {
    let z = t / sigma;
    t * integral(t, sigma) + sigma * libm::exp(-0.5 * z * z) / std::f64::consts::TAU.sqrt()
}
