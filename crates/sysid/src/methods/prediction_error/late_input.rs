//! Movement of an input between two samples, after a delay and a first-order lag.
//!
//! A command is held, and its delay ends between two samples. Behind a lag it moves throughout the interval. A dynamic as
//! fast as a sample responds to the shape of this movement, not only to its mean.

use nalgebra::Complex;

/// A value with its derivatives with respect to the delay and the lag.
type Sloped = [f64; 3];

/// A late input, from sample to sample.
pub(crate) struct LateInput {
    /// Weights of the lag's state at the start of an interval, of the older and of the newer command, in the state at the
    /// end, the mean and the excursion.
    weights: [[Sloped; 3]; 3],
    state: Sloped,
}

impl LateInput {
    /// An input whose newer command arrives `old_s` after each sample. The lag starts at rest at the command `state`.
    ///
    /// # Source
    /// Equation (I28) of docs/equations.md.
    pub fn new(period_s: f64, lag_s: f64, old_s: f64, state: f64) -> Self {
        let parts = [(old_s, 1.0), (period_s - old_s, -1.0)];
        let [before, after] =
            parts.map(|(length_s, grows)| Part::new(length_s, grows, lag_s.max(1e-6)));
        let weights =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|[state, old, new]| {
                let [between, old_integral, old_moment] = before.hold([state, 0.0, 0.0], old);
                let [end, new_integral, new_moment] = after.hold(between, new);
                let mut mean = [0.0; 3];
                let mut excursion = [0.0; 3];
                for of in 0..3 {
                    mean[of] = (old_integral[of] + new_integral[of]) / period_s;
                    let moment = old_moment[of] + old_s * new_integral[of] + new_moment[of];
                    excursion[of] = 0.5 * period_s * mean[of] - moment / period_s;
                }
                excursion[1] -= new_integral[0] / period_s;
                [end, mean, excursion]
            });
        Self { weights, state: [state, 0.0, 0.0] }
    }

    /// Mean and excursion over an interval with the commands `old` and `new`, each with its derivative with respect
    /// to the delay. The excursion is the mean of ∫ (v − mean) dt over the interval, where v is the lagged input.
    pub fn step(&mut self, [old, old_slope]: [f64; 2], [new, new_slope]: [f64; 2]) -> [Sloped; 2] {
        let inputs = [self.state, [old, old_slope, 0.0], [new, new_slope, 0.0]];
        let mut moved = [[0.0; 3]; 3];
        for (weights, [value, by_delay, by_lag]) in self.weights.iter().zip(inputs) {
            for (into, [weight, of_delay, of_lag]) in moved.iter_mut().zip(weights) {
                into[0] += weight * value;
                into[1] += weight * by_delay + of_delay * value;
                into[2] += weight * by_lag + of_lag * value;
            }
        }
        let [end, mean, excursion] = moved;
        self.state = end;
        [mean, excursion]
    }

    /// Frequency response of mean and excursion to a command held between samples, after a delay and a lag.
    pub fn response(period_s: f64, [delay_s, lag_s]: [f64; 2], radps: f64) -> [Complex<f64>; 2] {
        let whole = (delay_s / period_s).floor();
        let own = Self::new(period_s, lag_s, delay_s - whole * period_s, 0.0);
        let later = Complex::from_polar(1.0, -radps * period_s);
        let newer = Complex::from_polar(1.0, -radps * period_s * whole);
        let [state, old, new] = own.weights.map(|of| of.map(|[weight, ..]| weight));
        let of_commands = |of: usize| newer * (later * old[of] + new[of]);
        let at = of_commands(0) / (later.inv() - state[0]);
        [1, 2].map(|of| at * state[of] + of_commands(of))
    }
}

/// A part of an interval, under one command. The weights are those of a command, and of the distance from it at the start
/// of the part, in the lagged input v at the end, ∫ v dt and ∫ t v dt.
struct Part {
    command: [f64; 3],
    command_by_delay: [f64; 3],
    distance: [f64; 3],
    distance_by_delay: [f64; 3],
    distance_by_lag: [f64; 3],
}

impl Part {
    /// A part of `length_s`, which changes with the delay by the factor `grows`.
    fn new(length_s: f64, grows: f64, lag_s: f64) -> Self {
        let (h, lag) = (length_s, lag_s);
        let left = (-h / lag).exp();
        Self {
            command: [1.0, h, 0.5 * h * h],
            command_by_delay: [0.0, grows, grows * h],
            distance: [left, lag * (1.0 - left), lag * (lag * (1.0 - left) - h * left)],
            distance_by_delay: [-grows * left / lag, grows * left, grows * h * left],
            distance_by_lag: [
                left * h / (lag * lag),
                1.0 - left - left * h / lag,
                2.0 * lag * (1.0 - left) - left * h * (2.0 + h / lag),
            ],
        }
    }

    /// v at the end, ∫ v dt and ∫ t v dt, under a command.
    fn hold(&self, [at, by_delay, by_lag]: Sloped, command: f64) -> [Sloped; 3] {
        let away = at - command;
        std::array::from_fn(|of| {
            [
                self.command[of] * command + self.distance[of] * away,
                self.command_by_delay[of] * command
                    + self.distance[of] * by_delay
                    + self.distance_by_delay[of] * away,
                self.distance[of] * by_lag + self.distance_by_lag[of] * away,
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn the_response_is_that_of_the_samples() {
        let (period_s, delay_s, lag_s, angle) = (0.03, 0.042, 0.0133, PI / 8.0);
        let command = |sample: i32| [(angle * f64::from(sample)).cos(), 0.0];
        let mut input = LateInput::new(period_s, lag_s, delay_s - period_s, 1.0);
        let [mean, excursion] = LateInput::response(period_s, [delay_s, lag_s], angle / period_s);
        for sample in 0..200 {
            let [own_mean, own_excursion] = input.step(command(sample - 2), command(sample - 1));
            let turn = Complex::from_polar(1.0, angle * f64::from(sample));
            if sample > 100 {
                assert_abs_diff_eq!(own_mean[0], (mean * turn).re, epsilon = 1e-12);
                assert_abs_diff_eq!(own_excursion[0], (excursion * turn).re, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn a_step_within_an_interval_has_its_mean_and_excursion() {
        let [mean, excursion] = LateInput::new(1.0, 0.0, 0.25, 0.0).step([0.0, 0.0], [1.0, 0.0]);
        assert_abs_diff_eq!(mean[0], 0.75, epsilon = 1e-5);
        // ∫ (v − 3/4) dt is −3/4 t until 1/4, then returns to 0: a triangle of height 3/16.
        assert_abs_diff_eq!(excursion[0], -3.0 / 32.0, epsilon = 1e-5);
    }
}
