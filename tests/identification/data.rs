//! Recorded flights and experiments shared by the identification tests.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use hovernav::ekf::Solution;
use hovernav_dataset::Dataset;
use hovernav_model::Verdict;
use hovernav_replay::smooth;
use hovernav_sysid::helicopter::{
    FlightRecord, FrequencyDomain, Identification, ModelStructure, Velocity, identify,
};
use hovernav_sysid::record::Experiment;
use hovernav_testing::shared;
use nalgebra::DMatrix;

/// The flight included in every checkout, with its smoothed solutions. It is estimated once per test program.
pub fn flown() -> (Dataset, Vec<Solution>) {
    static FLOWN: LazyLock<(Dataset, Vec<Solution>)> = LazyLock::new(|| {
        let dir = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
        let mut dataset = Dataset::open(dir).unwrap();
        let settings = dataset.settings().unwrap();
        let solutions = smooth(&dataset, &settings, |_| ()).solutions;
        (dataset, solutions)
    });
    FLOWN.clone()
}

/// The identification of a flight with the built-in structure `name`.
pub fn identified(dataset: &Dataset, solutions: &[Solution], name: &str) -> Identification {
    let structure = ModelStructure::built_in(name).unwrap();
    identify(dataset, solutions, structure, Velocity::Estimated).unwrap()
}

/// The hybrid model of a flight, with its verdict.
pub fn judged(dataset: &Dataset, solutions: &[Solution]) -> (Identification, Verdict) {
    let found = identified(dataset, solutions, "hybrid");
    let record = FlightRecord::new(dataset, solutions, Velocity::Estimated).unwrap();
    let verdict = found.verdict(FrequencyDomain::of(&found, &record).ok().as_ref());
    (found, verdict)
}

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
