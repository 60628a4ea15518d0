//! What is known of a barometer beside the states: its level, and how much its readings scatter.

use super::square;

/// A barometer's level and scatter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Barometer {
    /// How much higher the first reading was than the filter's height, m.
    level_m: f32,
    /// The last reading, m.
    reading_m: f32,
    /// What was left of the last reading when it had been compared, m.
    left_m: f32,
    /// Variance by which readings scatter, m²; none before the first.
    variance: f32,
}

/// Memory of the scatter, s: a hundred readings of most barometers.
const SCATTER_S: f64 = 10.0;
/// A reading counts no more than so many one-sigmas: outliers are no scatter.
const MOST_SIGMAS: f64 = 3.0;
/// Nor moves it the scatter by more than such a share.
const MOST_SHARE: f64 = 0.05;
/// A reading that is told for longer, s, is one of coarse steps.
const HELD_S: f64 = 1.2;
/// One that is not known yet may scatter by so many times what it is said to.
const UNKNOWN: f64 = 2.0;
/// No barometer scatters by more than so many times what it is said to.
const MOST: f64 = 10.0;

impl Barometer {
    /// One that has not been heard.
    pub const UNHEARD: Self =
        Self { level_m: 0.0, reading_m: f32::NAN, left_m: 0.0, variance: 0.0 };

    /// One whose first reading was `level_m` higher than the filter's height, and that is said to scatter by a one-sigma of
    /// `noise_m`.
    pub fn at(level_m: f64, noise_m: f64) -> Self {
        let variance = (square(UNKNOWN * noise_m) as f32).max(f32::MIN_POSITIVE);
        Self { level_m: level_m as f32, variance, ..Self::UNHEARD }
    }

    /// Whether it has been heard.
    pub fn is_heard(&self) -> bool {
        self.variance > 0.0
    }

    /// Its level, m.
    pub fn level_m(&self) -> f64 {
        f64::from(self.level_m)
    }

    /// Whether a reading, `elapsed_s` after the last that was taken in, repeats the one before: a logger that writes more often
    /// than the barometer measures tells nothing new.
    pub fn repeats(&mut self, reading_m: f64, elapsed_s: f64) -> bool {
        let before_m = core::mem::replace(&mut self.reading_m, reading_m as f32);
        before_m == self.reading_m && elapsed_s < HELD_S
    }

    /// Takes in that a reading, `interval_s` after the last, is off by `innovation_m`; the wind of the vehicle's own speed and
    /// what the filter does not know of its motion explain a variance of `explained` since then, m². Gives the variance of
    /// the barometer's white error, m²: as its readings scatter, and no less than that of `noise_m`.
    ///
    /// What the filter got wrong is still as wrong a moment later; what is left of one reading and is not found in
    /// the next is the barometer's own.
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
        let counted = differs.max(0.0).min(square(MOST_SIGMAS) * known);
        let share = (interval_s / SCATTER_S).clamp(0.0, MOST_SHARE);
        self.variance += (share * (counted - f64::from(self.variance))) as f32;
        self.noise_variance(noise_m)
    }

    /// Variance of its white error as its readings have scattered, m², and no less than that of `noise_m`.
    pub fn noise_variance(&self, noise_m: f64) -> f64 {
        let least = square(noise_m);
        f64::from(self.variance).max(least).min(square(MOST) * least)
    }

    /// Notes what was left of a reading when it had been compared, m.
    pub fn compared(&mut self, left_m: f64) {
        self.left_m = left_m as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One-sigma that is learned in a minute at 10 Hz of readings that are off by ±`scatter_m`, as often alike as not, while
    /// the filter's height runs away at `drift_mps`, and every hundredth reading is off by 50 m besides.
    fn learned_m(scatter_m: f64, drift_mps: f64) -> f64 {
        let mut barometer = Barometer::at(7.0, 0.5);
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
        let mut barometer = Barometer::at(0.0, 0.5);
        let repeats = [(400.5, 0.02), (400.5, 0.02), (400.5, 1.3), (401.0, 0.02), (401.0, 0.5)]
            .map(|(reading_m, elapsed_s)| barometer.repeats(reading_m, elapsed_s));
        assert_eq!(repeats, [false, true, false, false, true]);
    }
}
