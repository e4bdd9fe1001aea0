//! What surrounds the exposure: trigger, light, and the times between them.

use core::convert::Infallible;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};

/// A pin or delay that a board does not have: the light that is never seen, the trigger that never comes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Absent;

impl ErrorType for Absent {
    type Error = Infallible;
}

impl OutputPin for Absent {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl InputPin for Absent {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(false)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl DelayNs for Absent {
    fn delay_ns(&mut self, _: u32) {}
}

/// Light and trigger of a head, and their times.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Exposure<S = Absent, T = Absent, D = Absent> {
    strobe: S,
    delay: D,
    lead_us: u32,
    trigger: Option<T>,
    /// Looks at the trigger before it is given up.
    looks: u32,
}

impl Exposure {
    /// The sensor runs freely and there is no light to switch.
    pub const fn free_running() -> Self {
        Self { strobe: Absent, delay: Absent, lead_us: 0, trigger: None, looks: 0 }
    }
}

impl<S: OutputPin, D: DelayNs> Exposure<S, Absent, D> {
    /// `strobe` is high from `lead_us` microseconds before the sensor is asked for a frame, which a light needs to come up,
    /// until its last row is there.
    pub fn with_light(strobe: S, delay: D, lead_us: u32) -> Self {
        Self { strobe, delay, lead_us, trigger: None, looks: 0 }
    }
}

impl<S, T, D> Exposure<S, T, D> {
    /// Microseconds between two looks at the trigger.
    pub const LOOK_US: u32 = 10;

    /// The same with a trigger: a frame begins when `trigger` goes from low to high.
    ///
    /// The pin is looked at every 10 microseconds, and only while no frame is under way: what comes earlier is missed, and
    /// so is a pulse that is shorter. Where that matters, lead the trigger to the sensor as well. The wait ends after
    /// `timeout_us` microseconds, rounded up to the next look; the bytes that are moved between the looks come on top.
    pub fn with_trigger<I: InputPin>(self, trigger: I, timeout_us: u32) -> Exposure<S, I, D> {
        let Self { strobe, delay, lead_us, .. } = self;
        let looks = timeout_us.div_ceil(Self::LOOK_US);
        Exposure { strobe, delay, lead_us, trigger: Some(trigger), looks }
    }
}

/// How the wait for a trigger ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wait {
    Triggered,
    TimedOut,
    Failed,
}

impl<S: OutputPin, T: InputPin, D: DelayNs> Exposure<S, T, D> {
    /// Waits for the trigger if there is one; `between` is called between two looks.
    pub(super) fn wait(&mut self, mut between: impl FnMut()) -> Wait {
        let Some(trigger) = &mut self.trigger else { return Wait::Triggered };
        let mut was_low = false;
        let mut left = self.looks;
        loop {
            match trigger.is_high() {
                Ok(true) if was_low => return Wait::Triggered,
                Ok(high) => was_low |= !high,
                Err(_) => return Wait::Failed,
            }
            let Some(fewer) = left.checked_sub(1) else { return Wait::TimedOut };
            left = fewer;
            between();
            self.delay.delay_us(Self::LOOK_US);
        }
    }

    pub(super) fn light_on(&mut self) -> Result<(), S::Error> {
        self.strobe.set_high()?;
        if self.lead_us > 0 {
            self.delay.delay_us(self.lead_us);
        }
        Ok(())
    }

    pub(super) fn light_off(&mut self) -> Result<(), S::Error> {
        self.strobe.set_low()
    }

    /// Gives light, trigger and delay back.
    pub fn release(self) -> (S, Option<T>, D) {
        (self.strobe, self.trigger, self.delay)
    }
}
