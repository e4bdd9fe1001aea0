use super::Real;

/// What the correction of an ellipse centre is worth against its own noise.
///
/// The mean of the ellipse centres by their inverse variances has the least noise and keeps most of the eccentricity; the
/// correction from there to the true centre takes the eccentricity away and, with a ratio of 0.5, 2.3 times the noise on.
/// The mean and the correction are independent, so this is the classic problem of a normal mean with known covariance near
/// a point that is likely. [`share`](Self::share) is the positive part rule of James and Stein 1961, "Estimation with
/// quadratic loss", Proc. 4th Berkeley Symp. 1, and Baranchik 1964: 1 - c / z^2, where z is the correction in units of its
/// standard deviation. In two dimensions no rule is better than the whole correction everywhere (Efron and Morris 1971,
/// "Limiting the risk of Bayes and empirical Bayes estimators", J. Am. Stat. Assoc. 66); c is chosen so that the worst
/// excess over the better of the outer ellipse's centre and the whole correction is least.
///
/// For two circles with a ratio of 0.4 to 0.5 that excess is 10 % of the RMS error, at no eccentricity at all and at 5 times
/// the standard deviation of the outer ellipse's centre. Pretests (Judge and Bock 1978, "The statistical implications of
/// pre-test and Stein-rule estimators in econometrics") come to 25 %, firm thresholds to 13 %, z^2 / (z^2 + c) to 11 %, each
/// with its best constants; no rule at all comes below 7 % at 0.5 (least favourable prior, in the tests). Other ratios have more to
/// lose: 12 % at 0.3 and 0.6, 16 % at 0.7; no rule comes below 9 % at 0.3 and 12 % at 0.7.
///
/// No covariance that follows from the correction alone is right at every eccentricity. The one here is right to 10 % (with a
/// ratio of 0.5) from an eccentricity of 2 standard deviations on; below it is too large, in the end 1.6 times.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Significance<T> {
    /// Share of the correction that is made, 0 to 1.
    pub share: T,
    /// Covariances of the correction to be added to the covariance of the weights that make that share, because the share
    /// depends on the noise too and leaves a part of the eccentricity.
    pub unsure: T,
}

impl<T: Real> Significance<T> {
    /// Of the `correction` (x, y) with its covariance (xx, xy, yy) from the mean of the ellipse centres, whose variance
    /// is `mean`; `outer` is that of the outer ellipse's centre. Variances of both coordinates together. Without noise the
    /// share is 1.
    pub fn new(correction: (T, T), covariance: (T, T, T), mean: T, outer: T) -> Self {
        let (one, zero) = (T::from(1.0), T::from(0.0));
        let ((x, y), (xx, xy, yy)) = (correction, covariance);
        let det = xx * yy - xy * xy;
        // Also refuses NaN.
        if !(det > zero) {
            return Self { share: one, unsure: zero };
        }
        let square = (x * x * yy - T::from(2.0) * x * y * xy + y * y * xx) / det;
        let least = T::from(0.2) * outer;
        let room = T::from(1.2) * outer - mean;
        let room = if room > least { room } else { least };
        let limit = Self::limit((xx + yy) / room);
        let share = if square > limit { one - limit / square } else { zero };
        let left = one - share;
        // The variance is `share` and the bias left, estimated from the correction itself (Morris 1983, "Parametric
        // empirical Bayes inference", J. Am. Stat. Assoc. 78, with the factor that fits a normal mean in two dimensions),
        // less what the weights already have.
        let bias = T::from(0.75) * left * left * square;
        Self { share, unsure: share * left + bias }
    }

    /// c for a variance of the correction of `price` in units of the variance that the outer ellipse's centre leaves for it:
    /// within 0.1 of the one with the least worst excess for ratios of 0.2 to 0.9.
    fn limit(price: T) -> T {
        let root = price.sqrt();
        T::from(10.0) * root / (root + T::from(8.0))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::centre::{mean, weights};
    use std::vec::Vec;

    /// Variances of the mean and of the correction of two circles, the outer one having 1, and the share of the eccentricity
    /// that the correction takes away.
    fn two_circles(ratio: f64) -> (f64, f64, f64) {
        let variances = [1.0, 1.0 / ratio];
        let plain = mean(variances.into_iter()).unwrap();
        let exact = weights(&[(1.0, 1.0), (ratio, variances[1])], 0.0).unwrap();
        let variance =
            |weight: &dyn Fn(usize) -> f64| (0..2).map(|k| weight(k) * weight(k) * variances[k]).sum::<f64>();
        let correction = variance(&|k| exact[k] - plain[k]);
        (variance(&|k| plain[k]), correction, plain[0] + plain[1] * ratio * ratio)
    }

    /// Largest RMS error of a rule, share as a function of z^2, over that of the better of the outer ellipse's centre and
    /// the whole correction; by summation over a grid.
    fn worst_excess(ratio: f64, rule: impl Fn(f64) -> f64) -> f64 {
        let (least, correction, part) = two_circles(ratio);
        let grid: Vec<f64> = (-60..=60).map(|i| f64::from(i) * 0.1).collect();
        let density = |x: f64| libm::exp(-0.5 * x * x) * 0.1 * 0.398_942_280_401_432_7;
        let excess = |ecc: f64| {
            let shift = part * ecc / libm::sqrt(0.5 * correction);
            let mut square = 0.0;
            for &x in &grid {
                for &y in &grid {
                    let (zx, zy) = (x + shift, y);
                    let share = rule(zx * zx + zy * zy);
                    let (ex, ey) = (share * zx - shift, share * zy);
                    square += density(x) * density(y) * (ex * ex + ey * ey);
                }
            }
            (least + 0.5 * correction * square) / (1.0 + ecc * ecc).min(least + correction)
        };
        libm::sqrt((0..=40).map(|i| excess(0.25 * f64::from(i))).fold(0.0, f64::max))
    }

    /// The library's rule.
    fn share(ratio: f64) -> impl Fn(f64) -> f64 {
        let (least, correction, _) = two_circles(ratio);
        let half = 0.5 * correction;
        move |square| Significance::new((libm::sqrt(square * half), 0.0), (half, 0.0, half), least, 1.0).share
    }

    #[test]
    fn its_worst_excess_is_the_least_of_the_rules() {
        for (ratio, bound) in [(0.3, 1.13), (0.4, 1.105), (0.5, 1.105), (0.6, 1.12), (0.7, 1.17)] {
            let worst = worst_excess(ratio, share(ratio));
            std::println!("ratio {ratio}: {worst:.3}");
            assert!(worst < bound && worst > bound - 0.03, "{ratio}: {worst}");
        }
        let firm = |square: f64| (1.333 * (1.0 - 1.4 / libm::sqrt(square))).clamp(0.0, 1.0);
        for (name, worst, figure) in [
            ("pretest", worst_excess(0.5, |square| f64::from(u8::from(square > 5.0))), 1.25),
            ("firm", worst_excess(0.5, firm), 1.13),
            ("z^2 / (z^2 + c)", worst_excess(0.5, |square| square / (square + 4.9)), 1.11),
        ] {
            std::println!("{name}: {worst:.3}");
            assert!((worst - figure).abs() < 0.01, "{name}: {worst}");
        }
    }

    /// The modified Bessel functions of orders 0 and 1 times exp(-x), by their integrals.
    fn bessel(x: f64) -> (f64, f64) {
        let (mut zero, mut one) = (0.0, 0.0);
        for k in 0..64 {
            let cos = libm::cos((f64::from(k) + 0.5) * core::f64::consts::PI / 64.0);
            let term = libm::exp(x * (cos - 1.0)) / 64.0;
            zero += term;
            one += term * cos;
        }
        (zero, one)
    }

    /// Bounds of the least worst excess that any rule can have for eccentricities of 0 to 10 standard deviations: the risk of the
    /// best rule against a prior bounds it from below (Wald 1950, "Statistical Decision Functions"), the worst excess of that
    /// rule from above. The prior is found by a game: each eccentricity gains weight by its excess.
    fn least_worst_excess(ratio: f64) -> (f64, f64) {
        const STEP: f64 = 0.1;
        let (least, correction, part) = two_circles(ratio);
        let eccs: Vec<f64> = (0..=40).map(|i| 0.25 * f64::from(i)).collect();
        let shifts: Vec<f64> = eccs.iter().map(|ecc| part * ecc / libm::sqrt(0.5 * correction)).collect();
        let scales: Vec<f64> =
            eccs.iter().map(|ecc| 1.0 / (1.0 + ecc * ecc).min(least + correction)).collect();
        let lengths: Vec<f64> = (0..200).map(|j| STEP * (f64::from(j) + 0.5)).collect();
        // Density of the length of z, and that times the mean cosine of its direction from the shift.
        let densities: Vec<Vec<(f64, f64)>> = (shifts.iter())
            .map(|shift| {
                let density = |r: &f64| {
                    let (zero, one) = bessel(r * shift);
                    let scale = STEP * r * libm::exp(-0.5 * (r - shift) * (r - shift));
                    (scale * zero, scale * one)
                };
                lengths.iter().map(density).collect()
            })
            .collect();
        let mut prior = std::vec![1.0 / 41.0; 41];
        let (mut lower, mut upper) = (0.0f64, f64::INFINITY);
        for step in 0..1500 {
            let mut sums = std::vec![(0.0, 0.0); lengths.len()];
            for (i, densities) in densities.iter().enumerate() {
                let weight = prior[i] * scales[i];
                for (sum, (density, towards)) in sums.iter_mut().zip(densities) {
                    sum.0 += weight * density;
                    sum.1 += weight * shifts[i] * towards;
                }
            }
            // The best rule makes the correction this long.
            let best: Vec<f64> = sums.iter().map(|(density, sum)| sum / density.max(1e-300)).collect();
            let excess = |i: usize| {
                let shift = shifts[i];
                let square = |(best, (density, towards)): (&f64, &(f64, f64))| {
                    (best * best + shift * shift) * density - 2.0 * best * shift * towards
                };
                (least + 0.5 * correction * best.iter().zip(&densities[i]).map(square).sum::<f64>())
                    * scales[i]
            };
            let excesses: Vec<f64> = (0..41).map(excess).collect();
            let mean = prior.iter().zip(&excesses).map(|(weight, excess)| weight * excess).sum::<f64>();
            lower = lower.max(mean);
            upper = upper.min(excesses.iter().copied().fold(0.0, f64::max));
            let rate = 1.0 / (1.0 + f64::from(step) / 200.0);
            prior.iter_mut().zip(&excesses).for_each(|(weight, e)| *weight *= libm::exp(rate * (e - mean)));
            let total: f64 = prior.iter().sum();
            prior.iter_mut().for_each(|weight| *weight /= total);
        }
        (libm::sqrt(lower), libm::sqrt(upper))
    }

    #[test]
    fn no_rule_at_all_is_much_better() {
        for (ratio, least) in [(0.3, 1.097), (0.5, 1.073), (0.7, 1.122)] {
            let ((lower, upper), own) = (least_worst_excess(ratio), worst_excess(ratio, share(ratio)));
            std::println!("ratio {ratio}: least {lower:.4} .. {upper:.4}, this rule {own:.3}");
            assert!(lower <= upper && upper - lower < 0.004, "{ratio}: {lower} {upper}");
            assert!((lower - least).abs() < 0.003, "{ratio}: {lower}");
            assert!(own >= lower && own < lower + 0.045, "{ratio}: {own} {lower}");
        }
    }

    #[test]
    fn it_is_continuous_in_the_correction_and_ends_at_all_of_it() {
        let rule = share(0.5);
        let mut last = rule(0.0);
        assert_eq!(last, 0.0);
        for i in 1..4000 {
            let next = rule(0.01 * f64::from(i));
            assert!((0.0..0.005).contains(&(next - last)), "{i}: {last} {next}");
            last = next;
        }
        assert!(rule(1e6) > 0.999_99);
        let quiet = Significance::new((0.1f32, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0);
        assert_eq!(quiet, Significance { share: 1.0, unsure: 0.0 });
        assert_eq!(Significance::new((f32::NAN, 0.0), (1.0, 0.0, 1.0), 1.0, 1.0).share, 0.0);
    }

    #[test]
    fn single_precision_is_enough() {
        for (x, y) in [(0.001, 0.002), (0.01, -0.003), (0.02, 0.02), (1.0, 0.3)] {
            let wide = Significance::<f64>::new((x, y), (4e-5, 1e-5, 2e-5), 2e-5, 3e-5);
            let single = Significance::<f32>::new((x as f32, y as f32), (4e-5, 1e-5, 2e-5), 2e-5, 3e-5);
            assert!((f64::from(single.share) - wide.share).abs() < 1e-5, "{single:?} {wide:?}");
            assert!((f64::from(single.unsure) - wide.unsure).abs() < 1e-4, "{single:?} {wide:?}");
        }
    }
}
