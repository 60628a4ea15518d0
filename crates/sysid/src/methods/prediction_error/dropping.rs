//! Leaving out what the data do not know.

use super::error::PredictionErrorError;
use super::estimates::{Estimate, Estimates, Status};
use super::identified::{Identified, OwnValues};
use super::problem::Problem;
use super::settings::{Dropping, Settings};
use super::statistics;
use crate::methods::least_squares::{Limits, Minimum, minimise};
use crate::methods::structure::Parameter;

/// Searches, then drops one parameter after the other and searches again.
pub(super) fn search(
    mut problem: Problem<'_>,
    settings: &Settings,
) -> Result<Identified, PredictionErrorError> {
    let mut iterations = settle(&mut problem, settings)?;
    let mut theta: Vec<f64> = problem.free.iter().map(|&index| problem.base[index]).collect();
    let mut minimum = minimised(&problem, &theta, settings.limits)?;
    iterations += minimum.iterations;
    let (mut log, mut dropped, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    let estimates = loop {
        let estimates = summarise(&problem, &minimum, settings, &dropped)?;
        let candidate = settings.dropping.as_ref().and_then(|limits| {
            let known = |index: &usize| kept.contains(index);
            worst(&estimates, limits, problem.structure.parameters.len(), known)
                .map(|(index, why)| (index, why, *limits))
        });
        let Some((index, why, limits)) = candidate else { break estimates };
        let Some(place) = problem.free.iter().position(|&free| free == index) else {
            break estimates;
        };
        let (name, before) = (problem.structure.parameters[index].name.clone(), minimum.clone());
        let (base, free) = (problem.base.clone(), problem.free.clone());
        let start = problem.structure.parameters[index].start;
        let value = if problem.structure.divides(index) { start } else { 0.0 };
        problem.base[index] = value;
        problem.free.remove(place);
        theta = minimum.theta.clone();
        theta.remove(place);
        let estimate = &estimates.list[index];
        let inflation = (estimate.bound / estimate.white_bound).powi(2).max(1.0);
        let without = minimised(&problem, &theta, settings.limits);
        let rise = without
            .as_ref()
            .map_or(f64::INFINITY, |without| 2.0 * (without.at.cost - before.at.cost) / inflation);
        match without {
            Ok(without) if rise <= limits.likelihood_rise => {
                iterations += without.iterations;
                log.push(format!("{name} dropped at {value}: {why}; −2 ln L rises by {rise:.2}"));
                dropped.push(index);
                minimum = without;
            }
            _ => {
                log.push(format!("{name} kept though {why}: −2 ln L would rise by {rise:.2}"));
                kept.push(index);
                (problem.base, problem.free) = (base, free);
                minimum = before;
            }
        }
    };
    finish(&problem, &minimum, estimates, iterations, log, &dropped)
}

/// A first search with the outputs' noise held at what their differences say.
///
/// Process noise can stand in for an output's noise and explain each sample by itself: that is a
/// second optimum of the likelihood, and a search from far off may end there.
fn settle(problem: &mut Problem<'_>, settings: &Settings) -> Result<usize, PredictionErrorError> {
    let first_output = problem.structure.parameters.len() + problem.structure.noises.len();
    let all = problem.free.clone();
    problem.free.retain(|&index| index < first_output);
    let start: Vec<f64> = problem.free.iter().map(|&index| problem.base[index]).collect();
    let minimum = minimised(problem, &start, settings.limits)?;
    problem.base = problem.whole(&minimum.theta);
    problem.free = all;
    Ok(minimum.iterations)
}

/// The parameter to drop next, and why: the most insensitive, then the least bounded.
fn worst(
    estimates: &Estimates,
    limits: &Dropping,
    own: usize,
    known: impl Fn(&usize) -> bool,
) -> Option<(usize, String)> {
    let candidates = || {
        let free = estimates.free.iter().copied().filter(|index| *index < own && !known(index));
        free.map(|index| (index, &estimates.list[index]))
    };
    let most = |percent: fn(&Estimate) -> f64, limit: f64| {
        candidates()
            .map(|(index, estimate)| (index, percent(estimate)))
            .filter(|(_, percent)| *percent > limit)
            .max_by(|one, other| one.1.total_cmp(&other.1))
    };
    if let Some((index, percent)) =
        most(Estimate::insensitivity_percent, limits.insensitivity_percent)
    {
        return Some((index, format!("its insensitivity is {percent:.0} %")));
    }
    most(Estimate::bound_percent, limits.bound_percent)
        .map(|(index, percent)| (index, format!("its bound is {percent:.0} %")))
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
        Some(white.clone())
    } else {
        problem.pass(&minimum.theta, true).and_then(|(_, forced, passed)| {
            statistics::colored_covariance(problem, &white, &forced, &passed, lags)
        })
    };
    let (mut covariance, mut white) = (covariance.ok_or_else(singular)?, white);
    let whole = problem.whole(&minimum.theta);
    let structure = problem.structure;
    let own = structure.parameters.len();
    // From ln σ to σ.
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
    Ok(Estimates { list, free: problem.free.clone(), covariance })
}

fn finish(
    problem: &Problem<'_>,
    minimum: &Minimum,
    estimates: Estimates,
    iterations: usize,
    log: Vec<String>,
    dropped: &[usize],
) -> Result<Identified, PredictionErrorError> {
    let singular = || PredictionErrorError::Singular { structure: problem.structure.name.clone() };
    let (predictor, _, passed) = problem.pass(&minimum.theta, false).ok_or_else(singular)?;
    let samples = problem.samples();
    let innovations_covariance =
        statistics::innovations_covariance(&passed, &predictor.whitener, samples)
            .ok_or_else(singular)?;
    let theta = problem.whole(&minimum.theta);
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
    let unknowns = (problem.free.len() + passed.own.iter().map(Vec::len).sum::<usize>()) as f64;
    let (count, outputs) = (samples as f64, structure.outputs.len() as f64);
    let constant = count * outputs * std::f64::consts::TAU.ln();
    Ok(Identified {
        innovations_form: problem.innovations,
        period_s: problem.period_s,
        samples,
        own,
        log,
        aic: 2.0 * minimum.at.cost + constant + 2.0 * unknowns,
        fpe: innovations_covariance.determinant() * (count + unknowns) / (count - unknowns),
        innovations_covariance,
        iterations,
        converged: minimum.converged,
        estimates,
        structure,
        theta,
    })
}

/// One search from where `problem` stands.
fn minimised(
    problem: &Problem<'_>,
    start: &[f64],
    limits: Limits,
) -> Result<Minimum, PredictionErrorError> {
    // A noise a thousand times off its start is not there, or not noise.
    const WIDEST: f64 = 7.0;
    let bound = |side: fn(&Parameter) -> f64, widen: f64| -> Vec<f64> {
        let free = problem.free.iter();
        free.map(|&index| match problem.structure.parameters.get(index) {
            Some(parameter) => side(parameter),
            None => problem.base[index] + widen,
        })
        .collect()
    };
    let lower = bound(|parameter| parameter.lower, -WIDEST);
    let upper = bound(|parameter| parameter.upper, WIDEST);
    minimise(problem, start, &lower, &upper, limits)
        .ok_or_else(|| PredictionErrorError::Start { structure: problem.structure.name.clone() })
}
