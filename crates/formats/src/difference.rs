//! Difference between a solution and the onboard estimator.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::onboard::{Onboard, OnboardMoment};
use hovernav::ekf::Solution;
use hovernav::frames::wrap_angle;
use hovernav::time::Time;
use hovernav_score::{Apart, Axis, Statistics};

/// Difference between a solution and the onboard estimator's. Both are estimates; neither is the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OnboardDifference {
    /// Name of the onboard estimator.
    pub name: String,
    /// The first moment compared, s.
    pub from_s: f64,
    /// The last moment compared, s.
    pub to_s: f64,
    /// Statistics of the difference per axis; keys are [`Axis::name`], with the unit.
    pub difference: BTreeMap<&'static str, Statistics>,
}

/// Assumed one-sigma of an onboard estimator north, east, down: position, m, and velocity, m/s. Logs do not state it.
/// The height comes from a barometer, whose error grows over a flight.
const OWN_SIGMAS: [f64; 6] = [2.0, 2.0, 4.0, 0.3, 0.3, 0.3];

/// Largest time from a moment to the solution that it is compared with, s.
const CLOSE_S: f64 = 0.05;

/// The axes compared, in the order of [`differences`].
const AXES: [Axis; 10] = [
    Axis::North,
    Axis::East,
    Axis::Down,
    Axis::Horizontal,
    Axis::VelocityNorth,
    Axis::VelocityEast,
    Axis::VelocityDown,
    Axis::Roll,
    Axis::Pitch,
    Axis::Yaw,
];

impl Onboard {
    /// Distances of `solutions`, in time order, from the onboard estimator.
    #[must_use]
    pub fn apart(&self, solutions: &[Solution]) -> Apart {
        let mut apart = Apart::new(format!("onboard {}", self.name), OWN_SIGMAS);
        for moment in &self.moments {
            if let Some(solution) = nearest(solutions, moment.time) {
                let [north, east, down, _, vn, ve, vd, ..] = differences(solution, moment);
                apart.push(moment.time, solution, [north, east, down, vn, ve, vd]);
            }
        }
        apart
    }

    /// Difference of `solutions`, in time order, from the onboard estimator. `None` if no moment has a solution within
    /// 0.05 s.
    #[must_use]
    pub fn difference(&self, solutions: &[Solution]) -> Option<OnboardDifference> {
        let mut columns: [Vec<f64>; 10] = Default::default();
        let mut span: Option<(Time, Time)> = None;
        for moment in &self.moments {
            let Some(solution) = nearest(solutions, moment.time) else { continue };
            span = Some((span.map_or(moment.time, |(first, _)| first), moment.time));
            for (column, difference) in columns.iter_mut().zip(differences(solution, moment)) {
                column.extend(Some(difference).filter(|difference| difference.is_finite()));
            }
        }
        let (first, last) = span?;
        let sizes = AXES.into_iter().zip(&columns).filter(|(_, column)| !column.is_empty());
        Some(OnboardDifference {
            name: self.name.clone(),
            from_s: first.seconds(),
            to_s: last.seconds(),
            difference: sizes
                .filter_map(|(axis, column)| Some((axis.name(), Statistics::of(column)?)))
                .collect(),
        })
    }
}

/// The solution nearest to `time`, if it is within [`CLOSE_S`].
fn nearest(solutions: &[Solution], time: Time) -> Option<&Solution> {
    let after = solutions.partition_point(|solution| solution.time < time);
    let around = &solutions[after.saturating_sub(1)..solutions.len().min(after + 1)];
    around
        .iter()
        .min_by(|a, b| (a.time - time).abs().total_cmp(&(b.time - time).abs()))
        .filter(|solution| (solution.time - time).abs() <= CLOSE_S)
}

/// Solution minus moment on each of [`AXES`]; NaN if the moment has no value. The solution's velocity and angular rate
/// extrapolate its position and attitude to the time of the moment.
fn differences(solution: &Solution, moment: &OnboardMoment) -> [f64; 10] {
    let later_s = moment.time - solution.time;
    let [north, east, down] = moment.position.map_or([f64::NAN; 3], |position| {
        let travelled_m = solution.velocity_mps * later_s;
        (solution.position.displacement_from(&position) + travelled_m).to_array()
    });
    let [vn, ve, vd] = moment
        .velocity_mps
        .map_or([f64::NAN; 3], |velocity| (solution.velocity_mps - velocity).to_array());
    let [roll, pitch, yaw] = moment.body_to_ned.map_or([f64::NAN; 3], |attitude| {
        let turned = solution.body_to_ned.turned_in_from(solution.angular_rate_radps * later_s);
        let (ours, theirs) = (turned.euler(), attitude.euler());
        [
            ours.roll_rad - theirs.roll_rad,
            ours.pitch_rad - theirs.pitch_rad,
            ours.yaw_rad - theirs.yaw_rad,
        ]
        .map(|turn_rad| wrap_angle(turn_rad).to_degrees())
    });
    [north, east, down, north.hypot(east), vn, ve, vd, roll, pitch, yaw]
}
