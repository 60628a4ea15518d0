//! Phase loss of the loops by a notch before the estimator.

use std::f64::consts::PI;

use super::error::DesignError;
use super::margins::Margins;
use hovernav::frames::Vector;
use hovernav::imu::{ImuSample, Motion, Notch, NotchConfig};
use hovernav::time::Time;

/// A notch on a rotor's harmonics, and the phase that each loop loses by it.
#[derive(Clone, Debug, PartialEq)]
pub struct NotchCost {
    /// The notch.
    pub config: NotchConfig,
    /// Sample rate of the filtered inertial unit, Hz.
    pub imu_hz: f64,
    /// Delay of motion much slower than the notch frequency, s; 0 for a notch that cannot remove the rotor's vibration.
    pub delay_s: f64,
    /// For each loop its name, its crossover, rad/s, and the phase lost there, rad.
    pub at_crossover: Vec<(String, f64, f64)>,
}

impl NotchCost {
    /// Delay that the notch `config` causes on samples of an inertial unit at `imu_hz`. [`on`](Self::on) adds the phase
    /// loss of the loops.
    ///
    /// # Errors
    /// [`DesignError::Range`] for an invalid notch, or a rate outside 5 Hz to 10 kHz.
    pub fn new(config: NotchConfig, imu_hz: f64) -> Result<Self, DesignError> {
        if let Some((name, value, expected)) = config.out_of_range() {
            return Err(DesignError::Range { name, value, expected });
        }
        if !(5.0..=1e4).contains(&imu_hz) {
            let expected = "5 to 10000 Hz";
            return Err(DesignError::Range { name: "imu_hz", value: imu_hz, expected });
        }
        let (delay_s, _) = answer(config, imu_hz, 0.02 * PI);
        Ok(Self { config, imu_hz, delay_s, at_crossover: Vec::new() })
    }

    /// The notch with the phase that each loop of `margins` loses by it.
    #[must_use]
    pub fn on(mut self, margins: &Margins) -> Self {
        let crossings = margins
            .channels
            .iter()
            .filter_map(|channel| Some((channel.name.clone(), channel.phase?.frequency_radps)));
        self.at_crossover = crossings
            .map(|(name, radps)| {
                let (_, lag_rad) = answer(self.config, self.imu_hz, radps);
                (name, radps, lag_rad)
            })
            .collect();
        self
    }
}

/// Delay of the notch, s, and its phase lag at `radps`, rad. Both come from a least-squares fit of the settled response
/// to a sine.
fn answer(config: NotchConfig, imu_hz: f64, radps: f64) -> (f64, f64) {
    /// Number of periods evaluated.
    const PERIODS: f64 = 2.0;
    /// Number of time constants of the notch before the evaluated periods.
    const SETTLING: f64 = 20.0;
    let mut notch = Notch::new(config);
    let settled_s = SETTLING / (PI * config.width_hz);
    let last = ((settled_s + PERIODS * 2.0 * PI / radps) * imu_hz).ceil() as u64;
    // Sums of products for the least squares: output with cosine and sine; cosine and sine with each other.
    let (mut onto, mut own) = ([0.0; 2], [0.0; 3]);
    for k in 0..=last {
        let time_s = k as f64 / imu_hz;
        let (sin, cos) = (radps * time_s).sin_cos();
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(cos, sin, 0.0),
            specific_force_mps2: Vector::ZERO,
        };
        let out = notch.filter(&ImuSample::new(Time::ZERO + time_s, motion));
        if let Motion::Rates { angular_rate_radps, .. } = out.motion
            && time_s >= settled_s
        {
            let value = angular_rate_radps.x();
            onto = [onto[0] + value * cos, onto[1] + value * sin];
            own = [own[0] + cos * cos, own[1] + cos * sin, own[2] + sin * sin];
        }
    }
    let determinant = own[0] * own[2] - own[1] * own[1];
    let cosine = (onto[0] * own[2] - onto[1] * own[1]) / determinant;
    let sine = (onto[1] * own[0] - onto[0] * own[1]) / determinant;
    (notch.delay_s(), sine.atan2(cosine))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use nalgebra::Complex;

    #[test]
    fn the_phase_is_that_of_the_closed_form() {
        for (imu_hz, frequency_hz) in [(200.0, 25.0), (100.0, 25.0), (33.0, 12.0)] {
            let config = NotchConfig::at_hz(frequency_hz);
            let (cos, alpha) =
                ((2.0 * PI * frequency_hz / imu_hz).cos(), (PI * config.width_hz / imu_hz).tan());
            for radps in [0.3, 2.0, 6.0, 15.0] {
                let back = Complex::from_polar(1.0, -radps / imu_hz);
                let numerator = back * (-2.0 * cos) + back * back + 1.0;
                let denominator = back * (-2.0 * cos) + back * back * (1.0 - alpha) + (1.0 + alpha);
                let expected = -(numerator / denominator).arg();
                let (_, found) = answer(config, imu_hz, radps);
                assert!(
                    (found - expected).abs() < 1e-4 + 2e-3 * expected,
                    "{imu_hz} {radps}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn what_is_slow_is_late_by_the_delay_that_the_notch_itself_reports() {
        let found = NotchCost::new(NotchConfig::at_hz(25.0).with_width_hz(5.0), 200.0).unwrap();
        assert_abs_diff_eq!(found.delay_s, 1.3e-3, epsilon = 1e-4);
        let (_, lag_rad) = answer(found.config, 200.0, 3.0);
        assert_abs_diff_eq!(lag_rad / (3.0 * found.delay_s), 1.0, epsilon = 0.01);
        // At 33 Hz the alias of 32 Hz is not distinguishable from the vehicle's motion: the notch does not remove it.
        assert_eq!(NotchCost::new(NotchConfig::at_hz(32.0), 33.0).unwrap().delay_s, 0.0);
        assert!(NotchCost::new(NotchConfig::at_hz(f64::NAN), 33.0).is_err());
        assert!(NotchCost::new(NotchConfig::at_hz(25.0), 1.0).is_err());
    }
}
