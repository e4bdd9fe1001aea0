//! Where the adjustment starts: closed forms.
//!
//! Views of a plane: Zhang 2000, "A flexible new technique for camera calibration", section 3.1, with skew 0. Views of
//! points in space: the projection matrix split into camera and pose. Lens distortion is 0 here.

use nalgebra::{DMatrix, Matrix3, Matrix3x4, SVD, Vector2};

use super::{CalibrationError, Intrinsics, Point, Pose, View};
use crate::matching::{
    homography::{homography, projection},
    plane::Plane,
};

/// Focal lengths that are taken, in larger sides of the frame.
const FOCAL: [f64; 2] = [0.1, 100.0];

/// How a view maps its points, without regard to what a camera can do.
enum Linear {
    Plane(Plane, Matrix3<f64>),
    Space(Matrix3x4<f64>),
}

impl Linear {
    fn of(view: &View) -> Result<Self, CalibrationError> {
        let image = |point: &Point| Vector2::from(point.image);
        let found = if let Some(plane) = Plane::through(view.points.iter().map(|point| point.object)) {
            let pairs: Vec<_> = view.points.iter().map(|p| (plane.coordinates(p.object), image(p))).collect();
            homography(&pairs).map(|h| Self::Plane(plane, h))
        } else {
            let pairs: Vec<_> = view.points.iter().map(|p| (p.object.into(), image(p))).collect();
            projection(&pairs).map(Self::Space)
        };
        found.ok_or_else(|| CalibrationError::Collinear { view: view.name.clone() })
    }

    fn pose(&self, camera: &Matrix3<f64>) -> Option<Pose> {
        let inverse = camera.try_inverse()?;
        match self {
            Self::Plane(plane, h) => {
                let m = inverse * h;
                let (a, b, c) = (m.column(0), m.column(1), m.column(2));
                let scale = 2.0 / (a.norm() + b.norm()) * c.z.signum();
                let (a, b) = (a * scale, b * scale);
                let rotation = nearest_rotation(&Matrix3::from_columns(&[a, b, a.cross(&b)]))?;
                let rotation = rotation * plane.axes().transpose();
                Some(Pose::new(&rotation, c * scale - rotation * plane.origin()))
            }
            Self::Space(p) => {
                let m = inverse * p;
                let turn = m.fixed_columns::<3>(0).into_owned();
                let scale = turn.determinant().cbrt();
                Some(Pose::new(&nearest_rotation(&(turn / scale))?, m.column(3) / scale))
            }
        }
    }
}

fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = SVD::new(*matrix, true, true);
    let rotation = svd.u? * svd.v_t?;
    (rotation.determinant() > 0.0).then_some(rotation)
}

/// A camera and the pose of every view.
///
/// # Errors
/// Points of a view on a line.
pub fn start(views: &[View]) -> Result<(Intrinsics, Vec<Pose>), CalibrationError> {
    let maps = views.iter().map(Linear::of).collect::<Result<Vec<_>, _>>()?;
    let [width, height] = views.first().map_or([1; 2], |view| view.size).map(f64::from);
    let frame = Frame { middle: [(width - 1.0) / 2.0, (height - 1.0) / 2.0], unit: width.max(height) };
    let intrinsics = frame.camera(&maps);
    let Intrinsics { fx, fy, cx, cy, .. } = intrinsics;
    let camera = Matrix3::new(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0);
    let poses = maps.iter().zip(views).map(|(map, view)| {
        map.pose(&camera).ok_or_else(|| CalibrationError::Collinear { view: view.name.clone() })
    });
    Ok((intrinsics, poses.collect::<Result<_, _>>()?))
}

/// Image coordinates in larger sides of the frame about its middle.
struct Frame {
    middle: [f64; 2],
    unit: f64,
}

impl Frame {
    /// The best camera that the maps tell: everything if they can, the focal lengths about the middle of the frame, one
    /// focal length, or a common lens.
    fn camera(&self, maps: &[Linear]) -> Intrinsics {
        let spatial: Vec<_> = maps.iter().filter_map(|map| self.of_projection(map)).collect();
        let scaled = middle_of(&spatial)
            .or_else(|| self.zhang(maps, &[0, 2, 3, 4, 5]))
            .or_else(|| self.zhang(maps, &[0, 2, 5]))
            .unwrap_or([1.0, 1.0, 0.0, 0.0]);
        let [fx, fy, cx, cy] = scaled.map(|value| value * self.unit);
        Intrinsics::pinhole(fx, fy, cx + self.middle[0], cy + self.middle[1])
    }

    /// Zhang's equations for the entries `unknown` of his `b` (eq. 6); the others are 0. Returns fx, fy, cx, cy.
    fn zhang(&self, maps: &[Linear], unknown: &[usize]) -> Option<[f64; 4]> {
        let mut rows = Vec::new();
        for map in maps {
            let Linear::Plane(_, h) = map else { continue };
            let h = self.scaled(h);
            let h = h / (h.column(0).norm() + h.column(1).norm());
            rows.push(constraint(&h, 0, 1));
            rows.push(constraint(&h, 0, 0).zip_map(&constraint(&h, 1, 1), |a, b| a - b));
        }
        let system = DMatrix::from_fn(rows.len().max(unknown.len()), unknown.len(), |row, column| {
            rows.get(row).map_or(0.0, |entries| entries[unknown[column]])
        });
        let svd = SVD::new(system, false, true);
        let solution = svd.v_t.as_ref()?.row(unknown.len() - 1).into_owned();
        let mut b = [0.0; 6];
        for (&entry, value) in unknown.iter().zip(solution.iter()) {
            b[entry] = *value;
        }
        let [b11, _, b22, b13, b23, b33] = b;
        let lambda = b33 - b13 * b13 / b11 - b23 * b23 / b22;
        plausible([(lambda / b11).sqrt(), (lambda / b22).sqrt(), -b13 / b11, -b23 / b22])
    }

    /// fx, fy, cx, cy of a projection matrix.
    fn of_projection(&self, map: &Linear) -> Option<[f64; 4]> {
        let Linear::Space(p) = map else { return None };
        let turn = self.scaled(&p.fixed_columns::<3>(0).into_owned());
        let square = turn * turn.transpose();
        let square = square / square[(2, 2)];
        let (cx, cy) = (square[(0, 2)], square[(1, 2)]);
        let fy = (square[(1, 1)] - cy * cy).sqrt();
        let skew = (square[(0, 1)] - cx * cy) / fy;
        plausible([(square[(0, 0)] - cx * cx - skew * skew).sqrt(), fy, cx, cy])
    }

    fn scaled(&self, map: &Matrix3<f64>) -> Matrix3<f64> {
        let ([x, y], s) = (self.middle, 1.0 / self.unit);
        Matrix3::new(s, 0.0, -x * s, 0.0, s, -y * s, 0.0, 0.0, 1.0) * map
    }
}

/// Zhang's `v_ij`.
fn constraint(h: &Matrix3<f64>, i: usize, j: usize) -> nalgebra::Vector6<f64> {
    let (a, b) = (h.column(i), h.column(j));
    nalgebra::Vector6::new(
        a.x * b.x,
        a.x * b.y + a.y * b.x,
        a.y * b.y,
        a.z * b.x + a.x * b.z,
        a.z * b.y + a.y * b.z,
        a.z * b.z,
    )
}

fn plausible(camera: [f64; 4]) -> Option<[f64; 4]> {
    let [fx, fy, cx, cy] = camera;
    let focal = |f: f64| (FOCAL[0]..=FOCAL[1]).contains(&f);
    (focal(fx) && focal(fy) && (0.5..2.0).contains(&(fx / fy)) && cx.abs() < 1.0 && cy.abs() < 1.0)
        .then_some(camera)
}

/// The median of each number.
fn middle_of(cameras: &[[f64; 4]]) -> Option<[f64; 4]> {
    (!cameras.is_empty()).then(|| {
        std::array::from_fn(|index| {
            let mut values: Vec<_> = cameras.iter().map(|camera| camera[index]).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        })
    })
}
