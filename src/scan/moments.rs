//! Moments of what an outline encloses, from its transitions.

use crate::fit::Shape;
use crate::math;

/// Moments of the pixels enclosed by an outline. Exact: a region as large as the largest frame has a second moment below 2^57.
/// Negative for the outline of a light region.
///
/// While the outline is open, sums over its transitions instead, x and y from the first of them on, added where dark turns
/// light and subtracted where light turns dark: of x, x^2, x^3, x y, x^2 y and x y^2. As there are as many of either in each
/// row, Green's theorem makes the moments of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    pub area: i64,
    pub x: i64,
    pub y: i64,
    pub xx: i64,
    pub xy: i64,
    pub yy: i64,
}

/// Extent below which 32 bits hold the sums of an outline: none is larger than twice its fourth power.
pub(super) const SHORT: u16 = 1 << 7;
/// Largest coordinate of which 32 bits hold the cube.
const SMALL: u32 = 1 << 10;

impl Moments {
    pub(super) const ZERO: Self = Self { area: 0, x: 0, y: 0, xx: 0, xy: 0, yy: 0 };

    /// Adds a transition to the lower halves of the sums of an outline whose extent is below [`SHORT`]. On small processors long
    /// sums are dear.
    #[inline(always)]
    pub(super) fn add_short(&mut self, sign: i32, x: i32, y: i32) {
        let add = |sum: &mut i64, term: i32| {
            let low = (*sum as u32).wrapping_add(term as u32);
            *sum = *sum & !i64::from(u32::MAX) | i64::from(low);
        };
        let signed = sign * x;
        let (xx, xy) = (signed * x, signed * y);
        add(&mut self.area, signed);
        add(&mut self.x, xx);
        add(&mut self.y, xy);
        add(&mut self.xx, xx * x);
        add(&mut self.xy, xx * y);
        add(&mut self.yy, xy * y);
    }

    /// Makes whole sums of their lower halves.
    #[inline(never)]
    pub(super) fn lengthen(&mut self) {
        let Self { area, x, y, xx, xy, yy } = self;
        for sum in [area, x, y, xx, xy, yy] {
            *sum = i64::from(*sum as i32);
        }
    }

    /// Adds a transition to the sums.
    #[inline(never)]
    pub(super) fn add_long(&mut self, sign: i32, x: i32, y: i32) {
        // Long products are dearer still. Squares are short in any case.
        let small = x.unsigned_abs() < SMALL && y.unsigned_abs() < SMALL;
        let product =
            |a: i32, b: i32| if small { i64::from(a.wrapping_mul(b)) } else { i64::from(a) * i64::from(b) };
        let signed = sign * x;
        let (xx, xy) = (signed * x, signed * y);
        self.area += i64::from(signed);
        self.x += i64::from(xx);
        self.y += i64::from(xy);
        self.xx += product(xx, x);
        self.xy += product(xx, y);
        self.yy += product(xy, y);
    }

    /// Adds sums about a place that lies `(x, y)` px farther; they have as many signs of either kind in each row.
    pub(super) fn join(&mut self, other: &Self, (x, y): (i64, i64)) {
        let Self { area, .. } = *other;
        // About its column.
        let (xx, row) = (other.x + 2 * x * area, other.y);
        self.area += area;
        self.x += xx;
        self.xx += other.xx + 3 * x * (other.x + x * area);
        self.y += row + y * area;
        self.xy += other.xy + 2 * x * row + y * xx;
        self.yy += other.yy + y * (2 * row + y * area);
    }

    /// Makes moments of the sums about `(x, y)`: left of a transition there are x pixels, whose columns add up to
    /// x (x - 1) / 2 and their squares to x (x - 1) (2 x - 1) / 6.
    pub(super) fn close(&mut self, place: (i64, i64)) {
        let mut sums = Self::ZERO;
        sums.join(self, place);
        *self = Self {
            area: sums.area,
            x: (sums.x - sums.area) / 2,
            y: sums.y,
            xx: sixth(2 * sums.xx - 3 * sums.x + sums.area),
            xy: (sums.xy - sums.y) / 2,
            yy: sums.yy,
        };
    }

    /// Those of a filled ellipse about the pixel `(x, y)`.
    pub fn of_ellipse(shape: &Shape, (x, y): (u16, u16), dark_inside: bool) -> Self {
        let (cx, cy) = (shape.cx, shape.cy);
        let det = shape.det();
        let sign = if dark_inside { 1.0 } else { -1.0 };
        let area = sign * core::f32::consts::PI / math::sqrt(det);
        let sum = |mean: f32| (area * mean) as i64;
        // Second moments of the area: a quarter of the inverse matrix, less what the square pixels have of their own.
        let own = 1.0 / 12.0;
        let (mxx, myy) = (0.25 * shape.ayy / det - own, 0.25 * shape.axx / det - own);
        let about = Self {
            area: sum(1.0),
            x: sum(cx),
            y: sum(cy),
            xx: sum(mxx + cx * cx),
            xy: sum(cx * cy - 0.25 * shape.axy / det),
            yy: sum(myy + cy * cy),
        };
        about.shifted(i64::from(x), i64::from(y))
    }

    /// The same with everything `(x, y)` px farther.
    fn shifted(&self, x: i64, y: i64) -> Self {
        Self {
            area: self.area,
            x: self.x + x * self.area,
            y: self.y + y * self.area,
            xx: self.xx + 2 * x * self.x + x * x * self.area,
            xy: self.xy + x * self.y + y * self.x + x * y * self.area,
            yy: self.yy + 2 * y * self.y + y * y * self.area,
        }
    }
}

/// The sixth part of a multiple of six: a division of 64 bits is a kilobyte of code.
fn sixth(sum: i64) -> i64 {
    // The reciprocal of 3 modulo 2^64.
    (sum >> 1).wrapping_mul(-0x5555_5555_5555_5555)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sixth_is_a_division_without_a_rest() {
        for sixth_part in (-3000..3000).chain([i64::MAX / 6, i64::MIN / 6, 1 << 40, -(1 << 50)]) {
            assert_eq!(sixth(6 * sixth_part), sixth_part);
        }
    }
}
