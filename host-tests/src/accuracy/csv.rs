//! Every cell and method as a line of comma-separated values (RFC 4180).

use anyhow::Result;
use concentric::Flags;

use super::{
    bound::per_coordinate, cell::Cell, method::METHODS, run::Outcome, statistics::Figures, study::Study,
};

/// The columns. Lengths in px, root mean squares of one coordinate; tilt in degrees, levels in grey levels. `expected` is `rms` without what
/// the noise of these frames makes of any good estimate. `systematic` is empty where each scene is seen once, all figures where the target was never found.
pub const HEADER: &str = "slice,cell,method,in_range,radius,tilt,ratio,psf,black,contrast,noise,shading,gamma,gain,f,x,y,k1,hidden,\
                          targets,frames,found,false,clipped,refined,eccentricity,bound,rms,rms_95,expected,expected_95,systematic,bias,drift,reported,\
                          over_sigma,inside_95\n";

/// The whole study.
///
/// # Errors
/// None that a caller can cause.
pub fn text(study: &Study) -> Result<String> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    for outcome in &study.outcomes {
        for method in METHODS {
            writer.write_record(record(outcome, method.name))?;
        }
    }
    Ok(HEADER.to_owned() + &String::from_utf8(writer.into_inner()?)?)
}

fn record(outcome: &Outcome, method: &str) -> Vec<String> {
    let Cell {
        radius,
        tilt,
        ratio,
        psf,
        black,
        contrast,
        noise,
        shading,
        gamma,
        gain,
        f,
        place,
        k1,
        hidden,
        targets,
        ..
    } = outcome.cell;
    let figures = outcome.figures(method);
    let mut record: Vec<String> =
        [outcome.cell.slice, &outcome.cell.label(), method, &outcome.cell.in_range().to_string()]
            .map(str::to_owned)
            .to_vec();
    let condition = [
        radius, tilt, ratio, psf, black, contrast, noise, shading, gamma, gain, f, place[0], place[1], k1,
        hidden,
    ];
    record.extend(condition.map(|value| value.to_string()));
    record.push(targets.to_string());
    let found = figures.map_or(0, |figures| figures.found);
    let counts = [
        outcome.samples().count(),
        found,
        outcome.wrong(),
        outcome.flagged(method, Flags::CLIPPED),
        outcome.flagged(method, Flags::REFINED),
    ];
    record.extend(counts.map(|count| count.to_string()));
    record.push(format!("{:.6}", outcome.eccentricity()));
    record.extend(columns(figures, least(outcome, method)));
    record
}

/// The bound over all frames, also where no target was found.
fn least(outcome: &Outcome, method: &str) -> f64 {
    let index = METHODS.iter().position(|known| known.name == method).unwrap_or(0);
    let squares = outcome.groups.iter().map(|group| per_coordinate(group.bounds[index]).powi(2));
    (squares.sum::<f64>() / outcome.groups.len() as f64).sqrt()
}

fn columns(figures: Option<Figures>, bound: f64) -> Vec<String> {
    let Some(f) = figures else { return [vec![format!("{bound:.6}")], vec![String::new(); 10]].concat() };
    let mut columns = vec![format!("{bound:.6}")];
    columns.extend([f.rms, f.spread, f.expected.0, f.expected.1].map(|value| format!("{value:.6}")));
    columns.push(f.systematic.map_or(String::new(), |value| format!("{value:.6}")));
    columns.extend([f.bias, f.drift, f.reported].map(|value| format!("{value:.6}")));
    columns.extend([f.over_sigma.0, f.within].map(|value| format!("{value:.4}")));
    columns
}
