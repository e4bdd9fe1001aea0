//! Planes through points.

use nalgebra::{Matrix3, SymmetricEigen, Vector2, Vector3};

/// Spread across a plane below which points lie on it, as a share of the largest spread.
const FLAT: f64 = 0.02;

/// A plane through points.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    origin: Vector3<f64>,
    axes: Matrix3<f64>,
}

impl Plane {
    /// The plane on which `points` lie. `None` if they do not lie on one.
    pub fn through(points: impl Iterator<Item = [f64; 3]> + Clone) -> Option<Self> {
        let objects = points.map(Vector3::from);
        let count = objects.clone().count() as f64;
        let origin = objects.clone().sum::<Vector3<f64>>() / count;
        let scatter = objects.map(|x| (x - origin) * (x - origin).transpose()).sum::<Matrix3<f64>>() / count;
        let eigen = SymmetricEigen::new(scatter);
        let (smallest, largest) = (eigen.eigenvalues.imin(), eigen.eigenvalues.imax());
        let flat = eigen.eigenvalues[smallest] <= FLAT * FLAT * eigen.eigenvalues[largest];
        let direction = |index: usize| eigen.eigenvectors.column(index).into_owned();
        let (e1, normal) = (direction(largest), direction(smallest));
        flat.then(|| Self { origin, axes: Matrix3::from_columns(&[e1, normal.cross(&e1), normal]) })
    }

    /// Middle of the points.
    pub fn origin(&self) -> Vector3<f64> {
        self.origin
    }

    /// Two directions in it and its normal, as columns.
    pub fn axes(&self) -> Matrix3<f64> {
        self.axes
    }

    /// Unit normal, in the object's axes; its sign means nothing.
    pub fn normal(&self) -> Vector3<f64> {
        self.axes.column(2).into_owned()
    }

    /// The place of a point in the plane, along the axes from the origin.
    pub fn coordinates(&self, object: [f64; 3]) -> Vector2<f64> {
        (self.axes.transpose() * (Vector3::from(object) - self.origin)).xy()
    }
}
