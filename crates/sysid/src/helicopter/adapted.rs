//! Structures adapted to a flight: to sticks that never move, to the unit of the sticks, and to a stabiliser bar.

use std::collections::BTreeSet;

use crate::methods::prediction_error::Estimates;
use crate::methods::structure::{Parameter, Structure, Term};
use crate::record::STICKS;

/// Initial values and priors of a rotor with a stabiliser bar: value and one sigma.
///
/// # Source
/// Mettler, Tischler and Kanade (2002), table 2; Gavrilets, Mettler and Feron (2003).
const WITH_BAR: [(&str, f64, f64); 6] = [
    ("tau_f", 0.05, 0.02),
    ("Ac", 0.5, 0.25),
    ("Bd", 0.5, 0.25),
    ("tau_s", 0.3, 0.1),
    ("Clon", 0.0, 0.4),
    ("Dlat", 0.0, 0.4),
];

impl Structure {
    /// Parameters of which every term multiplies the input `input`.
    fn parameters_of(&self, input: usize) -> BTreeSet<usize> {
        let column = self.states.len() + input;
        let multiplies = |term: &Term, index: usize| {
            term.factors.iter().any(|(own, power)| *own == index && *power > 0)
        };
        let is_own = |index: &usize| {
            let mut terms = self.dynamics.iter().filter(|term| multiplies(term, *index));
            terms.all(|term| term.column == column)
        };
        let terms = self.dynamics.iter().filter(|term| term.column == column);
        let factors = terms.flat_map(|term| &term.factors).filter(|(_, power)| *power > 0);
        factors.map(|(index, _)| *index).filter(is_own).collect()
    }

    /// The structure with the effect and the delay of `input`, which never moves, fixed at 0. A delay that also delays
    /// a moving input stays free. A parameter that also multiplies another signal stays free.
    pub(super) fn with_still(mut self, input: &str) -> Self {
        let Some(input) = self.inputs.iter().position(|own| own == input) else { return self };
        let delay = self.delays[input].take().filter(|own| !self.delays.contains(&Some(*own)));
        for index in self.parameters_of(input).into_iter().chain(delay) {
            (self.parameters[index].start, self.parameters[index].fixed) = (0.0, true);
        }
        self
    }

    /// The structure for sticks in the unit of the record; `units` are the values of full travel in this unit. The
    /// initial values of free control derivatives and the limits of all are converted. A search then takes the same
    /// steps in every unit. Fixed values and priors must already be in the unit of the record.
    pub(super) fn in_units(mut self, units: [f64; 4]) -> Self {
        for (stick, unit) in STICKS.iter().zip(units) {
            let Some(input) = self.inputs.iter().position(|own| own == stick) else { continue };
            for index in self.parameters_of(input) {
                let parameter = &mut self.parameters[index];
                (parameter.lower, parameter.upper) =
                    (parameter.lower / unit, parameter.upper / unit);
                if !parameter.fixed {
                    parameter.start /= unit;
                }
            }
        }
        self
    }

    /// The structure with a stabiliser bar. `found` contains the estimates without a bar. The initial value of a
    /// stick's derivative is half of its estimate, that of the bar's is the whole estimate.
    pub(super) fn with_bar(self, found: &Estimates, units: [f64; 4]) -> Self {
        let mut with = self;
        let of_stick = |name: &str| found.get(name).map_or(0.0, |estimate| estimate.value);
        let shared =
            [("Alon", "Clon"), ("Blat", "Dlat")].map(|(stick, bar)| (stick, bar, of_stick(stick)));
        for (stick, _, value) in shared {
            with = with.with(stick, 0.5 * value, false);
        }
        for parameter in &mut with.parameters {
            if let Some(&(name, value, sigma)) =
                WITH_BAR.iter().find(|(name, ..)| *name == parameter.name)
            {
                let own = shared.iter().find(|(_, bar, _)| *bar == name);
                let unit = match name {
                    "Dlat" => units[0],
                    "Clon" => units[1],
                    _ => 1.0,
                };
                let start = own.map_or(value, |(.., of_stick)| *of_stick);
                // A stabiliser bar stabilises: the opposite sign is impossible.
                let lower = if matches!(name, "Ac" | "Bd") { 0.0 } else { parameter.lower };
                let known = parameter
                    .clone()
                    .within(lower, parameter.upper)
                    .expected(value / unit, sigma / unit);
                *parameter = Parameter { start, fixed: false, ..known };
            }
        }
        with
    }

    /// Whether a stick of the pilot acts on a state at the parameters `theta`.
    pub(super) fn sticks_act(&self, theta: &[f64]) -> bool {
        let first = self.states.len();
        self.dynamics.iter().any(|term| {
            let input = term.column.checked_sub(first).and_then(|input| self.inputs.get(input));
            input.is_some_and(|input| STICKS.contains(&input.as_str())) && term.value(theta) != 0.0
        })
    }

    /// Indices of the parameters that multiply one stick and nothing else.
    pub(super) fn control_derivatives(&self) -> BTreeSet<usize> {
        let sticks =
            self.inputs.iter().enumerate().filter(|(_, input)| STICKS.contains(&&***input));
        sticks.flat_map(|(input, _)| self.parameters_of(input)).collect()
    }

    /// Inputs that are sticks of the pilot.
    pub(super) fn inputs_of_pilot(&self) -> impl Iterator<Item = &str> {
        self.inputs.iter().map(String::as_str).filter(|input| STICKS.contains(input))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::super::model_structure::built_in;
    use super::super::velocity_error::VelocityError;
    use super::*;
    use crate::methods::prediction_error::{Settings, identify};
    use crate::record::Experiment;

    #[test]
    fn a_still_collective_leaves_the_pedals_delay_to_be_found() {
        let is_held = |structure: &Structure| {
            let delay = structure.parameter("tau_ped").expect("it has one");
            structure.parameters[delay].fixed
        };
        let structure = built_in("yaw").equations.with_still("collective");
        assert!(!is_held(&structure));
        assert!(is_held(&structure.with_still("pedal")));
    }

    /// A step response with collective and pedal both delayed by a sample, as from one computer.
    #[test]
    fn torque_that_comes_as_late_as_the_pedal_does_not_slow_the_yaw() {
        const PERIOD_S: f64 = 0.03;
        const DAMPING: f64 = -20.0;
        let decay = f64::exp(DAMPING * PERIOD_S);
        let stepped = |sample: usize, every: usize| {
            if (sample / every).is_multiple_of(2) { 0.1 } else { -0.1 }
        };
        let (collective, pedal) = (|at| stepped(at, 37), |at| stepped(at, 50));
        let mut rate = 0.0;
        let outputs = DMatrix::from_fn(1000, 1, |sample, _| {
            let measured: f64 = rate + 0.002 * ((sample * sample) as f64 * 0.618).fract();
            let late = sample.saturating_sub(1);
            let driven = 40.0 * pedal(late) - 9.0 * collective(late);
            rate = decay * rate + (decay - 1.0) / DAMPING * driven;
            measured
        });
        let inputs = DMatrix::from_fn(1000, 3, |sample, input| match input {
            0 => collective(sample),
            1 => pedal(sample),
            _ => 0.0,
        });
        let names = ["collective", "pedal", "v"].map(str::to_owned).to_vec();
        let record = Experiment::new("yaw", PERIOD_S, names, vec!["r".to_owned()], inputs, outputs)
            .expect("finite numbers");
        let settings =
            Settings::innovations(built_in("yaw").process_sigma(&VelocityError::NONE, PERIOD_S));
        let structure = built_in("yaw").equations.with_still("v");
        let found = identify(&structure, &[record], &settings).expect("it is identifiable");
        for (name, expected) in [("Nr", DAMPING), ("Nped", 40.0), ("Ncol", -9.0)] {
            let value = found.estimates.get(name).expect("it has one").value;
            assert!((value / expected - 1.0).abs() < 0.03, "{name}: {value}, not {expected}");
        }
    }
}
