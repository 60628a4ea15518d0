//! A simulated barometer.

use hovernav::glam::DVec3;

use super::check::{Checked, ConfigError, frequency, positive, size};
use super::noise::{GaussMarkov, Noise, Stream};

/// Settings of the barometer. The default is a small MEMS barometer under a rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaroConfig {
    /// Samples per second.
    pub rate_hz: f64,
    /// Standard deviation of the white noise, m.
    pub noise_m: f64,
    /// Standard deviation of the slow error (Gauss-Markov), m.
    pub wander_m: f64,
    /// Correlation time of the slow error, s.
    pub wander_time_s: f64,
}

impl Default for BaroConfig {
    fn default() -> Self {
        Self { rate_hz: 10.0, noise_m: 0.4, wander_m: 1.0, wander_time_s: 200.0 }
    }
}

impl BaroConfig {
    fn check(&self) -> Checked {
        const SENSOR: &str = "barometer";
        frequency(SENSOR, "rate", self.rate_hz)?;
        size(SENSOR, "noise", self.noise_m)?;
        size(SENSOR, "wander", self.wander_m)?;
        positive(SENSOR, "correlation time", self.wander_time_s)
    }
}

/// A running barometer.
#[derive(Clone, Debug)]
pub struct SimulatedBaro {
    noise: Noise,
    noise_m: f64,
    wander: GaussMarkov,
}

impl SimulatedBaro {
    /// A barometer switched on, with its errors drawn from `seed`.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn new(config: &BaroConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let mut noise = Noise::new(seed, Stream::Baro);
        let sigma = DVec3::X * config.wander_m;
        let period_s = 1.0 / config.rate_hz;
        let wander = GaussMarkov::new(sigma, config.wander_time_s, period_s, &mut noise);
        Ok(Self { noise, noise_m: config.noise_m, wander })
    }

    /// Measured height for the true one, m.
    pub fn measure(&mut self, height_m: f64) -> f64 {
        height_m + self.wander.next(&mut self.noise).x + self.noise_m * self.noise.normal()
    }
}
