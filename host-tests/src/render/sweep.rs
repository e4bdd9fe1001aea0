//! Numbers and ranges of numbers on the command line.

use std::num::ParseFloatError;

/// Most values of one range.
const MOST: usize = 10_000;

/// One value, or evenly spaced values from `start:stop:steps`, both ends included.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep(Vec<f64>);

impl Sweep {
    /// The values, at least one.
    pub fn values(&self) -> &[f64] {
        &self.0
    }
}

fn number(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|error: ParseFloatError| format!("'{text}': {error}"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("'{text}' is not finite")) }
}

/// Parser of a number from `low` to `high`.
pub fn within(low: f64, high: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let value =
            number(text).map_err(|error| format!("{error}: must be a number from {low} to {high}"))?;
        if (low..=high).contains(&value) { Ok(value) } else { Err(format!("must be from {low} to {high}")) }
    }
}

/// Parser of a [`Sweep`] whose values are from `low` to `high`.
pub fn sweep(low: f64, high: f64) -> impl Fn(&str) -> Result<Sweep, String> + Clone {
    move |text| {
        let parse = within(low, high);
        let parts: Vec<&str> = text.split(':').collect();
        match parts[..] {
            [value] => Ok(Sweep(vec![parse(value)?])),
            [start, stop, steps] => {
                let (start, stop) = (parse(start)?, parse(stop)?);
                let steps: usize = steps.parse().map_err(|error| format!("steps '{steps}': {error}"))?;
                if !(2..=MOST).contains(&steps) {
                    return Err(format!("{steps} steps: must be 2 to {MOST}"));
                }
                let step = |i: usize| start + (stop - start) * i as f64 / (steps - 1) as f64;
                Ok(Sweep((0..steps).map(step).collect()))
            }
            _ => Err("must be a number or start:stop:steps".to_owned()),
        }
    }
}

/// Parser of `first<separator>second`, named `form` in messages.
pub fn pair<T: std::str::FromStr>(
    separator: char,
    form: &'static str,
) -> impl Fn(&str) -> Result<(T, T), String> + Clone {
    move |text| {
        let parts = text.split_once(separator);
        let parsed = parts.and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
        parsed.ok_or_else(|| format!("must be {form}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_has_both_ends() {
        let sweep = sweep(-90.0, 90.0);
        assert_eq!(sweep("12:72:6").unwrap().values(), [12.0, 24.0, 36.0, 48.0, 60.0, 72.0]);
        assert_eq!(sweep("-5").unwrap().values(), [-5.0]);
    }

    #[test]
    fn wrong_ranges_say_what_is_allowed() {
        let sweep = sweep(0.0, 85.0);
        for (text, message) in [
            ("90", "must be from 0 to 85"),
            ("0:90:3", "must be from 0 to 85"),
            ("x", "must be a number from 0 to 85"),
            ("nan", "must be a number from 0 to 85"),
            ("0:1:1", "must be 2 to 10000"),
            ("0:1", "start:stop:steps"),
        ] {
            let error = sweep(text).unwrap_err();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
