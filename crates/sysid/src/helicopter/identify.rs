//! Identification of a helicopter model from a flight and its navigation solution.

use super::bandwidth::{LONGEST_PERIOD_S, bandwidth_hz, longest_period_s, moving};
use super::error::IdentifyError;
use super::flight::{FlightRecord, Velocity};
use super::flight_condition::FlightCondition;
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
const MIN_TONE_HZ: f64 = 5.0;
/// Signals that are refilled with noise in the band of a removed tone: integrals of accelerometer signals.
const FILLED: [&str; 3] = ["u", "v", "w"];

/// An identified helicopter and the data that it was identified from.
#[derive(Debug, Clone)]
pub struct Identification {
    /// Source of the velocity.
    pub velocity: Velocity,
    /// Vibration tones, notched out of every signal.
    pub tones: Vec<Tone>,
    /// Dead band of the servo of each of the [`STICKS`], in the stick's unit; 0 where the flight shows none. The
    /// model's sticks are the positions of such servos.
    pub dead_bands: [f64; 4],
    /// Every test point of the flight.
    pub test_points: Vec<TestPoint>,
    /// Range of flight in which the model is valid.
    pub condition: FlightCondition,
    /// Median velocity u, v, w, m/s, of the flight used for the parameters.
    pub trim_velocity_mps: [f64; 3],
    /// Length of the flight used for the parameters, s: all flight in the condition, including the validation data.
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

/// Structure to identify, and the speed of the flight to identify it from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Request {
    /// The structure; `None` for the one that suits the flight, see [`identify`].
    pub structure: Option<ModelStructure>,
    /// Forward speed of the flight, m/s, in place of that of the structure.
    pub speed_mps: Option<f64>,
}

impl From<Option<ModelStructure>> for Request {
    fn from(structure: Option<ModelStructure>) -> Self {
        Self { structure, speed_mps: None }
    }
}

impl From<ModelStructure> for Request {
    fn from(structure: ModelStructure) -> Self {
        Some(structure).into()
    }
}

/// Identifies a model of the `wanted` structure from a flight. Without a structure it is `hybrid`. It is `multirotor`
/// for a vehicle whose rotors do not flap. Then the rotor's time constant is on its limit, and Akaike's criterion
/// prefers the model without flapping. Without fixes it is `rates`; pass [`gyro_solutions`](super::gyro_solutions) as
/// `solutions`.
///
/// The model is identified from all flight in the condition of the structure, usually near a hover, except the
/// validation data. For each stick with at least two repetitions, the last repetition is held back. For a flight
/// without test points, every fourth piece of 10 s is held back. The validation data judge that model. Its parameters
/// are then estimated again with these data included, and a stabiliser bar must again justify its extra parameters. The
/// windows of the fits are simulated over 5 s, each from its own initial state.
///
/// # Errors
/// See [`IdentifyError`].
pub fn identify(
    dataset: &Dataset,
    solutions: &[Solution],
    wanted: impl Into<Request>,
    velocity: Velocity,
) -> Result<Identification, IdentifyError> {
    let Request { structure, speed_mps } = wanted.into();
    let (is_requested, has_fixes) = (structure.is_some(), !dataset.fixes.is_empty());
    let usual = if has_fixes { "hybrid" } else { "rates" };
    let mut model = structure.unwrap_or_else(|| built_in(usual));
    model.condition.speed_mps = speed_mps.unwrap_or(model.condition.speed_mps);
    let condition = model.condition;
    if !has_fixes && !model.has_rates_alone() {
        return Err(IdentifyError::NoFix { model: model.name().to_owned() });
    }
    let flown = FlightRecord::new(dataset, solutions, velocity)?.within(condition);
    let least_hz = MIN_TONE_HZ.max(bandwidth_hz(&flown.experiment));
    let tones = find_tones(&flown.experiment, least_hz);
    let longest_s = match velocity {
        Velocity::Estimated => longest_period_s(&flown.experiment),
        // Held GPS velocity serves for comparison only.
        Velocity::HeldGps => LONGEST_PERIOD_S,
    };
    let travels = travels(&dataset.controls);
    let dead_bands = flown.dead_bands(&tones, longest_s, travels);
    let flown = flown.with_dead_bands(dead_bands);
    let record = flown.without_tones(&tones, &FILLED);
    let record = record.thinned(longest_s).map_err(IdentifyError::Preprocess)?;
    let end = record.start.offset_by(record.experiment.duration_s());
    let mut test_points = find_test_points(&dataset.controls);
    test_points.retain(|point| {
        point.start >= record.start
            && point.end <= end
            && record.is_whole(point.start, point.end)
            && record.holds(record.sample(point.start))
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
            let min_s = stretches::MIN_S;
            return Err(IdentifyError::NotFlown { model: name, condition, min_s });
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
    let trim_velocity_mps = median_velocity_mps(if all.is_empty() { &stretches } else { &all });
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
    warnings.extend(other_speed(&flown, condition, trim_velocity_mps));
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
        dead_bands,
        condition,
        trim_velocity_mps,
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

/// Difference, m/s, between the forward speed of the flight and that of the condition, above which a warning is given.
const OTHER_MPS: f64 = 1.0;

/// A warning where most of the flight `flown` is outside the `condition`, or where the part in it has another speed.
fn other_speed(
    flown: &FlightRecord,
    condition: FlightCondition,
    [own_mps, ..]: [f64; 3],
) -> Option<String> {
    let [whole_mps, ..] = median_velocity_mps(std::slice::from_ref(&flown.experiment));
    let apart = |mps: f64| (mps - condition.speed_mps).abs();
    if apart(whole_mps) > condition.within_mps {
        return Some(format!(
            "most of this flight is at {whole_mps:.1} m/s forward, and the model is of {condition}: --speed \
             {whole_mps:.0} identifies it at that speed"
        ));
    }
    (condition.speed_mps != 0.0 && apart(own_mps) > OTHER_MPS).then(|| {
        format!("the model is requested for {condition}, and the flight is at {own_mps:.1} m/s")
    })
}

/// Median of u, v and w over all samples of `pieces`, m/s: a mean would contain the acceleration to the speed.
fn median_velocity_mps(pieces: &[Experiment]) -> [f64; 3] {
    [0, 1, 2].map(|channel| {
        let columns = pieces.iter().map(|piece| piece.outputs.column(channel));
        let mut values: Vec<f64> =
            columns.flat_map(|column| column.iter().copied().collect::<Vec<_>>()).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    })
}
