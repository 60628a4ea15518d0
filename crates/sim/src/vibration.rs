//! Vibration of engine and rotors, as a sampled and filtered inertial unit measures it.

use core::f64::consts::TAU;

use hovernav::glam::DVec3;

use hovernav::frames::{Body, Vector};

use super::check::{Checked, finite_vector, frequency, positive, size};
use super::noise::{GaussMarkov, Noise};

/// A rotating part, and its vibration at the inertial unit.
#[derive(Clone, Debug, PartialEq)]
pub struct VibrationSource {
    /// Mean revolutions per second, Hz, above zero.
    pub frequency_hz: f64,
    /// Standard deviation of the slow drift of the frequency, Hz.
    pub wander_sigma_hz: f64,
    /// Correlation time of the drift, s.
    pub wander_time_s: f64,
    /// Harmonics of the vibration.
    pub harmonics: Vec<Harmonic>,
}

/// One sinusoid of a source. All components are in phase, or in antiphase where their signs differ. The vibration is
/// along one line and about one axis, so it causes neither coning nor sculling. The truth, without vibration, remains
/// the mean of the measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Cycles per revolution of the source: 2 for the blade passage of a two-bladed rotor, a gear ratio for a geared
    /// part.
    pub order: f64,
    /// Amplitude of the angular rate, °/s.
    pub angular_rate_degps: Vector<Body>,
    /// Amplitude of the specific force, m/s².
    pub specific_force_mps2: Vector<Body>,
}

impl VibrationSource {
    /// A 60-class helicopter in hover: main rotor (1 and 2 per revolution), tail rotor and engine,
    /// geared together and governed.
    ///
    /// # Source
    /// Frequencies and amplitudes as they alias into the 33 Hz samples of the `heli-hover` data set.
    #[must_use]
    pub fn helicopter() -> Self {
        let harmonic = |order, angular_rate_degps, specific_force_mps2| Harmonic {
            order,
            angular_rate_degps: Vector::from(angular_rate_degps),
            specific_force_mps2: Vector::from(specific_force_mps2),
        };
        Self {
            frequency_hz: 26.6,
            wander_sigma_hz: 0.05,
            wander_time_s: 20.0,
            harmonics: vec![
                harmonic(1.0, [1.0, -0.9, 0.6], [0.8, 0.8, -0.5]),
                harmonic(2.0, [1.6, 1.6, -0.8], [0.9, -0.9, 1.7]),
                harmonic(4.6, [-1.0, 1.0, 2.0], [0.5, 0.5, 0.4]),
                harmonic(9.0, [3.0, 3.0, 2.0], [1.4, -1.3, 1.8]),
            ],
        }
    }

    pub(super) fn check(&self) -> Checked {
        const SENSOR: &str = "vibration";
        frequency(SENSOR, "frequency", self.frequency_hz)?;
        size(SENSOR, "wander", self.wander_sigma_hz)?;
        positive(SENSOR, "correlation time of the frequency", self.wander_time_s)?;
        self.harmonics.iter().try_for_each(|harmonic| {
            size(SENSOR, "order", harmonic.order)?;
            finite_vector(SENSOR, "angular rate", harmonic.angular_rate_degps)?;
            finite_vector(SENSOR, "specific force", harmonic.specific_force_mps2)
        })
    }
}

/// A running source.
#[derive(Clone, Debug)]
pub(super) struct RunningSource {
    source: VibrationSource,
    wander: GaussMarkov,
    phases_rad: Vec<f64>,
}

impl RunningSource {
    pub(super) fn new(source: &VibrationSource, period_s: f64, noise: &mut Noise) -> Self {
        let sigma = DVec3::X * source.wander_sigma_hz;
        Self {
            wander: GaussMarkov::new(sigma, source.wander_time_s, period_s, noise),
            // A normal deviate of many turns is a uniform phase.
            phases_rad: source.harmonics.iter().map(|_| 100.0 * noise.normal()).collect(),
            source: source.clone(),
        }
    }

    /// Angular rate, rad/s, and specific force, m/s², after first-order low-passes with the two time constants. The
    /// values are those at the end of the next `step_s`, or the mean over it.
    ///
    /// # Source
    /// Equation (W6) of docs/equations.md.
    pub(super) fn next(
        &mut self,
        step_s: f64,
        mean: bool,
        [gyro_lag_s, accelerometer_lag_s]: [f64; 2],
        noise: &mut Noise,
    ) -> [DVec3; 2] {
        let frequency_hz = self.source.frequency_hz + self.wander.next(noise).x;
        let mut shaking = [DVec3::ZERO; 2];
        for (harmonic, phase) in self.source.harmonics.iter().zip(&mut self.phases_rad) {
            let rate_radps = TAU * frequency_hz * harmonic.order;
            let (sin_before, cos_before) = phase.sin_cos();
            *phase += rate_radps * step_s;
            let (sin, cos) = phase.sin_cos();
            let turned = rate_radps * step_s;
            let [in_phase, quadrature] = if mean && turned != 0.0 {
                [(cos_before - cos) / turned, (sin - sin_before) / turned]
            } else {
                [sin, cos]
            };
            let passed = |lag_s: f64| {
                let lag = rate_radps * lag_s;
                (in_phase - lag * quadrature) / (1.0 + lag * lag)
            };
            let angular_rate = harmonic.angular_rate_degps.components() * 1f64.to_radians();
            shaking[0] += angular_rate * passed(gyro_lag_s);
            shaking[1] += harmonic.specific_force_mps2.components() * passed(accelerometer_lag_s);
        }
        shaking
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Stream;
    use approx::assert_abs_diff_eq;

    fn source(frequency_hz: f64) -> VibrationSource {
        let harmonic = Harmonic {
            order: 1.0,
            angular_rate_degps: Vector::new(2.0, -1.0, 0.5),
            specific_force_mps2: Vector::new(1.0, 0.5, -3.0),
        };
        VibrationSource {
            frequency_hz,
            wander_sigma_hz: 0.0,
            wander_time_s: 1.0,
            harmonics: vec![harmonic],
        }
    }

    fn shaking(
        source: &VibrationSource,
        rate_hz: f64,
        mean: bool,
        lags_s: [f64; 2],
        samples: usize,
    ) -> Vec<[DVec3; 2]> {
        let mut noise = Noise::new(3, Stream::Vibration);
        let mut running = RunningSource::new(source, 1.0 / rate_hz, &mut noise);
        (0..samples).map(|_| running.next(1.0 / rate_hz, mean, lags_s, &mut noise)).collect()
    }

    /// Amplitude of the sampled down component at a frequency.
    fn amplitude(samples: &[[DVec3; 2]], rate_hz: f64, frequency_hz: f64) -> f64 {
        let [mut real, mut imaginary] = [0.0; 2];
        for (k, sample) in samples.iter().enumerate() {
            let (sin, cos) = (TAU * frequency_hz * k as f64 / rate_hz).sin_cos();
            real += sample[1].z * cos;
            imaginary += sample[1].z * sin;
        }
        2.0 * f64::hypot(real, imaginary) / samples.len() as f64
    }

    #[test]
    fn a_harmonic_beyond_half_the_sample_rate_shows_at_its_alias() {
        for (true_hz, alias_hz) in [(26.6, 6.4), (53.2, 12.8), (122.0, 10.0), (10.0, 10.0)] {
            let samples = shaking(&source(true_hz), 33.0, false, [0.0; 2], 3300);
            assert!((amplitude(&samples, 33.0, alias_hz) - 3.0).abs() < 1e-9, "{true_hz} Hz");
            assert!(amplitude(&samples, 33.0, alias_hz + 1.0) < 1e-9);
        }
    }

    #[test]
    fn the_low_pass_takes_its_share() {
        let lag_s = 1.0 / (TAU * 25.0);
        for (frequency_hz, share) in [(25.0, 0.5f64.sqrt()), (50.0, 0.2f64.sqrt())] {
            let samples = shaking(&source(frequency_hz), 330.0, false, [0.0, lag_s], 3300);
            assert_abs_diff_eq!(
                amplitude(&samples, 330.0, frequency_hz) / 3.0,
                share,
                epsilon = 1e-9
            );
        }
    }

    #[test]
    fn increments_are_the_mean_over_the_sample() {
        let (source, lags_s) = (VibrationSource::helicopter(), [0.006, 0.002]);
        let source = VibrationSource { wander_sigma_hz: 0.0, ..source };
        let means = shaking(&source, 100.0, true, lags_s, 50);
        let fine = shaking(&source, 100_000.0, false, lags_s, 50_000);
        for (mean, fine) in means.iter().zip(fine.chunks(1000)) {
            for kind in [0, 1] {
                let expected = fine.iter().map(|sample| sample[kind]).sum::<DVec3>() / 1000.0;
                assert!((mean[kind] - expected).length() < 0.01 * [0.1, 4.0][kind]);
            }
        }
    }

    #[test]
    fn frequency_wanders_by_its_sigma() {
        let source = VibrationSource { wander_sigma_hz: 0.5, wander_time_s: 0.05, ..source(20.0) };
        let rate_hz = 200.0;
        let samples = shaking(&source, rate_hz, false, [0.0; 2], 400_000);
        let rises = samples.windows(2).filter(|pair| pair[0][1].z < 0.0 && pair[1][1].z >= 0.0);
        let mean_hz = rises.count() as f64 * rate_hz / samples.len() as f64;
        assert_abs_diff_eq!(mean_hz, 20.0, epsilon = 0.02);
        // The phase drifts as the integral of the frequency: 2 σ² τ t.
        let reference = |k: usize| TAU * 20.0 * k as f64 / rate_hz;
        let mut turned = Vec::new();
        for (chunk, samples) in samples.chunks(400).enumerate() {
            let phase: [f64; 2] = [0, 380].map(|start| {
                let [mut sin, mut cos] = [0.0; 2];
                for (k, sample) in samples.iter().enumerate().skip(start).take(20) {
                    sin += sample[1].z * reference(400 * chunk + k).sin();
                    cos += sample[1].z * reference(400 * chunk + k).cos();
                }
                f64::atan2(cos, sin)
            });
            turned.push(hovernav::frames::wrap_angle(phase[1] - phase[0]));
        }
        let variance = turned.iter().map(|t| t * t).sum::<f64>() / turned.len() as f64;
        let expected = TAU * TAU * 2.0 * 0.25 * 0.05 * (1.9 - 0.05);
        assert!((variance / expected - 1.0).abs() < 0.2, "{variance}, expected {expected}");
    }

    #[test]
    fn the_shaking_neither_cones_nor_sculls() {
        // Angle times rate, and angle times force, average to zero over whole cycles.
        let samples = shaking(&source(25.0), 1000.0, true, [0.0; 2], 4000);
        let [mut angle, mut coning, mut sculling] = [DVec3::ZERO; 3];
        for [rate, force] in &samples {
            let middle = angle + 0.5e-3 * *rate;
            coning += middle.cross(*rate) * 1e-3;
            sculling += middle.cross(*force) * 1e-3;
            angle += *rate * 1e-3;
        }
        assert!(coning.length() < 1e-12 && sculling.length() / 4.0 < 1e-9, "{coning} {sculling}");
    }
}
