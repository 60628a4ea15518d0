//! A switch of the transmitter, whose pulses mean on or off.

use super::capture::Captured;
use super::config::{ConfigError, Direction, within};
use super::width::{LONGEST_MS, SHORTEST_MS};
use crate::time::Time;

/// Conditions that the pulses of a switch must meet for the state on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct SwitchConfig {
    /// Width that separates off and on, ms, from 0.5 to 2.5.
    pub threshold_ms: f64,
    /// Distance beyond the threshold that a width must have to change the state, ms, from 0 to 0.5.
    pub hysteresis_ms: f64,
    /// Number of consecutive pulses beyond the threshold that switch on, 1 to 100. A single pulse switches off.
    pub pulses: u8,
    /// Direction of the switch: with `normal` longer pulses mean on, with `reversed` shorter pulses mean on.
    pub direction: Direction,
}

impl Default for SwitchConfig {
    fn default() -> Self {
        Self { threshold_ms: 1.5, hysteresis_ms: 0.1, pulses: 5, direction: Direction::Normal }
    }
}

impl SwitchConfig {
    /// Checks that every setting is finite and in its range.
    ///
    /// # Errors
    /// [`ConfigError`] with the first invalid setting.
    pub fn check(&self) -> Result<(), ConfigError> {
        within("hysteresis_ms", self.hysteresis_ms, 0.0, 0.5)?;
        // Valid widths must exist on both sides of the threshold, beyond the hysteresis.
        let (shortest, longest) =
            (SHORTEST_MS + self.hysteresis_ms, LONGEST_MS - self.hysteresis_ms);
        within("threshold_ms", self.threshold_ms, shortest, longest)?;
        within("pulses", f64::from(self.pulses), 1.0, 100.0)
    }
}

/// A switch of the transmitter. It is on after its pulses have first meant off and then on.
///
/// A switch may be on when the pulses begin, or when they return after a loss. It then counts as off until the pilot
/// has opened it, because the pilot did not close it at that moment.
///
/// ```
/// use hovernav::servo::{Captured, Switch, SwitchConfig};
/// use hovernav::time::Time;
///
/// let mut switch = Switch::new(SwitchConfig::default())?;
/// let mut aux = Captured::default();
/// let mut on = Vec::new();
/// for pulse in 0..8 {
///     let now = Time::ZERO + 0.02 * f64::from(pulse);
///     aux.push(if pulse < 2 { 1.1 } else { 1.9 }, now)?;
///     on.push(switch.update(&aux, now, 0.1));
/// }
/// assert_eq!(on, [false, false, false, false, false, false, true, true]);
/// assert!(!switch.update(&aux, Time::ZERO + 0.5, 0.1)); // the pulses have stopped
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Switch {
    config: SwitchConfig,
    on: bool,
    /// Whether the pulses have meant off since they began.
    seen_off: bool,
    /// Number of consecutive pulses that mean on.
    on_pulses: u8,
    /// Number of pulse errors at the last call, and time of the last evaluated pulse.
    last: Option<(u32, Time)>,
}

impl Switch {
    /// Creates a switch that is off.
    ///
    /// # Errors
    /// [`ConfigError`] with the first invalid setting of `config`.
    pub fn new(config: SwitchConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config, on: false, seen_off: false, on_pulses: 0, last: None })
    }

    /// Whether the switch is closed without effect, because it was closed when its pulses began. The pilot must open it
    /// first.
    #[must_use]
    pub const fn must_be_opened(&self) -> bool {
        !self.seen_off && self.on_pulses >= self.config.pulses
    }

    /// Whether the switch is on at `now`, by the channel's last pulse. Pulses older than `stale_after_s`, s, count as
    /// off. A pulse error since the last call restarts the count of pulses.
    pub fn update(&mut self, aux: &Captured, now: Time, stale_after_s: f64) -> bool {
        let Some(width_ms) = aux.fresh_ms(now, stale_after_s) else {
            *self = Self { on: false, seen_off: false, on_pulses: 0, ..*self };
            return false;
        };
        let at = aux.pulse.map_or(now, |pulse| pulse.at);
        let before = self.last.replace((aux.errors, at));
        if before.is_some_and(|(errors, _)| errors != aux.errors) {
            self.on_pulses = 0;
        }
        if before.is_some_and(|(_, pulse)| pulse == at) {
            return self.on;
        }
        let beyond_ms = match self.config.direction {
            Direction::Normal => width_ms - self.config.threshold_ms,
            Direction::Reversed => self.config.threshold_ms - width_ms,
        };
        if beyond_ms < -self.config.hysteresis_ms {
            *self = Self { on: false, seen_off: true, on_pulses: 0, ..*self };
        } else if beyond_ms > self.config.hysteresis_ms {
            self.on_pulses = self.on_pulses.saturating_add(1);
            self.on |= self.seen_off && self.on_pulses >= self.config.pulses;
        } else if !self.on {
            self.on_pulses = 0;
        }
        self.on
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(pulse: u32) -> Time {
        Time::ZERO + 0.02 * f64::from(pulse)
    }

    /// State of the switch after each of the widths, 20 ms apart.
    fn states_after(config: SwitchConfig, widths_ms: &[f64]) -> Vec<bool> {
        let mut switch = Switch::new(config).unwrap();
        let mut aux = Captured::default();
        (0..)
            .zip(widths_ms)
            .map(|(pulse, width_ms)| {
                let _ = aux.push(*width_ms, at(pulse));
                switch.update(&aux, at(pulse), 0.1)
            })
            .collect()
    }

    #[test]
    fn a_switch_that_is_on_at_the_start_must_be_opened_first() {
        assert!(states_after(SwitchConfig::default(), &[1.9; 50]).iter().all(|on| !on));
        let again = [[1.9; 10], [1.1; 10], [1.9; 10]].concat();
        assert!(states_after(SwitchConfig::default(), &again)[29]);
        let mut switch = Switch::new(SwitchConfig::default()).unwrap();
        let mut aux = Captured::default();
        let waits: Vec<bool> = (0..20)
            .map(|pulse| {
                aux.push(if pulse < 10 { 1.9 } else { 1.1 }, at(pulse)).unwrap();
                switch.update(&aux, at(pulse), 0.1);
                switch.must_be_opened()
            })
            .collect();
        assert!((0..20).all(|pulse| waits[pulse] == (4..10).contains(&pulse)), "{waits:?}");
    }

    #[test]
    fn spikes_do_not_close_it_and_one_pulse_opens_it() {
        let mut widths = [1.1; 40];
        for spike in [5, 10, 11, 20, 21, 22, 30, 31, 32, 33] {
            widths[spike] = 1.9;
        }
        assert!(states_after(SwitchConfig::default(), &widths).iter().all(|on| !on));
        let closed = [&[1.1; 3][..], &[1.9; 8], &[1.1], &[1.9; 4]].concat();
        let on = states_after(SwitchConfig::default(), &closed);
        assert_eq!((on[10], on[11], on[15]), (true, false, false));
    }

    #[test]
    fn between_the_thresholds_it_stays_as_it_is() {
        let on =
            states_after(SwitchConfig::default(), &[&[1.1; 2][..], &[1.9; 6], &[1.5; 9]].concat());
        assert!(on[7..].iter().all(|on| *on));
        let off = states_after(
            SwitchConfig::default(),
            &[&[1.1; 2][..], &[1.9; 4], &[1.5], &[1.9; 4]].concat(),
        );
        assert!(off.iter().all(|on| !on), "the count restarted");
    }

    #[test]
    fn a_loss_of_pulses_or_an_impossible_one_opens_it_or_keeps_it_open() {
        let config = SwitchConfig { pulses: 3, ..SwitchConfig::default() };
        let impossible = [&[1.1; 2][..], &[1.9, 1.9, f64::NAN, 1.9, 1.9, 1.9]].concat();
        let on = states_after(config, &impossible);
        assert_eq!(on, [false, false, false, false, false, false, false, true]);

        let mut switch = Switch::new(config).unwrap();
        let mut aux = Captured::default();
        for pulse in 0..6 {
            aux.push(if pulse < 2 { 1.1 } else { 1.9 }, at(pulse)).unwrap();
            switch.update(&aux, at(pulse), 0.1);
        }
        assert!(switch.update(&aux, at(6), 0.1));
        assert!(!switch.update(&aux, at(20), 0.1));
        for pulse in 21..40 {
            aux.push(1.9, at(pulse)).unwrap();
            assert!(!switch.update(&aux, at(pulse), 0.1), "it was never opened");
        }
    }

    #[test]
    fn reversed_means_short_pulses() {
        let config = SwitchConfig { direction: Direction::Reversed, ..SwitchConfig::default() };
        assert!(states_after(config, &[&[1.9; 2][..], &[1.1; 5]].concat())[6]);
    }

    #[test]
    fn settings_that_cannot_be_are_named() {
        let good = SwitchConfig::default();
        for (bad, key) in [
            (SwitchConfig { threshold_ms: f64::NAN, ..good }, "threshold_ms"),
            (SwitchConfig { hysteresis_ms: -0.1, ..good }, "hysteresis_ms"),
            (SwitchConfig { pulses: 0, ..good }, "pulses"),
        ] {
            assert_eq!(Switch::new(bad).unwrap_err().key, key);
        }
    }
}
