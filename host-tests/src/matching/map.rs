//! Where the layout's targets appear in a frame: a homography, or a camera and its pose, and a lens that distorts.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Matrix3, Owned, Rotation3, SVector, Vector2, Vector3};

use super::{
    homography::{affinity, homography},
    plane::Plane,
};

/// Radial terms, at the end of the parameters.
const RADIAL: usize = 2;
/// The radial terms (by how much of that the lens moves a point at half the frame's diagonal) and the perspective of a plane
/// (relative change of depth from its middle to its end) are expected to be below this unless the points say otherwise, ...
const USUAL: f64 = 0.2;
/// ... where a share of half the diagonal of this size counts as an error of a point.
const ERROR: f64 = 1e-3;
/// Focal lengths with which a resection starts, in half diagonals.
const FOCAL: [f64; 3] = [1.0, 2.5, 6.0];
/// Most evaluations of a fit, in parameters.
const PATIENCE: usize = 30;
const TOLERANCE: f64 = 1e-9;

/// A pair of a place on the layout (mm) and one in the image (px).
pub type Pair = ([f64; 3], [f64; 2]);

/// Image coordinates in half diagonals about the middle of the frame, where the axis of the lens is taken to be.
#[derive(Clone, Copy, Debug)]
struct Frame {
    middle: Vector2<f64>,
    unit: f64,
}

/// What is before the camera.
#[derive(Clone, Copy, Debug)]
enum Object {
    Plane(Plane),
    Space { origin: Vector3<f64> },
}

/// A map from the layout to the image.
#[derive(Clone, Debug)]
pub struct Map {
    frame: Frame,
    object: Object,
    /// Largest distance on the layout from its middle, mm.
    reach: f64,
    /// Eight entries of a homography, or the logarithm of the focal length, rotation vector and translation; then the radial
    /// terms.
    parameters: DVector<f64>,
}

impl Map {
    /// The map that fits `pairs`, four or more, which may lie in space. `None` if they leave it open.
    pub fn new(pairs: &[Pair], layout: &[[f64; 3]], size: [u32; 2]) -> Option<Self> {
        let [width, height] = size.map(f64::from);
        let frame = Frame {
            middle: Vector2::new((width - 1.0) / 2.0, (height - 1.0) / 2.0),
            unit: width.hypot(height) / 2.0,
        };
        let origin = layout.iter().map(|&x| Vector3::from(x)).sum::<Vector3<f64>>() / layout.len() as f64;
        let reach = layout.iter().map(|&x| (Vector3::from(x) - origin).norm()).fold(0.0, f64::max);
        let plane = Plane::through(layout.iter().copied());
        let object = plane.map_or(Object::Space { origin }, Object::Plane);
        let blank = Self { frame, object, reach, parameters: DVector::zeros(0) };
        match plane {
            Some(plane) => blank.of_plane(&plane, pairs),
            None => blank.of_space(pairs),
        }
    }

    fn of_plane(self, plane: &Plane, pairs: &[Pair]) -> Option<Self> {
        let normalised: Vec<_> = pairs
            .iter()
            .map(|&(x, image)| (plane.coordinates(x) / self.reach, self.frame.normalise(image)))
            .collect();
        let h = homography(&normalised).or_else(|| affinity(&normalised))?.transpose();
        let mut parameters = DVector::zeros(8 + RADIAL);
        for (parameter, entry) in parameters.iter_mut().zip(h.iter().take(8)) {
            *parameter = entry / h[(2, 2)];
        }
        let finite = parameters.iter().all(|value| value.is_finite());
        finite.then(|| Self { parameters, ..self }.refit(pairs))
    }

    /// Starts from many rotations and some focal lengths, each with the translation that fits the middle and the size, and
    /// takes the best of what comes out.
    fn of_space(self, pairs: &[Pair]) -> Option<Self> {
        let count = pairs.len() as f64;
        let image = |pair: &Pair| self.frame.normalise(pair.1);
        let middle = pairs.iter().map(image).sum::<Vector2<f64>>() / count;
        let spread = pairs.iter().map(|pair| (image(pair) - middle).norm_squared()).sum::<f64>().sqrt();
        let object = |pair: &Pair| self.coordinates(pair.0);
        let centre = pairs.iter().map(object).sum::<Vector3<f64>>() / count;
        let mut best: Option<(f64, Self)> = None;
        for rotation in rotations() {
            let seen = |pair: &Pair| (rotation * (object(pair) - centre)).xy().norm_squared();
            let scale = spread / pairs.iter().map(seen).sum::<f64>().sqrt().max(1e-6);
            for focal in FOCAL {
                let depth = focal / scale;
                let tvec = (middle / focal).push(1.0) * depth - rotation * centre;
                let rvec = Rotation3::from_matrix_unchecked(rotation).scaled_axis();
                let start = [focal.ln(), rvec.x, rvec.y, rvec.z, tvec.x, tvec.y, tvec.z, 0.0, 0.0];
                let fitted = Self { parameters: start.to_vec().into(), ..self.clone() }.refit(pairs);
                let error = fitted.cost(pairs);
                if error.is_finite() && best.as_ref().is_none_or(|(least, _)| error < *least) {
                    best = Some((error, fitted));
                }
            }
        }
        best.map(|(_, map)| map)
    }

    /// The map of the same kind that fits `pairs` best, from this one on.
    pub fn refit(self, pairs: &[Pair]) -> Self {
        let fit = Fit { map: self, pairs };
        LevenbergMarquardt::new().with_tol(TOLERANCE).with_patience(PATIENCE).minimize(fit).0.map
    }

    /// Where the point `x` of the layout (mm) appears, px. `None` behind the camera, and where the lens folds the image.
    pub fn project(&self, x: [f64; 3]) -> Option<[f64; 2]> {
        let (image, front) = self.image(x);
        front.then_some((image * self.frame.unit + self.frame.middle).into())
    }

    /// Mean radius (px) with which a circle of `radius` (mm) about `x` appears. `None` where its plane is not known.
    pub fn size(&self, x: [f64; 3], radius: f64) -> Option<f64> {
        let Object::Plane(plane) = self.object else { return None };
        let centre = Vector2::from(self.project(x)?);
        let mut sum = 0.0;
        for direction in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let rim = Vector3::from(x) + plane.axes().column(direction.0) * (direction.1 * radius);
            sum += (Vector2::from(self.project(rim.into())?) - centre).norm();
        }
        Some(sum / 4.0)
    }

    /// In units of the layout's reach about its middle.
    fn coordinates(&self, x: [f64; 3]) -> Vector3<f64> {
        match self.object {
            Object::Plane(plane) => plane.coordinates(x).push(0.0) / self.reach,
            Object::Space { origin } => (Vector3::from(x) - origin) / self.reach,
        }
    }

    /// Where `x` appears in the frame's units, and whether a camera can see it.
    fn image(&self, x: [f64; 3]) -> (Vector2<f64>, bool) {
        let p = self.parameters.as_slice();
        let at = self.coordinates(x);
        let (point, focal) = match self.object {
            Object::Plane(_) => {
                let h = Matrix3::new(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], 1.0);
                (h * Vector3::new(at.x, at.y, 1.0), 1.0)
            }
            Object::Space { .. } => {
                let rotation = Rotation3::from_scaled_axis(Vector3::from_row_slice(&p[1..4]));
                (rotation * at + Vector3::from_row_slice(&p[4..7]), p[0].exp())
            }
        };
        let straight = point.xy() * (focal / point.z);
        let [k1, k2] = [p[p.len() - 2], p[p.len() - 1]];
        let r2 = straight.norm_squared();
        let growing = 1.0 + r2 * (3.0 * k1 + r2 * 5.0 * k2) > 0.0;
        (straight * (1.0 + r2 * (k1 + r2 * k2)), point.z > 0.0 && growing)
    }

    fn residuals(&self, pairs: &[Pair]) -> DVector<f64> {
        let expected = self.expected_small();
        let mut residuals = DVector::zeros(2 * pairs.len() + expected.len());
        for (index, &(x, image)) in pairs.iter().enumerate() {
            let shift = self.image(x).0 - self.frame.normalise(image);
            residuals.fixed_rows_mut::<2>(2 * index).copy_from(&shift);
        }
        for (row, index) in (2 * pairs.len()..).zip(expected) {
            residuals[row] = self.parameters[index] * (ERROR / USUAL);
        }
        residuals
    }

    /// The parameters that are small unless the points say otherwise.
    fn expected_small(&self) -> Vec<usize> {
        let radial = self.parameters.len() - RADIAL..self.parameters.len();
        let perspective = if matches!(self.object, Object::Plane(_)) { 6..8 } else { 0..0 };
        perspective.chain(radial).collect()
    }

    /// Infinite where a point would be behind the camera.
    fn cost(&self, pairs: &[Pair]) -> f64 {
        let ahead = pairs.iter().all(|pair| self.image(pair.0).1);
        if ahead { self.residuals(pairs).norm_squared() } else { f64::INFINITY }
    }
}

impl Frame {
    fn normalise(&self, image: [f64; 2]) -> Vector2<f64> {
        (Vector2::from(image) - self.middle) / self.unit
    }
}

/// The 24 rotations of a cube, turned so that none looks along an axis.
fn rotations() -> Vec<Matrix3<f64>> {
    let tilt = Rotation3::from_scaled_axis(Vector3::new(0.3, 0.2, 0.1));
    let axes: Vec<SVector<f64, 3>> =
        (0..6).map(|i| Vector3::ith(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 })).collect();
    let mut rotations = Vec::new();
    for a in &axes {
        for b in axes.iter().filter(|b| a.dot(b) == 0.0) {
            rotations.push(Matrix3::from_columns(&[*a, *b, a.cross(b)]) * tilt.matrix());
        }
    }
    rotations
}

struct Fit<'p> {
    map: Map,
    pairs: &'p [Pair],
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Fit<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.map.parameters.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.map.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.map.residuals(self.pairs))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns = (0..self.map.parameters.len()).map(|index| {
            let step = 1e-6 * (1.0 + self.map.parameters[index].abs());
            let at = |step: f64| {
                let mut map = self.map.clone();
                map.parameters[index] += step;
                map.residuals(self.pairs)
            };
            (at(step) - at(-step)) / (2.0 * step)
        });
        Some(DMatrix::from_columns(&columns.collect::<Vec<_>>()))
    }
}
