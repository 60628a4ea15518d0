//! Lag of the loops' measurements behind the motion.

use nalgebra::DMatrix;

use crate::DesignError;
use hovernav_model::{Signal, StateSpace, TimeDomain};

/// Lag of the loops' measurements behind the motion, s, due to inertial unit and estimator.
///
/// Between fixes the solution adds no lag to the inertial samples. Corrections by fixes are slower than the loops, so
/// they are no lag at the crossover frequencies. The relevant lags are that of the inertial unit's own filter and, for
/// velocity, the integration over half a sample.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct EstimatorLag {
    /// Lag of p, q and r.
    pub rate_s: f64,
    /// Lag of roll, pitch and heading.
    pub attitude_s: f64,
    /// Lag of velocity.
    pub velocity_s: f64,
}

impl EstimatorLag {
    /// No lag.
    pub const NONE: Self = Self { rate_s: 0.0, attitude_s: 0.0, velocity_s: 0.0 };

    /// The lags, each increased by `further_s`.
    #[must_use]
    pub fn and(self, further_s: f64) -> Self {
        Self {
            rate_s: self.rate_s + further_s,
            attitude_s: self.attitude_s + further_s,
            velocity_s: self.velocity_s + further_s,
        }
    }

    /// Lags of p, q, phi, theta, u, v, w, r, psi.
    const fn of_measured(self) -> [f64; 9] {
        let Self { rate_s, attitude_s, velocity_s } = self;
        [
            rate_s, rate_s, attitude_s, attitude_s, velocity_s, velocity_s, velocity_s, rate_s,
            attitude_s,
        ]
    }
}

impl Default for EstimatorLag {
    /// Lags measured on simulated flights with the thesis's inertial unit, whose filter passes 25 Hz and lags by 6.4
    /// ms. The solution lags the truth by 6.4 ms in rates, 7 ms in attitude and 10 ms in vertical velocity. The command
    /// for this result is `cargo test -p hovernav-sim --test helicopter estimator_lag -- --nocapture`. The lag of
    /// horizontal velocity is too small compared with its error to be distinguished from that of vertical velocity.
    fn default() -> Self {
        Self { rate_s: 0.0065, attitude_s: 0.007, velocity_s: 0.01 }
    }
}

/// `plant`, a discrete model whose outputs are the loops' measurements, with each output delayed by its `lag`.
///
/// Between samples an output is interpolated linearly. This is exact for slow signals, and its phase is accurate to 1 %
/// below a tenth of the sample rate.
///
/// # Source
/// Equation (L22) of docs/equations.md.
pub(super) fn late(
    plant: StateSpace,
    lag: EstimatorLag,
    period_s: f64,
) -> Result<StateSpace, DesignError> {
    let lags = lag.of_measured().map(|lag_s| lag_s / period_s);
    let n = plant.states().len();
    let kept: Vec<usize> = lags.iter().map(|samples| samples.ceil() as usize).collect();
    let size = n + kept.iter().sum::<usize>();
    if size == n {
        return Ok(plant);
    }
    let (mut a, mut c) = (plant.a().clone(), plant.c().clone());
    a.resize_mut(size, size, 0.0);
    c.resize_mut(lags.len(), size, 0.0);
    let mut first = n;
    for ((output, samples), kept) in lags.into_iter().enumerate().zip(kept) {
        if kept == 0 {
            continue;
        }
        // The states are the output one, two, … samples ago.
        a.view_mut((first, 0), (1, n)).copy_from(&plant.c().row(output));
        for ago in 1..kept {
            a[(first + ago, first + ago - 1)] = 1.0;
        }
        let older = samples - (kept - 1) as f64;
        c.row_mut(output).scale_mut(if kept == 1 { 1.0 - older } else { 0.0 });
        c[(output, first + kept - 1)] = older;
        if kept > 1 {
            c[(output, first + kept - 2)] = 1.0 - older;
        }
        first += kept;
    }
    let states = (0..size).map(|k| Signal::new(&format!("x{k}"), "")).collect();
    let inputs = plant.inputs().to_vec();
    let (outputs, b) = (plant.outputs().to_vec(), plant.b().clone().resize_vertically(size, 0.0));
    let through = DMatrix::zeros(outputs.len(), inputs.len());
    let time = TimeDomain::Discrete { period_s };
    Ok(StateSpace::new(plant.name(), time, states, inputs, a, b)?
        .with_outputs(outputs, c, through)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hover::closed_loop::{FlightMode, plant};
    use crate::hover::plant::normalised;
    use crate::hover::{Cut, HoverDesign};
    use hovernav_model::shipped;

    fn design(estimator: EstimatorLag) -> HoverDesign {
        HoverDesign { estimator, ..HoverDesign::default() }
    }

    #[test]
    fn each_output_is_as_late_as_it_is_said_to_be() {
        let whole = normalised(&shipped::raptor60()).unwrap();
        let at = |lag, output: usize, input: usize, radps| {
            let plant = plant(&design(lag), &whole, FlightMode::Velocity).unwrap();
            plant.linear().frequency_response(radps).unwrap()[(output, input)]
        };
        // A fraction of a sample, a whole sample, and more than two.
        let lag = EstimatorLag { rate_s: 0.0065, attitude_s: 1.0 / 33.0, velocity_s: 0.07 };
        for (output, input, lag_s) in
            [(0, 0, lag.rate_s), (2, 0, lag.attitude_s), (6, 2, lag.velocity_s)]
        {
            for radps in [1.0, 4.0, 8.0] {
                let ratio =
                    at(lag, output, input, radps) / at(EstimatorLag::NONE, output, input, radps);
                let expected = -radps * lag_s;
                assert!((ratio.arg() / expected - 1.0).abs() < 0.01, "{output} {radps}: {ratio}");
                assert!((ratio.norm() - 1.0).abs() < 0.01, "{output} {radps}: {ratio}");
            }
        }
    }

    #[test]
    fn a_lag_of_everything_costs_the_margin_its_phase_at_crossover() {
        let model = shipped::raptor60();
        let gains = HoverDesign::default().synthesise(&model).unwrap();
        let margins = |lag: f64| {
            let estimator = EstimatorLag::NONE.and(lag);
            let closed =
                design(estimator).close_in(&model, &gains, FlightMode::Velocity, Cut::Actuators);
            closed.unwrap().margins().unwrap().channels
        };
        // Small, so that the crossover does not move. Heave alone, which no other loop affects.
        let [one, other] = [margins(0.0), margins(1e-4)].map(|all| all[2].phase.unwrap());
        let expected = 1e-4 * one.frequency_radps;
        assert!(((one.margin - other.margin) / expected - 1.0).abs() < 0.05, "{one:?} {other:?}");
    }
}
