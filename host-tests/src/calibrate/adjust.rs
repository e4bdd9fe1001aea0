//! The bundle adjustment: camera and poses that make the sum of squared, whitened distances smallest.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Matrix2, Owned, Vector2, Vector3};

use super::{
    Intrinsics, Options, Point, Pose, View,
    model::{COUNT, Placed},
};

/// Parameters of a pose.
const POSE: usize = 6;
/// Parameters and sum of squares are found to this share.
const TOLERANCE: f64 = 1e-12;
/// Most evaluations, in parameters. Where the points tell the camera a tenth of that is enough.
const PATIENCE: usize = 3;

/// A point and the matrix that makes the covariance of its image the unit matrix.
struct Sight {
    object: Vector3<f64>,
    image: Vector2<f64>,
    radius: f64,
    whiten: Matrix2<f64>,
}

/// The problem at a place in parameter space.
pub struct Adjustment {
    sights: Vec<Vec<Sight>>,
    normal: Vector3<f64>,
    free: Vec<Vec<usize>>,
    /// Camera and poses.
    pub intrinsics: Intrinsics,
    /// A pose for each view.
    pub poses: Vec<Pose>,
}

/// `L^-1` of the covariance `L L'`. `None` if that is not positive definite.
pub fn whitening([xx, xy, yy]: [f64; 3]) -> Option<Matrix2<f64>> {
    Matrix2::new(xx, xy, xy, yy).cholesky()?.l().try_inverse()
}

impl Adjustment {
    /// `normal` is that of the targets' plane. Points whose `kept` is false take no part.
    pub fn new(
        views: &[View],
        kept: &[Vec<bool>],
        normal: Vector3<f64>,
        options: &Options,
        (intrinsics, poses): (Intrinsics, Vec<Pose>),
    ) -> Self {
        let sight = |point: &Point| {
            let covariance = if options.weighted { point.covariance } else { [1.0, 0.0, 1.0] };
            Sight {
                object: point.object.into(),
                image: point.image.into(),
                radius: point.radius,
                whiten: whitening(covariance).unwrap_or_else(Matrix2::zeros),
            }
        };
        let kept_points = |(view, kept): (&View, &Vec<bool>)| {
            view.points.iter().zip(kept).filter(|&(_, &kept)| kept).map(|(point, _)| sight(point)).collect()
        };
        let sights = views.iter().zip(kept).map(kept_points).collect();
        let mut adjustment = Self { sights, normal, free: options.free(), intrinsics, poses };
        // Focal lengths that must be the same are so from the start.
        adjustment.set_params(&adjustment.params());
        adjustment
    }

    /// Moves to the minimum; whether it was found.
    pub fn solve(self) -> (Self, bool) {
        let (solved, report) =
            LevenbergMarquardt::new().with_tol(TOLERANCE).with_patience(PATIENCE).minimize(self);
        // Rounding can end the descent before the tolerance does.
        let done = report.termination.was_successful() || report.termination.was_usage_issue();
        let ahead = solved.sights.iter().zip(&solved.poses).all(|(sights, pose)| {
            let placed = Placed::new(pose, solved.normal);
            sights.iter().all(|sight| placed.point(&sight.object).z > 0.0)
        });
        (solved, done && ahead && report.objective_function.is_finite())
    }

    /// Number of whitened distances.
    pub fn rows(&self) -> usize {
        2 * self.sights.iter().map(Vec::len).sum::<usize>()
    }

    /// Number of parameters.
    pub fn columns(&self) -> usize {
        self.free.len() + POSE * self.poses.len()
    }

    /// Covariance of the camera's parameters (by [`Intrinsics::NAMES`]; 0 for a fixed one) and, after those, the
    /// variances of the parameters of all poses. `None` if the points leave a parameter open.
    pub fn covariance(&self) -> Option<(DMatrix<f64>, Vec<f64>)> {
        let mut jacobian = self.jacobian()?;
        if jacobian.nrows() < jacobian.ncols() {
            return None;
        }
        let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
        for (mut column, norm) in jacobian.column_iter_mut().zip(&norms) {
            column /= *norm;
        }
        let columns = jacobian.ncols();
        let inverse = jacobian.qr().r().solve_upper_triangular(&DMatrix::identity(columns, columns))?;
        let entry = |i: usize, j: usize| inverse.row(i).dot(&inverse.row(j)) / (norms[i] * norms[j]);
        let mut camera = DMatrix::zeros(COUNT, COUNT);
        for (i, first) in self.free.iter().enumerate() {
            for (j, second) in self.free.iter().enumerate() {
                for (&a, &b) in first.iter().flat_map(|a| second.iter().map(move |b| (a, b))) {
                    camera[(a, b)] = entry(i, j);
                }
            }
        }
        let poses: Vec<_> = (self.free.len()..columns).map(|i| entry(i, i)).collect();
        let finite = camera.iter().chain(&poses).all(|value| value.is_finite());
        finite.then_some((camera, poses))
    }

    fn each(&self, mut take: impl FnMut(usize, usize, &Placed, &Sight)) {
        let mut row = 0;
        for (view, (sights, pose)) in self.sights.iter().zip(&self.poses).enumerate() {
            let placed = Placed::new(pose, self.normal);
            for sight in sights {
                take(row, view, &placed, sight);
                row += 2;
            }
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Adjustment {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        let mut camera = self.intrinsics.to_array();
        for (together, value) in self.free.iter().zip(x.iter()) {
            for &parameter in together {
                camera[parameter] = *value;
            }
        }
        self.intrinsics = Intrinsics::from_array(camera);
        let offset = self.free.len();
        for (view, pose) in self.poses.iter_mut().enumerate() {
            pose.rvec = x.fixed_rows::<3>(offset + POSE * view).into_owned();
            pose.tvec = x.fixed_rows::<3>(offset + POSE * view + 3).into_owned();
        }
    }

    fn params(&self) -> DVector<f64> {
        let camera = self.intrinsics.to_array();
        let camera = self.free.iter().map(|together| camera[together[0]]);
        let poses = self.poses.iter().flat_map(|pose| [pose.rvec, pose.tvec]).flat_map(|v| [v.x, v.y, v.z]);
        DVector::from_vec(camera.chain(poses).collect())
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let mut residuals = DVector::zeros(self.rows());
        self.each(|row, _, placed, sight| {
            let place = placed.seen_centre(&self.intrinsics, &sight.object, sight.radius);
            let distance = place - sight.image;
            residuals.fixed_rows_mut::<2>(row).copy_from(&(sight.whiten * distance));
        });
        Some(residuals)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut jacobian = DMatrix::zeros(self.rows(), self.columns());
        self.each(|row, view, placed, sight| {
            // What distortion does within an ellipse hardly depends on the parameters.
            let (point, by_pose) = placed.ellipse_centre(&sight.object, sight.radius);
            let projection = self.intrinsics.derive(&point);
            let by_camera = sight.whiten * projection.by_intrinsics;
            for (column, together) in self.free.iter().enumerate() {
                for &parameter in together {
                    let mut place = jacobian.fixed_view_mut::<2, 1>(row, column);
                    place += by_camera.column(parameter);
                }
            }
            let by_pose = sight.whiten * projection.by_point * by_pose;
            jacobian.fixed_view_mut::<2, POSE>(row, self.free.len() + POSE * view).copy_from(&by_pose);
        });
        Some(jacobian)
    }
}
