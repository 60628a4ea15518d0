//! Manoeuvres: stick movements that excite the vehicle's dynamics.

use core::f64::consts::TAU;

use crate::scalar::Scalar;

/// A deviation of one stick from its current position, from time 0 on. Its unit is that of the amplitude.
///
/// The thesis flew steps of 10 to 15 % held for 1.5 s. A sweep excites more of the dynamics in one run and is the
/// input required for frequency responses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Maneuver {
    /// Deviation by `amplitude` for `hold_s`, then back to 0.
    Step {
        /// Deviation of the stick.
        amplitude: f64,
        /// Duration, s.
        hold_s: f64,
    },
    /// Deviation by `amplitude` for `hold_s`, then by −`amplitude` for the same time.
    Doublet {
        /// Deviation of the stick.
        amplitude: f64,
        /// Duration in each direction, s.
        hold_s: f64,
    },
    /// Alternating pulses of 3, 2, 1 and 1 units: a flat spectrum over a decade.
    ///
    /// Source: J. Marchand, after R. Jategaonkar, *Flight Vehicle System Identification*, section
    /// 2.3.
    ThreeTwoOneOne {
        /// Deviation of the stick.
        amplitude: f64,
        /// Length of one unit, s.
        unit_s: f64,
    },
    /// A sine whose frequency rises from `first_hz` to `last_hz`, slowly at first so that low frequencies get enough
    /// time.
    ///
    /// Source: M. Tischler & R. Remple, *Aircraft and Rotorcraft System Identification*, section
    /// 5.11: ω = ω₁ + K (ω₂ − ω₁), K = 0.0187 (exp(4 t/T) − 1).
    Sweep {
        /// Largest deviation.
        amplitude: f64,
        /// Frequency at the start, Hz.
        first_hz: f64,
        /// Frequency at the end, Hz.
        last_hz: f64,
        /// Duration, s. At least four periods of `first_hz` are advised.
        duration_s: f64,
        /// Time over which the amplitude fades in and out, s.
        fade_s: f64,
    },
}

/// Constant 4 in the exponent of Tischler & Remple's sweep.
const SWEEP_RATE: f64 = 4.0;
/// Constant 0.0187 of Tischler & Remple's sweep, the factor of the exponential.
const SWEEP_SCALE: f64 = 0.0187;

impl Maneuver {
    /// Duration of the manoeuvre, s; after that the deviation is 0.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match *self {
            Self::Step { hold_s, .. } => hold_s,
            Self::Doublet { hold_s, .. } => 2.0 * hold_s,
            Self::ThreeTwoOneOne { unit_s, .. } => 7.0 * unit_s,
            Self::Sweep { duration_s, .. } => duration_s,
        }
    }

    /// The largest deviation, with the sign of its first movement.
    #[must_use]
    pub const fn amplitude(&self) -> f64 {
        match *self {
            Self::Step { amplitude, .. }
            | Self::Doublet { amplitude, .. }
            | Self::ThreeTwoOneOne { amplitude, .. }
            | Self::Sweep { amplitude, .. } => amplitude,
        }
    }

    /// The deviation at `time_s`; 0 before 0 and from [`Maneuver::duration_s`] on.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        if !(0.0..self.duration_s()).contains(&time_s) {
            return 0.0;
        }
        match *self {
            Self::Step { amplitude, .. } => amplitude,
            Self::Doublet { amplitude, hold_s } => {
                if time_s < hold_s {
                    amplitude
                } else {
                    -amplitude
                }
            }
            Self::ThreeTwoOneOne { amplitude, unit_s } => {
                let unit = time_s / unit_s;
                if unit < 3.0 || (5.0..6.0).contains(&unit) { amplitude } else { -amplitude }
            }
            Self::Sweep { amplitude, first_hz, last_hz, duration_s, fade_s } => {
                let rate = SWEEP_RATE / duration_s;
                let risen = SWEEP_SCALE * ((libm::exp(rate * time_s) - 1.0) / rate - time_s);
                let phase = TAU * (first_hz * time_s + (last_hz - first_hz) * risen);
                let edge = time_s.min(duration_s - time_s);
                let fade = if edge < fade_s { edge / fade_s } else { 1.0 };
                amplitude * fade * phase.sincos().0
            }
        }
    }

    /// The deviations at `samples` instants, `period_s` apart, of the manoeuvre that starts at `start_s`.
    #[cfg(feature = "alloc")]
    #[must_use]
    pub fn sampled(&self, samples: usize, period_s: f64, start_s: f64) -> alloc::vec::Vec<f64> {
        (0..samples).map(|sample| self.at(sample as f64 * period_s - start_s)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_change_sign_when_they_say_and_end_at_trim() {
        let maneuver = Maneuver::ThreeTwoOneOne { amplitude: 2.0, unit_s: 0.5 };
        let seen: [f64; 8] = core::array::from_fn(|unit| maneuver.at(0.25 + 0.5 * unit as f64));
        assert_eq!(seen, [2.0, 2.0, 2.0, -2.0, -2.0, 2.0, -2.0, 0.0]);
        let doublet = Maneuver::Doublet { amplitude: 1.0, hold_s: 1.0 };
        let seen: [f64; 5] = core::array::from_fn(|sample| doublet.at(0.75 * sample as f64 - 0.5));
        assert_eq!(seen, [0.0, 1.0, -1.0, -1.0, 0.0]);
    }

    #[test]
    fn a_sweep_ends_at_its_last_frequency_and_fades() {
        let sweep = Maneuver::Sweep {
            amplitude: 1.0,
            first_hz: 0.1,
            last_hz: 3.0,
            duration_s: 60.0,
            fade_s: 2.0,
        };
        assert!(sweep.at(0.0) == 0.0 && sweep.at(59.999).abs() < 0.01 && sweep.at(60.0) == 0.0);
        // Zero crossings of the last eight seconds before the fade, two a period.
        let at = |sample: i32| sweep.at(50.0 + 1e-3 * f64::from(sample));
        let crossings = (1..8000).filter(|&sample| at(sample - 1) * at(sample) < 0.0).count();
        let mean_hz = crossings as f64 / 16.0;
        assert!((1.5..3.0).contains(&mean_hz), "{mean_hz}");
    }
}
