//! Responses of a model: in frequency, in time, and over a gain.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, DVector};

use super::discretize::zero_order_hold;
use super::error::DesignError;
use hovernav_model::linalg::eigenvalues;
use hovernav_model::{StateSpace, TimeDomain};

/// `count` frequencies from `lowest_radps` to `highest_radps`, equally spaced on a logarithmic scale.
#[must_use]
pub fn logarithmic_frequencies(lowest_radps: f64, highest_radps: f64, count: usize) -> Vec<f64> {
    let ratio = (highest_radps / lowest_radps).ln();
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|index| lowest_radps * (ratio * index as f64 / last).exp()).collect()
}

/// Magnitude, dB, and phase, °, continuous over the frequencies, from one input to one output. NaN at the frequency of
/// an undamped mode.
///
/// # Errors
/// [`ModelError::Unknown`](hovernav_model::ModelError::Unknown) for an input that the model does not have,
/// [`DesignError::Range`] for an output index beyond its outputs.
pub fn bode(
    model: &StateSpace,
    input: &str,
    output: usize,
    frequencies_radps: &[f64],
) -> Result<Vec<(f64, f64)>, DesignError> {
    let input = model.input(input)?;
    if output >= model.outputs().len() {
        let expected = "the number of one of the outputs";
        return Err(DesignError::Range { name: "output", value: output as f64, expected });
    }
    let mut before: Option<f64> = None;
    let sweep = model.linear().sweep();
    let points = frequencies_radps.iter().map(|&frequency| {
        let Some(response) = sweep.at(frequency) else {
            return (f64::NAN, f64::NAN);
        };
        let value = response[(output, input)];
        let mut phase = value.arg();
        if let Some(before) = before {
            phase -= 2.0 * PI * ((phase - before) / (2.0 * PI)).round();
        }
        before = Some(phase);
        (20.0 * value.norm().log10(), phase.to_degrees())
    });
    Ok(points.collect())
}

/// Outputs after a unit step of one input from rest.
#[derive(Clone, Debug, PartialEq)]
pub struct StepResponse {
    /// Times, s, from zero.
    pub time_s: Vec<f64>,
    /// Outputs, p×N, one column per time.
    pub outputs: DMatrix<f64>,
}

/// Response to a unit step of `input` over `duration_s`. It is exact at every `interval_s`. For a discrete model the
/// interval is its period, and `interval_s` is ignored.
///
/// # Errors
/// [`ModelError::Unknown`](hovernav_model::ModelError::Unknown), and [`DesignError::Range`] for times that are not
/// above zero or give more than ten million points.
pub fn step_response(
    model: &StateSpace,
    input: &str,
    duration_s: f64,
    interval_s: f64,
) -> Result<StepResponse, DesignError> {
    let input = model.input(input)?;
    let held;
    let (stepped, interval_s) = match model.time() {
        TimeDomain::Continuous => {
            held = zero_order_hold(model, interval_s, 0.0)?;
            (&held, interval_s)
        }
        TimeDomain::Discrete { period_s } => (model, period_s),
    };
    let points = duration_s / interval_s;
    if !(0.0..1e7).contains(&points) {
        let expected = "at most ten million intervals";
        return Err(DesignError::Range { name: "duration_s", value: duration_s, expected });
    }
    let count = points.floor() as usize + 1;
    let mut state = DVector::zeros(stepped.states().len());
    let mut outputs = DMatrix::zeros(stepped.outputs().len(), count);
    for index in 0..count {
        outputs.set_column(index, &(stepped.c() * &state + stepped.d().column(input)));
        state = stepped.a() * state + stepped.b().column(input);
    }
    let time_s = (0..count).map(|index| index as f64 * interval_s).collect();
    Ok(StepResponse { time_s, outputs })
}

/// Closed-loop poles over the gain k of u = −k·y, from one input to one output. Each gain has a row of n poles, each
/// continued from the nearest pole of the previous row.
///
/// # Errors
/// As [`bode`], and [`DesignError::Singular`] at a gain of −1/D.
pub fn root_locus(
    model: &StateSpace,
    input: &str,
    output: usize,
    gains: &[f64],
) -> Result<Vec<Vec<Complex<f64>>>, DesignError> {
    let input = model.input(input)?;
    if output >= model.outputs().len() {
        let expected = "the number of one of the outputs";
        return Err(DesignError::Range { name: "output", value: output as f64, expected });
    }
    let onto = model.b().column(input) * model.c().row(output);
    let through = model.d()[(output, input)];
    let mut rows: Vec<Vec<Complex<f64>>> = Vec::with_capacity(gains.len());
    for &gain in gains {
        let around = 1.0 + gain * through;
        if around == 0.0 {
            return Err(DesignError::Singular { matrix: "1 + kD" });
        }
        let mut poles = eigenvalues(&(model.a() - &onto * (gain / around)))?;
        if let Some(before) = rows.last() {
            for (index, old) in before.iter().enumerate() {
                let distance = |pole: &Complex<f64>| (pole - old).norm();
                let nearest = (index..poles.len()).min_by(|&one, &other| {
                    distance(&poles[one]).total_cmp(&distance(&poles[other]))
                });
                poles.swap(index, nearest.unwrap_or(index));
            }
        }
        rows.push(poles);
    }
    Ok(rows)
}
