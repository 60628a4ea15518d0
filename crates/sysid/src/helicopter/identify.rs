//! Identification of a helicopter model from a flight and its navigation solution.

use rayon::prelude::*;

use super::bandwidth::{LONGEST_PERIOD_S, bandwidth_hz, longest_period_s, moving};
use super::equations::largest_process_sigma;
use super::error::IdentifyError;
use super::flight::{FlightRecord, INJECTED, STEPPED, Velocity};
use super::found::Found;
use super::kind::Kind;
use super::measured::Measured;
use super::reconcile::Conflict;
use super::stretches;
use super::velocity_error::VelocityError;
use crate::methods::prediction_error::{
    self, Dropping, Fit, Identified, PredictionErrorError, Settings, Status,
};
use crate::methods::structure::Structure;
use crate::record::Experiment;
use crate::record::{STICKS, TestPoint, find_test_points, travels};
use crate::record::{Tone, find_tones};
use hovernav::ekf::Solution;
use hovernav_log::Dataset;

/// Windows of the simulated fits, s: long enough for a response, short enough for an unstable vehicle.
const WINDOW_S: f64 = 5.0;
/// Factor on the bounds for effects that the structure omits: servo and governor dynamics. Tischler and Remple, section
/// 12.3, use 2.
pub(super) const WIDENED: f64 = 1.5;
/// Travel of a stick in a flight that suits the initial values, as a fraction of full travel to one side.
const USUAL_TRAVEL: f64 = 0.3;
/// Lowest frequency of a vibration tone, Hz. A lower spectral line may be a mode of the helicopter.
const LEAST_TONE_HZ: f64 = 5.0;
/// Signals that are refilled with noise in the band of a removed tone: integrals of accelerometer signals.
pub(super) const FILLED: [&str; 3] = ["u", "v", "w"];
/// Longest time over which residuals may be correlated, s: about the length of a gust.
const RESIDUAL_CORRELATION_S: f64 = 2.0;

/// An identified helicopter and the data that it was identified from.
#[derive(Debug, Clone)]
pub struct Identification {
    /// The identified model.
    pub kind: Kind,
    /// Source of the velocity.
    pub velocity: Velocity,
    /// Vibration tones, notched out of every signal.
    pub tones: Vec<Tone>,
    /// Every test point of the flight.
    pub test_points: Vec<TestPoint>,
    /// Length of the flight used for the parameters, s: all flight near a hover, including the validation data.
    pub estimated_s: f64,
    /// The test points used for estimation: indices into `test_points`.
    pub estimation_points: Vec<usize>,
    /// The test points held back for validation.
    pub validation_points: Vec<usize>,
    /// The parameters with their bounds, and the log of dropped terms.
    pub identified: Identified,
    /// The cyclic model with a stabiliser bar that was not selected. Its likelihood is higher than without a bar, but
    /// not by enough.
    pub passed_over: Option<Identified>,
    /// Fit over windows of the estimation test points.
    pub estimation: Fit,
    /// Fit over the validation test points, if any, of the model identified without them.
    pub validation: Option<Fit>,
    /// Time by which the vehicle responds before its sticks move in the record, s. `None` unless it is longer than
    /// sampling can explain. The stick record is late by this time plus the lag of the servos.
    pub answers_early_s: Option<f64>,
    /// Parameters on which time and frequency domain differ by more than chance allows.
    pub conflicts: Vec<Conflict>,
    /// Warnings for the reader, one sentence each.
    pub warnings: Vec<String>,
}

/// Identifies a model of `kind` from a flight. Without a kind it is [`Hybrid`](Kind::Hybrid), or [`Hover`](Kind::Hover)
/// for a vehicle whose rotors do not flap: the rotor's
/// time constant is then on its limit, and Akaike's criterion prefers the model without flapping.
///
/// The model is identified from all flight near a hover except the validation data. The last repetition on each stick
/// with at least two is held back; for a flight without test points, every fourth piece of 10 s is. The validation data
/// judge that model. Its parameters are then estimated again with these data included, and a stabiliser bar must again
/// justify its extra parameters. The windows of the fits are simulated over 5 s, each from its own initial state.
///
/// # Errors
/// See [`IdentifyError`].
pub fn identify(
    dataset: &Dataset,
    solutions: &[Solution],
    kind: impl Into<Option<Kind>>,
    velocity: Velocity,
) -> Result<Identification, IdentifyError> {
    let requested = kind.into();
    let mut kind = requested.unwrap_or(Kind::Hybrid);
    let flown = FlightRecord::new(dataset, solutions, velocity)?;
    let least_hz = LEAST_TONE_HZ.max(bandwidth_hz(&flown.experiment));
    let tones = find_tones(&flown.experiment, least_hz);
    let record = flown.without_tones(&tones, &FILLED);
    let longest_s = match velocity {
        Velocity::Estimated => longest_period_s(&record.experiment),
        // Held GPS velocity serves for comparison only.
        Velocity::HeldGps => LONGEST_PERIOD_S,
    };
    let record = record.thinned(longest_s).map_err(IdentifyError::Preprocess)?;
    let end = record.start.offset_by(record.experiment.duration_s());
    let mut test_points = find_test_points(&dataset.controls);
    test_points.retain(|point| {
        point.start >= record.start && point.end <= end && record.is_whole(point.start, point.end)
    });
    let mut structure = kind.structure();
    let (mut estimation_points, mut validation_points) = (Vec::new(), Vec::new());
    for (index, stick) in STICKS.iter().enumerate() {
        if !structure.inputs.iter().any(|input| input == stick) {
            continue;
        }
        let mut own: Vec<usize> = (0..test_points.len())
            .filter(|&point| test_points[point].stick == Some(index))
            .collect();
        if own.len() >= 2 {
            validation_points.extend(own.pop());
        }
        estimation_points.extend(own);
    }
    let mut still = Vec::new();
    let moved = moving(&record.experiment, &STICKS);
    for stick in structure.inputs_of_pilot() {
        if !moved.contains(&stick) {
            if matches!((kind, stick), (Kind::Yaw, "pedal") | (Kind::Heave, "collective")) {
                return Err(IdentifyError::StillStick { kind, stick: stick.to_owned() });
            }
            still.push(stick.to_owned());
        }
    }
    let mut warnings: Vec<String> = record.gaps.iter().map(ToString::to_string).collect();
    if estimation_points.is_empty() {
        if still.len() == structure.inputs_of_pilot().count() {
            return Err(IdentifyError::StillStick { kind, stick: still.join(", ") });
        }
        let pieces = stretches::pieces(&record);
        if pieces.is_empty() {
            return Err(IdentifyError::NoHover { kind, least_s: stretches::LEAST_S });
        }
        warnings.push(format!(
            "no test point found on {}: the parameters come from the pilot's other stick movements",
            structure.inputs_of_pilot().collect::<Vec<_>>().join(", ")
        ));
        // The held-back pieces are spread over the flight. If the sticks are tested one after another, pieces of each
        // remain.
        let all = test_points.len()..test_points.len() + pieces.len();
        test_points.extend(pieces);
        let is_held_back = |point: &usize| (point - all.start) % 4 == 3;
        (validation_points, estimation_points) = all.clone().partition(is_held_back);
    }
    let cut = |points: &[usize]| {
        points.iter().map(|&point| record.cut(&test_points[point])).collect::<Result<Vec<_>, _>>()
    };
    let (estimation, validation) = (cut(&estimation_points)?, cut(&validation_points)?);
    let held_back: Vec<&TestPoint> =
        validation_points.iter().map(|&point| &test_points[point]).collect();
    let mut stretches = stretches::stretches(&record, &held_back)?;
    if stretches.is_empty() {
        stretches.clone_from(&estimation);
    }
    let error = match velocity {
        Velocity::Estimated => VelocityError::of(solutions, &dataset.fixes),
        Velocity::HeldGps => VelocityError::NONE,
    };
    let period_s = record.experiment.period_s;
    let units = travels(&dataset.controls)
        .map(|travel| if travel > 0.0 { travel / USUAL_TRAVEL } else { 1.0 });
    let search = Search { stretches: &stretches, error: &error, still: &still, period_s, units };
    let mut parts = search.parts(kind)?;
    if requested.is_none() && parts.iter_mut().any(|part| search.drop_flapping(part)) {
        kind = Kind::Hover;
        structure = kind.structure();
    }
    let answers_early_s = search.answers_early_s(&parts);
    // The velocity held from fix to fix serves for comparison only.
    let measured = |held_back: &[&TestPoint]| match velocity {
        Velocity::Estimated => {
            let clean = flown.without_tones(&tones, &[]);
            Measured::of(&structure, &test_points, held_back, &clean).ok()
        }
        Velocity::HeldGps => None,
    };
    let mut conflicts = Vec::new();
    let mut estimated_s: f64 = stretches.iter().map(Experiment::duration_s).sum();
    let all = match velocity {
        Velocity::Estimated if !validation.is_empty() => stretches::stretches(&record, &[])?,
        _ => Vec::new(),
    };
    let on_all = if all.is_empty() {
        None
    } else {
        estimated_s = all.iter().map(Experiment::duration_s).sum();
        let search = Search { stretches: &all, ..search };
        let mut parts = search.on_from(&mut parts)?;
        conflicts = search.reconcile(&mut parts, measured(&[]).as_ref());
        Some(search.whole(kind, &parts)?)
    };
    let of_judged = search.reconcile(&mut parts, measured(&held_back).as_ref());
    let judged = search.whole(kind, &parts)?;
    let validation = match validation.as_slice() {
        [] => None,
        validation => Some(judged.simulate(validation, WINDOW_S)?),
    };
    // The structure is validated: the final parameters use all data.
    let identified = match on_all {
        Some(on_all) => on_all,
        None => {
            conflicts = of_judged;
            judged
        }
    };
    warnings.extend(conflicts.iter().map(ToString::to_string));
    let passed_over = parts.into_iter().find_map(|part| part.passed_over);
    for input in structure.inputs_of_pilot() {
        let tested =
            |&point: &usize| test_points[point].stick.is_some_and(|stick| STICKS[stick] == input);
        let any = estimation_points.iter().any(|&point| test_points[point].stick.is_some());
        if any && !estimation_points.iter().any(tested) {
            warnings.push(format!("no test point steps the {input} stick: its derivatives come from the pilot's other stick movements"));
        }
    }
    if !identified.converged {
        warnings.push("the search ended before it converged".into());
    }
    Ok(Identification {
        kind,
        velocity,
        tones,
        estimation: identified.simulate(&estimation, WINDOW_S)?,
        estimated_s,
        test_points,
        estimation_points,
        validation_points,
        identified,
        passed_over,
        validation,
        answers_early_s,
        conflicts,
        warnings,
    })
}

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
    error: &'a VelocityError,
    /// Sticks that never move.
    still: &'a [String],
    period_s: f64,
    /// Unit of each stick; see [`Structure::in_units`].
    units: [f64; 4],
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
    fn parts(&self, kind: Kind) -> Result<Vec<Found>, PredictionErrorError> {
        match kind.parts() {
            [] => Ok(vec![self.best(kind)?]),
            parts => parts.par_iter().map(|&part| self.best(part)).collect(),
        }
    }

    /// Replaces `part` by roll and pitch without flapping, if its rotor flaps as fast as the limit allows and the data
    /// are more likely without flapping, by Akaike's criterion. Returns whether it did. A multirotor's motors then count
    /// as lags of the inputs.
    fn drop_flapping(&self, part: &mut Found) -> bool {
        let rotor = part.identified.estimates.get("tau_f");
        if part.kind != Kind::Flapping || rotor.is_none_or(|own| own.status != Status::OnBound) {
            return false;
        }
        let rigid = self.best(Kind::RollPitch).ok();
        let Some(rigid) = rigid.filter(|own| own.identified.aic < part.identified.aic) else {
            return false;
        };
        *part = rigid;
        true
    }

    /// Continues the search of each part on the data of this search. A stabiliser bar that these data do not justify is
    /// also removed from `parts`.
    fn on_from(&self, parts: &mut [Found]) -> Result<Vec<Found>, PredictionErrorError> {
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
    fn whole(&self, kind: Kind, parts: &[Found]) -> Result<Identified, PredictionErrorError> {
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
    fn answers_early_s(&self, parts: &[Found]) -> Option<f64> {
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
