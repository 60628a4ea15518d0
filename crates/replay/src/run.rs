//! Runs of the estimator over a recorded flight.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use serde::Serialize;

use crate::comparisons::{ChannelTally, FixTally, Thinning, routine};
use crate::kept::{Keep, Kept};
use hovernav::ekf::layout::{Full, Layout as _};
use hovernav::ekf::{Aid, Ekf, Estimator, EstimatorConfig, FullEkf, Notice, Report, Solution};
use hovernav::event::Event;
use hovernav::time::Time;
use hovernav_dataset::Dataset;

/// Result of a run over a log.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// The settings of the run.
    pub config: EstimatorConfig,
    /// The solutions in memory, from the end of alignment on: one per accepted inertial sample, or some of them.
    pub solutions: Vec<Solution>,
    /// Number of solutions not in memory.
    pub solutions_thinned: usize,
    /// The estimator's notices, in order, without readings skipped by design. If solutions are thinned
    /// ([`Keep::Thinned`]), routine comparisons are too: at most 65 536 of fixes and 32 768 of each other aid stay.
    pub notices: Vec<Notice>,
    /// Number of comparisons of fixes not among the notices.
    pub fixes_thinned: usize,
    /// Number of comparisons of other aids not among the notices.
    pub comparisons_thinned: usize,
    /// Number of fixes with at least one used channel, and of fixes with at least one rejected channel.
    pub fixes_compared: FixTally,
    /// Tallies of all comparisons, by the channel's name.
    pub channels: BTreeMap<&'static str, ChannelTally>,
    /// Number of faulty readings that could not be used, each with a notice.
    pub unusable: UnusedReadings,
    /// Number of readings skipped by design: too soon after the last one, or before the heading is known.
    pub skipped: UnusedReadings,
    /// Delay of the fixes beyond the declared latency, s, and its one-sigma.
    pub gps_offset: Option<(f64, f64)>,
    /// Largest ratio of the variance of the inertial unit's noise to the assumed variance.
    pub noise_excess: f64,
    /// Mean ratio of the used to the stated one-sigmas, for positions and horizontal velocities of fixes.
    pub stated_times: [f64; 2],
    learned_from: usize,
    /// Thinning of the comparisons; `None` if all are kept.
    thinning: Option<Thinning>,
}

/// Number of unused readings of each aid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct UnusedReadings {
    /// Fixes.
    pub gps: usize,
    /// Attitudes of the inertial unit.
    pub attitude: usize,
    /// Magnetic fields.
    pub magnetometer: usize,
    /// Barometric heights.
    pub baro: usize,
    /// Headings of two antennas.
    pub second_antenna: usize,
    /// Distances to the ground.
    pub rangefinder: usize,
}

impl UnusedReadings {
    fn count(&mut self, aid: Aid) {
        match aid {
            Aid::Gps => self.gps += 1,
            Aid::Attitude => self.attitude += 1,
            Aid::Magnetometer => self.magnetometer += 1,
            Aid::Baro => self.baro += 1,
            Aid::SecondAntenna => self.second_antenna += 1,
            Aid::Rangefinder => self.rangefinder += 1,
            _ => {}
        }
    }
}

impl Run {
    /// The measurements that were compared with the filter, in order, except thinned ones.
    pub fn reports(&self) -> impl Iterator<Item = &Report> {
        self.notices.iter().filter_map(|notice| match notice {
            Notice::Updated(report) => Some(report),
            _ => None,
        })
    }

    pub(crate) fn learned_by(&mut self, filter: Option<&FullEkf>) {
        self.gps_offset = filter.map(gps_offset);
        let excess = filter.map_or(1.0, FullEkf::noise_excess);
        self.noise_excess = self.noise_excess.max(excess);
        if let Some(filter) = filter {
            self.learned_from += 1;
            for (mean, now) in self.stated_times.iter_mut().zip(filter.stated_times()) {
                *mean += (now - *mean) / self.learned_from as f64;
            }
        }
    }

    /// Keeps a notice. Readings skipped by design outnumber the samples, so they are only counted.
    pub(crate) fn keep(&mut self, notice: Notice) {
        if let Notice::NotUsed { aid, reason, .. } = notice {
            if !reason.is_fault() {
                return self.skipped.count(aid);
            }
            self.unusable.count(aid);
        }
        if let Notice::Updated(report) = &notice {
            ChannelTally::count(&mut self.channels, report);
            self.fixes_compared.count(report);
        }
        if let (Some(thinning), Some(channel)) = (&mut self.thinning, routine(&notice)) {
            let kept = self.notices.len();
            let takes = thinning.takes(channel, &mut self.notices);
            let skipped = kept - self.notices.len() + usize::from(!takes);
            match channel.is_of_fix() {
                true => self.fixes_thinned += skipped,
                false => self.comparisons_thinned += skipped,
            }
            if !takes {
                return;
            }
        }
        self.notices.push(notice);
    }
}

/// Runs the estimator over `dataset`. `progress` receives the number of inertial samples done.
pub fn estimate(
    dataset: &Dataset,
    config: &EstimatorConfig,
    mut progress: impl FnMut(usize),
) -> Run {
    estimated(dataset, config, Keep::All, &mut progress, &mut |_| ControlFlow::Continue(()))
}

/// [`estimate`] that also passes every solution to `each` as it is computed. `keep` selects the
/// solutions in the run.
///
/// # Errors
/// The first error of `each`, which ends the run.
pub fn estimate_each<E>(
    dataset: &Dataset,
    config: &EstimatorConfig,
    keep: Keep,
    mut progress: impl FnMut(usize),
    mut each: impl FnMut(&Solution) -> Result<(), E>,
) -> Result<Run, E> {
    let mut failure = None;
    let run = estimated(dataset, config, keep, &mut progress, &mut |solution| {
        failure = each(solution).err();
        if failure.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    failure.map_or(Ok(run), Err)
}

// Compiled once here, so that the whole filter is not compiled for every caller's closure.
fn estimated(
    dataset: &Dataset,
    config: &EstimatorConfig,
    keep: Keep,
    progress: &mut dyn FnMut(usize),
    each: &mut Each<'_>,
) -> Run {
    let mut estimator = Estimator::<Full, 28>::new(*config);
    over(dataset, config, keep, progress, |event, run| {
        estimator.push(event, |notice| run.keep(notice));
        run.learned_by(estimator.filter());
        let solution = estimator.solution().filter(|solution| is_of(event, solution.time));
        match solution.as_ref() {
            Some(solution) if each(solution).is_break() => ControlFlow::Break(()),
            _ => ControlFlow::Continue(solution),
        }
    })
}

/// Passes every event of `dataset` to `push`, and keeps the solution it returns for an inertial sample.
pub(crate) fn over(
    dataset: &Dataset,
    config: &EstimatorConfig,
    keep: Keep,
    progress: &mut dyn FnMut(usize),
    mut push: impl FnMut(&Event, &mut Run) -> ControlFlow<(), Option<Solution>>,
) -> Run {
    let thinning = (keep == Keep::Thinned).then(Thinning::default);
    let mut run = Run { config: *config, thinning, ..Run::default() };
    let mut kept = Kept::new(keep, dataset.sample_count());
    let mut samples = 0;
    for event in dataset.events() {
        let ControlFlow::Continue(solution) = push(&event, &mut run) else { break };
        if let Event::Imu(_) = event {
            samples += 1;
            progress(samples);
            if let Some(solution) = solution {
                kept.push(solution);
            }
        }
    }
    (run.solutions, run.solutions_thinned) = kept.finish();
    run
}

/// Whether a state of `time` belongs to this inertial sample: a rejected sample leaves the state at an earlier time.
pub(crate) fn is_of(event: &Event, time: Time) -> bool {
    matches!(event, Event::Imu(sample) if sample.time == time)
}

/// Receives every solution; returns whether to continue.
type Each<'a> = dyn FnMut(&Solution) -> ControlFlow<()> + 'a;

/// The delay of the fixes beyond the declared latency, s, and its one-sigma.
fn gps_offset(filter: &Ekf<Full, 28>) -> (f64, f64) {
    let state = Full::GPS_DELAY.unwrap_or_default();
    (filter.parameter(state), filter.covariance().variance(state).max(0.0).sqrt())
}
