//! The profile of a blurred edge: the normal distribution and its density.

/// Steps for each unit.
const STEPS: usize = 32;
/// Beyond this many standard deviations the edge is over (3e-5 of the contrast is left).
const REACH: usize = 4;
const LEN: usize = STEPS * REACH + 1;

/// `(cdf, density)` at 0, 1/32, .. 4.
static TABLE: [(f32, f32); LEN] = table();

/// Share of the step that lies before `z` standard deviations, and its density there. Within 3e-6, beyond 4 standard
/// deviations 3e-5.
pub(crate) fn normal(z: f32) -> (f32, f32) {
    let distance = z.abs();
    let at = distance * STEPS as f32;
    let Some(&(cdf, density)) = TABLE.get(at as usize).filter(|_| distance < REACH as f32) else {
        return (if z > 0.0 { 1.0 } else { 0.0 }, 0.0);
    };
    let node = (at as usize) as f32 / STEPS as f32;
    let step = distance - node;
    // Taylor series about the node: the density's derivatives are itself times Hermite polynomials.
    let share = cdf + density * step * (1.0 - 0.5 * node * step);
    let density = density * (1.0 - step * (node - 0.5 * step * (node * node - 1.0)));
    (if z > 0.0 { share } else { 1.0 - share }, density)
}

const fn table() -> [(f32, f32); LEN] {
    let mut table = [(0.0, 0.0); LEN];
    let mut i = 0;
    while i < LEN {
        let z = i as f64 / STEPS as f64;
        let density = exp_minus(0.5 * z * z) * 0.398_942_280_401_432_7;
        // 0.5 + density * (z + z^3/3 + z^5/15 + ..), all terms positive.
        let (mut term, mut sum, mut n) = (z, z, 1.0);
        while n < 60.0 {
            term *= z * z / (2.0 * n + 1.0);
            sum += term;
            n += 1.0;
        }
        table[i] = ((0.5 + density * sum) as f32, density as f32);
        i += 1;
    }
    table
}

/// exp(-x) for 0 <= x <= 8.
const fn exp_minus(x: f64) -> f64 {
    let (mut term, mut sum, mut n) = (1.0, 1.0, 1.0);
    while n < 80.0 {
        term *= x / n;
        sum += term;
        n += 1.0;
    }
    1.0 / sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_error_function() {
        for i in -4500..=4500 {
            let z = f64::from(i) / 1000.0;
            let (share, density) = normal(z as f32);
            let want = 0.5 * libm::erfc(-z / core::f64::consts::SQRT_2);
            let want_density = libm::exp(-0.5 * z * z) * 0.398_942_280_401_432_7;
            let tolerance = if z.abs() < 4.0 { 3e-6 } else { 4e-5 };
            assert!((f64::from(share) - want).abs() < tolerance, "{z}: {share} for {want}");
            assert!((f64::from(density) - want_density).abs() < 2e-4, "{z}: {density} for {want_density}");
        }
    }
}
