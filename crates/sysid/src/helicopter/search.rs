//! Searches for the parameters of the parts of a model.

use std::sync::Arc;

use rayon::prelude::*;

use super::flight::{INJECTED, STEPPED};
use super::found::{Found, WIDENED};
use super::model_structure::{ModelStructure, largest_process_sigma};
use super::velocity_error::VelocityError;
use crate::methods::prediction_error::{
    self, Dropping, Identified, PredictionErrorError, Settings, Status, delay_from_injected,
    identify_from_injected,
};
use crate::methods::structure::Structure;
use crate::record::Experiment;

/// Longest time over which residuals may be correlated, s: about the length of a gust.
const RESIDUAL_CORRELATION_S: f64 = 2.0;

/// Data and settings of a search.
pub(super) struct Search<'a> {
    pub stretches: &'a [Experiment],
    pub error: &'a VelocityError,
    /// Inputs that never move.
    pub still: &'a [String],
    pub period_s: f64,
    /// Range of each stick in the flight, in its unit.
    pub travels: [f64; 4],
}

impl Search<'_> {
    /// Value of each stick at full travel to one side, in the unit of the record; 1 if the numbers of `structure` are
    /// in this unit. See [`Structure::in_units`].
    fn units(&self, structure: &ModelStructure) -> [f64; 4] {
        self.travels.map(|travel| match structure.stick_travel {
            Some(usual) if travel > 0.0 => travel / usual,
            _ => 1.0,
        })
    }

    /// The equations of `structure` for this flight. Correlation times of the velocity's error come from the estimator.
    fn prepared(&self, structure: &ModelStructure) -> Structure {
        let mut equations = structure.equations.clone().in_units(self.units(structure));
        let error = self.error;
        for (name, time_s) in
            [("tau_vh", error.horizontal.time_s), ("tau_vv", error.vertical.time_s)]
        {
            let place = equations.parameter(name);
            if place.is_some_and(|place| equations.parameters[place].fixed) {
                equations = equations.with(name, time_s, true);
            }
        }
        self.still.iter().fold(equations, |known, input| known.with_still(input))
    }

    pub fn settings(&self, structure: &ModelStructure) -> Settings {
        Settings {
            held_sigma: structure.held_sigma(self.error, self.period_s),
            largest_process_sigma: largest_process_sigma(self.error, self.period_s),
            dropping: Some(Dropping::default()),
            residual_correlation_s: RESIDUAL_CORRELATION_S,
            widened: WIDENED,
            ..Settings::innovations(structure.process_sigma(self.error, self.period_s))
        }
    }

    /// Identifies each part of `structure` on its own; a `structure` without parts as a whole.
    pub fn parts(&self, structure: &ModelStructure) -> Result<Vec<Found>, PredictionErrorError> {
        match &structure.parts[..] {
            [] => Ok(vec![self.best(structure)?]),
            parts => parts.par_iter().map(|part| self.best(part)).collect(),
        }
    }

    /// Parts of `rigid`, a model without flapping, if two conditions hold. The rotor of `parts` flaps as fast as the
    /// limit allows. By Akaike's criterion, the data on roll and pitch are more likely without flapping.
    pub fn without_flapping(&self, parts: &[Found], rigid: &ModelStructure) -> Option<Vec<Found>> {
        let is_on_bound = |part: &&Found| {
            let rotor = part.identified.estimates.get("tau_f");
            rotor.is_some_and(|own| own.status == Status::OnBound)
        };
        let flapping = parts.iter().find(is_on_bound)?;
        let outputs = &flapping.structure.equations.outputs;
        let rigid = self.parts(rigid).ok()?;
        let own = rigid.iter().find(|part| part.structure.equations.outputs == *outputs)?;
        (own.identified.aic < flapping.identified.aic).then_some(rigid)
    }

    /// Continues the search of each part on the data of this search. A stabiliser bar that these data do not justify is
    /// also removed from `parts`.
    pub fn on_from(&self, parts: &mut [Found]) -> Result<Vec<Found>, PredictionErrorError> {
        let on_from = |part: &mut Found| {
            let settings = self.settings(&part.structure);
            let on = |found| prediction_error::identify_on(found, self.stretches, &settings);
            let identified = on(&part.identified)?;
            let Some(without_bar) = part.without_bar.take() else {
                return Ok(Found::alone(part.structure.clone(), identified));
            };
            let Ok(without) = on(&without_bar) else {
                return Ok(Found::alone(part.structure.clone(), identified));
            };
            let mut found = Found::of_two(part.structure.clone(), identified, without);
            if found.without_bar.is_none() {
                part.identified = without_bar;
                part.passed_over = found.passed_over.take();
            }
            Ok(found)
        };
        parts.par_iter_mut().map(on_from).collect()
    }

    /// The model of `structure`, assembled from its `parts`.
    pub fn whole(
        &self,
        structure: &ModelStructure,
        parts: &[Found],
    ) -> Result<Identified, PredictionErrorError> {
        let parts = parts.iter().map(|part| self.with_injected(part));
        let parts = parts.collect::<Result<Vec<Identified>, _>>()?;
        if let [all] = &parts[..] {
            return Ok(all.clone());
        }
        let settings = self.settings(structure);
        let equations = self.prepared(structure);
        prediction_error::assemble(&equations, &parts, self.stretches, &settings)
    }

    /// `part` with its parameters estimated again from the injected movement of the collective, or else its delay from
    /// the steps of its test points. A height controller responds to gusts, and the likelihood takes part of that response
    /// for the effect of the collective.
    fn with_injected(&self, part: &Found) -> Result<Identified, PredictionErrorError> {
        let (found, stretches) = (&part.identified, self.stretches);
        if is_of(part, "collective") {
            let settings = self.settings(&part.structure);
            let known = &part.known;
            let all = identify_from_injected(found, INJECTED[2], known, stretches, &settings)?;
            if let Some(all) = all {
                return Ok(all);
            }
            let steps = ("collective", STEPPED[2]);
            if let Some(delayed) = delay_from_injected(found, steps, stretches, &settings)? {
                return Ok(delayed);
            }
        }
        Ok(found.clone())
    }

    /// Time by which the vehicle responds before its sticks move, s, from yaw or else from heave. It is searched only
    /// where the estimated delay ended on its lower limit. The search is then repeated with a lower limit of −0.3 s,
    /// from initial values one sample apart.
    pub fn answers_early_s(&self, parts: &[Found]) -> Option<f64> {
        /// Lower limit of the delay in the repeated search, s.
        const EARLIEST_S: f64 = -0.3;
        let of = |stick: &str| parts.iter().find(|part| is_of(part, stick));
        let part = of("pedal").filter(|_| !self.is_still("pedal")).or_else(|| of("collective"))?;
        let (stick, name) = part.structure.own_delay()?;
        let mut free = part.identified.clone();
        let place = free.structure.parameter(name)?;
        let limit_s = free.structure.parameters[place].lower;
        let own = free.estimates.list.get(place)?;
        if own.status != Status::OnBound || own.value > limit_s {
            return None;
        }
        free.structure.parameters[place].lower = EARLIEST_S;
        let settings = self.settings(&part.structure);
        let samples = ((limit_s - EARLIEST_S) / self.period_s) as usize;
        let tried = (0..=samples).into_par_iter().filter_map(|sample| {
            let start = (name, limit_s - sample as f64 * self.period_s);
            prediction_error::identify_from(&free, start, self.stretches, &settings).ok()
        });
        let best = tried.min_by(|one, other| one.aic.total_cmp(&other.aic))?;
        let late = |name: &str| best.estimates.get(name).map_or(0.0, |own| own.value);
        let equations = &best.structure;
        let place = equations.inputs.iter().position(|own| own == stick);
        let lag = place.and_then(|input| equations.lags[input]);
        let late_s = late(name) + lag.map_or(0.0, |lag| late(&equations.parameters[lag].name));
        (late_s < limit_s).then_some(-late_s)
    }

    fn is_still(&self, stick: &str) -> bool {
        self.still.iter().any(|still| still == stick)
    }

    /// The most likely result of the searches from all starts.
    fn best(&self, structure: &ModelStructure) -> Result<Found, PredictionErrorError> {
        let equations = self.prepared(structure);
        // Velocity held from fix to fix serves for comparison only, so one search is enough.
        let is_held = *self.error == VelocityError::NONE;
        let most = if is_held { 1 } else { structure.starts.len() };
        let starts = structure.starts.iter().take(most);
        let tried = starts.collect::<Vec<_>>().into_par_iter().map(|start| {
            let mut settings = self.settings(structure);
            if let prediction_error::Form::Innovations(sigmas) = &mut settings.form {
                for (name, sigma) in equations.noises.iter().zip(sigmas) {
                    *sigma = start.noises.get(name).copied().unwrap_or(*sigma);
                }
            }
            let values = start.values.iter();
            let equations =
                values.fold(equations.clone(), |own, (name, value)| own.with(name, *value, false));
            prediction_error::identify(&equations, self.stretches, &settings)
        });
        let shared = Arc::new(structure.clone());
        let mut tried = tried.collect::<Vec<_>>().into_iter();
        let Some(first) = tried.next() else {
            let settings = self.settings(structure);
            let found = prediction_error::identify(&equations, self.stretches, &settings)?;
            return Ok(Found::alone(shared, found));
        };
        let best = tried.fold(first, |best, next| match (&best, &next) {
            (Ok(one), Ok(other)) if other.aic < one.aic => next,
            (Err(_), Ok(_)) => next,
            _ => best,
        })?;
        if structure.may_have_bar() && !is_held {
            let with_bar = equations.with_bar(&best.estimates, self.units(structure));
            return Ok(self.with_bar(best, shared, &with_bar));
        }
        Ok(Found::alone(shared, best))
    }

    /// Selects between `known` and the result of a search with `equations`, which add a stabiliser bar.
    fn with_bar(
        &self,
        known: Identified,
        structure: Arc<ModelStructure>,
        equations: &Structure,
    ) -> Found {
        // The search starts at the noise found without a bar. A gust tilts the disc by the same angle, so the noise of
        // the tilt rate scales with the inverse of the rotor's time constant. With the default initial noise, noise
        // sometimes replaces the effect of the bar.
        let rotor = equations.parameter("tau_f");
        let faster = rotor.map_or(1.0, |own| known.values()[own] / equations.parameters[own].start);
        let noises = equations.noises.iter().zip(known.process_sigma());
        let sigmas = noises.map(|(name, sigma)| match name.as_str() {
            "n_dp" | "n_dq" => faster * sigma,
            _ => sigma,
        });
        let form = prediction_error::Form::Innovations(sigmas.collect());
        let settings = Settings { form, ..self.settings(&structure) };
        let found = prediction_error::identify(equations, self.stretches, &settings).ok();
        match found.filter(|found| found.aic < known.aic) {
            Some(found) => Found::of_two(structure, found, known),
            None => Found::alone(structure, known),
        }
    }
}

/// Whether `stick` is the stick of `part` according to [`ModelStructure::own_delay`].
fn is_of(part: &Found, stick: &str) -> bool {
    part.structure.own_delay().is_some_and(|(own, _)| own == stick)
}
