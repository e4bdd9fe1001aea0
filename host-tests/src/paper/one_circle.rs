//! One circle before a known camera: the plane and the true centre from the shape of a single ellipse.
//!
//! Otepka 2004, "Precision target mensuration in vision metrology", and Otepka and Fraser 2004, do so in object space. Here
//! the radius is not needed: with the ellipse's conic Q and the camera's matrix K the cone K' Q K has two families of circular
//! sections; for each normal n the true centre is c ~ Q^-1 K^-T n. The library solves the same two equations without
//! eigenvectors ([`Sight`]).

use concentric::{Camera, Ellipse, Position, centre::Sight};

use crate::measure::px;

/// A plane on which the ellipse is the image of a circle.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Where the image shows the true centre, px, lens distortion included.
    pub centre: [f64; 2],
    /// Unit normal towards the camera, in camera axes.
    pub normal: [f64; 3],
}

/// Both planes. `ellipse` is one that was found with `camera` in the settings. `None` where the lens folds the image.
pub fn candidates(ellipse: &Ellipse, camera: &Camera) -> Option<[Candidate; 2]> {
    let ((fx, fy), (cx, cy)) = (camera.focal_lengths(), camera.principal_point());
    let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(f64::from);
    // Rows stretched to the scale of columns.
    let aspect = fx / fy;
    let middle = px(camera.undistort(ellipse.centre)?);
    let (l0, l1, l2) = triangle(ellipse);
    let at = (middle[0] - cx, aspect * (middle[1] - cy));
    let sight = Sight::new((l0, l1 / aspect, l2 / aspect), at, fx);
    let [a, b] = sight.sections().map(|section| {
        let (dx, dy) = section.centre;
        let centre = seen(camera, [middle[0] + dx, middle[1] + dy / aspect])?;
        let (nx, ny, nz) = sight.normal(section.line);
        Some(Candidate { centre, normal: [nx, ny, nz] })
    });
    Some([a?, b?])
}

/// (l0, l1, l2) of L = ((l0, l1), (0, l2)) that takes the ellipse to the unit circle.
fn triangle(ellipse: &Ellipse) -> (f64, f64, f64) {
    let [a, b, theta] = [ellipse.a, ellipse.b, ellipse.theta].map(f64::from);
    let (sin, cos) = theta.sin_cos();
    let (a, b) = (1.0 / (a * a), 1.0 / (b * b));
    let (xx, xy, yy) = (a * cos * cos + b * sin * sin, (a - b) * sin * cos, a * sin * sin + b * cos * cos);
    let l0 = xx.sqrt();
    let l1 = xy / l0;
    (l0, l1, (yy - l1 * l1).sqrt())
}

/// The undistorted `place` in the image as it is.
fn seen(camera: &Camera, place: [f64; 2]) -> Option<[f64; 2]> {
    let [x, y] = place.map(|axis| (axis * f64::from(Position::SCALE)).round() as i32);
    camera.distort(Position { x, y }).map(px)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use nalgebra::{Matrix3, SymmetricEigen, Vector3};

    use super::*;
    use crate::render::{self, Pose};

    /// The same by the eigenvectors of the cone, as in the books: true centres and normals.
    fn by_eigenvectors(conic: Matrix3<f64>, k: Matrix3<f64>) -> Vec<([f64; 2], Vector3<f64>)> {
        let cone = k.transpose() * conic * k;
        let eigen = SymmetricEigen::new(cone);
        let mut order = [0, 1, 2];
        // One eigenvalue has the other sign; among the two alike the larger one first.
        let odd =
            (0..3).find(|&i| (0..3).all(|j| j == i || eigen.eigenvalues[i] * eigen.eigenvalues[j] < 0.0));
        let odd = odd.expect("a cone");
        order.sort_by(|&i, &j| {
            let size = |i: usize| if i == odd { -1.0 } else { eigen.eigenvalues[i].abs() };
            size(j).total_cmp(&size(i))
        });
        let [l1, l2, l3] = order.map(|i| eigen.eigenvalues[i]);
        let [v1, _, v3] = order.map(|i| eigen.eigenvectors.column(i).into_owned());
        let (s, c) = (((l1 - l2) / (l1 - l3)).sqrt(), ((l2 - l3) / (l1 - l3)).sqrt());
        [1.0, -1.0]
            .map(|sign| {
                let normal = v1 * (sign * s) + v3 * c;
                let normal = if normal.z > 0.0 { -normal } else { normal };
                let centre = k * (cone.try_inverse().expect("a cone") * normal);
                ([centre.x / centre.z, centre.y / centre.z], normal)
            })
            .to_vec()
    }

    #[test]
    fn planes_are_those_of_the_cones_eigenvectors() {
        let lens = render::Camera::new(1280, 960, 1500.0);
        let camera = Camera::new(1500.0, 1500.0, 640.0, 480.0).unwrap();
        let k = Matrix3::new(1500.0, 0.0, 640.0, 0.0, 1500.0, 480.0, 0.0, 0.0, 1.0);
        for (tilt, azimuth) in [(20.0, 10.0), (45.0, 130.0), (60.0, 250.0)] {
            let pose = Pose { x: 900.0, y: 300.0, distance: 700.0, tilt, azimuth };
            let view = pose.view(&lens);
            let seen = view.ellipse(DVec2::ZERO, 25.0);
            let unit = |value: f64| (value * f64::from(Position::SCALE)).round() as i32;
            let ellipse = Ellipse {
                centre: Position { x: unit(seen.x), y: unit(seen.y) },
                a: seen.a as f32,
                b: seen.b as f32,
                theta: seen.theta as f32,
            };
            // The conic of the rounded ellipse.
            let (l0, l1, l2) = triangle(&ellipse);
            let [x, y] = px(ellipse.centre);
            let l = Matrix3::new(l0, l1, -l0 * x - l1 * y, 0.0, l2, -l2 * y, 0.0, 0.0, 1.0);
            let conic = l.transpose() * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)) * l;
            let books = by_eigenvectors(conic, k);
            let found = candidates(&ellipse, &camera).unwrap();
            let truth = [pose.x, pose.y];
            let mut nearest = f64::MAX;
            for candidate in found {
                let off = |(centre, normal): &([f64; 2], Vector3<f64>)| {
                    let turn = (normal - Vector3::from(candidate.normal)).norm();
                    (crate::measure::distance(*centre, candidate.centre), turn)
                };
                let (place, turn) =
                    books.iter().map(off).min_by(|a, b| a.0.total_cmp(&b.0)).expect("two candidates");
                // Places are rounded to 1/65536 px.
                assert!(place < 2e-5 && turn < 1e-7, "{place:e} {turn:e}");
                nearest = nearest.min(crate::measure::distance(candidate.centre, truth));
            }
            assert!(nearest < 1e-4, "{nearest}");
            // Teeth: a focal length 1 % off.
            let wrong = Camera::new(1515.0, 1515.0, 640.0, 480.0).unwrap();
            let [a, b] = candidates(&ellipse, &wrong).unwrap();
            let off = |candidate: Candidate| crate::measure::distance(candidate.centre, truth);
            assert!(off(a).min(off(b)) > 1e-3);
        }
    }
}
