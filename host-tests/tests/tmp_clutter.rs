mod common;
use common::{detect, errors};
use concentric::TargetSpec;
use concentric_host::render::Scene;
#[test]
fn clutter() {
    let mut n = 0;
    for (w, h) in [(640, 480), (1280, 1024)] {
        for seed in 0..8 {
            for spec in [TargetSpec::any(), TargetSpec::ring(0.5).unwrap()] {
                let scene = Scene::many(60, w, h, true, seed).unwrap();
                let frame = scene.render(seed);
                let (targets, summary) = detect(&frame, spec);
                let (found, f) = errors(&targets, &frame.truth);
                if f > 0 || found.len() < 60 {
                    n += 1;
                    for t in &targets {
                        let (x, y) = t.centre.to_px();
                        if !found.iter().any(|(_, _, t2)| std::ptr::eq(*t2, t)) {
                            let near: Vec<_> = scene
                                .decoys
                                .iter()
                                .filter(|d| (d.x - f64::from(x)).hypot(d.y - f64::from(y)) < d.size)
                                .map(|d| (d.kind, d.size, d.x, d.y))
                                .collect();
                            println!(
                                "{w} seed {seed} any {} FALSE {x} {y} {:?} {near:?} {:?}",
                                spec.ratios().is_empty(),
                                t.flags.names().collect::<Vec<_>>(),
                                t.circles
                                    .iter()
                                    .map(|c| (c.ellipse.a, c.ellipse.b, c.gap, c.points))
                                    .collect::<Vec<_>>()
                            );
                        }
                    }
                    println!("   found {} {:?}", found.len(), summary.rejected.iter().collect::<Vec<_>>());
                }
            }
        }
    }
    println!("{n} frames wrong");
}
