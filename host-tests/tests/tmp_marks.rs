mod common;
use common::detect;
use concentric::TargetSpec;
use concentric_host::render::{Mark, Scene};
#[test]
fn marks() {
    for mark in [Mark::Digits("58".into())] {
        for spec in [TargetSpec::any(), TargetSpec::ring(0.5).unwrap()] {
            for radius in [10.0, 20.0, 40.0] {
                for tilt in [0.0, 20.0, 40.0, 60.0] {
                    for trial in 0..3u32 {
                        let turn =
                            |step: f64| (f64::from(trial) * step + radius * 0.37 + tilt * 0.11).fract();
                        let phase = [turn(0.618_034) - 0.5, turn(0.754_878) - 0.5];
                        let mut scene = Scene::single(radius, tilt, 360.0 * turn(0.381_966), phase);
                        scene.targets[0].artwork.mark = Some(mark.clone());
                        let frame = scene.render(u64::from(trial) + (radius * 1000.0 + tilt) as u64);
                        let (t, s) = detect(&frame, spec);
                        if t.len() != 1 {
                            println!(
                                "{radius} {tilt} {trial} {:?} {:?}",
                                spec.ratios(),
                                s.rejected.iter().filter(|x| x.1 > 0).collect::<Vec<_>>()
                            );
                            std::fs::write(
                                "/tmp/m.pgm",
                                [b"P5\n1280 1024\n255\n".to_vec(), frame.pixels.clone()].concat(),
                            )
                            .unwrap();
                        }
                    }
                }
            }
        }
    }
}
