//! Identification from initial values.

use std::cell::RefCell;

use nalgebra::DMatrix;

use super::error::PredictionErrorError;
use super::estimates::Estimates;
use super::identified::Identified;
use super::problem::Problem;
use super::settings::{Form, Settings};
use super::sweep::Record;
use super::{dropping, statistics};
use crate::methods::structure::{Parameter, Structure};
use crate::record::Experiment;

/// Identifies `structure` on `experiments`.
///
/// Signals are matched by name; an experiment may contain others.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn identify(
    structure: &Structure,
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let records = records(structure, experiments)?;
    let problem = problem(structure, &records, experiments, settings)?;
    let own = problem.own.borrow().values.iter().map(Vec::len).sum::<usize>();
    let (unknowns, numbers) =
        (problem.free.len() + own, problem.samples() * structure.outputs.len());
    if unknowns >= numbers {
        return Err(PredictionErrorError::TooShort {
            structure: structure.name.clone(),
            unknowns,
            numbers,
        });
    }
    dropping::search(problem, settings)
}

/// Continues the identification `found` on `experiments`, which contain its data and more. The search starts from its
/// values and keeps its structure, including dropped parameters.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn identify_on(
    found: &Identified,
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let records = records(&found.structure, experiments)?;
    let problem = problem(&found.structure, &records, experiments, settings)?;
    dropping::search_on(problem, found, settings)
}

/// Repeats the search from the result `found`, with the parameter `name` starting at `value`.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn identify_from(
    found: &Identified,
    (name, value): (&str, f64),
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let mut moved = found.clone();
    if let Some(place) = found.structure.parameter(name) {
        moved.theta[place] = value;
    }
    identify_on(&moved, experiments, settings)
}

/// Repeats the search from the result `found` with the results `known` of another method: index, value and one sigma of
/// parameters. Each value is the initial value of its parameter. It counts as one more measurement and replaces the
/// prior of the structure.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn identify_with(
    found: &Identified,
    known: &[(usize, f64, f64)],
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let mut moved = Identified { structure: with_known(&found.structure, known), ..found.clone() };
    for &(place, value, _) in known {
        moved.theta[place] = value;
    }
    let mut found_with = identify_on(&moved, experiments, settings)?;
    found_with.structure.clone_from(&found.structure);
    Ok(found_with)
}

/// `structure` with the results `known` in place of the priors of these parameters.
pub(super) fn with_known(structure: &Structure, known: &[(usize, f64, f64)]) -> Structure {
    let mut structure = structure.clone();
    for &(place, value, sigma) in known {
        structure.parameters[place].prior = Some((value, sigma));
    }
    structure
}

pub(super) fn records(
    structure: &Structure,
    experiments: &[Experiment],
) -> Result<Vec<Record>, PredictionErrorError> {
    let records = experiments.iter().map(|experiment| Record::new(structure, experiment));
    Ok(records.collect::<Result<Vec<_>, _>>()?)
}

/// The likelihood with all parameters at their initial values.
pub(super) fn problem<'a>(
    structure: &'a Structure,
    records: &'a [Record],
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Problem<'a>, PredictionErrorError> {
    let name = || structure.name.clone();
    let periods_s: Vec<f64> = experiments.iter().map(|experiment| experiment.period_s).collect();
    let period_s = periods_s.first().copied().unwrap_or(f64::NAN);
    // The effect of a thousandth of a period on the estimates is negligible.
    if !periods_s.iter().all(|other| (other / period_s - 1.0).abs() < 1e-3) || periods_s.is_empty()
    {
        return Err(PredictionErrorError::Periods { structure: name(), periods_s });
    }
    let (base, free) = start(structure, records, settings)?;
    let (lower, upper) = limits(structure, &base, settings);
    Ok(Problem {
        structure,
        records,
        period_s,
        innovations: settings.form != Form::OutputError,
        base,
        free,
        lower,
        upper,
        prior_weight: Vec::new(),
        own: RefCell::new(Problem::guesses(structure, records)),
    })
}

/// The model of `structure` from `parts` that were identified separately on the same `experiments`. Values, bounds and
/// noises are copied by name. Parameters of different parts are uncorrelated, and nothing is searched.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn assemble(
    structure: &Structure,
    parts: &[Identified],
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let records = records(structure, experiments)?;
    let mut problem = problem(structure, &records, experiments, settings)?;
    let own = structure.parameters.len();
    let names = structure.parameters.iter().map(|parameter| parameter.name.clone());
    let noises = structure.noises.iter().chain(&structure.outputs).map(|name| format!("σ {name}"));
    let mut list = Vec::new();
    for (index, name) in names.chain(noises).enumerate() {
        let found = parts.iter().find_map(|part| part.estimates.get(&name));
        let Some(found) = found else {
            return Err(PredictionErrorError::NotInParts {
                structure: structure.name.clone(),
                name,
            });
        };
        problem.base[index] = if index < own { found.value } else { found.value.ln() };
        list.push(found.clone());
    }
    // Index in `list` of the free estimate with number `of` in `part`.
    let place = |part: &Identified, of: usize| {
        let name = &part.estimates.list[part.estimates.free[of]].name;
        list.iter().position(|estimate| estimate.name == *name)
    };
    let mut free: Vec<usize> = parts
        .iter()
        .flat_map(|part| (0..part.estimates.free.len()).filter_map(move |of| place(part, of)))
        .collect();
    free.sort_unstable();
    let mut covariance = DMatrix::zeros(free.len(), free.len());
    let mut white_covariance = covariance.clone();
    for part in parts {
        let places: Vec<Option<usize>> = (0..part.estimates.free.len())
            .map(|of| free.binary_search(&place(part, of)?).ok())
            .collect();
        for (row, to_row) in places.iter().enumerate() {
            for (column, to_column) in places.iter().enumerate() {
                if let (Some(to_row), Some(to_column)) = (to_row, to_column) {
                    let (own, to) = ((row, column), (*to_row, *to_column));
                    covariance[to] = part.estimates.covariance[own];
                    white_covariance[to] = part.estimates.white_covariance[own];
                }
            }
        }
    }
    problem.free.clear();
    problem.own = RefCell::new(Problem::guesses(structure, problem.records));
    let estimates = Estimates { list, free, covariance, white_covariance };
    dropping::assembled(&problem, estimates, parts)
}

/// Lower and upper limit of each entry of the whole parameter vector.
fn limits(structure: &Structure, base: &[f64], settings: &Settings) -> (Vec<f64>, Vec<f64>) {
    // ln 33: a noise below a thirtieth of its initial value is negligible.
    const MIN: f64 = 3.5;
    // ln 1100: a noise above a thousand times its initial value is not noise.
    const MAX: f64 = 7.0;
    let own = structure.parameters.len();
    let side = |of: fn(&Parameter) -> f64, noise: &dyn Fn(usize, f64) -> f64| {
        let parameters = structure.parameters.iter().map(of);
        let noises = base.iter().enumerate().skip(own);
        parameters.chain(noises.map(|(index, &start)| noise(index - own, start))).collect()
    };
    (
        side(|parameter| parameter.lower, &|_, start| start - MIN),
        side(|parameter| parameter.upper, &|noise, start| {
            let known = settings.largest_process_sigma.iter();
            let mut known = known.filter(|(name, _)| structure.noises.get(noise) == Some(name));
            known.next().map_or(start + MAX, |(_, largest)| largest.ln().max(start))
        }),
    )
}

/// The whole parameter vector at its initial values, and its free entries.
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
