//! A standard deviation that outliers hardly move.

use crate::list::rolled;
use crate::math;

/// Squares are told apart to half an octave, so the deviation to a quarter, from 2^-20 ...
const LOWEST: u32 = (127 - 20) << 1;
/// ... to 2^16.
const BINS: usize = 2 * 36;
/// Bits of an f32 below the first of its mantissa.
const BELOW: u32 = 22;
/// Square of the standard deviation over the median of the squares, for a normal distribution.
const TO_VARIANCE: f32 = 2.198;

/// Residuals, for the median of their squares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    bins: [u16; BINS],
    count: u32,
}

impl Default for Spread {
    fn default() -> Self {
        Self { bins: [0; BINS], count: 0 }
    }
}

impl Spread {
    /// Adds the square of a residual.
    pub fn add(&mut self, square: f32) {
        self.count((square.to_bits() >> BELOW).saturating_sub(LOWEST));
    }

    /// The same of a residual below 2^16, of which one is 2^`bits`.
    pub fn add_fixed(&mut self, residual: i32, bits: u32) {
        let square = residual.unsigned_abs().saturating_pow(2);
        if square == 0 {
            return self.count(0);
        }
        let zeros = square.leading_zeros();
        // The bin of that as f32: its exponent, and the bit below its first one.
        let half = (square << zeros) >> (u32::BITS - 2) & 1;
        let bin = (2 * (u32::BITS - 1 - zeros + 127) + half).saturating_sub(LOWEST + 4 * bits);
        self.count(bin);
    }

    fn count(&mut self, bin: u32) {
        let bin = (bin as usize).min(BINS - 1);
        if let Some(bin) = self.bins.get_mut(bin) {
            *bin = bin.saturating_add(1);
        }
        self.count += 1;
    }

    /// Standard deviation from the upper end of the bin with the median: up to 20 % too large. The smallest is 1.7e-3, that of no
    /// residuals infinite.
    #[inline(never)]
    pub fn sigma(&self) -> f32 {
        if self.count == 0 {
            return f32::INFINITY;
        }
        let mut below = 0;
        let lower_half = |&&count: &&u16| {
            below += u32::from(count);
            2 * below < self.count
        };
        let bin = rolled(&self.bins).take_while(lower_half).count() as u32;
        math::sqrt(TO_VARIANCE * f32::from_bits((bin + 1 + LOWEST) << BELOW))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_fall_into_the_bins_of_their_squares() {
        for bits in [0, 6, 12, 14] {
            for residual in (-70_000i32..70_000).filter(|r| r.abs() < 300 || r % 97 == 0) {
                let mut both = [Spread::default(); 2];
                both[0].add_fixed(residual, bits);
                let residual = residual as f32 / (1u32 << bits) as f32;
                both[1].add(residual * residual);
                let [fixed, float] = both.map(|spread| spread.bins);
                assert!(fixed == float || residual.abs() >= 65_536.0 / (1u32 << bits) as f32, "{residual}");
            }
        }
    }

    #[test]
    fn a_third_of_outliers_does_not_move_it() {
        for sigma in [0.004f32, 0.02, 1.0, 30.0] {
            let mut spread = Spread::default();
            for i in 0..999 {
                // Quantiles of the normal distribution, roughly, by the logistic one.
                let share = (i as f32 + 0.5) / 999.0;
                let residual = 0.614 * sigma * libm::logf(share / (1.0 - share));
                spread.add(residual * residual);
            }
            let clean = spread.sigma();
            assert!((0.95..1.35).contains(&(clean / sigma)), "{clean} for {sigma}");
            (0..500).for_each(|_| spread.add(2500.0 * sigma * sigma));
            assert!((1.0..2.1).contains(&(spread.sigma() / clean)), "{}", spread.sigma());
        }
        assert_eq!(Spread::default().sigma(), f32::INFINITY);
    }
}
