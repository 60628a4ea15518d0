//! From a flight and its estimate to an identified helicopter.

use nalgebra::DMatrix;
use thiserror::Error;

use super::kind::Kind;
use crate::methods::prediction_error::{
    self, Dropping, Fit, Identified, PredictionErrorError, Settings,
};
use crate::record::{Experiment, ExperimentError};
use crate::record::{STICKS, TestPoint, find_test_points};
use crate::record::{Tone, find_tones, without_tones};
use hovernav::ekf::Solution;
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_log::Dataset;

/// The signals of a flight, in order: what the estimator says of the motion.
pub const MOTION: [&str; 8] = ["u", "v", "w", "p", "q", "r", "phi", "theta"];

/// Windows of the simulated fits, s: long enough for an answer, short enough for an unstable plant.
const WINDOW_S: f64 = 5.0;
/// Below this a line may be the helicopter's own mode, Hz.
const LEAST_TONE_HZ: f64 = 5.0;
/// Over which residuals may be correlated, s: about a gust.
const RESIDUAL_CORRELATION_S: f64 = 2.0;

/// Whose velocity is identified from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Velocity {
    /// The estimator's.
    Estimated,
    /// The receiver's own, each fix held until the next, turned into body axes: what the thesis had.
    HeldGps,
}

/// Why a flight cannot be identified from.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// No sticks were recorded.
    #[error("no controls recorded: there is nothing to identify from")]
    NoControls,
    /// Too few solutions for a record.
    #[error("found {found} solutions, expected at least 100")]
    NoSolution {
        /// Solutions there are.
        found: usize,
    },
    /// No test point steps a stick the model has.
    #[error(
        "{kind}: no test point found on {sticks}; a test point is a stick stepped by 3 % or more, twice or more, alone"
    )]
    NoTestPoint {
        /// The model asked for.
        kind: Kind,
        /// The sticks it has.
        sticks: String,
    },
    /// The record itself.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// The search.
    #[error(transparent)]
    PredictionError(#[from] PredictionErrorError),
}

/// A flight as one uniformly sampled record.
#[derive(Debug, Clone)]
pub struct FlightRecord {
    /// Time of the first sample.
    pub start: Time,
    /// Inputs are [`STICKS`], outputs [`MOTION`].
    pub experiment: Experiment,
}

/// An identified helicopter and what it was identified from.
#[derive(Debug, Clone)]
pub struct Identification {
    /// The model.
    pub kind: Kind,
    /// Whose velocity.
    pub velocity: Velocity,
    /// Vibration's tones, notched out of every signal.
    pub tones: Vec<Tone>,
    /// Every test point of the flight.
    pub test_points: Vec<TestPoint>,
    /// Those the parameters are from: indices into `test_points`.
    pub estimation_points: Vec<usize>,
    /// Those held back.
    pub validation_points: Vec<usize>,
    /// The parameters with their bounds, the log of what was dropped.
    pub identified: Identified,
    /// Fit over windows of the test points the parameters are from.
    pub estimation: Fit,
    /// Fit over those held back, where there are any.
    pub validation: Option<Fit>,
    /// What a reader must know, one plain sentence each.
    pub warnings: Vec<String>,
}

impl FlightRecord {
    /// `solutions` of `dataset`, in time order, on a uniform grid at their median interval: motion
    /// interpolated, sticks held.
    ///
    /// # Errors
    /// [`IdentifyError`] where there are no controls or no solutions.
    pub fn new(
        dataset: &Dataset,
        solutions: &[Solution],
        velocity: Velocity,
    ) -> Result<Self, IdentifyError> {
        let short = IdentifyError::NoSolution { found: solutions.len() };
        let (Some(first), Some(last)) = (solutions.first(), solutions.last()) else {
            return Err(short);
        };
        let mut intervals: Vec<f64> =
            solutions.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
        intervals.sort_by(f64::total_cmp);
        if solutions.len() < 100 {
            return Err(short);
        }
        let usual = intervals[intervals.len() / 2];
        // The mean of the usual intervals: a median alone has the clock's rounding in it.
        let usual: Vec<f64> = intervals
            .into_iter()
            .filter(|interval| (0.9..1.1).contains(&(interval / usual)))
            .collect();
        let period_s = usual.iter().sum::<f64>() / usual.len() as f64;
        let span = last.time - first.time;
        let samples = (span / period_s + 1e-6) as usize + 1;
        let controls = &dataset.controls;
        if controls.is_empty() {
            return Err(IdentifyError::NoControls);
        }
        let mut inputs = DMatrix::zeros(samples, STICKS.len());
        let mut outputs = DMatrix::zeros(samples, MOTION.len());
        for sample in 0..samples {
            let time = first.time.offset_by(sample as f64 * period_s);
            let late = time.offset_by(0.25 * period_s);
            let held = controls.partition_point(|control| control.0 <= late).max(1) - 1;
            for (stick, value) in controls[held].1.iter().enumerate() {
                inputs[(sample, stick)] = *value;
            }
            let next = solutions
                .partition_point(|solution| solution.time < time)
                .clamp(1, solutions.len() - 1);
            let (before, after) = (&solutions[next - 1], &solutions[next]);
            let part = ((time - before.time) / (after.time - before.time)).clamp(0.0, 1.0);
            let (one, other) =
                (motion(before, &dataset.fixes, velocity), motion(after, &dataset.fixes, velocity));
            for channel in 0..MOTION.len() {
                outputs[(sample, channel)] = one[channel] + part * (other[channel] - one[channel]);
            }
        }
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let name = dataset.manifest.name.clone();
        let experiment =
            Experiment::new(name, period_s, names(&STICKS), names(&MOTION), inputs, outputs)?;
        Ok(Self { start: first.time, experiment })
    }

    /// The samples of a test point, named after its stick and time.
    ///
    /// # Errors
    /// [`IdentifyError::Experiment`] where it lies outside the record.
    pub fn cut(&self, point: &TestPoint) -> Result<Experiment, IdentifyError> {
        let index = |time: Time| {
            let samples = (time - self.start) / self.experiment.period_s;
            (samples.round().max(0.0) as usize).min(self.experiment.samples())
        };
        let mut piece = self.experiment.slice(index(point.start)..index(point.end))?;
        let stick = point.stick.map_or("manoeuvre", |stick| STICKS[stick]);
        piece.name = format!("{stick} at {:.1} s", point.first_step.seconds());
        Ok(piece)
    }
}

/// u, v, w, p, q, r, φ, θ of a solution.
fn motion(solution: &Solution, fixes: &[Fix], velocity: Velocity) -> [f64; 8] {
    let held = fixes.partition_point(|fix| fix.time <= solution.time).max(1) - 1;
    let measured = match velocity {
        Velocity::Estimated => None,
        Velocity::HeldGps => fixes.get(held).and_then(Fix::velocity_mps),
    };
    let [u, v, w] = measured
        .map_or_else(
            || solution.velocity_body_mps(),
            |velocity| solution.body_to_ned.inverse() * velocity,
        )
        .to_array();
    let [p, q, r] = solution.angular_rate_radps.to_array();
    let angles = solution.body_to_ned.euler();
    [u, v, w, p, q, r, angles.roll_rad, angles.pitch_rad]
}

/// Identifies a helicopter of `kind` from a flight's test points.
///
/// The last repetition on each stick is held back where there are at least two, and never seen by the
/// search; the windows of the fits are simulated over 5 s from an initial state of their own.
///
/// # Errors
/// See [`IdentifyError`].
pub fn identify(
    dataset: &Dataset,
    solutions: &[Solution],
    kind: Kind,
    velocity: Velocity,
) -> Result<Identification, IdentifyError> {
    let mut record = FlightRecord::new(dataset, solutions, velocity)?;
    let tones = find_tones(&record.experiment, LEAST_TONE_HZ);
    record.experiment = without_tones(&record.experiment, &tones);
    let end = record.start.offset_by(record.experiment.duration_s());
    let mut test_points = find_test_points(&dataset.controls);
    test_points.retain(|point| point.start >= record.start && point.end <= end);
    let structure = kind.structure();
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
    if estimation_points.is_empty() {
        return Err(IdentifyError::NoTestPoint { kind, sticks: structure.inputs.join(", ") });
    }
    let cut = |points: &[usize]| {
        points.iter().map(|&point| record.cut(&test_points[point])).collect::<Result<Vec<_>, _>>()
    };
    let (estimation, validation) = (cut(&estimation_points)?, cut(&validation_points)?);
    let settings = Settings {
        held_sigma: kind.held_sigma(),
        dropping: Some(Dropping::default()),
        residual_correlation_s: RESIDUAL_CORRELATION_S,
        ..Settings::innovations(kind.process_sigma())
    };
    let identified = prediction_error::identify(&structure, &estimation, &settings)?;
    let validation = match validation.as_slice() {
        [] => None,
        validation => Some(identified.simulate(validation, WINDOW_S)?),
    };
    let mut warnings = Vec::new();
    for input in &structure.inputs {
        let tested =
            |&point: &usize| test_points[point].stick.is_some_and(|stick| STICKS[stick] == input);
        if !estimation_points.iter().any(tested) {
            warnings.push(format!("no test point steps the {input} stick: its derivatives rest on what the pilot did besides"));
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
        test_points,
        estimation_points,
        validation_points,
        identified,
        validation,
        warnings,
    })
}
