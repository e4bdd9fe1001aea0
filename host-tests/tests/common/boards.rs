//! Boards before a lens that distorts much, as points.

use concentric_host::{
    calibrate::Pose,
    layout::{CodeName, Layout, LayoutTarget},
    render::{self, Camera, Distortion, Frame},
};
use nalgebra::{Rotation3, Vector3};
use rand_distr::{Distribution, StandardNormal, Uniform, uniform::SampleUniform};
use rand_pcg::Pcg64;

/// A wide lens that distorts much.
pub const WIDE: [f64; 9] = [905.0, 900.0, 652.0, 471.0, -0.3, 0.11, 0.0012, -0.0008, -0.02];
/// Size of its frames, px.
pub const SIZE: [u32; 2] = [1280, 960];
pub struct Draw(Pcg64);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::new(u128::from(seed), 0xa02bdbf7bb3c0a7ac28fa16a64abf96))
    }

    pub fn between<T: SampleUniform>(&mut self, low: T, high: T) -> T {
        Uniform::new(low, high).unwrap().sample(&mut self.0)
    }

    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}

/// 9 x 7 points, 30 mm apart.
pub fn board() -> Vec<[f64; 3]> {
    let at = |i: usize| [(i % 9) as f64 * 30.0 - 120.0, (i / 9) as f64 * 30.0 - 90.0, 0.0];
    (0..63).map(at).collect()
}

/// The board tilted by 20 to 50 degrees in any direction.
pub fn tilted(draw: &mut Draw) -> Pose {
    let direction = draw.between(0.0, std::f64::consts::TAU);
    let tilt = draw.between(20f64, 50.0).to_radians();
    let axis = Vector3::new(direction.cos(), direction.sin(), 0.0) * tilt;
    let roll = Vector3::z() * draw.between(-3.0, 3.0);
    let rotation = Rotation3::from_scaled_axis(axis) * Rotation3::from_scaled_axis(roll);
    let tvec = Vector3::new(draw.between(-60.0, 60.0), draw.between(-40.0, 40.0), draw.between(300.0, 420.0));
    Pose::new(rotation.matrix(), tvec)
}

/// A board of 9 x 7 targets with radii of 6 and 3 mm, 30 mm apart, five of them with a code.
pub fn coded_board() -> Layout {
    let coded = [(10, 32), (16, 123), (32, 336), (46, 366), (52, 515)];
    let target = |(index, position): (usize, [f64; 3])| {
        let id = coded.iter().find(|(at, _)| *at == index).map(|(_, id)| *id);
        LayoutTarget { id, position, radii: vec![6.0, 3.0] }
    };
    let targets = board().into_iter().enumerate().map(target).collect();
    Layout { code: Some(CodeName::Five), targets, ..Layout::default() }
}

/// A camera of 960 x 720 px whose lens distorts.
pub fn small_camera() -> Camera {
    let mut camera = Camera::new(960, 720, 900.0);
    (camera.cx, camera.cy) = (486.0, 351.0);
    camera.distortion = Distortion { k1: -0.2, k2: 0.06, p1: 0.001, p2: -0.0005 };
    camera
}

/// Pictures of [`coded_board`], tilted in all directions, of noise 2.
pub fn rendered(count: usize) -> Vec<Frame> {
    let camera = small_camera();
    let view = |index: usize| {
        let at = index as f64;
        let pose = render::Pose {
            x: 480.0 + 90.0 * (at * 2.1).cos(),
            y: 360.0 + 60.0 * (at * 2.1).sin(),
            distance: 430.0 + 20.0 * (at * 1.3).sin(),
            tilt: 25.0 + 5.0 * (at % 4.0),
            azimuth: at * 360.0 / count as f64,
        };
        let mut scene = coded_board().scene(camera, pose).unwrap();
        scene.photometry.noise = 2.0;
        scene.render(index as u64)
    };
    (0..count).map(view).collect()
}
