//! Dropping of parameters that the data do not identify.

use super::error::PredictionErrorError;
use super::estimates::{Estimate, Estimates, Status};
use super::identified::{Identified, OwnValues};
use super::problem::Problem;
use super::settings::{Dropping, Settings};
use super::statistics;
use crate::methods::least_squares::{Cost as _, Limits, Minimum, minimise};

/// Predicted decrease of the cost at which an intermediate search ends. It is far below the rise of the cost that
/// decides whether a parameter is dropped.
const COARSE: f64 = 0.05;

/// Searches, drops the parameters that the data do not identify, several at once, and searches again.
pub(super) fn search(
    mut problem: Problem<'_>,
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let mut iterations = settle(&mut problem, settings)?;
    let theta: Vec<f64> = problem.free.iter().map(|&index| problem.base[index]).collect();
    let min_decrease = COARSE.max(settings.limits.min_decrease);
    let coarse = Limits { min_decrease, ..settings.limits };
    let mut minimum = minimised(&problem, &theta, coarse)?;
    iterations += minimum.iterations;
    if problem.priors().next().is_some() {
        weigh_priors(&mut problem, &minimum, settings)?;
        minimum = minimised(&problem, &minimum.theta, coarse)?;
        iterations += minimum.iterations;
    }
    let (mut log, mut dropped, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(limits) = &settings.dropping {
        let estimates = summarise(&problem, &minimum, settings, &dropped)?;
        let mut weak = unknown(&problem, &estimates, limits);
        weak.retain(|(index, ..)| !kept.contains(index));
        if weak.is_empty() {
            break;
        }
        // All insignificant parameters are dropped together. If the cost then rises too much, the attempt is repeated
        // with the less significant half.
        weak.sort_by(|one, other| one.1.total_cmp(&other.1));
        loop {
            let before = (problem.base.clone(), problem.free.clone());
            let theta = remove_weak(&mut problem, &minimum, &weak);
            let without = minimised(&problem, &theta, coarse);
            let inflation = weak.iter().map(|weak| weak.2).fold(1.0, f64::max);
            let rise = without.as_ref().map_or(f64::INFINITY, |without| {
                2.0 * (without.at.cost - minimum.at.cost) / inflation
            });
            match without {
                Ok(without) if rise <= limits.likelihood_rise * weak.len() as f64 => {
                    iterations += without.iterations;
                    let together = match weak.len() {
                        1 => String::new(),
                        count => format!(" for {count} together"),
                    };
                    log.extend(weak.iter().map(|(index, ..)| {
                        let estimate = &estimates.list[*index];
                        let (name, percent) = (&estimate.name, estimate.bound_percent());
                        let value = problem.base[*index];
                        format!(
                            "{name} dropped at {value}: its bound is {percent:.0} %; −2 ln L rises by \
                             {rise:.2}{together}"
                        )
                    }));
                    dropped.extend(weak.iter().map(|(index, ..)| *index));
                    minimum = without;
                    break;
                }
                _ => (problem.base, problem.free) = before,
            }
            if weak.len() == 1 {
                let estimate = &estimates.list[weak[0].0];
                let (name, percent) = (&estimate.name, estimate.bound_percent());
                log.push(format!(
                    "{name} kept though its bound is {percent:.0} %: −2 ln L would rise by {rise:.2}"
                ));
                kept.push(weak[0].0);
                break;
            }
            weak.truncate(weak.len().div_ceil(2));
        }
    }
    minimum = minimised(&problem, &minimum.theta, settings.limits)?;
    iterations += minimum.iterations;
    let estimates = summarise(&problem, &minimum, settings, &dropped)?;
    finish(&problem, &minimum, estimates, iterations, log, &dropped)
}

/// Continues the search from the end of `found`, possibly on other records, without dropping parameters.
pub(super) fn search_on(
    mut problem: Problem<'_>,
    found: &Identified,
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    problem.base.clone_from(&found.theta);
    problem.free.clone_from(&found.estimates.free);
    let theta: Vec<f64> = problem.free.iter().map(|&index| problem.base[index]).collect();
    if problem.priors().next().is_some() {
        let here = minimised(&problem, &theta, Limits { iterations: 1, ..settings.limits })?;
        weigh_priors(&mut problem, &here, settings)?;
    }
    let minimum = minimised(&problem, &theta, settings.limits)?;
    let list = found.estimates.list.iter().enumerate();
    let dropped: Vec<usize> =
        list.filter(|(_, own)| own.status == Status::Dropped).map(|(index, _)| index).collect();
    let estimates = summarise(&problem, &minimum, settings, &dropped)?;
    let iterations = found.iterations + minimum.iterations;
    finish(&problem, &minimum, estimates, iterations, found.log.clone(), &dropped)
}

/// Parameters that may be dropped and differ insignificantly from their dropped values: index, Wald statistic, and
/// factor by which coloured innovations increase their variance.
fn unknown(
    problem: &Problem<'_>,
    estimates: &Estimates,
    limits: &Dropping,
) -> Vec<(usize, f64, f64)> {
    let parameters = &problem.structure.parameters;
    let free = estimates.free.iter().filter(|&&index| index < parameters.len());
    let candidates = free.filter_map(|&index| {
        let estimate = &estimates.list[index];
        let wide = estimate.bound_percent() > limits.bound_percent
            || estimate.insensitivity_percent() > limits.insensitivity_percent;
        let wald = ((estimate.value - without(problem, index)) / estimate.bound).powi(2);
        let inflation = (estimate.bound / estimate.white_bound).powi(2).max(1.0);
        let goes = wide && !parameters[index].needed && wald <= limits.likelihood_rise;
        goes.then_some((index, wald, inflation))
    });
    candidates.collect()
}

/// Value of a dropped parameter.
fn without(problem: &Problem<'_>, index: usize) -> f64 {
    if problem.structure.divides(index) { problem.structure.parameters[index].start } else { 0.0 }
}

/// Removes `weak` from the search and returns the remaining parameter values.
fn remove_weak(
    problem: &mut Problem<'_>,
    minimum: &Minimum,
    weak: &[(usize, f64, f64)],
) -> Vec<f64> {
    let goes = |index: usize| weak.iter().any(|(weak, ..)| *weak == index);
    let theta = problem.free.iter().zip(&minimum.theta);
    let theta = theta.filter(|(index, _)| !goes(**index)).map(|(_, value)| *value).collect();
    problem.free.retain(|&index| !goes(index));
    for &(index, ..) in weak {
        problem.base[index] = without(problem, index);
    }
    theta
}

/// Weights the priors by the information of the actual innovations, instead of that of white innovations.
///
/// # Source
/// Equation (I27) of docs/equations.md.
fn weigh_priors(
    problem: &mut Problem<'_>,
    minimum: &Minimum,
    settings: &Settings,
) -> Result<(), PredictionErrorError> {
    let singular = || PredictionErrorError::Singular { structure: problem.structure.name.clone() };
    let lags = (settings.residual_correlation_s / problem.period_s).round() as usize;
    let (_, forced, passed) = problem.pass(&minimum.theta, true).ok_or_else(singular)?;
    let ratios = statistics::overconfidence(problem, &minimum.at, &forced, &passed, lags)
        .ok_or_else(singular)?;
    let mut weight = vec![1.0; problem.base.len()];
    for (&index, ratio) in problem.free.iter().zip(ratios) {
        weight[index] = ratio * settings.widened.powi(2);
    }
    problem.prior_weight = weight;
    Ok(())
}

/// First search for the structure's own parameters. All noise is fixed, that of the outputs at a tenth of their
/// standard deviation.
///
/// Process noise can replace the response to the sticks and explain each sample by the previous sample. That is a
/// second optimum of the likelihood, in which a search from a distant start may end.
fn settle(problem: &mut Problem<'_>, settings: &Settings) -> Result<usize, PredictionErrorError> {
    /// σ of an output's noise, as a fraction of the output's standard deviation.
    const NOISE: f64 = 0.1;
    let structure = problem.structure;
    let first_noise = structure.parameters.len();
    let first_output = first_noise + structure.noises.len();
    let (all, base) = (problem.free.clone(), problem.base.clone());
    let outputs = structure.outputs.len();
    for output in 0..outputs {
        let index = first_output + output;
        if all.contains(&index) {
            let sigma = NOISE * statistics::deviation_of(problem.records, output, outputs);
            problem.base[index] = sigma.ln().max(base[index]);
        }
    }
    problem.free.retain(|&index| index < first_noise);
    let start: Vec<f64> = problem.free.iter().map(|&index| problem.base[index]).collect();
    // The result is only an initial value: convergence to one unit of −ln L is sufficient.
    let minimum = minimised(problem, &start, Limits { min_decrease: 1.0, ..settings.limits })?;
    let found = problem.whole(&minimum.theta);
    problem.base[..first_noise].copy_from_slice(&found[..first_noise]);
    problem.base[first_noise..].copy_from_slice(&base[first_noise..]);
    problem.free = all;
    Ok(minimum.iterations)
}

fn summarise(
    problem: &Problem<'_>,
    minimum: &Minimum,
    settings: &Settings,
    dropped: &[usize],
) -> Result<Estimates, PredictionErrorError> {
    let singular = || PredictionErrorError::Singular { structure: problem.structure.name.clone() };
    let lags = (settings.residual_correlation_s / problem.period_s).round() as usize;
    let white = statistics::white_covariance(&minimum.at).ok_or_else(singular)?;
    let covariance = if lags == 0 {
        Some(&white * settings.widened.powi(2))
    } else {
        problem.pass(&minimum.theta, true).and_then(|(_, forced, passed)| {
            statistics::colored_covariance(
                problem,
                &white,
                &forced,
                &passed,
                lags,
                settings.widened,
            )
        })
    };
    let (mut covariance, mut white) = (covariance.ok_or_else(singular)?, white);
    // Fixed noise may exceed the noise of the flight. A bound is therefore never below the bound for white innovations
    // with the noise of the model.
    let widen: Vec<f64> = (0..white.nrows())
        .map(|place| settings.widened * (white[(place, place)] / covariance[(place, place)]).sqrt())
        .map(|factor| if factor.is_finite() { factor.max(1.0) } else { 1.0 })
        .collect();
    for (place, factor) in widen.iter().enumerate() {
        covariance.row_mut(place).scale_mut(*factor);
        covariance.column_mut(place).scale_mut(*factor);
    }
    let whole = problem.whole(&minimum.theta);
    let structure = problem.structure;
    let own = structure.parameters.len();
    // Scale from ln σ to σ.
    let scale: Vec<f64> = problem
        .free
        .iter()
        .map(|&index| if index < own { 1.0 } else { whole[index].exp() })
        .collect();
    for matrix in [&mut covariance, &mut white] {
        for (place, factor) in scale.iter().enumerate() {
            matrix.row_mut(place).scale_mut(*factor);
            matrix.column_mut(place).scale_mut(*factor);
        }
    }
    let noises = structure.noises.iter().chain(&structure.outputs);
    let names = structure
        .parameters
        .iter()
        .map(|parameter| (parameter.name.clone(), parameter.unit.clone(), parameter.start))
        .chain(noises.map(|noise| (format!("σ {noise}"), String::new(), f64::NAN)));
    let list = names
        .enumerate()
        .map(|(index, (name, unit, start))| {
            let is_noise = index >= own;
            let value = if is_noise { whole[index].exp() } else { whole[index] };
            let start = if is_noise { problem.base[index].exp() } else { start };
            let mut estimate = Estimate {
                name,
                unit,
                value,
                start,
                status: if dropped.contains(&index) { Status::Dropped } else { Status::Held },
                bound: 0.0,
                white_bound: 0.0,
                insensitivity: 0.0,
            };
            if let Some(place) = problem.free.iter().position(|&free| free == index) {
                let sigma = |variance: f64| variance.max(0.0).sqrt();
                estimate.status =
                    if minimum.on_bound[place] { Status::OnBound } else { Status::Free };
                estimate.bound = sigma(covariance[(place, place)]);
                estimate.white_bound = sigma(white[(place, place)]);
                estimate.insensitivity =
                    scale[place] / minimum.at.information[(place, place)].sqrt();
            }
            estimate
        })
        .collect();
    Ok(Estimates { list, free: problem.free.clone(), covariance, white_covariance: white })
}

fn finish(
    problem: &Problem<'_>,
    minimum: &Minimum,
    estimates: Estimates,
    iterations: usize,
    log: Vec<String>,
    dropped: &[usize],
) -> Result<Identified, PredictionErrorError> {
    let ended = Ended { cost: minimum.at.cost, iterations, converged: minimum.converged };
    described(problem, &minimum.theta, estimates, &ended, log, dropped)
}

/// Final cost and iterations of the searches.
pub(super) struct Ended {
    pub cost: f64,
    pub iterations: usize,
    pub converged: bool,
}

/// Result of [`assemble`](super::assemble) for the parts: `problem` contains their values and has no free parameters.
pub(super) fn assembled(
    problem: &Problem<'_>,
    estimates: Estimates,
    parts: &[Identified],
) -> Result<Identified, PredictionErrorError> {
    let singular = || PredictionErrorError::Singular { structure: problem.structure.name.clone() };
    let ended = Ended {
        cost: problem.cost(&[]).ok_or_else(singular)?,
        iterations: parts.iter().map(|part| part.iterations).sum(),
        converged: parts.iter().all(|part| part.converged),
    };
    let log = parts.iter().flat_map(|part| part.log.iter().cloned()).collect();
    let own = problem.structure.parameters.len();
    let dropped: Vec<usize> =
        (0..own).filter(|&index| estimates.list[index].status == Status::Dropped).collect();
    let held: Vec<usize> = (0..own).filter(|index| !estimates.free.contains(index)).collect();
    let mut found = described(problem, &[], estimates, &ended, log, &dropped)?;
    for index in held {
        found.structure.parameters[index].fixed = true;
    }
    Ok(found)
}

pub(super) fn described(
    problem: &Problem<'_>,
    theta: &[f64],
    estimates: Estimates,
    ended: &Ended,
    log: Vec<String>,
    dropped: &[usize],
) -> Result<Identified, PredictionErrorError> {
    let singular = || PredictionErrorError::Singular { structure: problem.structure.name.clone() };
    let (steady, _, passed) = problem.pass(theta, true).ok_or_else(singular)?;
    let samples = problem.samples();
    let innovations_covariance =
        statistics::innovations_covariance(&passed, &steady.predictor.whitener, samples)
            .ok_or_else(singular)?;
    let theta = problem.whole(theta);
    let mut structure = problem.structure.clone();
    for &index in dropped {
        structure.parameters[index].fixed = true;
        structure.parameters[index].start = theta[index];
    }
    let (n, o) = (structure.states.len(), structure.offsets.len());
    let own: Vec<OwnValues> = problem
        .records
        .iter()
        .zip(&passed.own)
        .map(|(record, own)| OwnValues {
            experiment: record.name.clone(),
            initial_state: own[..n].to_vec(),
            offsets: own[n..n + o].to_vec(),
            biases: own[n + o..].to_vec(),
        })
        .collect();
    let unknowns = (estimates.free.len() + passed.own.iter().map(Vec::len).sum::<usize>()) as f64;
    let (count, outputs) = (samples as f64, structure.outputs.len() as f64);
    let constant = count * outputs * std::f64::consts::TAU.ln();
    Ok(Identified {
        innovations_form: problem.innovations,
        period_s: problem.period_s,
        samples,
        own,
        log,
        aic: 2.0 * ended.cost + constant + 2.0 * unknowns,
        fpe: innovations_covariance.determinant() * (count + unknowns) / (count - unknowns),
        innovations_covariance,
        innovations_correlation: statistics::innovations_correlation(
            &passed,
            structure.outputs.len(),
            problem.period_s,
        ),
        iterations: ended.iterations,
        converged: ended.converged,
        estimates,
        structure,
        theta,
    })
}

/// One search, starting from the values of `problem`.
fn minimised(
    problem: &Problem<'_>,
    start: &[f64],
    limits: Limits,
) -> Result<Minimum, PredictionErrorError> {
    let of_free =
        |whole: &[f64]| problem.free.iter().map(|&index| whole[index]).collect::<Vec<_>>();
    let (lower, upper) = (of_free(&problem.lower), of_free(&problem.upper));
    minimise(problem, start, &lower, &upper, limits)
        .ok_or_else(|| PredictionErrorError::Start { structure: problem.structure.name.clone() })
}
