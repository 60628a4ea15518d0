//! The pilot's pulses: their widths, ages and errors.

use core::fmt;

use super::width::{LONGEST_MS, SHORTEST_MS, is_plausible};
use crate::controls::{Channel, Channels};
use crate::time::Time;

/// A pulse, with its width and the time of its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Width of the pulse, ms, from 0.5 to 2.5.
    pub width_ms: f64,
    /// End of the pulse.
    pub at: Time,
}

/// Reason why a pulse counts as an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PulseFault {
    /// The width, ms, is impossible for a servo. The previous pulse is kept.
    Width(f64),
    /// The time of the pulse is before that of the previous pulse. The pulse is accepted: if two clocks disagree, the
    /// order of arrival decides.
    Backwards,
}

impl fmt::Display for PulseFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Width(width_ms) => {
                write!(f, "a pulse of {width_ms} ms, expected {SHORTEST_MS} to {LONGEST_MS}")
            }
            Self::Backwards => f.write_str("a pulse with a time before that of the previous pulse"),
        }
    }
}

impl core::error::Error for PulseFault {}

/// State of one channel: its last good pulse and the number of errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Captured {
    /// The last good pulse; `None` before the first.
    pub pulse: Option<Pulse>,
    /// Number of pulses since the start that had an impossible width, went backwards in time, or were damaged in
    /// transfer.
    pub errors: u32,
}

impl Captured {
    /// Processes a pulse of `width_ms` that ended at the time `at`.
    ///
    /// # Errors
    /// [`PulseFault`] if the pulse counts as an error.
    pub fn push(&mut self, width_ms: f64, at: Time) -> Result<(), PulseFault> {
        if !is_plausible(width_ms) {
            self.count_error();
            return Err(PulseFault::Width(width_ms));
        }
        let backwards = self.pulse.is_some_and(|before| at < before.at);
        self.pulse = Some(Pulse { width_ms, at });
        if backwards {
            self.count_error();
            return Err(PulseFault::Backwards);
        }
        Ok(())
    }

    /// Counts a pulse that was damaged in transfer.
    pub fn count_error(&mut self) {
        self.errors = self.errors.saturating_add(1);
    }

    /// Seconds from the last good pulse to `now`; `None` before the first.
    #[must_use]
    pub fn age_s(&self, now: Time) -> Option<f64> {
        self.pulse.map(|pulse| now - pulse.at)
    }

    /// The last good width, ms, if it is not older than `longest_age_s`. A pulse further than `longest_age_s` in the
    /// future is rejected too.
    #[must_use]
    pub fn fresh_ms(&self, now: Time, longest_age_s: f64) -> Option<f64> {
        self.pulse
            .filter(|pulse| libm::fabs(now - pulse.at) <= longest_age_s)
            .map(|pulse| pulse.width_ms)
    }
}

/// State of the pilot's pulses on all channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PilotPulses {
    /// State of each channel with a servo.
    pub channels: Channels<Captured>,
    /// State of the sixth channel, aux: the pilot's switch for the autopilot. It has no servo, and its loss does not
    /// count as loss of the pilot's signal.
    pub aux: Captured,
    /// Whether the receiver reports the loss of the transmitter.
    pub receiver_failsafe: bool,
}

/// Conditions for the loss of the pilot's signal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct SignalConfig {
    /// Age, s, beyond which a pulse is stale. The default is five pulse intervals at 50 Hz.
    pub stale_after_s: f64,
    /// Width, ms, below which a throttle pulse is the receiver's failsafe position; 0 if the receiver has no such
    /// position. The width is below the range of the stick.
    pub failsafe_throttle_ms: f64,
}

impl Default for SignalConfig {
    fn default() -> Self {
        Self { stale_after_s: 0.1, failsafe_throttle_ms: 0.0 }
    }
}

/// State of the pilot's signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Every channel is fresh.
    Good,
    /// This channel, and perhaps others, has had no good pulse for too long.
    Stale(Channel),
    /// The receiver reports the loss of the transmitter, or sends its failsafe throttle position.
    Failsafe,
}

impl PilotPulses {
    /// State of the pilot's signal at `now`.
    #[must_use]
    pub fn signal(&self, now: Time, config: &SignalConfig) -> Signal {
        let fresh_ms = self.channels.map(|channel| channel.fresh_ms(now, config.stale_after_s));
        let throttle_is_low =
            fresh_ms.throttle.is_some_and(|width_ms| width_ms < config.failsafe_throttle_ms);
        if self.receiver_failsafe || throttle_is_low {
            return Signal::Failsafe;
        }
        fresh_ms
            .iter()
            .find(|(_, width_ms)| width_ms.is_none())
            .map_or(Signal::Good, |(channel, _)| Signal::Stale(channel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: f64) -> Time {
        Time::from_seconds(seconds)
    }

    fn all_at(width_ms: f64, time: Time) -> PilotPulses {
        let captured = Captured { pulse: Some(Pulse { width_ms, at: time }), errors: 0 };
        PilotPulses { channels: Channels::from_fn(|_| captured), ..PilotPulses::default() }
    }

    #[test]
    fn an_impossible_width_is_counted_and_the_good_one_stays_and_ages() {
        let mut captured = Captured::default();
        captured.push(1.6, at(1.0)).unwrap();
        for width_ms in [0.49, 2.51, 0.0, -1.5, f64::NAN, f64::INFINITY] {
            assert!(matches!(captured.push(width_ms, at(1.02)), Err(PulseFault::Width(_))));
        }
        assert_eq!(captured.errors, 6);
        assert_eq!(captured.age_s(at(1.05)), Some(at(1.05) - at(1.0)));
        assert_eq!(captured.fresh_ms(at(1.05), 0.1), Some(1.6));
        assert_eq!(captured.fresh_ms(at(1.11), 0.1), None);
    }

    #[test]
    fn one_pulse_dated_into_the_future_does_not_lock_the_others_out() {
        let mut captured = Captured::default();
        captured.push(1.5, at(1e6)).unwrap();
        assert_eq!(captured.fresh_ms(at(1.0), 0.1), None);
        assert_eq!(captured.push(1.6, at(1.0)), Err(PulseFault::Backwards));
        assert_eq!(captured.fresh_ms(at(1.0), 0.1), Some(1.6));
        assert_eq!(captured.push(1.7, at(1.02)), Ok(()));
    }

    #[test]
    fn a_signal_is_lost_when_one_channel_is() {
        let config = SignalConfig::default();
        let mut pulses = all_at(1.5, at(1.0));
        assert_eq!(pulses.signal(at(1.09), &config), Signal::Good);
        assert_eq!(pulses.signal(at(1.2), &config), Signal::Stale(Channel::Throttle));
        pulses.channels.pedal = Captured::default();
        assert_eq!(pulses.signal(at(1.0), &config), Signal::Stale(Channel::Pedal));
    }

    #[test]
    fn a_receiver_shows_its_failsafe_by_word_or_by_throttle() {
        let config = SignalConfig { failsafe_throttle_ms: 0.95, ..SignalConfig::default() };
        let mut pulses = all_at(1.0, at(1.0));
        assert_eq!(pulses.signal(at(1.0), &config), Signal::Good);
        pulses.receiver_failsafe = true;
        assert_eq!(pulses.signal(at(1.0), &config), Signal::Failsafe);
        pulses = all_at(0.9, at(1.0));
        assert_eq!(pulses.signal(at(1.0), &config), Signal::Failsafe);
    }
}
