//! What a flight says of the model in the frequency domain, where it was not fitted.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::flight::FlightRecord;
use super::identify::Identification;
use crate::methods::frequency::{Band, ResponseSettings, frequency_response};
use crate::record::STICKS;

/// The on-axis response to one stick, flown and modelled, at the same frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct StickResponse {
    /// The stick.
    pub stick: &'static str,
    /// The output: p, q, w or r.
    pub output: &'static str,
    /// The output's unit per full stick.
    pub unit: &'static str,
    /// Frequencies, Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// From the test points on the stick: magnitude, dB, and phase, °, continuous.
    pub flight: Vec<(f64, f64)>,
    /// Coherence of the two, 0 to 1: what part of the output the stick explains linearly.
    pub coherence: Vec<f64>,
    /// Random error of the flight's response as a part of its size, one sigma.
    pub random_error: Vec<f64>,
    /// From the identified model, its sticks held from sample to sample and late as found: magnitude,
    /// dB, and phase, °.
    pub model: Vec<(f64, f64)>,
}

impl StickResponse {
    /// How far flight and model are apart where the coherence is at least `coherence`: 0 where they
    /// agree, below 100 where a fit is good. `None` where fewer than five frequencies are worth it.
    ///
    /// # Source
    /// Tischler and Remple, equation 11.4: weights by coherence, 1 per dB² and 0.01745 per °².
    #[must_use]
    pub fn cost(&self, coherence: f64) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0.0);
        for (at, known) in
            self.coherence.iter().enumerate().filter(|(_, known)| **known >= coherence)
        {
            let ((size, phase), (size_model, phase_model)) =
                (*self.flight.get(at)?, *self.model.get(at)?);
            let weight = (1.58 * (1.0 - (-known * known).exp())).powi(2);
            let apart = (size - size_model).powi(2) + 0.01745 * (phase - phase_model).powi(2);
            if apart.is_finite() {
                sum += weight * apart;
                count += 1.0;
            }
        }
        (count >= 5.0).then(|| 20.0 / count * sum)
    }
}

/// Which output answers to which stick.
const ON_AXIS: [(&str, &str); 4] = [("p", "rad/s"), ("q", "rad/s"), ("w", "m/s"), ("r", "rad/s")];
/// The slowest movement a test point of ten seconds holds, Hz.
const FIRST_HZ: f64 = 0.15;
/// The fastest a step of the stick still excites, Hz.
const LAST_HZ: f64 = 4.0;
const POINTS: usize = 60;

/// The on-axis responses of `found` for which `record`, the flight it was identified from, has test
/// points, those held back included.
#[must_use]
pub fn stick_responses(found: &Identification, record: &FlightRecord) -> Vec<StickResponse> {
    let clean = record.without_tones(&found.tones, &[]);
    (0..STICKS.len()).filter_map(|stick| stick_response(found, &clean, stick)).collect()
}

/// `None` where the model has no such stick or output, or the flight no test point on it.
fn stick_response(
    found: &Identification,
    record: &FlightRecord,
    stick: usize,
) -> Option<StickResponse> {
    let (name, (output, unit)) = (STICKS[stick], ON_AXIS[stick]);
    let structure = &found.identified.structure;
    if !structure.inputs.iter().any(|input| input == name) {
        return None;
    }
    let points = found.test_points.iter().filter(|point| point.stick == Some(stick));
    let experiments: Vec<_> = points
        .filter_map(|point| record.cut(point).ok()?.select(&[name], &[output]).ok())
        .map(|piece| piece.detrended())
        .collect();
    let shortest_s = experiments.iter().map(|piece| piece.duration_s()).reduce(f64::min)?;
    let period_s = record.experiment.period_s;
    let last_hz = LAST_HZ.min(0.4 / period_s);
    let band = Band { first_hz: FIRST_HZ, last_hz, points: POINTS };
    let settings = ResponseSettings::composite(band, 2.0 * shortest_s);
    let flown = frequency_response(&experiments, &settings).ok()?;

    let vehicle = found.identified.vehicle().ok()?;
    let held = vehicle.linear().held(period_s)?;
    let (row, column) = (vehicle.state(output).ok()?, vehicle.input(name).ok()?);
    let delay_s = found.identified.delay(name).map_or(0.0, |delay| delay.value);
    let lag_s = found.identified.lag(name).map_or(0.0, |lag| lag.value);
    let modelled = flown.frequencies_hz.iter().map(|&frequency_hz| {
        let radps = TAU * frequency_hz;
        let response = held.frequency_response(radps);
        let late = Complex::from_polar(1.0, -radps * delay_s) / Complex::new(1.0, radps * lag_s);
        response.map_or(Complex::new(f64::NAN, f64::NAN), |response| response[(row, column)] * late)
    });
    let modelled: Vec<_> = modelled.collect();
    let measured: Vec<_> = flown.responses.iter().map(|response| response[(0, 0)]).collect();
    Some(StickResponse {
        stick: name,
        output,
        unit,
        flight: decibels_and_degrees(&measured, modelled.first().copied()),
        model: decibels_and_degrees(&modelled, None),
        coherence: flown.coherence.iter().map(|coherence| coherence[(0, 0)]).collect(),
        random_error: flown.random_error.iter().map(|error| error[(0, 0)]).collect(),
        frequencies_hz: flown.frequencies_hz,
    })
}

/// Magnitude and continuous phase; the first phase is taken within half a turn of that of `near`.
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
