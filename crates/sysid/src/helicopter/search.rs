//! Searches for the parameters of the parts of a model.

use rayon::prelude::*;

use super::equations::largest_process_sigma;
use super::flight::{INJECTED, STEPPED};
use super::found::{Found, WIDENED};
use super::kind::Kind;
use super::velocity_error::VelocityError;
use crate::methods::prediction_error::{
    self, Dropping, Identified, PredictionErrorError, Settings, Status,
};
use crate::methods::structure::Structure;
use crate::record::Experiment;

/// Longest time over which residuals may be correlated, s: about the length of a gust.
const RESIDUAL_CORRELATION_S: f64 = 2.0;

/// `structure` with the correlation times of the velocity's `error`.
fn with_error(structure: Structure, error: &VelocityError) -> Structure {
    structure.with("tau_vh", error.horizontal.time_s, true).with(
        "tau_vv",
        error.vertical.time_s,
        true,
    )
}

/// Data and settings of a search.
pub(super) struct Search<'a> {
    pub stretches: &'a [Experiment],
    pub error: &'a VelocityError,
    /// Sticks that never move.
    pub still: &'a [String],
    pub period_s: f64,
    /// Unit of each stick; see [`Structure::in_units`].
    pub units: [f64; 4],
}

impl Search<'_> {
    fn prepared(&self, structure: Structure) -> Structure {
        self.still
            .iter()
            .fold(with_error(structure.in_units(self.units), self.error), |known, stick| {
                known.with_still(stick)
            })
    }

    pub fn settings(&self, kind: Kind) -> Settings {
        Settings {
            held_sigma: kind.held_sigma(self.error, self.period_s),
            largest_process_sigma: largest_process_sigma(self.error, self.period_s),
            dropping: Some(Dropping::default()),
            residual_correlation_s: RESIDUAL_CORRELATION_S,
            widened: WIDENED,
            ..Settings::innovations(kind.process_sigma(self.error, self.period_s))
        }
    }

    /// Identifies each part of `kind` on its own; a `kind` without parts as a whole.
    pub fn parts(&self, kind: Kind) -> Result<Vec<Found>, PredictionErrorError> {
        match kind.parts() {
            [] => Ok(vec![self.best(kind)?]),
            parts => parts.par_iter().map(|&part| self.best(part)).collect(),
        }
    }

    /// Roll and pitch without flapping in place of `part`, if its rotor flaps as fast as the limit allows and the data
    /// are more likely without flapping, by Akaike's criterion. The lags of the inputs then also contain those of a
    /// multirotor's motors.
    pub fn without_flapping(&self, part: &Found) -> Option<Found> {
        let rotor = part.identified.estimates.get("tau_f");
        if part.kind != Kind::Flapping || rotor.is_none_or(|own| own.status != Status::OnBound) {
            return None;
        }
        let rigid = self.best(Kind::RollPitch).ok();
        rigid.filter(|own| own.identified.aic < part.identified.aic)
    }

    /// Continues the search of each part on the data of this search. A stabiliser bar that these data do not justify is
    /// also removed from `parts`.
    pub fn on_from(&self, parts: &mut [Found]) -> Result<Vec<Found>, PredictionErrorError> {
        let on_from = |part: &mut Found| {
            let settings = self.settings(part.kind);
            let on = |found| prediction_error::identify_on(found, self.stretches, &settings);
            let identified = on(&part.identified)?;
            let Some(without_bar) = part.without_bar.take() else {
                return Ok(Found::alone(part.kind, identified));
            };
            let Ok(without) = on(&without_bar) else {
                return Ok(Found::alone(part.kind, identified));
            };
            let mut found = Found::of_two(part.kind, identified, without);
            if found.without_bar.is_none() {
                part.identified = without_bar;
                part.passed_over = found.passed_over.take();
            }
            Ok(found)
        };
        parts.par_iter_mut().map(on_from).collect()
    }

    /// The model of `kind`, assembled from its `parts`.
    pub fn whole(&self, kind: Kind, parts: &[Found]) -> Result<Identified, PredictionErrorError> {
        let parts = parts.iter().map(|part| self.with_injected_delay(part));
        let parts = parts.collect::<Result<Vec<Identified>, _>>()?;
        if let [all] = &parts[..] {
            return Ok(all.clone());
        }
        let structure = self.prepared(kind.structure());
        prediction_error::assemble(&structure, &parts, self.stretches, &self.settings(kind))
    }

    /// `part` with the collective's delay re-estimated from the injected movement, or else from the steps of its test
    /// points. A height controller responds to gusts, and the likelihood interprets that response as a delay.
    fn with_injected_delay(&self, part: &Found) -> Result<Identified, PredictionErrorError> {
        let found = &part.identified;
        if part.kind != Kind::Heave {
            return Ok(found.clone());
        }
        let settings = self.settings(part.kind);
        for deliberate in [INJECTED[2], STEPPED[2]] {
            let signals = ("collective", deliberate);
            let told =
                prediction_error::delay_from_injected(found, signals, self.stretches, &settings)?;
            if let Some(told) = told {
                return Ok(told);
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
        let of = |kind: Kind| parts.iter().find(|part| part.kind == kind);
        let part = of(Kind::Yaw).filter(|_| !self.is_still("pedal")).or_else(|| of(Kind::Heave))?;
        let name = part.kind.own_delay()?;
        let mut free = part.identified.clone();
        let place = free.structure.parameter(name)?;
        let limit_s = free.structure.parameters[place].lower;
        let own = free.estimates.list.get(place)?;
        if own.status != Status::OnBound || own.value > limit_s {
            return None;
        }
        free.structure.parameters[place].lower = EARLIEST_S;
        let settings = self.settings(part.kind);
        let samples = ((limit_s - EARLIEST_S) / self.period_s) as usize;
        let tried = (0..=samples).into_par_iter().filter_map(|sample| {
            let start = (name, limit_s - sample as f64 * self.period_s);
            prediction_error::identify_from(&free, start, self.stretches, &settings).ok()
        });
        let best = tried.min_by(|one, other| one.aic.total_cmp(&other.aic))?;
        let late = |name: &str| best.estimates.get(name).map_or(0.0, |own| own.value);
        let late_s = late(name) + late(&name.replace("tau", "lag"));
        (late_s < limit_s).then_some(-late_s)
    }

    fn is_still(&self, stick: &str) -> bool {
        self.still.iter().any(|still| still == stick)
    }

    /// The most likely result of the searches from all starts.
    ///
    /// Where process noise can replace the response to the sticks, the likelihood has a second optimum. The searches
    /// therefore start near both optima.
    fn best(&self, kind: Kind) -> Result<Found, PredictionErrorError> {
        /// Model, parameter, initial value of the parameter, and factor on the initial process noise.
        const STARTS: [(Kind, &str, f64, f64); 5] = [
            (Kind::Flapping, "tau_f", 0.1, 1.0),
            (Kind::Yaw, "Nr", -4.0, 1.0),
            (Kind::Yaw, "Nr", -25.0, 0.1),
            (Kind::Heave, "Zw", -0.7, 1.0),
            (Kind::Heave, "Zw", -0.7, 10.0),
        ];
        let structure = self.prepared(kind.structure());
        // Velocity held from fix to fix serves for comparison only, so one search is enough.
        let is_held = *self.error == VelocityError::NONE;
        let most = if is_held { 1 } else { STARTS.len() };
        let starts: Vec<_> = STARTS.iter().filter(|(of, ..)| *of == kind).take(most).collect();
        let tried: Vec<_> = starts
            .par_iter()
            .map(|&&(_, name, start, noise)| {
                let mut settings = self.settings(kind);
                if let prediction_error::Form::Innovations(sigmas) = &mut settings.form {
                    let own = structure
                        .noises
                        .iter()
                        .map(|name| matches!(name.as_str(), "n_p" | "n_q" | "n_r" | "n_dw"));
                    sigmas
                        .iter_mut()
                        .zip(own)
                        .filter(|(_, own)| *own)
                        .for_each(|(s, _)| *s *= noise);
                }
                let structure = structure.clone().with(name, start, false);
                let found = prediction_error::identify(&structure, self.stretches, &settings);
                // Starts are compared at their best delays.
                found.map(|found| if is_held { found } else { self.hopped(found, kind) })
            })
            .collect();
        let alone = |identified| Found::alone(kind, identified);
        let mut tried = tried.into_iter();
        let Some(first) = tried.next() else {
            let settings = self.settings(kind);
            return prediction_error::identify(&structure, self.stretches, &settings).map(alone);
        };
        let best = tried.fold(first, |best, next| match (&best, &next) {
            (Ok(one), Ok(other)) if other.aic < one.aic => next,
            (Err(_), Ok(_)) => next,
            _ => best,
        })?;
        if kind == Kind::Flapping && !is_held {
            let with_bar = structure.with_bar(&best.estimates, self.units);
            return Ok(self.with_bar(best, kind, &with_bar));
        }
        Ok(alone(best))
    }

    /// The most likely of `found` and the optima whose delay differs by whole samples.
    ///
    /// Between two samples the held stick is a weighted mean of both. The likelihood therefore has an optimum of the
    /// delay at each sample. Under feedback the neighbouring optimum is nearly as likely.
    fn hopped(&self, mut found: Identified, kind: Kind) -> Identified {
        /// Largest number of samples in each direction.
        const MOST: usize = 3;
        let Some(delay) = kind.own_delay() else { return found };
        let settings = self.settings(kind);
        for by_s in [-self.period_s, self.period_s] {
            for _ in 0..MOST {
                let now_s = found.estimates.get(delay).map_or(0.0, |estimate| estimate.value);
                let start = (delay, now_s + by_s);
                let other =
                    prediction_error::identify_from(&found, start, self.stretches, &settings);
                match other {
                    Ok(other) if other.aic < found.aic => found = other,
                    _ => break,
                }
            }
        }
        found
    }

    /// Selects between `known` and the result of a search with `structure`, which adds a stabiliser bar.
    fn with_bar(&self, known: Identified, kind: Kind, structure: &Structure) -> Found {
        // The search starts at the noise found without a bar. A gust tilts the disc by the same angle, so its rate of
        // tilt scales with the speed of the rotor. With the default initial noise, noise sometimes replaces the effect
        // of the bar.
        let rotor = structure.parameter("tau_f");
        let faster = rotor.map_or(1.0, |own| known.values()[own] / structure.parameters[own].start);
        let noises = structure.noises.iter().zip(known.process_sigma());
        let sigmas = noises.map(|(name, sigma)| match name.as_str() {
            "n_dp" | "n_dq" => faster * sigma,
            _ => sigma,
        });
        let form = prediction_error::Form::Innovations(sigmas.collect());
        let settings = Settings { form, ..self.settings(kind) };
        let found = prediction_error::identify(structure, self.stretches, &settings).ok();
        match found.filter(|found| found.aic < known.aic) {
            Some(found) => Found::of_two(kind, found, known),
            None => Found::alone(kind, known),
        }
    }
}
