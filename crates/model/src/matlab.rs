//! A model as a MATLAB script.

use std::fmt::Write as _;

use nalgebra::DMatrix;

use super::linear::TimeDomain;
use super::signal::Signal;
use super::state_space::StateSpace;

impl StateSpace {
    /// A MATLAB script that defines `model`, an `ss` object of the Control System Toolbox with the names and units of
    /// states, inputs and outputs. Delays of the sticks become input delays; a negative delay becomes 0. `lags_s`
    /// contains the first-order lag of each input, s. A collective without its own delay or lag has that of the pedal.
    ///
    /// ```
    /// let script = hovernav_model::shipped::open("r50")?.to_matlab();
    /// assert!(script.contains("model = ss(A, B, C, D);"));
    /// # Ok::<(), hovernav_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn to_matlab(&self) -> String {
        let mut text = String::new();
        for line in [self.name(), self.source()].into_iter().flat_map(str::lines) {
            let _ = writeln!(text, "% {}", plain(line));
        }
        for (name, values) in [("A", self.a()), ("B", self.b()), ("C", self.c()), ("D", self.d())] {
            let _ = writeln!(text, "{name} = {};", matrix(values));
        }
        let period = match self.time() {
            TimeDomain::Continuous => String::new(),
            TimeDomain::Discrete { period_s } => format!(", {period_s:?}"),
        };
        let _ = writeln!(text, "model = ss(A, B, C, D{period});");
        for (kind, signals) in
            [("State", self.states()), ("Input", self.inputs()), ("Output", self.outputs())]
        {
            let list = |of: fn(&Signal) -> &str| {
                let quoted = signals.iter().map(|signal| format!("'{}'", plain(of(signal))));
                quoted.collect::<Vec<_>>().join("; ")
            };
            let _ = writeln!(text, "model.{kind}Name = {{{}}};", list(|signal| &signal.name));
            let _ = writeln!(text, "model.{kind}Unit = {{{}}};", list(|signal| &signal.unit));
        }
        if self.time() == TimeDomain::Continuous {
            let _ = writeln!(text, "model.InputDelay = {};", self.of_sticks("tau"));
        }
        let _ = writeln!(text, "lags_s = {};", self.of_sticks("lag"));
        text
    }

    /// The parameter `kind` of each input, at least 0, as a column; 0 for an input without one. A collective without
    /// one uses that of the pedal.
    fn of_sticks(&self, kind: &str) -> String {
        let of = |stick: &str| {
            let name = format!("{kind}_{stick}");
            self.parameters().iter().find(|parameter| parameter.name == name)
        };
        let value = |input: &Signal| {
            let stick = input.name.get(..3).unwrap_or(&input.name);
            let own = of(stick).or_else(|| of("ped").filter(|_| stick == "col"));
            own.map_or(0.0, |parameter| parameter.value.max(0.0))
        };
        matrix(&DMatrix::from_iterator(self.inputs().len(), 1, self.inputs().iter().map(value)))
    }
}

/// A matrix with every digit of its values.
fn matrix(values: &DMatrix<f64>) -> String {
    let row = |row: usize| {
        let values = values.row(row);
        values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", ")
    };
    format!("[{}]", (0..values.nrows()).map(row).collect::<Vec<_>>().join("; "))
}

/// `text` without characters that end a MATLAB string or line.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c == '\'' || c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use crate::shipped;

    /// The rows of the matrix `name` in a script.
    fn read(script: &str, name: &str) -> Vec<Vec<f64>> {
        let start = format!("{name} = [");
        let line = script.lines().find_map(|line| line.strip_prefix(&start)).unwrap();
        let rows = line.trim_end_matches("];").split("; ");
        rows.map(|row| row.split(", ").map(|value| value.parse().unwrap()).collect()).collect()
    }

    #[test]
    fn a_script_has_every_digit_of_the_matrices_and_a_name_for_each_signal() {
        let model = shipped::open("r50").unwrap();
        let script = model.to_matlab();
        for (name, matrix) in [("A", model.a()), ("B", model.b()), ("C", model.c())] {
            let rows = read(&script, name);
            assert_eq!(rows.len(), matrix.nrows());
            for (row, values) in rows.iter().enumerate() {
                assert!(values.iter().eq(matrix.row(row).iter()), "{name}, row {row}");
            }
        }
        for (kind, signals) in [("State", model.states()), ("Input", model.inputs())] {
            let names: Vec<&str> = signals.iter().map(|signal| &*signal.name).collect();
            let line = format!("model.{kind}Name = {{'{}'}};", names.join("'; '"));
            assert!(script.contains(&line), "{line}");
        }
        assert_eq!(read(&script, "model.InputDelay").len(), model.inputs().len());
    }
}
