//! How far from the truth each compensation is when the eccentricity is not large against the noise, by drawing noisy
//! ellipse centres and putting them through the library's own forms.

use concentric::Compensation;
use concentric::centre::{Significance, Weights, mean, perspective, weights};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// Ratio of the radii.
const RATIO: f64 = 0.5;
/// Radius of the outer circle in RMS distances of its ellipse's centre from where it should be: 30 px at 0.003 px.
const RADIUS: f64 = 1e4;
/// Draws for a point of the curves: the RMS errors are then good to 0.5 %.
const DRAWS: u32 = 20_000;
const STEP: f64 = 0.25;
const LAST: u32 = 40;

/// RMS errors in units of that of the outer ellipse's centre without eccentricity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Risk {
    /// Eccentricity of the outer ellipse over the RMS distance that noise moves its centre.
    pub ecc_over_sigma: f64,
    /// Of the outer ellipse's centre.
    pub none: f64,
    /// Of eq. (7).
    pub eq7: f64,
    /// Of the exact form.
    pub exact: f64,
    /// Of [`Compensation::Auto`].
    pub auto: f64,
    /// RMS of the error of `Auto` in units of the standard deviation that it reports.
    pub auto_over_sigma: f64,
}

impl Risk {
    /// RMS error of `Auto` over that of the better of the outer ellipse's centre and the exact form.
    pub fn excess(&self) -> f64 {
        self.auto / self.none.min(self.exact)
    }
}

/// The curves for two circles with a ratio of 0.5 seen nearly from the front, eccentricity over sigma from 0 to 10. Under
/// tilt the ellipse centres are surest along the eccentricity, and `Auto` is better than here.
pub fn risk_curves() -> Vec<Risk> {
    (0..=LAST).map(|i| risk(f64::from(i) * STEP, |significance| significance)).collect()
}

/// A point of the curves; `rule` may change what the library makes of the significance.
fn risk(ecc: f64, rule: impl Fn(Significance<f64>) -> Significance<f64>) -> Risk {
    let mut random = Pcg64::seed_from_u64((ecc * 1000.0) as u64);
    let mut sum = Risk::default();
    for _ in 0..DRAWS {
        let view = View::draw(ecc, &mut random);
        let square = |compensation| {
            let (x, y, _) = view.centre(compensation, &rule);
            x * x + y * y
        };
        sum.none += square(Compensation::None);
        sum.eq7 += square(Compensation::Eq7);
        sum.exact += square(Compensation::Exact);
        let (x, y, variance) = view.centre(Compensation::Auto, &rule);
        sum.auto += x * x + y * y;
        sum.auto_over_sigma += 0.5 * (x * x + y * y) / variance;
    }
    let rms = |sum: f64| (sum / f64::from(DRAWS)).sqrt();
    Risk {
        ecc_over_sigma: ecc,
        none: rms(sum.none),
        eq7: rms(sum.eq7),
        exact: rms(sum.exact),
        auto: rms(sum.auto),
        auto_over_sigma: rms(sum.auto_over_sigma),
    }
}

/// The ellipse centres of a target, as they are measured; the true centre is the origin.
struct View {
    centres: [(f64, f64); 2],
}

impl View {
    /// Variance of either coordinate of the ellipse centres: inverse to the number of edge points.
    const VARIANCES: [f64; 2] = [0.5, 0.5 / RATIO];

    fn draw(ecc: f64, random: &mut Pcg64) -> Self {
        let mut noise = |variance: f64| {
            let normal: f64 = StandardNormal.sample(random);
            variance.sqrt() * normal
        };
        let [outer, inner] = Self::VARIANCES;
        let shift = ecc * RATIO * RATIO;
        Self { centres: [(ecc + noise(outer), noise(outer)), (shift + noise(inner), noise(inner))] }
    }

    /// The centre with the variance of either coordinate.
    fn centre(
        &self,
        compensation: Compensation,
        rule: impl Fn(Significance<f64>) -> Significance<f64>,
    ) -> (f64, f64, f64) {
        let [(x1, y1), (x2, y2)] = self.centres;
        let [outer, inner] = Self::VARIANCES;
        let t = perspective(((x2 - x1).powi(2) + (y2 - y1).powi(2)) / (RADIUS * RADIUS), RATIO);
        let corrected = |t: f64| weights(&[(1.0, outer), (RATIO, inner)], t).expect("the radii differ");
        match compensation {
            Compensation::None => (x1, y1, outer),
            Compensation::Eq7 => self.weighted(&corrected(0.0)),
            Compensation::Auto => self.significant(&corrected(t), rule),
            _ => self.weighted(&corrected(t)),
        }
    }

    fn significant(
        &self,
        exact: &Weights<f64>,
        rule: impl Fn(Significance<f64>) -> Significance<f64>,
    ) -> (f64, f64, f64) {
        let plain = mean(Self::VARIANCES.into_iter()).expect("two circles");
        let difference: Weights<f64> = exact.iter().zip(&plain).map(|(exact, plain)| exact - plain).collect();
        let (dx, dy, noise) = self.weighted(&difference);
        let (_, _, least) = self.weighted(&plain);
        let outer = 2.0 * Self::VARIANCES[0];
        let Significance { share, unsure } =
            rule(Significance::new((dx, dy), (noise, 0.0, noise), 2.0 * least, outer));
        let weights: Weights<f64> =
            plain.iter().zip(&difference).map(|(plain, difference)| plain + share * difference).collect();
        let (x, y, variance) = self.weighted(&weights);
        (x, y, variance + unsure * noise)
    }

    fn weighted(&self, weights: &Weights<f64>) -> (f64, f64, f64) {
        let terms = weights.iter().zip(self.centres).zip(Self::VARIANCES);
        terms.fold((0.0, 0.0, 0.0), |(x, y, sum), ((weight, centre), variance)| {
            (x + weight * centre.0, y + weight * centre.1, sum + weight * weight * variance)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst(curves: &[Risk]) -> f64 {
        curves.iter().map(Risk::excess).fold(0.0, f64::max)
    }

    /// 1.10 by integration; 1 % for the draws.
    const WORST: f64 = 1.11;

    #[test]
    fn auto_is_at_most_a_tenth_worse_than_the_better_of_none_and_exact() {
        let curves = risk_curves();
        for risk in curves.iter().step_by(4) {
            println!("{risk:.3?} excess {:.3}", risk.excess());
        }
        println!("worst excess {:.3}", worst(&curves));
        assert!(worst(&curves) <= WORST, "{}", worst(&curves));
        // Half of the range it is no worse than 5 %, and far better where the two meet.
        assert!(curves.iter().any(|risk| risk.excess() < 0.83));
        assert!(curves.last().unwrap().excess() < 1.05);
    }

    /// The bound has teeth: all of the correction always, none of it always, and a share that jumps all break it.
    #[test]
    fn other_rules_are_worse() {
        let forced = |share: fn(f64) -> f64| {
            let rule = |found: Significance<f64>| Significance { share: share(found.share), ..found };
            worst(&(0..=LAST).map(|i| risk(f64::from(i) * STEP, rule)).collect::<Vec<_>>())
        };
        let [all, none, pretest] = [forced(|_| 1.0), forced(|_| 0.0), forced(|h| f64::from(h > 0.5))];
        println!("worst excess with all {all:.3}, none {none:.3}, pretest {pretest:.3}");
        assert!(all > 1.8 && none > 3.0 && pretest > 1.2);
    }

    #[test]
    fn its_sigma_is_right_from_2_sigma_on_and_never_too_small() {
        for risk in risk_curves() {
            let (ecc, over) = (risk.ecc_over_sigma, risk.auto_over_sigma);
            assert!(over < 1.1, "{ecc}: {over}");
            assert!(ecc < 2.0 || over > 0.9, "{ecc}: {over}");
            // The price at no eccentricity: 1.6 times the error.
            assert!(over > 0.6, "{ecc}: {over}");
        }
    }
}
