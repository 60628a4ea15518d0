//! Signals that move the vehicle: several per log, from the pilot's sticks to the outputs of the mixer.

use std::path::Path;

use hovernav::time::Time;
use hovernav_dataset::{ClockSteps, LogError, Remarks, Rows};

/// Sources by their distance from the actuators, the nearest first. The nearest one is what the vehicle responds to.
/// The pilot's sticks are that only without a controller in between. Outputs of single motors follow those of their
/// mixer. If a log has both, those of the mixer are more frequent, and lack the curve of a motor's thrust.
const NEAREST: [&str; 8] = [
    "RATE",
    "vehicle_torque_setpoint",
    "actuator_controls_0",
    "RCOU",
    "actuator_motors",
    "RCIN",
    "manual_control_setpoint",
    "RC_CHANNELS",
];
/// Smallest span of a signal that moves, as a fraction of full travel.
const MIN_SPAN: f64 = 2e-3;
/// Largest valid input; sticks may exceed 1 if trim is off centre.
const LARGEST: f64 = 2.0;
/// Longest time, s, from an injected value to the input that contains it.
const LONGEST_S: f64 = 0.05;

/// Time, and lateral, longitudinal, collective and pedal inputs.
type Row = (Time, [f64; 4]);

/// The recorded inputs of a log, by source.
#[derive(Debug, Default)]
pub(crate) struct Inputs {
    sources: Vec<(&'static str, Rows<Row>)>,
    /// Time, stick and value of the signal injected by a system identification mode.
    injected: Rows<(Time, usize, f64)>,
    /// The source to read; `None` for the nearest one that moves.
    pub wanted: Option<String>,
}

/// The inputs of one source.
pub(crate) struct Chosen {
    pub controls: Vec<Row>,
    /// Injected inputs, one for each of `controls`; empty if nothing was injected.
    pub injected: Vec<[f64; 4]>,
    /// Sentence on the source that is read and the other sources, if there are several.
    pub note: Option<String>,
}

impl Inputs {
    /// Adds a row of the source `name`. A row with an implausible value is ignored without a warning, because
    /// unconnected sticks are common.
    pub fn take(&mut self, name: &'static str, place: u64, (time, values): Row) {
        if !values.iter().all(|value| value.abs() <= LARGEST) {
            return;
        }
        match self.sources.iter_mut().find(|(own, _)| *own == name) {
            Some((_, rows)) => rows.push(place, (time, values)),
            None => {
                let mut rows = Rows::new();
                rows.push(place, (time, values));
                self.sources.push((name, rows));
            }
        }
    }

    /// Adds a value injected on a stick, in any unit.
    pub fn inject(&mut self, time: Time, stick: usize, value: f64) {
        if value.is_finite() {
            self.injected.push(0, (time, stick, value));
        }
    }

    /// The wanted source, otherwise the moving source that is nearest to the actuators.
    ///
    /// # Errors
    /// [`LogError::Unusable`] if the wanted source is absent; [`LogError::Clock`] as for other rows.
    pub fn choose(
        mut self,
        path: &Path,
        steps: &mut ClockSteps,
        remarks: &mut Remarks,
    ) -> Result<Chosen, LogError> {
        let rank = |name: &str| NEAREST.iter().position(|own| *own == name);
        self.sources.sort_by_key(|(name, _)| rank(name));
        let mut sources = Vec::new();
        for (name, rows) in self.sources {
            sources.push((name, rows.in_time_order(|row| &mut row.0, path, steps, remarks)?.0));
        }
        let names = sources.iter().map(|(name, _)| *name).collect::<Vec<_>>();
        let place = match &self.wanted {
            Some(wanted) => {
                let place = names.iter().position(|name| name.eq_ignore_ascii_case(wanted));
                Some(place.ok_or_else(|| {
                    let has = if names.is_empty() { "none".into() } else { names.join(", ") };
                    let reason = format!("found no input {wanted}; the log has {has}");
                    LogError::Unusable { path: path.to_path_buf(), reason }
                })?)
            }
            None => {
                sources.iter().position(|(_, rows)| moves(rows)).or(sources.len().checked_sub(1))
            }
        };
        let note = place.filter(|_| names.len() > 1).map(|place| {
            let others: Vec<&str> =
                names.iter().filter(|name| **name != names[place]).copied().collect();
            let why = if self.wanted.is_some() { "" } else { ", nearest to the actuators" };
            format!("inputs: {} is read{why}; the log also has {}", names[place], others.join(", "))
        });
        let controls = place.map(|place| sources.swap_remove(place).1).unwrap_or_default();
        let injected = injected(&controls, self.injected.shifted(|one| &mut one.0, steps));
        Ok(Chosen { controls, injected, note })
    }
}

/// Whether any of the four signals moves.
fn moves(rows: &[Row]) -> bool {
    (0..4).any(|stick| {
        let values = || rows.iter().map(|row| row.1[stick]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min) > MIN_SPAN
    })
}

/// The `injected` value at each row of `controls`: the nearest within `LONGEST_S`, otherwise zero. Empty if all are
/// zero.
fn injected(controls: &[Row], mut injected: Vec<(Time, usize, f64)>) -> Vec<[f64; 4]> {
    if injected.iter().all(|(.., value)| *value == 0.0) {
        return Vec::new();
    }
    injected.sort_by_key(|(time, ..)| *time);
    let at = |row: &Row| {
        let next = injected.partition_point(|(time, ..)| *time < row.0);
        let near = &injected[next.saturating_sub(1)..injected.len().min(next + 1)];
        let off = |one: &(Time, usize, f64)| (one.0 - row.0).abs();
        let nearest = near.iter().min_by(|one, other| off(one).total_cmp(&off(other)));
        let mut values = [0.0; 4];
        if let Some(&(_, stick, value)) = nearest.filter(|nearest| off(nearest) <= LONGEST_S) {
            values[stick] = value;
        }
        values
    };
    controls.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: f64) -> Time {
        Time::from_seconds(time_s)
    }

    fn inputs() -> Inputs {
        let mut inputs = Inputs::default();
        for sample in 0..100_u32 {
            let time = at(0.1 * f64::from(sample));
            let value = 0.1 * f64::from(sample).sin();
            let place = u64::from(sample);
            inputs.take("RCIN", place, (time, [value, 0.0, 0.0, 0.0]));
            inputs.take("RATE", place, (time, [0.0, value, 0.0, 0.3]));
            inputs.take("RCOU", place, (time, [0.0; 4]));
        }
        inputs
    }

    fn choose(inputs: Inputs) -> Result<Chosen, LogError> {
        let steps = &mut ClockSteps::default();
        inputs.choose("log".as_ref(), steps, &mut Remarks::new("other sensors"))
    }

    #[test]
    fn the_nearest_source_that_moves_is_read_unless_another_is_wanted() {
        let chosen = choose(inputs()).unwrap();
        assert_eq!(chosen.controls[20].1[3], 0.3);
        let told = "inputs: RATE is read, nearest to the actuators; the log also has RCOU, RCIN";
        assert_eq!(chosen.note.unwrap(), told);
        let wanted = |name: &str| choose(Inputs { wanted: Some(name.into()), ..inputs() });
        assert_eq!(wanted("rcin").unwrap().controls[20].1[3], 0.0);
        let error = wanted("SIDD").err().unwrap().to_string();
        assert!(error.contains("found no input SIDD; the log has RATE, RCOU, RCIN"), "{error}");
    }

    #[test]
    fn what_was_injected_is_found_at_the_time_of_each_input() {
        let mut with = inputs();
        with.inject(at(2.01), 1, 0.07);
        let injected = choose(with).unwrap().injected;
        assert_eq!(injected.len(), 100);
        assert_eq!(injected[20], [0.0, 0.07, 0.0, 0.0]);
        assert_eq!(injected[22], [0.0; 4]);
        assert!(choose(inputs()).unwrap().injected.is_empty());
    }
}
