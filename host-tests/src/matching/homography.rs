//! Maps from a plane, or from space, to the image that are linear in homogeneous coordinates.

use nalgebra::{DMatrix, Matrix3, Matrix3x4, SVD, Vector2, Vector3};

/// Smallest share of the largest singular value by which a system must be determined.
const DETERMINED: f64 = 1e-7;
/// The same of a homography in normalised coordinates. A plane seen at 89 degrees has 0.01.
const REGULAR: f64 = 1e-3;

/// The homography that takes each first place to the second: direct linear transform with normalised coordinates (Hartley
/// 1997, "In defense of the eight-point algorithm"). `None` for fewer than four pairs, or if all but one lie on a line.
pub fn homography(pairs: &[(Vector2<f64>, Vector2<f64>)]) -> Option<Matrix3<f64>> {
    if pairs.len() < 4 {
        return None;
    }
    let from = normalisation(pairs.iter().map(|pair| pair.0.data.0[0]))?;
    let to = normalisation(pairs.iter().map(|pair| pair.1.data.0[0]))?;
    let pair = |(source, target): &(Vector2<f64>, Vector2<f64>)| {
        let [[x, y], [u, v]] = [from.apply(source.data.0[0]), to.apply(target.data.0[0])];
        ([x, y, 1.0], [u, v])
    };
    let h = null_vector::<3>(pairs.iter().map(pair))?;
    let h = Matrix3::from_row_slice(&h);
    // Three places on a line that are not so in the image flatten the plane.
    let stretches = h.singular_values();
    let h = to.inverse() * h * from.matrix();
    (stretches.min() > REGULAR * stretches.max()).then(|| h / h.norm())
}

/// The affine map that takes each first place nearest to the second, as a homography. `None` if they lie on a line.
pub fn affinity(pairs: &[(Vector2<f64>, Vector2<f64>)]) -> Option<Matrix3<f64>> {
    let from = normalisation(pairs.iter().map(|pair| pair.0.data.0[0]))?;
    let rows: Vec<_> = pairs.iter().map(|(source, _)| from.apply(source.data.0[0])).collect();
    let system = DMatrix::from_fn(pairs.len(), 3, |row, axis| rows[row].get(axis).copied().unwrap_or(1.0));
    let images = DMatrix::from_fn(pairs.len(), 2, |row, axis| pairs[row].1[axis]);
    let svd = SVD::new(system, true, true);
    let values = &svd.singular_values;
    if values.len() < 3 || values[2] < REGULAR * values[0] {
        return None;
    }
    let solution = svd.solve(&images, 0.0).ok()?;
    let row = |axis: usize| [solution[(0, axis)], solution[(1, axis)], solution[(2, axis)]];
    Some(Matrix3::from_row_slice(&[row(0), row(1), [0.0, 0.0, 1.0]].concat()) * from.matrix())
}

/// The projection matrix that takes points of space to the image, by the same method. `None` for fewer than six pairs, or
/// if the points lie on a plane or another surface that leaves it open.
pub fn projection(pairs: &[(Vector3<f64>, Vector2<f64>)]) -> Option<Matrix3x4<f64>> {
    if pairs.len() < 6 {
        return None;
    }
    let from = normalisation(pairs.iter().map(|pair| pair.0.data.0[0]))?;
    let to = normalisation(pairs.iter().map(|pair| pair.1.data.0[0]))?;
    let pair = |(source, target): &(Vector3<f64>, Vector2<f64>)| {
        let ([x, y, z], uv) = (from.apply(source.data.0[0]), to.apply(target.data.0[0]));
        ([x, y, z, 1.0], uv)
    };
    let p = null_vector::<4>(pairs.iter().map(pair))?;
    let [a, b, c] = from.middle;
    let s = from.scale;
    let shift = nalgebra::Matrix4::new(
        s,
        0.0,
        0.0,
        -s * a, //
        0.0,
        s,
        0.0,
        -s * b, //
        0.0,
        0.0,
        s,
        -s * c, //
        0.0,
        0.0,
        0.0,
        1.0,
    );
    Some(to.inverse() * Matrix3x4::from_row_slice(&p) * shift)
}

/// `place` through the homography `h`.
pub fn apply(h: &Matrix3<f64>, place: Vector2<f64>) -> Vector2<f64> {
    let image = h * place.push(1.0);
    image.xy() / image.z
}

/// Moves the mean of some places to the origin and their mean square distance to that of unit vectors.
struct Normalisation<const D: usize> {
    middle: [f64; D],
    scale: f64,
}

fn normalisation<const D: usize>(places: impl Iterator<Item = [f64; D]> + Clone) -> Option<Normalisation<D>> {
    let count = places.clone().count() as f64;
    let middle = std::array::from_fn(|axis| places.clone().map(|place| place[axis]).sum::<f64>() / count);
    let square =
        |place: [f64; D]| place.iter().zip(&middle).map(|(v, m): (_, &f64)| (v - m).powi(2)).sum::<f64>();
    let spread = (places.map(square).sum::<f64>() / count).sqrt();
    (spread > 0.0 && spread.is_finite()).then(|| Normalisation { middle, scale: (D as f64).sqrt() / spread })
}

impl<const D: usize> Normalisation<D> {
    fn apply(&self, place: [f64; D]) -> [f64; D] {
        std::array::from_fn(|axis| (place[axis] - self.middle[axis]) * self.scale)
    }
}

impl Normalisation<2> {
    fn matrix(&self) -> Matrix3<f64> {
        let [x, y] = self.middle.map(|middle| -middle * self.scale);
        Matrix3::new(self.scale, 0.0, x, 0.0, self.scale, y, 0.0, 0.0, 1.0)
    }

    fn inverse(&self) -> Matrix3<f64> {
        let ([x, y], s) = (self.middle, 1.0 / self.scale);
        Matrix3::new(s, 0.0, x, 0.0, s, y, 0.0, 0.0, 1.0)
    }
}

/// The rows of the matrix that takes each `[f64; N]` to the direction of `(u, v, 1)`.
fn null_vector<const N: usize>(
    pairs: impl ExactSizeIterator<Item = ([f64; N], [f64; 2])>,
) -> Option<Vec<f64>> {
    // With a row of zeros where the system has too few, so that the decomposition holds all of its kernel.
    let mut system = DMatrix::zeros((2 * pairs.len()).max(3 * N), 3 * N);
    for (row, (source, image)) in pairs.enumerate() {
        for axis in 0..2 {
            for (i, &value) in source.iter().enumerate() {
                system[(2 * row + axis, axis * N + i)] = value;
                system[(2 * row + axis, 2 * N + i)] = -image[axis] * value;
            }
        }
    }
    let svd = SVD::new(system, false, true);
    let values = &svd.singular_values;
    // Sorted, largest first: the last is that of the answer.
    let determined = values[3 * N - 2] > DETERMINED * values[0];
    determined.then(|| svd.v_t.map(|v_t| v_t.row(3 * N - 1).iter().copied().collect()))?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_points_are_enough_and_a_line_is_not() {
        let truth = Matrix3::new(2.0, 0.3, 500.0, -0.1, 1.8, 300.0, 1e-3, -4e-4, 1.0);
        let places = [[0.0, 0.0], [200.0, 10.0], [190.0, 150.0], [-20.0, 140.0], [77.0, 33.0]]
            .map(|[x, y]| Vector2::new(x, y));
        let pairs = |places: &[Vector2<f64>]| -> Vec<_> {
            places.iter().map(|&place| (place, apply(&truth, place))).collect()
        };
        for count in [4, 5] {
            let found = homography(&pairs(&places[..count])).unwrap();
            for &place in &places {
                assert!((apply(&found, place) - apply(&truth, place)).norm() < 1e-9);
            }
        }
        assert!(homography(&pairs(&places[..3])).is_none());
        let line: Vec<_> = (0..6).map(|i| Vector2::new(f64::from(i) * 7.0, f64::from(i) * 3.0)).collect();
        assert!(homography(&pairs(&line)).is_none());
        let mut all_but_one = line;
        all_but_one[2].x += 50.0;
        assert!(homography(&pairs(&all_but_one)).is_none());
    }

    #[test]
    fn projection_of_points_in_space() {
        let truth = Matrix3x4::new(900.0, 20.0, 300.0, 5e5, -30.0, 880.0, 200.0, 4e5, 0.1, 0.2, 0.97, 800.0);
        let place = |x: &Vector3<f64>| {
            let image = truth * x.push(1.0);
            image.xy() / image.z
        };
        let corners: Vec<_> = (0..7)
            .map(|i| Vector3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 100.0)
            .collect();
        let pairs: Vec<_> = corners.iter().map(|x| (*x, place(x))).collect();
        let found = projection(&pairs).unwrap();
        let probe = Vector3::new(33.0, 71.0, -20.0);
        let image = found * probe.push(1.0);
        assert!((image.xy() / image.z - place(&probe)).norm() < 1e-7);
        assert!(projection(&pairs[..4]).is_none());
        let flat: Vec<_> = pairs.iter().map(|(x, u)| (Vector3::new(x.x + x.z, x.y, 0.0), *u)).collect();
        assert!(projection(&flat).is_none());
    }
}
