//! Handling qualities of an attitude loop: disturbance rejection and response to commands.

use std::f64::consts::PI;

use super::error::DesignError;
use super::margins::Loop;
use super::response::logarithmic_frequencies;
use hovernav_model::TimeDomain;

/// Disturbance rejection and command bandwidth of one output of a loop.
///
/// # Source
/// Tischler, Berger, Ivler and others, *Practical Methods for Aircraft and Rotorcraft Flight Control Design*
/// (2017), for disturbance rejection; ADS-33E-PRF (2000), section 3.3.2, for bandwidth and phase delay.
#[derive(Clone, Debug, PartialEq)]
pub struct HandlingQualities {
    /// The output: phi, theta or psi.
    pub output: String,
    /// Disturbance rejection bandwidth, rad/s: the frequency at which the sensitivity first rises through −3 dB. `None`
    /// where slow disturbances are not rejected, or the sensitivity never reaches −3 dB.
    pub rejection_bandwidth_radps: Option<f64>,
    /// Disturbance rejection peak, dB: the maximum of the sensitivity.
    pub rejection_peak_db: f64,
    /// Bandwidth by phase, rad/s: the frequency at which the response to a command lags by 135°; `None` where the lag
    /// never reaches 135°.
    pub bandwidth_radps: Option<f64>,
    /// Phase delay, s: slope of the phase beyond 180°. `None` where the phase does not reach 180° in the lower half of
    /// the frequency range.
    pub phase_delay_s: Option<f64>,
}

/// Lowest frequency, rad/s.
const LOWEST_RADPS: f64 = 0.02;
/// Number of frequencies.
const FREQUENCIES: usize = 800;
/// Highest frequency of a continuous loop, rad/s.
const HIGHEST_RADPS: f64 = 300.0;

impl HandlingQualities {
    /// Handling qualities of `output` of a loop broken at its outputs, with all other outputs closed.
    ///
    /// A command enters at the measurement of the output, so the response to it is one minus the sensitivity.
    ///
    /// # Errors
    /// [`DesignError::Model`] where the loop has no such output.
    ///
    /// # Source
    /// Equation (L19) of docs/equations.md.
    pub fn of(closed: &Loop, output: &str) -> Result<Self, DesignError> {
        let place = closed.open().input(output)?;
        let highest = match closed.open().time() {
            TimeDomain::Continuous => HIGHEST_RADPS,
            TimeDomain::Discrete { period_s } => PI / period_s,
        };
        let mut rejection = Vec::with_capacity(FREQUENCIES);
        let mut phase: Vec<(f64, f64)> = Vec::with_capacity(FREQUENCIES);
        for frequency in logarithmic_frequencies(LOWEST_RADPS, highest, FREQUENCIES) {
            let Some(sensitivity) = closed.sensitivity(frequency) else { continue };
            let left = sensitivity[(place, place)];
            rejection.push((frequency, 20.0 * left.norm().log10()));
            let own = (-left + 1.0).arg();
            let before = phase.last().map_or(0.0, |(_, before)| *before);
            phase.push((frequency, own - 2.0 * PI * ((own - before) / (2.0 * PI)).round()));
        }
        let held_down = rejection.first().is_some_and(|(_, db)| *db < -3.0);
        let rising = |level: f64| crossing(&rejection, level);
        let half_turn = crossing(&phase, -PI);
        let phase_delay_s = half_turn.and_then(|half_turn| {
            let (_, late) = phase.iter().find(|(frequency, _)| *frequency >= 2.0 * half_turn)?;
            Some((-PI - late) / (2.0 * half_turn))
        });
        Ok(Self {
            output: output.to_owned(),
            rejection_bandwidth_radps: rising(-10.0 * 2f64.log10()).filter(|_| held_down),
            rejection_peak_db: rejection.iter().map(|(_, db)| *db).fold(f64::MIN, f64::max),
            bandwidth_radps: crossing(&phase, -0.75 * PI),
            phase_delay_s,
        })
    }
}

/// First crossing of `level` by `points`, in either direction, with linear interpolation.
fn crossing(points: &[(f64, f64)], level: f64) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let [(one, before), (other, after)] = pair else { return None };
        let goes = (before - level) * (after - level) <= 0.0 && before != after;
        goes.then(|| one + (other - one) * (level - before) / (after - before))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use hovernav_model::{Signal, StateSpace};
    use nalgebra::{DMatrix, dmatrix};

    fn qualities(a: DMatrix<f64>, b: DMatrix<f64>, c: DMatrix<f64>) -> HandlingQualities {
        let states = (0..a.nrows()).map(|k| Signal::new(&format!("x{k}"), "1")).collect();
        let phi = || vec![Signal::new("phi", "rad")];
        let plant = StateSpace::new("test", TimeDomain::Continuous, states, phi(), a, b)
            .unwrap()
            .with_outputs(phi(), c, DMatrix::zeros(1, 1))
            .unwrap();
        let one = StateSpace::new(
            "one",
            TimeDomain::Continuous,
            vec![Signal::new("none", "1")],
            phi(),
            dmatrix![-1.0],
            dmatrix![0.0],
        )
        .unwrap()
        .with_outputs(phi(), dmatrix![0.0], dmatrix![1.0])
        .unwrap();
        HandlingQualities::of(&Loop::at_plant_output(&plant, &one).unwrap(), "phi").unwrap()
    }

    #[test]
    fn an_integrator_rejects_up_to_its_gain_and_never_peaks() {
        let found = qualities(dmatrix![0.0], dmatrix![2.0], dmatrix![1.0]);
        assert_abs_diff_eq!(found.rejection_bandwidth_radps.unwrap(), 2.0, epsilon = 1e-3);
        assert!(found.rejection_peak_db < 1e-3, "{found:?}");
        assert_eq!((found.bandwidth_radps, found.phase_delay_s), (None, None));
    }

    #[test]
    fn a_second_order_answer_has_the_bandwidth_of_its_closed_form() {
        // T = 1/(s² + 2ζs + 1) lags by 135° at ζ + √(ζ² + 1).
        let damping = 0.4f64;
        let found = qualities(
            dmatrix![0.0, 1.0; 0.0, -2.0 * damping],
            dmatrix![0.0; 1.0],
            dmatrix![1.0, 0.0],
        );
        let expected = damping + (damping * damping + 1.0).sqrt();
        assert!((found.bandwidth_radps.unwrap() - expected).abs() < 1e-3, "{found:?}");
        assert!(found.rejection_peak_db > 3.0);
    }

    #[test]
    fn an_output_that_is_none_is_refused() {
        let plain = dmatrix![1.0];
        let one = |name: &str| {
            let signal = || vec![Signal::new(name, "1")];
            StateSpace::new(
                name,
                TimeDomain::Continuous,
                signal(),
                signal(),
                -plain.clone(),
                plain.clone(),
            )
            .unwrap()
            .with_outputs(signal(), plain.clone(), DMatrix::zeros(1, 1))
            .unwrap()
        };
        let closed = Loop::at_plant_output(&one("phi"), &one("phi")).unwrap();
        assert!(HandlingQualities::of(&closed, "theta").is_err());
    }
}
