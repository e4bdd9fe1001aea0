//! Real photographs, from the folder that the environment variable `CONCENTRIC_PHOTOS` names.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use concentric::{Effort, Settings, Target, TargetSpec};
use concentric_host::{
    detect,
    measure::{distance, px},
    picture::Picture,
};

/// Centres of the complete targets by another detector, with a bias of about 0.2 px of its own.
const CCTAG: [[f64; 2]; 4] = [[884.75, 812.08], [932.20, 963.85], [485.73, 480.76], [1148.71, 885.52]];
/// A target that the frame cuts.
const CUT: [f64; 2] = [16.0, 417.0];

/// The folder of the photographs; a relative one starts at the workspace. Where it is not set, says so past the capture
/// of test output.
fn folder() -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("CONCENTRIC_PHOTOS") else {
        let _ = writeln!(std::io::stderr(), "photographs skipped: set CONCENTRIC_PHOTOS to their folder");
        return None;
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    assert!(folder.is_dir(), "CONCENTRIC_PHOTOS: {} is no folder", folder.display());
    Some(folder)
}

fn targets(path: &Path, spec: TargetSpec) -> Vec<Target> {
    let picture = Picture::read(path).unwrap_or_else(|error| panic!("{}: {error:#}", path.display()));
    detect::run(&picture, Settings::new(spec)).unwrap().targets
}

#[test]
fn thin_rings_in_uneven_light_are_found() {
    let Some(folder) = folder() else { return };
    let centres: Vec<_> = targets(&folder.join("cctag-01.png"), TargetSpec::any())
        .iter()
        .map(|target| px(target.centre))
        .collect();
    for expected in CCTAG {
        assert!(
            centres.iter().any(|centre| distance(*centre, expected) <= 0.5),
            "no centre within 0.5 px of {expected:?}: {centres:?}"
        );
    }
    let beside: Vec<_> = centres.iter().filter(|centre| distance(**centre, CUT) > 5.0).collect();
    assert_eq!(beside.len(), CCTAG.len(), "false targets: {centres:?}");
}

/// The code around a target and an uneven print are seen with less effort, too: such targets are measured in full.
#[test]
fn less_effort_finds_the_same() {
    let Some(folder) = folder() else { return };
    for (name, least) in [("cctag-01.png", 4), ("ringgrid-board.png", 60)] {
        let picture = Picture::read(&folder.join(name)).unwrap();
        let [full, quick] = [Effort::Full, Effort::Quick].map(|effort| {
            detect::run(&picture, Settings::new(TargetSpec::any()).effort(effort)).unwrap().targets
        });
        assert!(full.len() >= least && quick.len() == full.len(), "{name}: {} {}", full.len(), quick.len());
        for (full, quick) in full.iter().zip(&quick) {
            let off = distance(px(full.centre), px(quick.centre));
            let sigma = f64::from(full.covariance.xx + full.covariance.yy).sqrt();
            assert!(off < 1.5 * sigma, "{name}: {off} px from {:?}, sigma {sigma}", px(full.centre));
        }
    }
}

#[test]
fn nothing_is_found_where_there_is_nothing() {
    let Some(folder) = folder() else { return };
    for name in ["apriltags", "cat", "eye", "graffiti", "qrcode"] {
        for spec in [TargetSpec::any(), TargetSpec::ring(0.5).unwrap()] {
            let path = folder.join(format!("openmv-{name}.pgm"));
            let found = targets(&path, spec);
            assert!(found.is_empty(), "{name}, {spec:?}: {found:?}");
        }
    }
}
