//! Several passes, and the best of them on held-back data.

use super::error::SubspaceError;
use super::input_fit::fit_initial_state;
use super::pass::identify;
use super::refine::{Criterion, RefineSettings, Refined, refine};
use super::settings::{Identified, SubspaceSettings, Weighting};
use crate::methods::innovation::InnovationModel;
use crate::methods::validate::fit_percent;
use crate::record::Experiment;

/// Settings of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchSettings {
    /// Number of states; `None` derives it from the singular values of the first pass, for all passes.
    pub order: Option<usize>,
    /// Horizons to try; those too long for the record are skipped.
    pub horizons: Vec<usize>,
    /// Weightings to try.
    pub weightings: Vec<Weighting>,
    /// Whether inputs act on outputs within the same sample.
    pub feedthrough: bool,
    /// Fraction of the record, at its end, that is held back from the fits while candidates are compared.
    pub set_aside: f64,
    /// Largest number of steps of each refinement.
    pub max_steps: usize,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self {
            order: None,
            horizons: vec![8, 12, 20, 30, 45],
            weightings: vec![Weighting::Cva, Weighting::Moesp, Weighting::N4sid],
            feedthrough: true,
            set_aside: 0.25,
            max_steps: 100,
        }
    }
}

/// A method that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The method.
    pub way: Way,
    /// Mean over the outputs of the simulation fit on the held-back data, percent.
    pub set_aside_fit: f64,
}

/// A method of identification.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// One subspace pass.
    Pass(SubspaceSettings),
    /// Refinement for simulation, started from this pass while candidates are compared. On the whole record it starts
    /// from every pass and keeps the lowest cost, because a single start may end in a local minimum.
    Refined(SubspaceSettings),
}

/// Result of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// The model, fitted on the whole record with the best method.
    pub model: InnovationModel,
    /// Best method.
    pub chosen: Candidate,
    /// All methods that gave a model, best first.
    pub candidates: Vec<Candidate>,
}

/// Tries every horizon and weighting, with and without refinement, on the first part of `experiment`. The method whose
/// simulation fits the rest best is then applied to the whole record.
///
/// The vehicle is assumed stable, as a simulation requires. The choice uses `experiment` only; validation data are not
/// used.
///
/// # Errors
/// The first pass's [`SubspaceError`] where no pass gave a model.
pub fn search(experiment: &Experiment, settings: &SearchSettings) -> Result<Search, SubspaceError> {
    let samples = experiment.samples();
    let fitted = ((1.0 - settings.set_aside.clamp(0.05, 0.5)) * samples as f64) as usize;
    let too_short = |_| SubspaceError::TooShort {
        experiment: experiment.name.clone(),
        samples,
        horizon: settings.horizons.first().copied().unwrap_or(0),
        needed: samples + 1,
    };
    let first = experiment.slice(0..fitted).map_err(too_short)?;
    let rest = experiment.slice(fitted..samples).map_err(too_short)?;

    let tried = Tried::on(&first, settings)?;
    let mut candidates: Vec<Candidate> = tried
        .passes
        .iter()
        .flat_map(|(pass, found)| {
            let refined = refined(found, &first, settings);
            let refined = refined.map(|refined| (Way::Refined(*pass), refined.model));
            [Some((Way::Pass(*pass), found.model.clone())), refined].into_iter().flatten()
        })
        .filter_map(|(way, model)| {
            Some(Candidate { way, set_aside_fit: free_run_fit(&model, &rest)? })
        })
        .collect();
    candidates.sort_by(|one, other| other.set_aside_fit.total_cmp(&one.set_aside_fit));
    for candidate in &candidates {
        let model = match candidate.way {
            Way::Pass(pass) => identify(experiment, &pass).ok().map(|found| found.model),
            Way::Refined(_) => Tried::on(experiment, settings)?.best_refined(experiment, settings),
        };
        if let Some(model) = model {
            return Ok(Search { model, chosen: candidate.clone(), candidates });
        }
    }
    Err(SubspaceError::Breakdown {
        experiment: experiment.name.clone(),
        step: "every method tried",
    })
}

/// All passes over one record.
struct Tried {
    passes: Vec<(SubspaceSettings, Identified)>,
}

impl Tried {
    fn on(experiment: &Experiment, settings: &SearchSettings) -> Result<Self, SubspaceError> {
        let mut order = settings.order;
        let mut failure = None;
        let mut passes = Vec::new();
        for &weighting in &settings.weightings {
            for &horizon in &settings.horizons {
                let (horizon, feedthrough) = (Some(horizon), settings.feedthrough);
                let pass =
                    SubspaceSettings { order, horizon, weighting, feedthrough, stable: true };
                match identify(experiment, &pass) {
                    Ok(found) => {
                        // All candidates have the same order.
                        order = Some(found.model.system.order());
                        passes.push((SubspaceSettings { order, ..pass }, found));
                    }
                    Err(error) => {
                        failure.get_or_insert(error);
                    }
                }
            }
        }
        match failure {
            Some(error) if passes.is_empty() => Err(error),
            _ => Ok(Self { passes }),
        }
    }

    fn best_refined(
        &self,
        experiment: &Experiment,
        settings: &SearchSettings,
    ) -> Option<InnovationModel> {
        self.passes
            .iter()
            .filter_map(|(_, found)| refined(found, experiment, settings))
            .min_by(|one, other| one.cost[1].total_cmp(&other.cost[1]))
            .map(|refined| refined.model)
    }
}

fn refined(
    start: &Identified,
    experiment: &Experiment,
    settings: &SearchSettings,
) -> Option<Refined> {
    let how = RefineSettings {
        criterion: Criterion::Simulation,
        feedthrough: settings.feedthrough,
        max_steps: settings.max_steps,
    };
    refine(start, experiment, &how)
}

fn free_run_fit(model: &InnovationModel, experiment: &Experiment) -> Option<f64> {
    let start = fit_initial_state(model, experiment);
    let run = model.system.simulate(&experiment.inputs, &start);
    let fits = fit_percent(&experiment.outputs, &run);
    let mean = fits.iter().sum::<f64>() / fits.len() as f64;
    mean.is_finite().then_some(mean)
}
