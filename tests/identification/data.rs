//! The recorded experiments the identification tests share.

use std::fs;
use std::path::Path;

use hovernav_sysid::record::Experiment;
use nalgebra::DMatrix;

/// The record `name` of the shared identification sets, its first `inputs` columns the inputs;
/// `None`, with a line printed, where the folder is missing.
pub fn recorded(name: &str, inputs: usize, period_s: f64) -> Option<Experiment> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/datasets/sysid"))
        .join(format!("{name}.csv"));
    let Ok(text) = fs::read_to_string(&path) else {
        println!("skipped: no {}", path.display());
        return None;
    };
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
