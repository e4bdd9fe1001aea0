//! The profile of a blurred edge: the normal distribution and its density.

/// Beyond this many standard deviations the edge is over: 2.3e-4 of the contrast is left.
const REACH: f32 = 3.5;

/// (share - 1/2) / z as a polynomial in z^2, lowest power first: least maximum error on 0..3.5.
const SHARE: [f32; 8] = [
    3.989198873e-01,
    -6.639556376e-02,
    9.855545969e-03,
    -1.120220118e-03,
    9.452947597e-05,
    -5.523200879e-06,
    1.958275636e-07,
    -3.123530649e-09,
];

/// The density as a polynomial in z^2, likewise.
const DENSITY: [f32; 8] = [
    3.989050775e-01,
    -1.990446054e-01,
    4.906119518e-02,
    -7.720292352e-03,
    8.189382862e-04,
    -5.651953392e-05,
    2.269036418e-06,
    -3.980953785e-08,
];

/// The density in the middle.
pub(super) const PEAK: f32 = DENSITY[0];

/// Share of the step that lies before `z` standard deviations, and its density there: within 5e-6 and 4e-5 up to 3.5
/// standard deviations, then constant. Polynomials, so that four samples are done at once where the processor can.
#[inline]
pub(crate) fn normal(z: f32) -> (f32, f32) {
    let z = z.clamp(-REACH, REACH);
    let square = z * z;
    (0.5 + z * polynomial(&SHARE, square), polynomial(&DENSITY, square))
}

/// Bits of shares and densities, and of standard deviations, of [`normal_fixed`].
const SHARE_BITS: u32 = 14;
const DEVIATION_BITS: u32 = 12;
/// Bits of a standard deviation from an entry of [`TABLE`] to the next, 1/32.
const STEP_BITS: u32 = 7;
/// Where the table ends on either side, standard deviations: a power of two beyond [`REACH`].
const TABLE_END: i32 = 4 << DEVIATION_BITS;
const ENTRIES: usize = ((2 * TABLE_END as usize) >> STEP_BITS) + 1;

/// Share and density every 1/32 standard deviation from -4 to 4, with room for the one after the last.
static TABLE: [(i16, i16); ENTRIES + 1] = table();

const fn table() -> [(i16, i16); ENTRIES + 1] {
    let one = (1 << SHARE_BITS) as f32;
    let mut table = [(0, 0); ENTRIES + 1];
    let mut i = 0;
    while i <= ENTRIES {
        let z = ((i << STEP_BITS) as i32 - TABLE_END) as f32 / (1 << DEVIATION_BITS) as f32;
        let bounded = if z > REACH {
            REACH
        } else if z < -REACH {
            -REACH
        } else {
            z
        };
        let square = bounded * bounded;
        let share = 0.5 + bounded * polynomial(&SHARE, square);
        let density = if square == z * z { polynomial(&DENSITY, square) } else { 0.0 };
        table[i] = ((share * one + 0.5) as i16, (density * one + 0.5) as i16);
        i += 1;
    }
    table
}

/// [`normal`] in integers: shares and densities in 1/16384, `z` in 1/4096, both within 1e-4. The density fades to 0 within 1/32
/// beyond 3.5 standard deviations.
#[inline]
pub(crate) fn normal_fixed(z: i32) -> (i32, i32) {
    let place = (z.clamp(-TABLE_END, TABLE_END - 1) + TABLE_END) as u32;
    let rest = (place & ((1 << STEP_BITS) - 1)) as i32;
    let entries = TABLE.get((place >> STEP_BITS) as usize..).and_then(|rest| rest.first_chunk());
    let Some(&[(share, density), (next, next_density)]) = entries else { return (0, 0) };
    let between = |a: i16, b: i16| {
        let (a, b) = (i32::from(a), i32::from(b));
        a + (((b - a) * rest + (1 << (STEP_BITS - 1))) >> STEP_BITS)
    };
    (between(share, next), between(density, next_density))
}

/// The same with the density of the nearest entry, which is within 1 % of the largest: as good a weight.
#[inline]
pub(crate) fn normal_near(z: i32) -> (i32, i32) {
    const MIDDLE: i32 = TABLE_END >> STEP_BITS;
    let near = (z + (1 << (STEP_BITS - 1))) >> STEP_BITS;
    let Some(&(share, density)) = TABLE.get((near.clamp(-MIDDLE, MIDDLE - 1) + MIDDLE) as usize) else {
        return (0, 0);
    };
    // Where the table has ended, so has the density.
    let (share, density) = (i32::from(share), i32::from(density));
    let more = density * (z - (near << STEP_BITS)) + (1 << (DEVIATION_BITS - 1));
    (share + (more >> DEVIATION_BITS), density)
}

/// Mean share of the step over a stretch of pixels, the first of which is at `z` standard deviations, below 0, and which lead away
/// from the edge by `k` each; `log` is the binary logarithm of their number.
#[inline(never)]
pub(super) fn mean_tail(z: i32, k: i32, log: u32) -> i32 {
    const OVER: i32 = (REACH * (1 << DEVIATION_BITS) as f32) as i32;
    if log == 0 {
        return normal_fixed(z).0;
    }
    // The integral of the tail from the border of the first pixel.
    let z = z + (k >> 1);
    if z <= -OVER {
        return 0;
    }
    let (share, density) = normal_fixed(z);
    (((density + ((z * share) >> 12)) << 12) / k.max(1)) >> log
}

/// A blurred edge along an axis that crosses it.
///
/// The edge is taken as a parabola. Blur moves the level of one half towards its hollow side, by half the curvature times
/// the variance (the diffusion equation in polar coordinates).
#[derive(Clone, Copy, Debug)]
pub(super) struct Blurred {
    /// Standard deviations of the blur beyond the edge as a power series of the distance on the axis: for 1 px, with half the unit
    /// of shares, and for its square.
    pub k: i32,
    pub second: i32,
    /// How far blur moves the level of one half, standard deviations.
    pub lead: i32,
}

impl Blurred {
    /// Standard deviations `h` px beyond the edge on the axis.
    #[inline]
    pub fn deviation(&self, h: i32) -> i32 {
        self.lead + ((h * (self.k + ((h * self.second) >> 15)) + (1 << 12)) >> 13)
    }

    /// The same of a straight edge, up to 60 px away.
    #[inline]
    pub fn straight(&self, h: i32) -> i32 {
        ((h >> 2) * self.k + (1 << 10)) >> 11
    }
}

#[inline]
const fn polynomial(coefficients: &[f32; 8], x: f32) -> f32 {
    let [a, b, c, d, e, f, g, h] = *coefficients;
    // In pairs, because a chain of eight steps would keep the processor waiting.
    let (x2, x4) = (x * x, (x * x) * (x * x));
    ((a + x * b) + x2 * (c + x * d)) + x4 * ((e + x * f) + x2 * (g + x * h))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_agree_with_the_polynomials() {
        for i in -20_000..=20_000 {
            let (share, density) = normal_fixed(i);
            let (want, want_density) = normal(i as f32 / 4096.0);
            let want_density = if i.abs() <= 14_336 { want_density } else { 0.0 };
            assert!((share as f32 / 16_384.0 - want).abs() < 9e-5, "{i}: {share} for {want}");
            let fades = (14_337..14_464).contains(&i.abs());
            assert!(
                fades || (density as f32 / 16_384.0 - want_density).abs() < 1e-4,
                "{i}: {density} for {want_density}"
            );
        }
    }

    #[test]
    fn agrees_with_the_error_function() {
        for i in -4500..=4500 {
            let z = f64::from(i) / 1000.0;
            let (share, density) = normal(z as f32);
            let want = 0.5 * libm::erfc(-z / core::f64::consts::SQRT_2);
            let want_density = libm::exp(-0.5 * z * z) * 0.398_942_280_401_432_7;
            let (near, near_density) = if z.abs() <= 3.5 { (6e-6, 5e-5) } else { (2.5e-4, 9e-4) };
            assert!((f64::from(share) - want).abs() < near, "{z}: {share} for {want}");
            assert!(
                (f64::from(density) - want_density).abs() < near_density,
                "{z}: {density} for {want_density}"
            );
        }
    }
}
