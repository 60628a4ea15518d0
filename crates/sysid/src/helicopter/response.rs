//! On-axis frequency responses for plots: flight and model in decibels and degrees.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::frequency_domain::FrequencyDomain;

/// The on-axis response to one stick, measured and modelled, at the same frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct StickResponse {
    /// The stick.
    pub stick: &'static str,
    /// The output: p, q, az or r.
    pub output: &'static str,
    /// The output's unit per full stick.
    pub unit: &'static str,
    /// Frequencies, Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// Response from the flight, conditioned on the other sticks: magnitude, dB, and phase, °, continuous.
    pub flight: Vec<(f64, f64)>,
    /// Partial coherence, 0 to 1: fraction of the output that the stick alone explains linearly.
    pub coherence: Vec<f64>,
    /// Random error of the flight's response, one sigma, as a fraction of its magnitude.
    pub random_error: Vec<f64>,
    /// Response of the model identified in the time domain, with sticks held between samples and the identified delays:
    /// magnitude, dB, and phase, °.
    pub model: Vec<(f64, f64)>,
}

/// On-axis output of each stick, and its unit.
const ON_AXIS: [(&str, &str, &str); 4] = [
    ("lateral", "p", "rad/s"),
    ("longitudinal", "q", "rad/s"),
    ("collective", "az", "m/s²"),
    ("pedal", "r", "rad/s"),
];

impl FrequencyDomain {
    /// The on-axis responses of sticks that moved.
    #[must_use]
    pub fn stick_responses(&self) -> Vec<StickResponse> {
        ON_AXIS.into_iter().filter_map(|on_axis| self.stick_response(on_axis)).collect()
    }

    fn stick_response(
        &self,
        (stick, output, unit): (&'static str, &'static str, &'static str),
    ) -> Option<StickResponse> {
        let measured = &self.measured;
        let place = |names: &[String], name: &str| names.iter().position(|own| own == name);
        let at = (place(&measured.output_names, output)?, place(&measured.input_names, stick)?);
        let modelled: Vec<_> = self.modelled.iter().map(|response| response[at]).collect();
        let flown: Vec<_> = measured.responses.iter().map(|response| response[at]).collect();
        Some(StickResponse {
            stick,
            output,
            unit,
            frequencies_hz: measured.frequencies_hz.clone(),
            flight: decibels_and_degrees(&flown, modelled.first().copied()),
            model: decibels_and_degrees(&modelled, None),
            coherence: measured.coherence.iter().map(|coherence| coherence[at]).collect(),
            random_error: measured.random_error.iter().map(|error| error[at]).collect(),
        })
    }
}

/// Magnitude and continuous phase; the first phase is within half a turn of that of `near`.
fn decibels_and_degrees(response: &[Complex<f64>], near: Option<Complex<f64>>) -> Vec<(f64, f64)> {
    let mut before = near.map(|value| value.arg());
    let points = response.iter().map(|value| {
        let mut phase = value.arg();
        if let Some(before) = before {
            phase -= TAU * ((phase - before) / TAU).round();
        }
        if phase.is_finite() {
            before = Some(phase);
        }
        (20.0 * value.norm().log10(), phase.to_degrees())
    });
    points.collect()
}
