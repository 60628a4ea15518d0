//! A recorded flight through the estimator.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use serde::Serialize;

use crate::comparisons::{ChannelTally, FixTally, Thinning, routine};
use crate::dataset::{Dataset, Source};
use crate::kept::{Keep, Kept};
use hovernav::ekf::layout::{Full, Layout as _};
use hovernav::ekf::{Aid, Ekf, Estimator, EstimatorConfig, FullEkf, Notice, Solution};
use hovernav::event::Event;
use hovernav::time::Time;

/// A span without GPS, to see how the filter fares alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outage {
    /// When it starts.
    pub start: Time,
    /// How long it lasts, s.
    pub duration_s: f64,
}

impl Outage {
    /// Whether a moment falls into it.
    #[must_use]
    pub fn covers(&self, time: Time) -> bool {
        time >= self.start && time - self.start < self.duration_s
    }
}

/// What a run over a log gave.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// The settings it was made with.
    pub config: EstimatorConfig,
    /// One solution per inertial sample that was taken in, from the end of alignment on, or those of them that were kept.
    pub solutions: Vec<Solution>,
    /// How many were not.
    pub solutions_left_out: usize,
    /// What the estimator reported, in order, but for readings left out by design. Of the comparisons that were
    /// accepted as a matter of course, at most 65 536 of fixes and 32 768 of each other aid, evenly thinned, where
    /// solutions are ([`Keep::Thinned`]).
    pub notices: Vec<Notice>,
    /// How many comparisons of fixes are not among the notices.
    pub fixes_left_out: usize,
    /// How many comparisons of other aids are not.
    pub comparisons_left_out: usize,
    /// Fixes of which anything corrected the state, and of which anything was refused.
    pub fixes_compared: FixTally,
    /// What became of all comparisons, by the channel's name.
    pub channels: BTreeMap<&'static str, ChannelTally>,
    /// Readings that could not be used for a fault of theirs, each a notice too.
    pub unusable: UnusedReadings,
    /// Readings left out by design: too soon after the last, or before the heading is known.
    pub left_out: UnusedReadings,
    /// How much earlier than declared the fixes turned out to hold, s, with one-sigma.
    pub gps_offset: Option<(f64, f64)>,
    /// By how many times the inertial unit turned out noisier than assumed, in variance, at most.
    pub noise_excess: f64,
    /// How many times the one-sigmas that fixes state their places and level velocities turned out, in the mean.
    pub stated_times: [f64; 2],
    learned_from: usize,
    /// `None` where all comparisons are kept.
    thinning: Option<Thinning>,
}

/// How many readings of each aid were not used.
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

    /// Keeps a notice; of readings left out by design, of which there are more than samples, the
    /// number alone.
    pub(crate) fn keep(&mut self, notice: Notice) {
        if let Notice::NotUsed { aid, reason, .. } = notice {
            if !reason.is_fault() {
                return self.left_out.count(aid);
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
            let left_out = kept - self.notices.len() + usize::from(!takes);
            match channel.is_of_fix() {
                true => self.fixes_left_out += left_out,
                false => self.comparisons_left_out += left_out,
            }
            if !takes {
                return;
            }
        }
        self.notices.push(notice);
    }
}

impl Dataset {
    /// Leaves out the fixes within `outages`, and thins the rest to at most `rate_hz`.
    pub fn withhold(&mut self, outages: &[Outage], rate_hz: Option<f64>) {
        // A tenth of the interval forgives the jitter of the receiver's clock.
        let interval_s = rate_hz.map_or(0.0, |rate_hz| 0.9 / rate_hz);
        let mut last: Option<Time> = None;
        let keep = self.fixes.iter().map(|fix| {
            let keep = !outages.iter().any(|outage| outage.covers(fix.time))
                && (rate_hz.is_none() || last.is_none_or(|last| fix.time - last >= interval_s));
            if keep {
                last = Some(fix.time);
            }
            keep
        });
        let keep: Vec<bool> = keep.collect();
        let mut kept = keep.iter();
        self.order.retain(|source| *source != Source::Gps || kept.next() != Some(&false));
        let mut kept = keep.iter();
        self.fixes.retain(|_| kept.next() == Some(&true));
    }

    /// How many fixes come before the first inertial sample, of no use to anyone.
    #[must_use]
    pub fn fixes_before_imu(&self) -> usize {
        let first = self.sample_span().map_or(Time::ZERO, |(first, _)| first);
        self.fixes.iter().take_while(|fix| fix.time < first).count()
    }

    /// Runs the estimator over the log. `progress` is called with the number of inertial samples done.
    pub fn estimate(&self, config: &EstimatorConfig, mut progress: impl FnMut(usize)) -> Run {
        self.estimated(config, Keep::All, &mut progress, &mut |_| ControlFlow::Continue(()))
    }

    /// [`estimate`](Self::estimate), every solution handed to `each` when it is there, and kept in the
    /// run as far as `keep` says.
    ///
    /// # Errors
    /// The first of `each`, which ends the run.
    pub fn estimate_each<E>(
        &self,
        config: &EstimatorConfig,
        keep: Keep,
        mut progress: impl FnMut(usize),
        mut each: impl FnMut(&Solution) -> Result<(), E>,
    ) -> Result<Run, E> {
        let mut failure = None;
        let run = self.estimated(config, keep, &mut progress, &mut |solution| {
            failure = each(solution).err();
            if failure.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        failure.map_or(Ok(run), Err)
    }

    // Compiled here once, and not with the filter for every caller's closure.
    fn estimated(
        &self,
        config: &EstimatorConfig,
        keep: Keep,
        progress: &mut dyn FnMut(usize),
        each: &mut Each<'_>,
    ) -> Run {
        let mut estimator = Estimator::<Full, 28>::new(*config);
        self.run(config, keep, progress, |event, run| {
            estimator.push(event, |notice| run.keep(notice));
            run.learned_by(estimator.filter());
            let solution = estimator.solution().filter(|solution| is_of(event, solution.time));
            match solution.as_ref() {
                Some(solution) if each(solution).is_break() => ControlFlow::Break(()),
                _ => ControlFlow::Continue(solution),
            }
        })
    }

    /// Gives every event to `push`, and keeps the solution it returns for an inertial sample.
    pub(crate) fn run(
        &self,
        config: &EstimatorConfig,
        keep: Keep,
        progress: &mut dyn FnMut(usize),
        mut push: impl FnMut(&Event, &mut Run) -> ControlFlow<(), Option<Solution>>,
    ) -> Run {
        let thinning = (keep == Keep::Thinned).then(Thinning::default);
        let mut run = Run { config: *config, thinning, ..Run::default() };
        let mut kept = Kept::new(keep, self.sample_count());
        let mut samples = 0;
        for event in self.events() {
            let ControlFlow::Continue(solution) = push(&event, &mut run) else { break };
            if let Event::Imu(_) = event {
                samples += 1;
                progress(samples);
                if let Some(solution) = solution {
                    kept.push(solution);
                }
            }
        }
        (run.solutions, run.solutions_left_out) = kept.finish();
        run
    }
}

/// Whether a state of `time` is that at an inertial sample: one that was refused leaves the state where it was.
pub(crate) fn is_of(event: &Event, time: Time) -> bool {
    matches!(event, Event::Imu(sample) if sample.time == time)
}

/// Is handed every solution; whether to go on.
type Each<'a> = dyn FnMut(&Solution) -> ControlFlow<()> + 'a;

/// The delay of the fixes beyond the declared latency, s, and its one-sigma.
fn gps_offset(filter: &Ekf<Full, 28>) -> (f64, f64) {
    let state = Full::GPS_DELAY.unwrap_or_default();
    (filter.parameter(state), filter.covariance().variance(state).max(0.0).sqrt())
}
