//! The picture of the README: one enlarged target of the demonstration's picture.

use image::RgbImage;

use crate::{HOW_TO_BLESS, bless, file, program};

const PICTURE: &str = "host-tests/golden/demo.png";
/// Height of the title, and size of the first card at the right rim below it, px.
const TITLE: u32 = 30;
const CARD: [u32; 2] = [502, 292];
/// Most pixels, of a hundred, that differ by more than [`LEVELS`]: an error ellipse is drawn 200 times as large, so that
/// a hundredth of a sigma moves it.
const PERCENT: usize = 1;
const LEVELS: u8 = 48;

fn drawn() -> RgbImage {
    let folder = tempfile::tempdir().expect("a folder");
    program::run(folder.path(), &["demo", "--out", "demo.png"]);
    let whole = image::open(folder.path().join("demo.png")).expect("the demonstration's picture");
    let [width, height] = CARD;
    whole.crop_imm(whole.width() - width, TITLE, width, height).into_rgb8()
}

#[test]
fn picture_is_what_the_demonstration_draws() {
    let drawn = drawn();
    if bless() {
        drawn.save(file(PICTURE)).expect("the picture can be written");
        return;
    }
    let golden = image::open(file(PICTURE)).unwrap_or_else(|error| panic!("{PICTURE}: {error}")).into_rgb8();
    assert_eq!(golden.dimensions(), drawn.dimensions(), "{PICTURE}: {HOW_TO_BLESS}");
    let apart = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > LEVELS)
    };
    let count = golden.pixels().zip(drawn.pixels()).filter(apart).count();
    let most = golden.pixels().len() * PERCENT / 100;
    assert!(count <= most, "{PICTURE}: {count} pixels differ, at most {most} may; {HOW_TO_BLESS}");
}
