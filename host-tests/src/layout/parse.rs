//! The text of a layout file to a [`Layout`].

use std::collections::HashMap;

use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;

use super::{COLUMNS, CodeName, Layout, LayoutTarget, VERSION};

/// Farthest that a target may be from the origin, and largest radius, mm.
const FARTHEST: f64 = 1e6;
/// Smallest radius, mm.
const SMALLEST: f64 = 1e-3;

/// A line that counts, with its number.
type Line<'t> = (usize, &'t str);

pub(super) fn parse(text: &str) -> Result<Layout> {
    let content =
        |(index, line): (usize, &'_ str)| (index + 1, line.split('#').next().unwrap_or("").trim().to_owned());
    let lines: Vec<_> = text.lines().enumerate().map(content).filter(|(_, line)| !line.is_empty()).collect();
    let mut lines = lines.iter().map(|(number, line)| (*number, line.as_str()));
    version(lines.next())?;
    let mut layout = Layout::default();
    header(&mut layout, &mut lines)?;
    let mut numbers = Vec::new();
    for (number, line) in lines {
        let target = target(line, layout.code).with_context(|| format!("line {number}"))?;
        layout.targets.push(target);
        numbers.push(number);
    }
    ensure!(!layout.targets.is_empty(), "no targets: after the line `{COLUMNS}` comes one line for each");
    check(&layout.targets, &numbers)?;
    Ok(layout)
}

fn version(first: Option<Line<'_>>) -> Result<()> {
    let missing = || format!("no version: the first line must be `concentric-layout: {VERSION}`");
    let (number, line) = first.with_context(missing)?;
    let (key, value) = line.split_once(':').with_context(missing)?;
    ensure!(key.trim() == "concentric-layout", "line {number}: {}", missing());
    ensure!(
        value.trim() == VERSION.to_string(),
        "line {number}: version `{}` is not known; this program reads version {VERSION}",
        value.trim()
    );
    Ok(())
}

/// The lines up to the one above the targets.
fn header<'t>(layout: &mut Layout, lines: &mut impl Iterator<Item = Line<'t>>) -> Result<()> {
    let mut seen = Vec::new();
    for (number, line) in lines {
        let columns: Vec<_> = line.split(',').map(str::trim).collect();
        if columns.len() > 1 {
            let wanted: Vec<_> = COLUMNS.split(',').collect();
            if let Some(unknown) = columns.iter().find(|column| !wanted.contains(column)) {
                bail!("line {number}: unknown field `{unknown}`; the fields are `{COLUMNS}`");
            }
            ensure!(columns == wanted, "line {number}: the fields must be `{COLUMNS}`, in this order");
            return Ok(());
        }
        let (key, value) = line
            .split_once(':')
            .with_context(|| format!("line {number}: `{line}` is neither a setting nor `{COLUMNS}`"))?;
        let (key, value) = (key.trim(), value.trim());
        ensure!(!seen.contains(&key), "line {number}: {key} is given twice");
        seen.push(key);
        match (key, value) {
            ("code", "none") => layout.code = None,
            ("code", name) => {
                let known = CodeName::from_str(name, false);
                layout.code = Some(known.ok().with_context(|| {
                    format!("line {number}: code `{name}` is not known; must be none, cct14, cct12 or five")
                })?);
            }
            ("ink", "dark") => layout.light = false,
            ("ink", "light") => layout.light = true,
            ("ink", tone) => bail!("line {number}: ink `{tone}` must be dark or light"),
            _ => bail!("line {number}: unknown field `{key}`; must be code or ink"),
        }
    }
    bail!("no targets: the line `{COLUMNS}` is missing")
}

fn target(line: &str, code: Option<CodeName>) -> Result<LayoutTarget> {
    let fields: Vec<_> = line.split(',').map(str::trim).collect();
    let [id, x, y, z, radii] = fields[..] else {
        bail!("{} fields given: must be 5, `{COLUMNS}`", fields.len())
    };
    let place = |name: &str, text: &str| {
        let value = number(name, text)?;
        ensure!(value.abs() <= FARTHEST, "{name} = {text} is outside -{FARTHEST}..={FARTHEST}");
        Ok(value)
    };
    Ok(LayoutTarget {
        id: id_of(id, code)?,
        position: [place("x_mm", x)?, place("y_mm", y)?, place("z_mm", z)?],
        radii: radii_of(radii)?,
    })
}

fn id_of(text: &str, code: Option<CodeName>) -> Result<Option<u16>> {
    if text.is_empty() {
        return Ok(None);
    }
    let Some(name) = code else {
        bail!(
            "id `{text}` in a layout without a code: a line `code: cct14`, `cct12` or `five` must stand above the targets"
        )
    };
    let id = text.parse().ok().with_context(|| format!("id `{text}` is no number"))?;
    let code = name.code();
    if !code.has(id) {
        let ids: Vec<_> = code.ids().collect();
        let allowed = match &ids[..] {
            [first, .., last] if ids.len() > 10 => format!("{first} to {last}"),
            ids => ids.iter().map(u16::to_string).collect::<Vec<_>>().join(", "),
        };
        bail!("id {id} is not in the code {}: must be {allowed}", name.name());
    }
    Ok(Some(id))
}

fn radii_of(text: &str) -> Result<Vec<f64>> {
    let radii =
        text.split_whitespace().map(|radius| number("radii_mm", radius)).collect::<Result<Vec<_>>>()?;
    ensure!(
        (2..=4).contains(&radii.len()),
        "radii_mm: {} given; must be 2 to 4, separated by spaces",
        radii.len()
    );
    ensure!(
        radii.iter().all(|radius| (SMALLEST..=FARTHEST).contains(radius)),
        "radii_mm = {text}: each must be {SMALLEST} to {FARTHEST}"
    );
    ensure!(
        radii.windows(2).all(|pair| pair[0] > pair[1]),
        "radii_mm = {text} must fall: the outer circle comes first"
    );
    Ok(radii)
}

fn number(name: &str, text: &str) -> Result<f64> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
    value.with_context(|| format!("{name}: `{text}` is no number"))
}

/// What is wrong with targets together.
fn check(targets: &[LayoutTarget], numbers: &[usize]) -> Result<()> {
    let mut ids = HashMap::new();
    for (target, number) in targets.iter().zip(numbers) {
        if let Some(id) = target.id
            && let Some(first) = ids.insert(id, number)
        {
            bail!("line {number}: id {id} is given twice: the first time in line {first}");
        }
    }
    for (index, (target, number)) in targets.iter().zip(numbers).enumerate() {
        for (other, first) in targets.iter().zip(numbers).take(index) {
            let squares = target.position.iter().zip(other.position).map(|(a, b)| (a - b).powi(2));
            let distance = squares.sum::<f64>().sqrt();
            ensure!(
                distance > 0.0,
                "line {number}: x_mm, y_mm, z_mm are those of the target in line {first}: two targets at the same place"
            );
            ensure!(
                distance >= target.reach() + other.reach(),
                "line {number}: the target overlaps with that in line {first}: their centres are {distance} mm apart, \
                 and must be {} mm",
                target.reach() + other.reach()
            );
        }
    }
    Ok(())
}
