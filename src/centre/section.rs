use super::Real;

/// An ellipse in the frame where it is the unit circle, q = L (p - c), and the camera that sees it, for circles on a plane.
///
/// A place p is on the plane's vanishing line where `l.(p - c) + 1 = 0`; in the frame that is `s.q + 1 = 0` with `l = L's`.
/// The pole of that line, `-s`, is the true centre of a circle that is imaged as the ellipse. On that line the conic
/// `q'q - 1` must be a multiple of the image of the absolute conic, which is `q'G q + 2 g.q + m` here: two equations for
/// s, of second order, with two solutions (Kanatani and Liu 1993, "3D interpretation of conics and orthogonality", CVGIP:
/// Image Underst. 58(3); there by the eigenvectors of the cone, which f32 cannot tell apart for a small circle).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sight<T> {
    /// L^-1 = ((e0, e1), (0, e2)), px.
    e: (T, T, T),
    /// The ellipse's centre from the principal point, px.
    at: (T, T),
    focal_length: T,
    g: (T, T),
    m: T,
    /// Half the trace of G, px^2.
    mean: T,
    /// Its deviator ((xx - yy) / 2, xy), px^2.
    deviator: (T, T),
}

/// A plane on which an ellipse is the image of a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Section<T> {
    /// The true centre from the ellipse's centre, px.
    pub centre: (T, T),
    /// The plane's vanishing line: the places p with l.(p - c) + 1 = 0 about the ellipse's centre c, 1/px.
    pub line: (T, T),
}

/// What a vanishing line leaves of the [`Sight`]'s two equations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Misfit<T> {
    /// (a, b): the ellipse would be the image of a circle if its conic were q'q - 1 + a (u^2 - v^2) + 2 b u v.
    pub stretch: (T, T),
    /// Its derivative by s, as a complex number: d(stretch) = slope x ds.
    pub slope: (T, T),
}

/// Product of complex numbers.
fn product<T: Real>((a, b): (T, T), (c, d): (T, T)) -> (T, T) {
    (a * c - b * d, a * d + b * c)
}

/// One of the square roots of a complex number.
fn root<T: Real>((a, b): (T, T)) -> (T, T) {
    let half = T::from(0.5);
    let zero = T::from(0.0);
    let size = (a * a + b * b).sqrt();
    if !(size > zero) {
        return (zero, zero);
    }
    // The larger part first, where nothing cancels.
    if a > zero {
        let real = (half * (size + a)).sqrt();
        (real, half * b / real)
    } else {
        let imaginary = (half * (size - a)).sqrt();
        (half * b / imaginary, imaginary)
    }
}

impl<T: Real> Sight<T> {
    /// `l` is (l0, l1, l2) of L = ((l0, l1), (0, l2)) with the ellipse (p - c)' L'L (p - c) = 1; `at` is c from the principal
    /// point of a camera with square pixels. Lengths in px.
    pub fn new((l0, l1, l2): (T, T, T), at: (T, T), focal_length: T) -> Self {
        let one = T::from(1.0);
        let half = T::from(0.5);
        let e @ (e0, e1, e2) = (one / l0, -l1 / (l0 * l2), one / l2);
        let (xx, xy, yy) = (e0 * e0, e0 * e1, e1 * e1 + e2 * e2);
        Self {
            e,
            at,
            focal_length,
            g: (e0 * at.0, e1 * at.0 + e2 * at.1),
            m: at.0 * at.0 + at.1 * at.1 + focal_length * focal_length,
            mean: half * (xx + yy),
            deviator: (half * ((e0 - e2) * (e0 + e2) - e1 * e1), xy),
        }
    }

    /// The factor between the two conics on the line s.
    fn factor(&self, (x, y): (T, T)) -> T {
        let two = T::from(2.0);
        let square = x * x + y * y;
        (two * self.mean - two * (self.g.0 * x + self.g.1 * y) + self.m * square) / (two - square)
    }

    /// The two planes (they coincide for a circle seen from the front). Exact: the factor between the conics, whose
    /// influence is of the order of (radius / distance)^2, is iterated. In f32 within 1e-5 px for semi-major axes up to 100 px
    /// and tilts of 10 degrees or more (`one_of_the_sections_is_the_plane`).
    pub fn sections(&self) -> [Section<T>; 2] {
        [T::from(1.0), T::from(-1.0)].map(|sign| {
            let mut factor = self.mean;
            let mut s = (T::from(0.0), T::from(0.0));
            for _ in 0..12 {
                let m = self.m + factor;
                let two_m = m + m;
                let square = product(self.g, self.g);
                let radicand = (square.0 - two_m * self.deviator.0, square.1 - two_m * self.deviator.1);
                let root = root(radicand);
                s = ((self.g.0 + sign * root.0) / m, (self.g.1 + sign * root.1) / m);
                factor = self.factor(s);
            }
            self.section(s)
        })
    }

    fn section(&self, s: (T, T)) -> Section<T> {
        let (e0, e1, e2) = self.e;
        // l = L's, with L = ((1/e0, -e1 / (e0 e2)), (0, 1/e2)).
        let line = (s.0 / e0, (s.1 - e1 * s.0 / e0) / e2);
        Section { centre: (-(e0 * s.0 + e1 * s.1), -(e2 * s.1)), line }
    }

    /// s of a line about the ellipse's centre.
    pub fn in_frame(&self, (x, y): (T, T)) -> (T, T) {
        let (e0, e1, e2) = self.e;
        (e0 * x, e1 * x + e2 * y)
    }

    /// What the vanishing line `s` of the frame leaves of the equations.
    pub fn misfit(&self, s: (T, T)) -> Misfit<T> {
        let half = T::from(0.5);
        let factor = self.factor(s);
        let square = product(s, s);
        let oblique = product(self.g, s);
        let stretch = |deviator: T, oblique: T, square: T| {
            (deviator - oblique + half * self.m * square) / factor + half * square
        };
        let slope = |s: T, g: T| (self.m * s - g) / factor + s;
        Misfit {
            stretch: (
                stretch(self.deviator.0, oblique.0, square.0),
                stretch(self.deviator.1, oblique.1, square.1),
            ),
            slope: (slope(s.0, self.g.0), slope(s.1, self.g.1)),
        }
    }

    /// Unit normal, towards the camera, of the plane with the vanishing line `line` about the ellipse's centre: in camera
    /// axes, x right, y down, z forward.
    pub fn normal(&self, line: (T, T)) -> (T, T, T) {
        let z = (T::from(1.0) - line.0 * self.at.0 - line.1 * self.at.1) / self.focal_length;
        let length = (line.0 * line.0 + line.1 * line.1 + z * z).sqrt();
        (-line.0 / length, -line.1 / length, -z / length)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    type Vector = [f64; 3];

    fn dot(a: Vector, b: Vector) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    fn cross(a: Vector, b: Vector) -> Vector {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }

    /// A circle before the camera: where its centre appears from the principal point, its ellipse there (c, L), its normal.
    struct Seen {
        truth: (f64, f64),
        centre: (f64, f64),
        l: (f64, f64, f64),
        normal: Vector,
    }

    /// `at` px from the principal point, of semi-major axis `radius` px, the normal `tilt` degrees off the line of sight in
    /// direction `azimuth`.
    fn seen(focal_length: f64, at: (f64, f64), radius: f64, tilt: f64, azimuth: f64) -> Seen {
        let centre = [at.0 / focal_length, at.1 / focal_length, 1.0];
        let size = dot(centre, centre).sqrt();
        let sight = centre.map(|v| v / size);
        let side = cross(sight, [0.0, 1.0, 0.0]);
        let side = side.map(|v| v / dot(side, side).sqrt());
        let up = cross(sight, side);
        let (s, c) = tilt.to_radians().sin_cos();
        let (sa, ca) = azimuth.to_radians().sin_cos();
        let mix = |a: f64, u: Vector, b: f64, v: Vector| -> Vector {
            core::array::from_fn(|i| a * u[i] + b * v[i])
        };
        let away = mix(ca, side, sa, up);
        // The normal points away from the camera here.
        let normal = mix(c, sight, s, away);
        let e1 = mix(-sa, side, ca, up);
        let e2 = cross(normal, e1);
        let r = radius / focal_length;
        // x(t) = c + S e / (1 + p.e) in units of the circle.
        let column = |e: Vector| {
            [e[0] - at.0 / focal_length * e[2], e[1] - at.1 / focal_length * e[2]].map(|v| v * radius)
        };
        let (s1, s2) = (column(e1), column(e2));
        let p = [r * e1[2], r * e2[2]];
        let scale = 1.0 - p[0] * p[0] - p[1] * p[1];
        let w = [s1[0] * p[0] + s2[0] * p[1], s1[1] * p[0] + s2[1] * p[1]];
        let entry = |i: usize, j: usize| (s1[i] * s1[j] + s2[i] * s2[j] + w[i] * w[j] / scale) / scale;
        let (xx, xy, yy) = (entry(0, 0), entry(0, 1), entry(1, 1));
        let det = xx * yy - xy * xy;
        let l0 = (yy / det).sqrt();
        let l1 = -xy / det / l0;
        let l2 = (xx / det - l1 * l1).sqrt();
        let centre = (at.0 - w[0] / scale, at.1 - w[1] / scale);
        Seen { truth: at, centre, l: (l0, l1, l2), normal: normal.map(|v| -v) }
    }

    /// Scenes of circles with this semi-major axis, px, and tilt, degrees: focal length and what is seen.
    fn scenes(radius: f64, tilt: f64) -> Vec<(f64, Seen)> {
        let cameras = [
            (600.0, (0.0, 0.0)),
            (600.0, (-300.0, 220.0)),
            (2580.0, (500.0, -400.0)),
            (1000.0, (9.0, 500.0)),
        ];
        let turns = [20.0, 130.0, 250.0];
        cameras.iter().flat_map(|&(f, at)| turns.map(|turn| (f, seen(f, at, radius, tilt, turn)))).collect()
    }

    /// Distance of the nearer candidate from the true centre, px, and the angle of its normal from the true one, degrees.
    fn error<T: Real + Into<f64>>(seen: &Seen, focal_length: f64, real: impl Fn(f64) -> T) -> (f64, f64) {
        let pair = |(x, y): (f64, f64)| (real(x), real(y));
        let l = (real(seen.l.0), real(seen.l.1), real(seen.l.2));
        let sight = Sight::new(l, pair(seen.centre), real(focal_length));
        let off = |section: &Section<T>| {
            let x: f64 = section.centre.0.into();
            let y: f64 = section.centre.1.into();
            let (nx, ny, nz) = sight.normal(section.line);
            let angle = cross([nx.into(), ny.into(), nz.into()], seen.normal);
            let distance = (seen.centre.0 + x - seen.truth.0).hypot(seen.centre.1 + y - seen.truth.1);
            (distance, dot(angle, angle).sqrt().asin().to_degrees())
        };
        let [a, b] = sight.sections().map(|section| off(&section));
        if a.0 < b.0 { a } else { b }
    }

    #[test]
    fn one_of_the_sections_is_the_plane() {
        // From near the front the root of a rounding error shows in f32; noise is far above it there.
        for (tilt, limit) in
            [(2.0, 1e-4), (5.0, 3e-5), (10.0, 1e-5), (30.0, 1e-5), (60.0, 1e-5), (78.0, 1e-5)]
        {
            for radius in [8.0, 30.0, 100.0] {
                for (f, seen) in scenes(radius, tilt) {
                    let (double, angle) = error(&seen, f, |x| x);
                    let (single, _) = error(&seen, f, |x| x as f32);
                    let what =
                        std::format!("R {radius}, tilt {tilt}, f {f}: {double:e}, {angle:e}, f32 {single:e}");
                    assert!(double < 1e-12 && angle < 1e-11, "{what}");
                    assert!(single < limit, "{what}");
                    // Teeth: a focal length that is 0.1 % off shows.
                    assert!(error(&seen, 1.001 * f, |x| x).0 > 1e-12 + 1e-7 * radius, "{what}");
                }
            }
        }
    }

    /// From the front the two planes are one, which only the root of a rounding error tells apart.
    #[test]
    fn from_the_front_both_are_the_same() {
        for (f, seen) in scenes(30.0, 0.0) {
            let (double, angle) = error(&seen, f, |x| x);
            assert!(double < 1e-7 && angle < 1e-5, "{double:e} px, {angle:e} degrees");
            assert!(error(&seen, f, |x| x as f32).0 < 1e-3);
        }
    }

    #[test]
    fn misfit_is_zero_on_the_plane_and_its_slope_is_right() {
        for (f, seen) in scenes(30.0, 30.0) {
            let sight = Sight::new(seen.l, seen.centre, f);
            for section in sight.sections() {
                let s = sight.in_frame(section.line);
                let Misfit { stretch, slope } = sight.misfit(s);
                assert!(stretch.0.hypot(stretch.1) < 1e-12, "{stretch:?}");
                let h = (1e-6, -2e-6);
                let moved = sight.misfit((s.0 + h.0, s.1 + h.1)).stretch;
                let expected = product(slope, h);
                let off = (moved.0 - expected.0).hypot(moved.1 - expected.1);
                assert!(off < 0.02 * expected.0.hypot(expected.1), "{moved:?} for {expected:?}");
            }
        }
    }
}
