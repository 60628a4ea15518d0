//! Recorded experiments shared by the identification tests.

use std::fs;

use hovernav_sysid::record::Experiment;
use hovernav_testing::shared;
use nalgebra::DMatrix;

/// The record `name` of the shared identification sets, its first `inputs` columns the inputs.
pub fn recorded(name: &str, inputs: usize, period_s: f64) -> Option<Experiment> {
    let text = fs::read_to_string(shared(format!("datasets/sysid/{name}.csv"))?).unwrap();
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect();
    let columns = |from: usize, to: usize| {
        DMatrix::from_fn(rows.len(), to - from, |row, column| rows[row][from + column])
    };
    let experiment = Experiment::new(
        name,
        period_s,
        names[..inputs].to_vec(),
        names[inputs..].to_vec(),
        columns(0, inputs),
        columns(inputs, names.len()),
    );
    Some(experiment.unwrap())
}
