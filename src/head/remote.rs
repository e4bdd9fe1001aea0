//! What a command changes.

use crate::report::{Command, DecodeError, Detail, Format, Outcome, RATIO_ONE, Request};
use crate::{Compensation, MAX_SPEC_CIRCLES, Polarity, Settings, SettingsError, TargetSpec};

/// Everything that commands can change.
pub(super) struct Changeable<'a> {
    pub settings: &'a mut Settings,
    pub detail: &'a mut Detail,
    pub format: &'a mut Format,
    /// Frames from one that is searched as a whole to the next.
    pub period: &'a mut u16,
    /// Whether a hello is to be sent.
    pub hello: &'a mut bool,
}

/// Carries out what arrived: the tag of its answer, and what became of it.
pub(super) fn carry_out(arrived: Result<Command, DecodeError>, to: Changeable<'_>) -> (u16, Outcome) {
    match arrived {
        Ok(command) => (command.tag, change(command.request, to).err().unwrap_or(Outcome::Done)),
        Err(DecodeError::Version(_) | DecodeError::Kind(_) | DecodeError::Body) => (0, Outcome::Unknown),
        Err(_) => (0, Outcome::Damaged),
    }
}

fn change(request: Request, to: Changeable<'_>) -> Result<(), Outcome> {
    match request {
        Request::Settings => {}
        Request::Hello => *to.hello = true,
        Request::Ratios(ratios) => to.settings.spec = spec(&ratios, to.settings.spec.polarity())?,
        Request::Polarity(polarity) => to.settings.spec = to.settings.spec.with_polarity(polarity),
        Request::Compensation(Compensation::Known) if to.settings.known_camera().is_none() => {
            return Err(Outcome::NoCamera);
        }
        Request::Compensation(compensation) => to.settings.compensation = compensation,
        Request::Detail(detail) => {
            *to.hello |= detail != *to.detail && *to.format == Format::Binary;
            *to.detail = detail;
        }
        Request::Format(format) => {
            *to.hello |= format != *to.format && format == Format::Binary;
            *to.format = format;
        }
        Request::WholeEvery(period) => *to.period = period,
        Request::PxPerRun(px) => to.settings.px_per_run = px,
        Request::Effort(effort) => to.settings.effort = effort,
    }
    Ok(())
}

/// The specification that the ratios of a command describe.
fn spec(ratios: &[u16], polarity: Polarity) -> Result<TargetSpec, Outcome> {
    let too_many = Outcome::RatioCount { given: ratios.len() as u8, max: MAX_SPEC_CIRCLES as u8 - 1 };
    let mut values = [0.0; MAX_SPEC_CIRCLES - 1];
    let values = values.get_mut(..ratios.len()).ok_or(too_many)?;
    for (value, &ratio) in values.iter_mut().zip(ratios) {
        *value = f32::from(ratio) / RATIO_ONE;
    }
    let spec = if values.is_empty() { Ok(TargetSpec::any()) } else { TargetSpec::circles(values) };
    let spec = spec.map_err(|error| match error {
        SettingsError::Ratio { value, max } => Outcome::Ratio {
            value: (value * RATIO_ONE) as u16,
            // Rounded to the inside of the range.
            min: (TargetSpec::MIN_RATIO * RATIO_ONE) as u16 + 1,
            max: (max * RATIO_ONE) as u16,
        },
        // The others are of codes, of which a command says nothing.
        _ => too_many,
    })?;
    Ok(spec.with_polarity(polarity))
}
