//! Identification from its start values.

use std::cell::RefCell;

use super::error::PredictionErrorError;
use super::identified::Identified;
use super::problem::Problem;
use super::settings::{Form, Settings};
use super::sweep::Record;
use super::{dropping, statistics};
use crate::methods::structure::Structure;
use crate::record::Experiment;

/// Identifies `structure` on `experiments`.
///
/// The signals are found by name; an experiment may hold others.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn identify(
    structure: &Structure,
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let name = || structure.name.clone();
    let periods_s: Vec<f64> = experiments.iter().map(|experiment| experiment.period_s).collect();
    let period_s = periods_s.first().copied().unwrap_or(f64::NAN);
    // A thousandth of a period is far below what a period moves an estimate by.
    if !periods_s.iter().all(|other| (other / period_s - 1.0).abs() < 1e-3) || periods_s.is_empty()
    {
        return Err(PredictionErrorError::Periods { structure: name(), periods_s });
    }
    let records = experiments
        .iter()
        .map(|experiment| Record::new(structure, experiment))
        .collect::<Result<Vec<_>, _>>()?;
    let (base, free) = start(structure, &records, settings)?;
    let problem = Problem {
        structure,
        records: &records,
        period_s,
        innovations: settings.form != Form::OutputError,
        base,
        free,
        own: RefCell::new(Problem::guesses(structure, &records)),
    };
    let own = problem.own.borrow().values.iter().map(Vec::len).sum::<usize>();
    let (unknowns, numbers) =
        (problem.free.len() + own, problem.samples() * structure.outputs.len());
    if unknowns >= numbers {
        return Err(PredictionErrorError::TooShort { structure: name(), unknowns, numbers });
    }
    dropping::search(problem, settings)
}

/// The whole parameter vector at its start, and which entries are free.
fn start(
    structure: &Structure,
    records: &[Record],
    settings: &Settings,
) -> Result<(Vec<f64>, Vec<usize>), PredictionErrorError> {
    let own = structure.parameters.len();
    let mut free: Vec<usize> =
        (0..own).filter(|&index| !structure.parameters[index].fixed).collect();
    if free.is_empty() {
        return Err(PredictionErrorError::NothingFree { structure: structure.name.clone() });
    }
    let expected = structure.noises.len();
    let process = match &settings.form {
        Form::Innovations(sigmas)
            if sigmas.len() == expected && sigmas.iter().all(|&s| s > 0.0 && s.is_finite()) =>
        {
            sigmas.clone()
        }
        Form::Innovations(sigmas) => {
            return Err(PredictionErrorError::ProcessNoise {
                structure: structure.name.clone(),
                found: sigmas.clone(),
                expected,
            });
        }
        Form::OutputError => vec![1.0; expected],
    };
    if settings.form != Form::OutputError {
        free.extend(own..own + expected);
    }
    let mut measurement = Vec::new();
    for (output, name) in structure.outputs.iter().enumerate() {
        if let Some((_, sigma)) = settings.held_sigma.iter().find(|(held, _)| held == name) {
            measurement.push(*sigma);
        } else {
            measurement.push(statistics::noise_of(records, output, structure.outputs.len()));
            free.push(own + expected + output);
        }
    }
    let mut base = structure.start();
    base.extend(process.iter().chain(&measurement).map(|sigma| sigma.ln()));
    Ok((base, free))
}
