//! One line of comma-separated values per target (RFC 4180).

use anyhow::Result;
use concentric::Target;

use super::Outcome;
use crate::{measure::px, picture::Picture};

/// The columns. Lengths in px, `xx`, `xy`, `yy` the covariance of (x, y) in px^2, theta in radians, gap in degrees,
/// contrast and noise in grey levels; `a`, `b`, `theta`, `rms` belong to the outer circle, `outer_x`, `outer_y` to the
/// centre of its ellipse, `measured_ratio` to the innermost circle, `residual` and `gap` to all of them. `id` is empty where no
/// code was read.
pub const HEADER: &str = "image,number,x,y,xx,xy,yy,eq7_x,eq7_y,outer_x,outer_y,a,b,theta,rms,circles,measured_ratio,\
                          eccentricity,model_difference,contrast,noise,blur,residual,gap,flags,id\n";

/// The lines for `picture`; none where there is no target.
///
/// # Errors
/// None that a caller can cause.
pub fn lines(picture: &Picture, outcome: &Outcome) -> Result<String> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    for (index, target) in outcome.targets.iter().enumerate() {
        writer.write_record(record(&picture.name, index + 1, target))?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

fn record(image: &str, number: usize, target: &Target) -> Vec<String> {
    let outer = target.circles.first().copied().unwrap_or_default();
    let mut record = vec![image.to_owned(), number.to_string()];
    let place = |position| px(position).map(|axis| axis.to_string());
    let cov = target.covariance;
    record.extend(place(target.centre));
    record.extend([cov.xx, cov.xy, cov.yy].map(|value| value.to_string()));
    record.extend(place(target.eq7));
    record.extend(place(outer.ellipse.centre));
    record.extend(
        [outer.ellipse.a, outer.ellipse.b, outer.ellipse.theta, outer.rms].map(|value| value.to_string()),
    );
    record.push(target.circles.len().to_string());
    let innermost = target.circles.last().copied().unwrap_or_default();
    record.extend([innermost.measured_ratio, target.eccentricity()].map(|value| value.to_string()));
    record.extend([target.model_difference(), target.contrast, target.noise].map(|value| value.to_string()));
    record.extend([target.blur, target.residual(), target.gap()].map(|value| value.to_string()));
    record.push(target.flags.names().collect::<Vec<_>>().join(" "));
    record.push(target.code.map_or_else(String::new, |code| code.id.to_string()));
    record
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_fills_the_columns() {
        assert_eq!(record("a", 1, &Target::default()).len(), HEADER.split(',').count());
    }
}
