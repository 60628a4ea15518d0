//! The contents of the page of a flight.

use hovernav::ekf::{Innovation, Notice, Solution};
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_dataset::statistics::Extremes;
use hovernav_dataset::{Dataset, LogError, Outage, Reference, ReferenceMoment};
use hovernav_findings::Finding;
use hovernav_formats::Onboard;
use hovernav_score::{Score, Verdict};

use crate::Fact;

/// The contents of the page of a flight. Slices may be empty. The page then states that a figure is empty, or omits it
/// if it is optional (`smoothed`, `reference`, `score`).
///
/// All series are in order of time.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlightData<'a> {
    /// The heading of the page, plain text.
    pub title: &'a str,
    /// The verdict on the solution.
    pub verdict: Option<&'a Verdict>,
    /// The headline numbers.
    pub headlines: &'a [Fact],
    /// Further facts, as a table.
    pub facts: &'a [Fact],
    /// Errors and points to check, plain text.
    pub warnings: &'a [String],
    /// The time spans without GPS in this run.
    pub outages: &'a [Outage],
    /// The filter's solution.
    pub solutions: &'a [Solution],
    /// The smoother's solution.
    pub smoothed: &'a [Solution],
    /// The GPS fixes, as received.
    pub fixes: &'a [Fix],
    /// The result of each scalar update, in the filter's order.
    pub innovations: &'a [Innovation],
    /// The reference at the times of the solution.
    pub reference: &'a [(Time, ReferenceMoment)],
    /// The solution of the onboard estimator: for comparison, never used as truth.
    pub onboard: Option<&'a Onboard>,
    /// The log, for its inertial samples.
    pub log: Option<&'a Dataset>,
    /// Barometric heights, m.
    pub baro: &'a [(Time, f64)],
    /// The sticks, from [`sticks`].
    pub sticks: &'a [Vec<(Time, f64)>],
    /// The notices of the estimator.
    pub notices: &'a [Notice],
    /// Events of the run, as spans of time.
    pub findings: &'a [Finding],
    /// The errors of the solution against the reference.
    pub score: Option<&'a Score>,
}

impl FlightData<'_> {
    /// First and last time of solutions and fixes.
    pub fn span(&self) -> Option<(Time, Time)> {
        let solutions = self.solutions.iter().map(|solution| solution.time);
        let times = || solutions.clone().chain(self.fixes.iter().map(|fix| fix.time));
        Some((times().min()?, times().max()?))
    }
}

/// The sticks of `dataset` (lateral, longitudinal, collective, pedal) over time, thinned for a page; empty without
/// stick data.
pub fn sticks(dataset: &Dataset) -> Result<Vec<Vec<(Time, f64)>>, LogError> {
    let mut sticks = <[Extremes<Time>; 4]>::default();
    dataset.each_control(|time, positions| {
        for (stick, position) in sticks.iter_mut().zip(positions) {
            stick.push((time, position));
        }
    })?;
    let mut sticks: Vec<_> = sticks.into_iter().map(Extremes::finish).collect();
    sticks.retain(|points| !points.is_empty());
    Ok(sticks)
}

/// The reference at the times of the solution; empty without a reference.
pub fn reference_moments(
    solutions: &[Solution],
    reference: Option<&Reference>,
) -> Vec<(Time, ReferenceMoment)> {
    let moment = |reference: &Reference, time| (time, reference.at(time));
    reference.map_or_else(Vec::new, |reference| {
        solutions.iter().map(|solution| moment(reference, solution.time)).collect()
    })
}
