//! Commands to the head: from the words of the command line to bytes, one after the other as they are answered.

use std::io::{self, Write};
use std::str::FromStr;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use concentric::report::{COMMAND_MAX_LEN, Command, Detail, Format, RATIO_ONE, Ratios, Request};
use concentric::{Compensation, Effort, Polarity};

/// How long an answer may take: the head gives it between two frames.
const PATIENCE: Duration = Duration::from_secs(2);
/// How often a command is sent that nobody answers.
const TRIES: usize = 3;

/// A command as it is written on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Word(Request);

impl FromStr for Word {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (name, value) = text.split_once('=').unwrap_or((text, ""));
        Ok(Self(match name {
            "settings" => Request::Settings,
            "hello" => Request::Hello,
            "ratio" => Request::Ratios(ratios(value)?),
            "polarity" => Request::Polarity(one_of(text, &POLARITIES)?),
            "compensation" => Request::Compensation(one_of(text, &COMPENSATIONS)?),
            "detail" => Request::Detail(one_of(text, &DETAILS)?),
            "format" => Request::Format(one_of(text, &FORMATS)?),
            "whole-every" => Request::WholeEvery(number(name, "frames", value)?),
            "px-per-run" => Request::PxPerRun(number(name, "pixels", value)?),
            "effort" => Request::Effort(one_of(text, &EFFORTS)?),
            _ => bail!(
                "wanted settings, hello, ratio=, polarity=, compensation=, detail=, format=, whole-every=, px-per-run= \
                 or effort="
            ),
        }))
    }
}

const POLARITIES: [(&str, Polarity); 2] = [("dark", Polarity::Dark), ("light", Polarity::Light)];
const COMPENSATIONS: [(&str, Compensation); 5] = [
    ("none", Compensation::None),
    ("eq7", Compensation::Eq7),
    ("exact", Compensation::Exact),
    ("auto", Compensation::Auto),
    ("known", Compensation::Known),
];
const DETAILS: [(&str, Detail); 3] =
    [("terse", Detail::Terse), ("normal", Detail::Normal), ("full", Detail::Full)];
const EFFORTS: [(&str, Effort); 2] = [("full", Effort::Full), ("quick", Effort::Quick)];
const FORMATS: [(&str, Format); 2] = [("binary", Format::Binary), ("text", Format::Text)];

/// The value in `name=value`.
fn one_of<T: Copy>(text: &str, values: &[(&str, T)]) -> Result<T> {
    let (name, value) = text.split_once('=').unwrap_or((text, ""));
    let found = values.iter().find(|(known, _)| *known == value);
    found.map(|&(_, value)| value).with_context(|| {
        let names: Vec<_> = values.iter().map(|(known, _)| *known).collect();
        format!("{name}: wanted one of {}", names.join(", "))
    })
}

/// `any`, or ratios with commas between them. Whether they make sense is for the head to say.
fn ratios(text: &str) -> Result<Ratios> {
    if text == "any" {
        return Ok(Ratios::new());
    }
    let mut ratios = Ratios::new();
    for part in text.split(',') {
        let ratio = part.parse().ok().filter(|ratio| (0.0..1.0).contains(ratio));
        let ratio: f32 =
            ratio.context("ratio: wanted `any` or up to 3 numbers from 0.1 to 0.95, as in 0.75,0.5")?;
        ensure!(
            ratios.push((ratio * RATIO_ONE) as u16).is_ok(),
            "ratio: more numbers than a command can hold"
        );
    }
    Ok(ratios)
}

/// So many of something.
fn number(name: &str, what: &str, text: &str) -> Result<u16> {
    text.parse().ok().with_context(|| format!("{name}: wanted a number of {what} from 0 to 65535, as in 10"))
}

/// Sends the commands, each when the one before is answered. `answered` has the tags of the answers.
pub(super) fn send(words: &[Word], output: &mut dyn Write, answered: &Receiver<u16>) -> io::Result<()> {
    for (tag, Word(request)) in (1..).zip(words) {
        let mut bytes = [0; COMMAND_MAX_LEN];
        let command = Command { tag, request: request.clone() };
        let bytes = command.encode(&mut bytes).map_err(io::Error::other)?;
        let mut sent = 0;
        while sent < TRIES {
            output.write_all(bytes)?;
            output.flush()?;
            sent += 1;
            if wait_for(tag, answered) {
                break;
            }
            if sent == TRIES {
                return Err(io::Error::new(
                    io::ErrorKind::TimedOut,
                    format!("command {tag} was sent {TRIES} times and not answered"),
                ));
            }
        }
    }
    Ok(())
}

fn wait_for(tag: u16, answered: &Receiver<u16>) -> bool {
    let end = Instant::now() + PATIENCE;
    loop {
        match answered.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(known) if known == tag => return true,
            Ok(_) => {}
            Err(_) => return false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read() {
        let read = |text: &str| text.parse::<Word>().map(|word| word.0).map_err(|error| format!("{error:#}"));
        assert_eq!(read("ratio=0.75,0.5"), Ok(Request::Ratios(Ratios::from_slice(&[49152, 32768]).unwrap())));
        assert_eq!(read("ratio=any"), Ok(Request::Ratios(Ratios::new())));
        assert_eq!(read("polarity=light"), Ok(Request::Polarity(Polarity::Light)));
        assert_eq!(read("compensation=eq7"), Ok(Request::Compensation(Compensation::Eq7)));
        assert_eq!(read("detail=full"), Ok(Request::Detail(Detail::Full)));
        assert_eq!(read("format=text"), Ok(Request::Format(Format::Text)));
        assert_eq!(read("whole-every=10"), Ok(Request::WholeEvery(10)));
        assert!(read("whole-every=-1").unwrap_err().contains("frames from 0 to 65535"));
        assert_eq!(read("px-per-run=32"), Ok(Request::PxPerRun(32)));
        assert!(read("px-per-run=").unwrap_err().contains("pixels from 0 to 65535"));
        assert_eq!(read("effort=quick"), Ok(Request::Effort(Effort::Quick)));
        assert_eq!(read("effort=none"), Err("effort: wanted one of full, quick".into()));
        assert_eq!(read("settings"), Ok(Request::Settings));
        assert_eq!(read("hello"), Ok(Request::Hello));
        assert_eq!(read("detail=fine"), Err("detail: wanted one of terse, normal, full".into()));
        assert!(read("ratio=1.5").unwrap_err().contains("0.1 to 0.95"));
        assert!(read("size=3").unwrap_err().starts_with("wanted settings, hello, ratio="));
    }
}
