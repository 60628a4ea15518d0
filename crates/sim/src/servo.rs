//! A simulated servo, with its true position.

use super::check::{Checked, ConfigError, positive, size};

/// Settings of the servos, which are identical. The default is a digital servo of a 60-class helicopter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoConfig {
    /// Corner of the first-order response to small commands, Hz; infinite without a lag.
    pub bandwidth_hz: f64,
    /// Highest speed, stick units (full travel is 1) per second; infinite without a limit.
    pub rate_per_s: f64,
    /// Largest error that does not move the servo, stick units; 0 for no dead band.
    pub dead_band: f64,
    /// Resolution of the pulse width, stick units; 0 for unlimited.
    pub resolution: f64,
}

impl Default for ServoConfig {
    /// A speed of 0.1 s for 45°, with full travel of 30° to each side. Pulses of 400 µs for full travel in steps of 1
    /// µs, and a dead band of 1.5 µs.
    fn default() -> Self {
        Self {
            bandwidth_hz: 8.0,
            rate_per_s: 15.0,
            dead_band: 1.5 / 400.0,
            resolution: 1.0 / 400.0,
        }
    }
}

impl ServoConfig {
    /// A servo without lag, limit or dead band.
    pub const IDEAL: Self = Self {
        bandwidth_hz: f64::INFINITY,
        rate_per_s: f64::INFINITY,
        dead_band: 0.0,
        resolution: 0.0,
    };

    fn check(&self) -> Checked {
        const SENSOR: &str = "servo";
        positive(SENSOR, "bandwidth", self.bandwidth_hz)?;
        positive(SENSOR, "rate", self.rate_per_s)?;
        size(SENSOR, "dead band", self.dead_band)?;
        size(SENSOR, "resolution", self.resolution)
    }
}

/// A running servo.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedServo {
    config: ServoConfig,
    /// Position of the servo, stick units.
    position: f64,
}

impl SimulatedServo {
    /// A servo at `position`, limited to ±1.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn new(config: &ServoConfig, position: f64) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config: *config, position: position.clamp(-1.0, 1.0) })
    }

    /// Position after `interval_s` under `command`.
    ///
    /// # Source
    /// Equation (W5) of docs/equations.md.
    pub fn step(&mut self, command: f64, interval_s: f64) -> f64 {
        let ServoConfig { bandwidth_hz, rate_per_s, dead_band, resolution } = self.config;
        let target = command.clamp(-1.0, 1.0);
        let target =
            if resolution > 0.0 { (target / resolution).round() * resolution } else { target };
        let error = target - self.position;
        if error.abs() > dead_band {
            let answered = 1.0 - (-core::f64::consts::TAU * bandwidth_hz * interval_s).exp();
            let fastest = rate_per_s * interval_s;
            self.position += (answered * error).clamp(-fastest, fastest);
        }
        self.position
    }

    /// Position of the servo.
    #[must_use]
    pub const fn position(&self) -> f64 {
        self.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_small_step_is_answered_with_the_time_constant() {
        let config = ServoConfig { dead_band: 0.0, resolution: 0.0, ..ServoConfig::default() };
        let mut servo = SimulatedServo::new(&config, 0.0).unwrap();
        let lag_s = 1.0 / (core::f64::consts::TAU * config.bandwidth_hz);
        for _ in 0..100 {
            servo.step(0.01, lag_s / 100.0);
        }
        assert_abs_diff_eq!(servo.position() / 0.01, 1.0 - (-1f64).exp(), epsilon = 1e-9);
    }

    #[test]
    fn a_large_step_takes_the_time_of_the_rate() {
        let mut servo = SimulatedServo::new(&ServoConfig::default(), -1.0).unwrap();
        for _ in 0..60 {
            servo.step(1.0, 1e-3);
        }
        assert_abs_diff_eq!(servo.position() + 1.0, 15.0 * 0.06, epsilon = 1e-9);
    }

    #[test]
    fn errors_within_the_dead_band_do_not_move_it() {
        let config = ServoConfig { resolution: 0.0, ..ServoConfig::default() };
        let mut servo = SimulatedServo::new(&config, 0.2).unwrap();
        servo.step(0.2 + 0.9 * config.dead_band, 1.0);
        assert_eq!(servo.position(), 0.2);
    }
}
