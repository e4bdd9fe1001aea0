//! Trigger, light and delay, each of which checks what is done with it and in which order.

use concentric::head::{Exposure, Head, HeadError, Results};
use concentric::report::Detail;
use concentric::{Detector, Settings, TargetSpec};
use embedded_hal::delay::DelayNs;
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::delay::{CheckedDelay, Transaction as Pause};
use embedded_hal_mock::eh1::digital::{Mock as Pin, State, State::High, State::Low, Transaction as Edge};

use crate::support::{BUFFER, FIRMWARE, Outcome, PlayedLine, SIZE, Sensor, TestStorage};

/// Measures a frame with these pins and delays and checks that each was used as it says.
fn frame(light: &[Edge], trigger: Option<&[Edge]>, pauses: &[Pause], prepare: fn(&mut Sensor)) -> Outcome {
    let line = PlayedLine::fast();
    let (mut storage, mut buffer, mut row) = (TestStorage::new(), [0; BUFFER], [0; SIZE as usize]);
    let mut sensor = Sensor::new(&line);
    prepare(&mut sensor);
    let mut detector = Detector::new(Settings::new(TargetSpec::any()), &mut storage);
    let mut results = Results::<4>::new(Detail::Normal);
    let (mut light, mut delay) = (Pin::new(light), CheckedDelay::new(pauses));
    let mut pin = Pin::new(trigger.unwrap_or_default());
    let exposure = Exposure::with_light(light.clone(), delay.clone(), 50);
    let outcome = if trigger.is_some() {
        let exposure = exposure.with_trigger(pin.clone(), 35);
        let mut head = Head::new(line, exposure, FIRMWARE, &mut buffer);
        head.frame(&mut detector, &mut sensor, &mut row, &mut results)
    } else {
        let mut head = Head::new(line, exposure, FIRMWARE, &mut buffer);
        head.frame(&mut detector, &mut sensor, &mut row, &mut results)
    };
    light.done();
    pin.done();
    delay.done();
    outcome
}

fn looks(states: &[State]) -> Vec<Edge> {
    states.iter().map(|&state| Edge::get(state)).collect()
}

fn pauses(us: &[u32]) -> Vec<Pause> {
    us.iter().map(|&us| Pause::delay_us(us)).collect()
}

const NOTHING: fn(&mut Sensor) = |_| {};

#[test]
fn the_light_leads_the_frame_and_is_off_afterwards() {
    let light = [Edge::set(High), Edge::set(Low)];
    let outcome = frame(&light, None, &pauses(&[50]), NOTHING);
    assert_eq!(outcome.map(|summary| summary.targets), Ok(1));
    let broken = frame(&light, None, &pauses(&[50]), |sensor| sensor.broken = Some(3));
    assert_eq!(broken, Err(HeadError::Source("no line sync")));
}

#[test]
fn a_frame_begins_at_the_rising_edge_of_the_trigger() {
    let light = [Edge::set(High), Edge::set(Low)];
    let edge = looks(&[Low, Low, High]);
    assert!(frame(&light, Some(&edge), &pauses(&[10, 10, 50]), NOTHING).is_ok());
    // A trigger that is still high from the last time has to fall first.
    let late = looks(&[High, Low, High]);
    assert!(frame(&light, Some(&late), &pauses(&[10, 10, 50]), NOTHING).is_ok());
}

#[test]
fn a_trigger_that_does_not_come_is_told_and_the_light_stays_off() {
    for state in [Low, High] {
        // 35 us are four looks after the first.
        let outcome = frame(&[], Some(&looks(&[state; 5])), &pauses(&[10; 4]), NOTHING);
        assert_eq!(outcome, Err(HeadError::NoTrigger));
    }
    assert_eq!(HeadError::<(), ()>::NoTrigger.to_string(), "no trigger came in its time");
}

#[test]
fn pins_that_fail_are_told() {
    let failed = || MockError::Io(std::io::ErrorKind::NotConnected);
    let trigger = [Edge::get(Low).with_error(failed())];
    assert_eq!(frame(&[], Some(&trigger), &[], NOTHING), Err(HeadError::Trigger));
    let light = [Edge::set(High).with_error(failed())];
    assert_eq!(frame(&light, None, &[], NOTHING), Err(HeadError::Strobe));
    let light = [Edge::set(High), Edge::set(Low).with_error(failed())];
    assert_eq!(frame(&light, None, &pauses(&[50]), NOTHING), Err(HeadError::Strobe));
}

#[test]
fn pins_and_delay_come_back() {
    let exposure = Exposure::with_light(Pin::new(&[]), CheckedDelay::new(&pauses(&[7])), 50);
    let exposure = exposure.with_trigger(Pin::new(&[]), 1000);
    let head = Head::new(PlayedLine::fast(), exposure, FIRMWARE, &mut []);
    let (_, exposure) = head.release();
    let (mut light, trigger, mut delay) = exposure.release();
    delay.delay_us(7);
    light.done();
    trigger.unwrap().done();
    delay.done();
}
