//! Identification of a helicopter model from a flight and its navigation solution.

use super::bandwidth::{LONGEST_PERIOD_S, bandwidth_hz, longest_period_s, moving};
use super::error::IdentifyError;
use super::flight::{FlightRecord, Velocity};
use super::measured::Measured;
use super::model_structure::{ModelStructure, built_in};
use super::reconcile::Conflict;
use super::search::Search;
use super::stretches;
use super::velocity_error::VelocityError;
use crate::methods::prediction_error::{Fit, Identified, Status};
use crate::record::Experiment;
use crate::record::{STICKS, TestPoint, find_test_points, travels};
use crate::record::{Tone, find_tones};
use hovernav::ekf::Solution;
use hovernav_dataset::Dataset;

/// Windows of the simulated fits, s: long enough for a response, short enough for an unstable vehicle.
const WINDOW_S: f64 = 5.0;
/// Lowest frequency of a vibration tone, Hz. A lower spectral line may be a mode of the helicopter.
const LEAST_TONE_HZ: f64 = 5.0;
/// Signals that are refilled with noise in the band of a removed tone: integrals of accelerometer signals.
const FILLED: [&str; 3] = ["u", "v", "w"];

/// An identified helicopter and the data that it was identified from.
#[derive(Debug, Clone)]
pub struct Identification {
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

/// Identifies a model of `structure` from a flight. Without a structure it is `hybrid`, or `multirotor` for a vehicle
/// whose rotors do not flap: the rotor's time constant is then on its limit, and Akaike's criterion prefers the model
/// without flapping. Without fixes it is `rates`; pass [`gyro_solutions`](super::gyro_solutions) as
/// `solutions`.
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
    structure: impl Into<Option<ModelStructure>>,
    velocity: Velocity,
) -> Result<Identification, IdentifyError> {
    let requested = structure.into();
    let (is_requested, has_fixes) = (requested.is_some(), !dataset.fixes.is_empty());
    let usual = if has_fixes { "hybrid" } else { "rates" };
    let mut model = requested.unwrap_or_else(|| built_in(usual));
    if !has_fixes && !model.has_rates_alone() {
        return Err(IdentifyError::NoFix { model: model.name().to_owned() });
    }
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
    let (mut estimation_points, mut validation_points) = (Vec::new(), Vec::new());
    for (index, stick) in STICKS.iter().enumerate() {
        if !model.equations.inputs.iter().any(|input| input == stick) {
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
    let name = model.name().to_owned();
    for stick in model.equations.inputs_of_pilot() {
        if !moved.contains(&stick) {
            if model.own_delay().is_some_and(|(own, _)| own == stick) {
                return Err(IdentifyError::StillStick { model: name, stick: stick.to_owned() });
            }
            still.push(stick.to_owned());
        }
    }
    let mut warnings: Vec<String> = record.gaps.iter().map(ToString::to_string).collect();
    if estimation_points.is_empty() {
        if still.len() == model.equations.inputs_of_pilot().count() {
            return Err(IdentifyError::StillStick { model: name, stick: still.join(", ") });
        }
        let pieces = stretches::pieces(&record);
        if pieces.is_empty() {
            return Err(IdentifyError::NoHover { model: name, least_s: stretches::LEAST_S });
        }
        warnings.push(format!(
            "no test point found on {}: the parameters come from the pilot's other stick movements",
            model.equations.inputs_of_pilot().collect::<Vec<_>>().join(", ")
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
    let travels = travels(&dataset.controls);
    let is_zero =
        |input: &&String| record.experiment.signal(input).is_ok_and(|signal| signal.amax() == 0.0);
    let others = model.equations.inputs.iter().filter(|input| !STICKS.contains(&input.as_str()));
    still.extend(others.filter(is_zero).cloned());
    let search = Search { stretches: &stretches, error: &error, still: &still, period_s, travels };
    let mut parts = search.parts(&model)?;
    if !is_requested {
        let rigid = built_in("multirotor");
        if let Some(own) = search.without_flapping(&parts, &rigid) {
            (parts, model) = (own, rigid);
        }
    }
    let answers_early_s = search.answers_early_s(&parts);
    // The velocity held from fix to fix serves for comparison only.
    let measured = |held_back: &[&TestPoint]| match velocity {
        Velocity::Estimated => {
            let clean = flown.without_tones(&tones, &[]);
            Measured::of(&model.equations, &test_points, held_back, &clean).ok()
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
        Some(search.whole(&model, &parts)?)
    };
    let of_judged = search.reconcile(&mut parts, measured(&held_back).as_ref());
    let judged = search.whole(&model, &parts)?;
    let validation = match validation.as_slice() {
        [] => None,
        validation => Some(judged.simulate(validation, WINDOW_S)?),
    };
    // The structure is validated: the final parameters use all data.
    let mut identified = match on_all {
        Some(on_all) => on_all,
        None => {
            conflicts = of_judged;
            judged
        }
    };
    model.name().clone_into(&mut identified.structure.name);
    for estimate in &mut identified.estimates.list {
        if estimate.status == Status::Free && estimate.bound == 0.0 {
            estimate.status = Status::Held;
            warnings.push(format!(
                "{} has no effect in this flight: it keeps its initial value",
                estimate.name
            ));
        }
    }
    warnings.extend(conflicts.iter().map(ToString::to_string));
    let passed_over = parts.into_iter().find_map(|part| part.passed_over);
    for input in model.equations.inputs_of_pilot() {
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
