//! What the page of a flight shows.

use hovernav::ekf::{Innovation, Notice, Solution};
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_formats::Onboard;
use hovernav_log::statistics::Extremes;
use hovernav_log::{Dataset, Finding, LogError, Outage, Reference, ReferenceMoment, Run, Score};

use crate::page::Fact;

/// What the page of a flight shows. A slice may be empty: its figures then say so, or, for what is
/// optional (`smoothed`, `reference`, `score`), are left out.
///
/// Series are in order of time.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlightData<'a> {
    /// The page's heading, plain text.
    pub title: &'a str,
    /// The few numbers to see first.
    pub headlines: &'a [Fact],
    /// The rest of what there is to say, as a table.
    pub facts: &'a [Fact],
    /// What went wrong or deserves a second look, plain text.
    pub warnings: &'a [String],
    /// The stretches for which GPS was withheld.
    pub outages: &'a [Outage],
    /// The filter's solution.
    pub solutions: &'a [Solution],
    /// The smoother's solution.
    pub smoothed: &'a [Solution],
    /// The fixes, as received.
    pub fixes: &'a [Fix],
    /// What became of each scalar update, in the order in which the filter took them.
    pub innovations: &'a [Innovation],
    /// The reference at moments of the solution.
    pub reference: &'a [(Time, ReferenceMoment)],
    /// What the estimator on board said: to compare with, never the truth.
    pub onboard: Option<&'a Onboard>,
    /// The log, for its inertial samples.
    pub log: Option<&'a Dataset>,
    /// Barometric heights, m.
    pub baro: &'a [(Time, f64)],
    /// The sticks, from [`sticks`].
    pub sticks: &'a [Vec<(Time, f64)>],
    /// What the estimator reported.
    pub notices: &'a [Notice],
    /// What happened in the run, as spans.
    pub findings: &'a [Finding],
    /// How far the solution is from the reference.
    pub score: Option<&'a Score>,
}

impl FlightData<'_> {
    /// First and last moment of solutions and fixes.
    pub fn span(&self) -> Option<(Time, Time)> {
        let solutions = self.solutions.iter().map(|solution| solution.time);
        let times = || solutions.clone().chain(self.fixes.iter().map(|fix| fix.time));
        Some((times().min()?, times().max()?))
    }
}

/// What became of each scalar update of a run, in the order in which the filter took them.
pub fn innovations(run: &Run) -> Vec<Innovation> {
    let reports = run.notices.iter().filter_map(|notice| match notice {
        Notice::Updated(report) => Some(report),
        _ => None,
    });
    reports.flat_map(|report| report.innovations().copied()).collect()
}

/// The sticks of `dataset`, lateral, longitudinal, collective and pedal, each over time as far as a page shows it;
/// nothing where there are none.
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

/// The reference at the moments of the solution; nothing where there is no reference.
pub fn reference_moments(
    solutions: &[Solution],
    reference: Option<&Reference>,
) -> Vec<(Time, ReferenceMoment)> {
    let moment = |reference: &Reference, time| (time, reference.at(time));
    reference.map_or_else(Vec::new, |reference| {
        solutions.iter().map(|solution| moment(reference, solution.time)).collect()
    })
}
