extern crate std;

use super::{are_near, can_be_concentric, has_centre_of, moments_shape, set_arc, shape};
use crate::arcs::Arc;
use crate::fit::Shape;
use crate::scan::{Outline, Seen};

const FRAME: (u16, u16) = (1000, 900);

struct Random(u32);

impl Random {
    fn within(&mut self, least: f32, most: f32) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        least + (most - least) * (self.0 >> 8) as f32 / (1u32 << 24) as f32
    }

    /// An outline about a place in the frame, with a box and moments as an ellipse gives them.
    fn outline(&mut self, place: (f32, f32)) -> Outline {
        let b = libm::powf(100.0, self.within(0.05, 1.0));
        let (p, q) = (0.25 * b * b, 0.25 * libm::powf(b * self.within(1.0, 6.0), 2.0));
        let (s, c) = libm::sincosf(self.within(0.0, 3.1));
        let (xx, yy) = (p * c * c + q * s * s, p * s * s + q * c * c);
        let about = (place.0 as u16, place.1 as u16);
        let shape = Shape::from_moments(0.3, -0.2, xx, (p - q) * s * c, yy).unwrap();
        let mut outline = Outline::ZERO;
        set_arc(&mut outline, &Arc { shape, dark_inside: self.within(0.0, 1.0) < 0.5 }, about, FRAME);
        if self.within(0.0, 1.0) >= 0.5 {
            outline.seen = Seen::Whole;
        }
        outline
    }
}

/// What whole numbers refuse, the centres refuse.
#[test]
fn a_refusal_by_whole_numbers_is_one_by_the_centres() {
    let mut random = Random(1);
    let (mut refused, mut admitted) = (0, 0);
    for _ in 0..50_000 {
        let place = (random.within(0.0, 1000.0), random.within(0.0, 900.0));
        let outline = random.outline(place);
        let reach = 3.0 * f32::from(outline.width().max(outline.height()));
        let beside = |p: f32, most: f32, off: f32| (p + off).clamp(0.0, most);
        // Most of them near.
        let mut off = || reach * libm::powf(random.within(-1.0, 1.0), 5.0);
        let (dx, dy) = (off(), off());
        let inner = random.outline((beside(place.0, 1000.0, dx), beside(place.1, 900.0, dy)));
        let Ok(shape) = moments_shape(&outline) else { continue };
        let centres = has_centre_of(&outline, &shape, &inner, FRAME.0);
        let inside = outline.surrounds(&inner) && inner.bottom <= outline.bottom;
        if outline.is_partial() || inner.is_partial() || inside {
            assert!(!centres || can_be_concentric(&outline, &inner), "{outline:?} {inner:?}");
        }
        refused += u32::from(!are_near(&outline, &inner));
        admitted += u32::from(centres);
    }
    assert!(refused > 2000 && admitted > 2000, "no test: {refused} {admitted}");
}

/// Which outlines are ellipses: by their area and the number of crossings.
#[test]
fn an_outline_without_crossings_or_of_another_area_is_refused() {
    use crate::reject::Reject;
    let mut whole = Random(2).outline((500.0, 450.0));
    (whole.seen, whole.cut) = (Seen::Whole, false);
    assert_eq!(shape(&whole).err(), Some(Reject::LowContrast));
    let mut dented = whole;
    dented.moments.area = dented.moments.area * 3 / 4;
    assert_eq!(shape(&dented).err(), Some(Reject::NotElliptic));
}

/// The narrowest outline is wider than what refuses without its axes.
#[test]
fn a_row_of_pixels_has_the_least_semi_axis() {
    let mut row = Outline::ZERO;
    let n = 9i64;
    (row.left, row.right, row.top, row.bottom) = (0, 9, 0, 0);
    let m = &mut row.moments;
    (m.area, m.x, m.y, m.xx, m.xy, m.yy) = (n, n * (n - 1) / 2, 0, (n - 1) * n * (2 * n - 1) / 6, 0, 0);
    let (_, b) = moments_shape(&row).unwrap().semi_axes();
    assert!(b > super::LEAST_SEMI_AXIS && b < 0.6, "{b}");
}

/// What is alone is told before anyone looks closer, but a circle around which another one closes soon is not alone, and
/// neither is that one.
#[test]
fn only_what_stays_alone_is_refused_as_such() {
    use crate::reject::Reject;
    use crate::{Detector, Image, Settings, Storage, TargetSpec};
    const SIZE: usize = 96;
    let mut storage = std::boxed::Box::new(Storage::<SIZE, 8, 400>::new());
    let mut detector = Detector::new(Settings::new(TargetSpec::any()), &mut storage);
    for shift in 0..8u8 {
        let at = |x: usize, y: usize, (cx, cy): (f32, f32), radius: f32| {
            (radius + 0.5 - (x as f32 - cx).hypot(y as f32 - cy)).clamp(0.0, 1.0)
        };
        let pixels: std::vec::Vec<u8> = (0..SIZE * SIZE)
            .map(|i| {
                let (x, y) = (i % SIZE, i / SIZE);
                let ring = (30.3, 30.2 + f32::from(shift));
                let square = (60..66).contains(&x) && (20..26).contains(&y);
                let ink = at(x, y, ring, 8.0) - at(x, y, ring, 5.0);
                let ink = ink + at(x, y, (70.0, 60.4), 9.0) + if square { 1.0 } else { 0.0 };
                (220.0 - 180.0 * ink) as u8
            })
            .collect();
        let image = Image::new(&pixels, SIZE as u16, SIZE as u16).unwrap();
        let mut found = detector.detect(&image).unwrap();
        assert_eq!(found.by_ref().count(), 1, "{shift}");
        assert_eq!(found.summary().rejected.count(Reject::Alone), 2, "{shift}");
    }
}
