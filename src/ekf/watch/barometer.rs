//! Level and noise of a barometer, kept outside the filter's states.

use super::OUTLIER_SIGMAS;
use crate::matrix::square;

/// A barometer's level and scatter.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct Barometer {
    /// First reading minus the filter's height, m.
    level_m: f32,
    /// The last reading, m.
    reading_m: f32,
    /// Residual of the last reading after its update, m.
    left_m: f32,
    /// Variance of the readings' noise, m²; zero before the first reading.
    variance: f32,
}

/// Averaging time of the scatter, s: a hundred readings of most barometers.
const SCATTER_S: f64 = 10.0;
/// Largest weight of one reading in the variance.
const MAX_SHARE: f64 = 0.05;
/// Longest time, s, for which a logger repeats a reading; longer repetitions come from a coarse resolution.
const HELD_S: f64 = 1.2;
/// Initial one-sigma of the noise, in multiples of the stated one-sigma.
const UNKNOWN: f64 = 2.0;
/// Largest one-sigma of the noise, in multiples of the stated one-sigma.
const MAX_SIGMAS: f64 = 10.0;

impl Barometer {
    /// State before the first reading.
    pub const BEFORE_FIRST_READING: Self =
        Self { level_m: 0.0, reading_m: f32::NAN, left_m: 0.0, variance: 0.0 };

    /// Sets the level: the first reading is `level_m` above the filter's height. The stated one-sigma of the noise is
    /// `noise_m`.
    pub fn start(&mut self, level_m: f64, noise_m: f64) {
        self.level_m = level_m as f32;
        self.variance = (square(UNKNOWN * noise_m) as f32).max(f32::MIN_POSITIVE);
    }

    /// Whether a reading has been received.
    pub fn has_reading(&self) -> bool {
        self.variance > 0.0
    }

    /// Level of the barometer, m.
    pub fn level_m(&self) -> f64 {
        f64::from(self.level_m)
    }

    /// Whether a reading, `elapsed_s` after the last one used, repeats the previous value. A logger that writes faster
    /// than the barometer measures adds no information.
    pub fn repeats(&mut self, reading_m: f64, elapsed_s: f64) -> bool {
        let before_m = core::mem::replace(&mut self.reading_m, reading_m as f32);
        before_m == self.reading_m && elapsed_s < HELD_S
    }

    /// Feeds the innovation `innovation_m` of a reading, `interval_s` after the previous one. `explained`, m², is the
    /// variance from airspeed pressure and from motion unknown to the filter during that interval. Returns the variance
    /// of the barometer's white error, m², as [`noise_variance`](Self::noise_variance) does.
    ///
    /// The filter's errors persist from one reading to the next. The part of a residual that is absent in the next
    /// residual is the barometer's white error.
    ///
    /// # Source
    /// Equation (M18) of docs/equations.md.
    pub fn scatter(
        &mut self,
        innovation_m: f64,
        interval_s: f64,
        explained: f64,
        noise_m: f64,
    ) -> f64 {
        let known = f64::from(self.variance).max(square(noise_m));
        let differs = 0.5 * square(innovation_m - f64::from(self.left_m)) - explained;
        let counted = differs.max(0.0).min(square(OUTLIER_SIGMAS) * known);
        let share = (interval_s / SCATTER_S).clamp(0.0, MAX_SHARE);
        self.variance += (share * (counted - f64::from(self.variance))) as f32;
        self.noise_variance(noise_m)
    }

    /// Variance of the white error from the observed scatter, m². It is between 1 and [`MAX_SIGMAS`]² times the square of
    /// `noise_m`.
    pub fn noise_variance(&self, noise_m: f64) -> f64 {
        let least = square(noise_m);
        f64::from(self.variance).max(least).min(square(MAX_SIGMAS) * least)
    }

    /// Stores the residual of a reading after its update, m, for comparison with the next reading.
    pub fn compared(&mut self, left_m: f64) {
        self.left_m = left_m as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Learned one-sigma after a minute at 10 Hz. The reading error is ±`scatter_m`; half of the readings keep the sign
    /// of the previous one. The filter's height drifts at `drift_mps`, and every hundredth reading has an outlier of 50
    /// m.
    fn learned_m(scatter_m: f64, drift_mps: f64) -> f64 {
        let mut barometer = Barometer::BEFORE_FIRST_READING;
        barometer.start(7.0, 0.5);
        let mut noise_m = f64::NAN;
        for reading in 0..600 {
            let side = if reading % 4 < 2 { 1.0 } else { -1.0 };
            let spike_m = if reading % 100 == 50 { 50.0 } else { 0.0 };
            let off_m = side * scatter_m + 0.1 * drift_mps * f64::from(reading) + spike_m;
            noise_m = barometer.scatter(off_m, 0.1, 0.0, 0.5).sqrt();
            barometer.compared(off_m);
        }
        noise_m
    }

    #[test]
    fn a_barometer_is_as_noisy_as_it_scatters_and_no_less_than_it_is_said_to_be() {
        for scatter_m in [1.0, 2.0] {
            let learned_m = learned_m(scatter_m, 0.0);
            assert!((learned_m / scatter_m - 1.0).abs() < 0.15, "{learned_m} of {scatter_m}");
        }
        assert!((learned_m(0.2, 0.0) - 0.5).abs() < 1e-3);
        assert!((learned_m(100.0, 0.0) - 5.0).abs() < 1e-3);
    }

    #[test]
    fn a_height_that_runs_away_is_no_scatter() {
        assert!((learned_m(0.2, 2.0) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn a_reading_that_a_logger_repeats_counts_once_and_one_of_coarse_steps_again_after_a_while() {
        let mut barometer = Barometer::BEFORE_FIRST_READING;
        let repeats = [(400.5, 0.02), (400.5, 0.02), (400.5, 1.3), (401.0, 0.02), (401.0, 0.5)]
            .map(|(reading_m, elapsed_s)| barometer.repeats(reading_m, elapsed_s));
        assert_eq!(repeats, [false, true, false, false, true]);
    }
}
