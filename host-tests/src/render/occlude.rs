//! The option `--occlude`.

use super::occluder::{Cover, Occluder};
use super::scene::Scene;

/// What one option lays over the targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Occlude {
    /// A wedge of this share, direction and tone over every target.
    Wedges(f64, f64, f64),
    /// One occluder.
    One(Occluder),
}

impl Occlude {
    /// Forms of the option.
    pub const FORMS: &'static str = "wedge:SHARE,DEG,TONE; strip:X,Y,WIDTH,DEG,TONE; scratch:X,Y,WIDTH,LENGTH,DEG,TONE; \
                                     disc:X,Y,RADIUS,TONE; glare:X,Y,RADIUS,STRENGTH";

    /// Lays it over the scene.
    pub fn apply(self, scene: &mut Scene) {
        match self {
            Self::Wedges(share, direction, tone) => {
                (0..scene.targets.len()).for_each(|target| scene.hide(target, share, direction, tone));
            }
            Self::One(mut occluder) => {
                if let Cover::Strip { length, .. } = &mut occluder.cover
                    && length.is_infinite()
                {
                    // From border to border, wherever its middle is.
                    let size = f64::from(scene.camera.width).hypot(f64::from(scene.camera.height));
                    *length = 4.0 * size;
                }
                scene.occluders.push(occluder);
            }
        }
    }
}

/// Parser of the option; the values are checked with the scene.
pub fn parse(text: &str) -> Result<Occlude, String> {
    let wrong = || format!("must be one of {}", Occlude::FORMS);
    let (kind, values) = text.split_once(':').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let values: Vec<f64> = values.split(',').map(number).collect::<Option<_>>().ok_or_else(wrong)?;
    let one = |cover, tone| Ok(Occlude::One(Occluder { cover, tone }));
    match (kind, &values[..]) {
        ("wedge", &[share, direction, tone]) => Ok(Occlude::Wedges(share, direction, tone)),
        ("strip", &[x, y, width, direction, tone]) => {
            one(Cover::Strip { x, y, width, length: f64::INFINITY, direction }, tone)
        }
        ("scratch", &[x, y, width, length, direction, tone]) => {
            one(Cover::Strip { x, y, width, length, direction }, tone)
        }
        ("disc", &[x, y, radius, tone]) => one(Cover::Disc { x, y, radius }, tone),
        ("glare", &[x, y, radius, strength]) => one(Cover::Glare { x, y, radius, strength }, 1.0),
        _ => Err(wrong()),
    }
}
