//! Frequency responses of an identified model under the conditions of a flight.

use nalgebra::{Complex, DMatrix};

use super::outputs::OUTPUTS;
use crate::methods::frequency::{FrequencyResponse, Responses};
use crate::methods::prediction_error::{Identified, LateInput};

/// Frequency responses of the equations under the conditions of a flight: sticks are held between samples, with delay
/// and lag.
pub(super) struct Responder<'a> {
    identified: &'a Identified,
    kept: Vec<usize>,
    /// For each output the index of its state; for an acceleration also the index of its tilt, and gravity, m/s².
    /// Indices refer to the kept states.
    outputs: Vec<(usize, Option<(usize, f64)>)>,
    /// Index of each modelled stick among all sticks.
    sticks: Vec<usize>,
    /// Indices of the delay and lag parameters of each stick.
    late: Vec<[Option<usize>; 2]>,
    period_s: f64,
}

impl<'a> Responder<'a> {
    pub fn new(identified: &'a Identified, measured: &FrequencyResponse, period_s: f64) -> Self {
        let structure = &identified.structure;
        let kept = identified.vehicle_states();
        let place = |name: &str| kept.iter().position(|&state| structure.states[state] == name);
        let output = |name: &String| {
            let output = OUTPUTS.iter().find(|output| output.name == name)?;
            let state = place(output.state)?;
            // Without a tilt among the states, as for heave alone, gravity has no effect.
            let felt = output.felt.map(|(_, tilt, gravity_mps2)| {
                place(tilt).map_or((state, 0.0), |t| (t, gravity_mps2))
            });
            Some((state, felt))
        };
        let of_pilot: Vec<&str> = structure.inputs_of_pilot().collect();
        let stick = |name: &String| of_pilot.iter().position(|own| own == name);
        let late = measured.input_names.iter().map(|name| {
            let input = structure.inputs.iter().position(|own| own == name);
            [&structure.delays, &structure.lags].map(|of| input.and_then(|input| of[input]))
        });
        Self {
            outputs: measured.output_names.iter().filter_map(output).collect(),
            sticks: measured.input_names.iter().filter_map(stick).collect(),
            late: late.collect(),
            identified,
            kept,
            period_s,
        }
    }

    pub fn at(&self, values: &[f64], radps: &[f64]) -> Option<Responses> {
        let mut vehicle = self.identified.vehicle_at(values, &self.kept);
        // The excursions of the sticks between samples act like sticks with the columns A B.
        let sticks = vehicle.b.ncols();
        let excursions = &vehicle.a * &vehicle.b;
        vehicle.b.extend(excursions.column_iter());
        vehicle.d = vehicle.d.insert_columns(sticks, sticks, 0.0);
        let held = vehicle.held(self.period_s)?;
        let one = |&radps: &f64| {
            let whole = held.frequency_response(radps)?;
            // Gain of the central difference of samples for a rate.
            let rate = Complex::new(0.0, (radps * self.period_s).sin() / self.period_s);
            let late = self.late.iter().map(|late| {
                let late = late.map(|of| of.map_or(0.0, |parameter| values[parameter]));
                LateInput::response(self.period_s, late, radps)
            });
            let late: Vec<[Complex<f64>; 2]> = late.collect();
            Some(DMatrix::from_fn(self.outputs.len(), self.sticks.len(), |output, stick| {
                let [mean, excursion] = late[stick];
                let (state, felt) = self.outputs[output];
                let input = self.sticks[stick];
                let of = |state: usize| {
                    whole[(state, input)] * mean + whole[(state, sticks + input)] * excursion
                };
                match felt {
                    None => of(state),
                    Some((tilt, gravity_mps2)) => of(state) * rate + of(tilt) * gravity_mps2,
                }
            }))
        };
        radps.iter().map(one).collect()
    }
}
