//! Three gyros, or three accelerometers, with their errors.

use core::f64::consts::TAU;

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::glam::DVec3;

use super::check::{Checked, positive, size};
use super::noise::{GaussMarkov, Noise};

/// Errors of the three gyros, identical in distribution and independent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroConfig {
    /// Standard deviation of the constant bias drawn at turn-on, °/s.
    pub turn_on_bias_sigma_degps: f64,
    /// Standard deviation of the drifting bias (Gauss-Markov), °/s.
    pub wandering_bias_sigma_degps: f64,
    /// Correlation time of the drifting bias, s.
    pub wandering_bias_time_s: f64,
    /// White noise of the rate, °/√h.
    pub angle_random_walk_deg_per_sqrt_h: f64,
    /// Standard deviation of the scale factor error, drawn at turn-on, as a fraction.
    pub scale_factor_sigma: f64,
    /// Resolution of the output, °/s; 0 for unlimited. For increments it applies to the mean rate over a sample, and
    /// the rounding error is carried over to the next sample.
    pub resolution_degps: f64,
    /// Largest output, °/s; infinite without a limit.
    pub range_degps: f64,
    /// Corner of the first-order low-pass, Hz; infinite without a low-pass.
    pub bandwidth_hz: f64,
}

/// Errors of the three accelerometers, identical in distribution and independent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerometerConfig {
    /// Standard deviation of the constant bias drawn at turn-on, m/s².
    pub turn_on_bias_sigma_mps2: f64,
    /// Standard deviation of the drifting bias (Gauss-Markov), m/s².
    pub wandering_bias_sigma_mps2: f64,
    /// Correlation time of the drifting bias, s.
    pub wandering_bias_time_s: f64,
    /// White noise of the specific force, m/s/√h.
    pub velocity_random_walk_mps_per_sqrt_h: f64,
    /// Standard deviation of the scale factor error, drawn at turn-on, as a fraction.
    pub scale_factor_sigma: f64,
    /// Resolution of the output, m/s²; 0 for unlimited. For increments it applies to the mean over a sample, and the
    /// rounding error is carried over to the next sample.
    pub resolution_mps2: f64,
    /// Largest output, m/s²; infinite without a limit.
    pub range_mps2: f64,
    /// Corner of the first-order low-pass, Hz; infinite without a low-pass.
    pub bandwidth_hz: f64,
}

impl Default for GyroConfig {
    fn default() -> Self {
        Self {
            turn_on_bias_sigma_degps: 0.25,
            wandering_bias_sigma_degps: 0.02,
            wandering_bias_time_s: 200.0,
            angle_random_walk_deg_per_sqrt_h: 2.25,
            scale_factor_sigma: 0.005,
            resolution_degps: 200.0 * 1.5 / 32_768.0,
            range_degps: 200.0,
            bandwidth_hz: 25.0,
        }
    }
}

impl GyroConfig {
    /// Gyros without errors.
    pub const IDEAL: Self = Self {
        turn_on_bias_sigma_degps: 0.0,
        wandering_bias_sigma_degps: 0.0,
        wandering_bias_time_s: 1.0,
        angle_random_walk_deg_per_sqrt_h: 0.0,
        scale_factor_sigma: 0.0,
        resolution_degps: 0.0,
        range_degps: f64::INFINITY,
        bandwidth_hz: f64::INFINITY,
    };

    pub(super) fn errors(&self) -> TriadErrors {
        TriadErrors {
            bias_sigma: self.turn_on_bias_sigma_degps.to_radians(),
            wander_sigma: self.wandering_bias_sigma_degps.to_radians(),
            wander_time_s: self.wandering_bias_time_s,
            random_walk: self.angle_random_walk_deg_per_sqrt_h.to_radians() / 60.0,
            scale_sigma: self.scale_factor_sigma,
            resolution: self.resolution_degps.to_radians(),
            range: self.range_degps.to_radians(),
            bandwidth_hz: self.bandwidth_hz,
        }
    }
}

impl Default for AccelerometerConfig {
    fn default() -> Self {
        Self {
            turn_on_bias_sigma_mps2: 0.09,
            wandering_bias_sigma_mps2: 0.01,
            wandering_bias_time_s: 200.0,
            velocity_random_walk_mps_per_sqrt_h: 0.45,
            scale_factor_sigma: 0.005,
            resolution_mps2: 4.0 * STANDARD_GRAVITY_MPS2 * 1.5 / 32_768.0,
            range_mps2: 4.0 * STANDARD_GRAVITY_MPS2,
            bandwidth_hz: 75.0,
        }
    }
}

impl AccelerometerConfig {
    /// Accelerometers without errors.
    pub const IDEAL: Self = Self {
        turn_on_bias_sigma_mps2: 0.0,
        wandering_bias_sigma_mps2: 0.0,
        wandering_bias_time_s: 1.0,
        velocity_random_walk_mps_per_sqrt_h: 0.0,
        scale_factor_sigma: 0.0,
        resolution_mps2: 0.0,
        range_mps2: f64::INFINITY,
        bandwidth_hz: f64::INFINITY,
    };

    pub(super) fn errors(&self) -> TriadErrors {
        TriadErrors {
            bias_sigma: self.turn_on_bias_sigma_mps2,
            wander_sigma: self.wandering_bias_sigma_mps2,
            wander_time_s: self.wandering_bias_time_s,
            random_walk: self.velocity_random_walk_mps_per_sqrt_h / 60.0,
            scale_sigma: self.scale_factor_sigma,
            resolution: self.resolution_mps2,
            range: self.range_mps2,
            bandwidth_hz: self.bandwidth_hz,
        }
    }
}

/// Errors of a triad of gyros (rad, s) or of accelerometers (m, s).
#[derive(Clone, Copy, Debug)]
pub(super) struct TriadErrors {
    bias_sigma: f64,
    wander_sigma: f64,
    wander_time_s: f64,
    random_walk: f64,
    scale_sigma: f64,
    resolution: f64,
    range: f64,
    bandwidth_hz: f64,
}

impl TriadErrors {
    pub(super) fn check(&self, sensor: &'static str) -> Checked {
        size(sensor, "turn-on bias", self.bias_sigma)?;
        size(sensor, "wandering bias", self.wander_sigma)?;
        positive(sensor, "correlation time of the bias", self.wander_time_s)?;
        size(sensor, "random walk", self.random_walk)?;
        size(sensor, "scale factor", self.scale_sigma)?;
        size(sensor, "resolution", self.resolution)?;
        positive(sensor, "range", self.range)?;
        positive(sensor, "bandwidth", self.bandwidth_hz)
    }

    /// Time constant of the low-pass, s.
    pub(super) fn lag_s(&self) -> f64 {
        1.0 / (TAU * self.bandwidth_hz)
    }
}

/// Three running sensors, in rad/s or m/s².
#[derive(Clone, Debug)]
pub(super) struct Triad {
    noise: Noise,
    scale: DVec3,
    bias: DVec3,
    wander: GaussMarkov,
    white_sigma: f64,
    range: f64,
    resolution: f64,
    low_pass: LowPass,
    /// Accumulated rounding error of the increments, in steps of the resolution.
    omitted: DVec3,
}

impl Triad {
    pub(super) fn new(errors: &TriadErrors, period_s: f64, mut noise: Noise) -> Self {
        let wander_sigma = DVec3::splat(errors.wander_sigma);
        Self {
            scale: 1.0 + errors.scale_sigma * noise.normal3(),
            bias: errors.bias_sigma * noise.normal3(),
            wander: GaussMarkov::new(wander_sigma, errors.wander_time_s, period_s, &mut noise),
            white_sigma: errors.random_walk / period_s.sqrt(),
            range: errors.range,
            resolution: errors.resolution,
            low_pass: LowPass::new(errors.lag_s(), period_s),
            omitted: DVec3::ZERO,
            noise,
        }
    }

    /// Output of the sensors for a true input: `motion` passes through the low-pass here, `vibration` has passed it
    /// already. With `carry`, the rounding error is carried over to the next sample.
    ///
    /// # Source
    /// Equation (W2) of docs/equations.md.
    pub(super) fn measure(&mut self, motion: DVec3, vibration: DVec3, carry: bool) -> DVec3 {
        let filtered = self.low_pass.next(motion) + vibration;
        let error =
            self.bias + self.wander.next(&mut self.noise) + self.white_sigma * self.noise.normal3();
        let value = (self.scale * filtered + error)
            .clamp(DVec3::splat(-self.range), DVec3::splat(self.range));
        if self.resolution == 0.0 {
            return value;
        }
        let steps = value / self.resolution + self.omitted;
        let whole = steps.round();
        if carry {
            self.omitted = steps - whole;
        }
        whole * self.resolution
    }
}

/// A first-order low-pass, exact for a signal that is linear between samples.
#[derive(Clone, Debug)]
struct LowPass {
    keep: f64,
    before: f64,
    now: f64,
    state: Option<(DVec3, DVec3)>,
}

impl LowPass {
    fn new(lag_s: f64, period_s: f64) -> Self {
        let keep = (-period_s / lag_s).exp();
        let mean = (1.0 - keep) * lag_s / period_s;
        Self { keep, before: mean - keep, now: 1.0 - mean, state: None }
    }

    fn next(&mut self, input: DVec3) -> DVec3 {
        let output = match self.state {
            Some((last, output)) => output * self.keep + last * self.before + input * self.now,
            None => input,
        };
        self.state = Some((input, output));
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Stream;
    use approx::assert_abs_diff_eq;

    const PERIOD_S: f64 = 0.01;

    fn gyros(config: GyroConfig, seed: u64) -> Triad {
        Triad::new(&config.errors(), PERIOD_S, Noise::new(seed, Stream::Gyro))
    }

    fn still(triad: &mut Triad) -> DVec3 {
        triad.measure(DVec3::ZERO, DVec3::ZERO, false)
    }

    /// Root mean square over axes and samples.
    fn rms(values: &[DVec3]) -> f64 {
        let squares: f64 = values.iter().map(|value| value.length_squared()).sum();
        (squares / (3 * values.len()) as f64).sqrt()
    }

    #[test]
    fn white_noise_averages_down_with_the_root_of_time() {
        let config = GyroConfig { angle_random_walk_deg_per_sqrt_h: 3.0, ..GyroConfig::IDEAL };
        let mut triad = gyros(config, 4);
        let values: Vec<DVec3> = (0..100_000).map(|_| still(&mut triad)).collect();
        let walk = 3f64.to_radians() / 60.0;
        // The Allan deviation of white noise is its random walk over the root of the time.
        for samples in [1, 10, 100, 1000] {
            let means: Vec<DVec3> = values
                .chunks(samples)
                .map(|chunk| chunk.iter().sum::<DVec3>() / samples as f64)
                .collect();
            let steps: Vec<DVec3> = means.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let allan_deviation = rms(&steps) / 2f64.sqrt();
            let expected = walk / (samples as f64 * PERIOD_S).sqrt();
            let scatter = 4.0 / (means.len() as f64).sqrt() + 0.01;
            assert!((allan_deviation / expected - 1.0).abs() < scatter, "over {samples}");
        }
    }

    #[test]
    fn velocity_random_walk_is_the_scatter_of_the_integral() {
        let config = AccelerometerConfig {
            velocity_random_walk_mps_per_sqrt_h: 0.6,
            ..AccelerometerConfig::IDEAL
        };
        let velocities: Vec<DVec3> = (0..1000)
            .map(|seed| {
                let noise = Noise::new(seed, Stream::Accelerometer);
                let mut triad = Triad::new(&config.errors(), PERIOD_S, noise);
                (0..400).map(|_| still(&mut triad) * PERIOD_S).sum()
            })
            .collect();
        // 0.6 m/s/√h is 0.01 m/s/√s: 0.02 m/s after 4 s.
        assert_abs_diff_eq!(rms(&velocities) / 0.02, 1.0, epsilon = 0.06);
    }

    #[test]
    fn turn_on_bias_scatters_over_seeds_and_stays() {
        let config = GyroConfig { turn_on_bias_sigma_degps: 0.5, ..GyroConfig::IDEAL };
        let biases: Vec<DVec3> = (0..1000)
            .map(|seed| {
                let mut triad = gyros(config, seed);
                let bias = still(&mut triad);
                assert!((0..100).all(|_| still(&mut triad) == bias));
                bias
            })
            .collect();
        assert_abs_diff_eq!(rms(&biases) / 0.5f64.to_radians(), 1.0, epsilon = 0.06);
    }

    #[test]
    fn wandering_bias_has_its_size_and_its_time() {
        let config = GyroConfig {
            wandering_bias_sigma_degps: 0.1,
            wandering_bias_time_s: 0.5,
            ..GyroConfig::IDEAL
        };
        let mut triad = gyros(config, 9);
        let values: Vec<DVec3> = (0..300_000).map(|_| still(&mut triad)).collect();
        let sigma = 0.1f64.to_radians();
        assert_abs_diff_eq!(rms(&values) / sigma, 1.0, epsilon = 0.05);
        let one_time_apart: Vec<DVec3> =
            values.windows(51).map(|window| window[50] - window[0]).collect();
        let expected = sigma * (2.0 * (1.0 - (-1f64).exp())).sqrt();
        assert_abs_diff_eq!(rms(&one_time_apart) / expected, 1.0, epsilon = 0.05);
    }

    #[test]
    fn scale_factor_errors_scatter_over_seeds_and_multiply() {
        let config = GyroConfig { scale_factor_sigma: 0.01, ..GyroConfig::IDEAL };
        let errors: Vec<DVec3> = (0..1000)
            .map(|seed| {
                let mut triad = gyros(config, seed);
                let [one, two] = [1.0, 2.0].map(|rate| {
                    triad.measure(DVec3::splat(rate), DVec3::ZERO, false) - DVec3::splat(rate)
                });
                assert!((two - 2.0 * one).length() < 1e-14);
                one
            })
            .collect();
        assert_abs_diff_eq!(rms(&errors) / 0.01, 1.0, epsilon = 0.06);
    }

    #[test]
    fn rates_come_in_whole_steps_within_the_range() {
        let config = GyroConfig { resolution_degps: 0.5, range_degps: 100.0, ..GyroConfig::IDEAL };
        let mut triad = gyros(config, 1);
        let mut shown = |degps: f64| {
            let rate = DVec3::splat(degps.to_radians());
            triad.measure(rate, DVec3::ZERO, false).x.to_degrees()
        };
        for (rate, expected) in [(0.24, 0.0), (0.26, 0.5), (-33.3, -33.5), (99.9, 100.0)] {
            assert_abs_diff_eq!(shown(rate), expected, epsilon = 1e-12);
        }
        for (rate, expected) in [(100.3, 100.0), (1e4, 100.0), (-250.0, -100.0)] {
            assert_abs_diff_eq!(shown(rate), expected, epsilon = 1e-12);
        }
    }

    #[test]
    fn increments_carry_over_what_rounding_leaves_out() {
        let config = GyroConfig { resolution_degps: 0.5, ..GyroConfig::IDEAL };
        let mut triad = gyros(config, 1);
        let rate = DVec3::new(0.11, -0.2, 3.33) * 1f64.to_radians();
        let sum: DVec3 = (0..1000).map(|_| triad.measure(rate, DVec3::ZERO, true)).sum();
        assert!((sum - 1000.0 * rate).abs().max_element() < 0.26f64.to_radians());
    }

    #[test]
    fn the_low_pass_lags_a_ramp_by_its_time_constant_and_halves_power_at_its_corner() {
        let config = GyroConfig { bandwidth_hz: 5.0, ..GyroConfig::IDEAL };
        let lag_s = 1.0 / (TAU * 5.0);
        let mut triad = gyros(config, 1);
        let ramp = |time_s: f64| DVec3::new(1.0, -2.0, 0.5) * time_s;
        let shown =
            (0..200).map(|k| triad.measure(ramp(f64::from(k) * PERIOD_S), DVec3::ZERO, false));
        let off = shown.last().unwrap() - ramp(1.99 - lag_s);
        assert!(off.length() < 1e-12);

        let mut triad = gyros(config, 1);
        let shown: Vec<DVec3> = (0..2000)
            .map(|k| DVec3::splat((TAU * 5.0 * f64::from(k) * PERIOD_S).sin()))
            .map(|rate| triad.measure(rate, DVec3::ZERO, false))
            .collect();
        // Linear interpolation between the 20 samples of a cycle reduces the amplitude by 1 %.
        assert_abs_diff_eq!(rms(&shown[1000..]), 0.5, epsilon = 0.01);
    }
}
