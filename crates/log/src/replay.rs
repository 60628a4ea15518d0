//! A recorded flight through the estimator.

use serde::Serialize;

use crate::dataset::{Dataset, Source};
use hovernav::ekf::layout::{Full, Layout as _};
use hovernav::ekf::{
    Aid, Ekf, Estimator, EstimatorConfig, FullEkf, HeadingSearch, Notice, Smoother, Solution,
};
use hovernav::event::Event;
use hovernav::imu::Notch;
use hovernav::ins::{HeadingSource, Start};
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
    /// One solution per inertial sample from the end of alignment on.
    pub solutions: Vec<Solution>,
    /// What the estimator reported, in order, but for readings left out by design.
    pub notices: Vec<Notice>,
    /// Readings that could not be used for a fault of theirs, each a notice too.
    pub unusable: UnusedReadings,
    /// Readings left out by design: too soon after the last, or before the heading is known.
    pub left_out: UnusedReadings,
    /// How much earlier than declared the fixes turned out to hold, s, with one-sigma.
    pub gps_offset: Option<(f64, f64)>,
    /// By how many times the inertial unit turned out noisier than assumed, in variance, at most.
    pub noise_excess: f64,
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
    fn learned_by(&mut self, filter: Option<&FullEkf>) {
        self.gps_offset = filter.map(gps_offset);
        let excess = filter.map_or(1.0, FullEkf::noise_excess);
        self.noise_excess = self.noise_excess.max(excess);
    }

    /// Keeps a notice; of readings left out by design, of which there are more than samples, the
    /// number alone.
    fn keep(&mut self, notice: Notice) {
        if let Notice::NotUsed { aid, reason, .. } = notice {
            if !reason.is_fault() {
                return self.left_out.count(aid);
            }
            self.unusable.count(aid);
        }
        self.notices.push(notice);
    }
}

/// What a run over a log and back gave.
#[derive(Clone, Debug, Default)]
pub struct SmoothedRun {
    /// The filter's own solutions, moment by moment.
    pub forward: Run,
    /// The smoothed solutions, at the times of the forward run's; none where nothing could be
    /// smoothed, see [`Dataset::smooth`].
    pub solutions: Vec<Solution>,
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
        let first = self.imu.first().map_or(Time::ZERO, |sample| sample.time);
        self.fixes.iter().take_while(|fix| fix.time < first).count()
    }

    /// Everything the sensors sent, in order of arrival: as [`order`](Self::order) has it, else by
    /// time, a fix arriving its latency after it is true.
    pub fn events(&self) -> impl Iterator<Item = Event> + '_ {
        let latency_s = self.manifest.gps.latency_s;
        let mut imu = self.imu.iter().peekable();
        let mut fixes = self.fixes.iter().peekable();
        let mut baro = self.baro.iter().peekable();
        let mut magnetometer = self.magnetometer.iter().peekable();
        let mut headings = self.headings.iter().peekable();
        let mut ranges = self.ranges.iter().peekable();
        let mut rotor = self.rotor.iter().peekable();
        let mut notch = self.manifest.imu.notch.map(Notch::new);
        let mut order = if self.has_order() { self.order.iter() } else { [].iter() };
        std::iter::from_fn(move || {
            let source = order.next().copied().or_else(|| {
                let times = [
                    (Source::Imu, imu.peek().map(|sample| sample.time)),
                    (Source::Gps, fixes.peek().map(|fix| fix.time.offset_by(latency_s))),
                    (Source::Baro, baro.peek().map(|(time, _)| *time)),
                    (Source::Magnetometer, magnetometer.peek().map(|(time, _)| *time)),
                    (Source::AntennaHeading, headings.peek().map(|heading| heading.time)),
                    (Source::Range, ranges.peek().map(|reading| reading.time)),
                ];
                let present = times.into_iter().filter_map(|(source, time)| Some((source, time?)));
                present.min_by_key(|(_, time)| *time).map(|(source, _)| source)
            })?;
            match source {
                Source::Imu => imu.next().map(|sample| {
                    let Some(notch) = &mut notch else { return Event::Imu(*sample) };
                    while let Some((_, rotor_hz)) = rotor.next_if(|row| row.0 <= sample.time) {
                        notch.set_frequency_hz(*rotor_hz);
                    }
                    Event::Imu(notch.filter(sample))
                }),
                Source::AntennaHeading => headings.next().copied().map(Event::AntennaHeading),
                Source::Range => ranges.next().copied().map(Event::Range),
                Source::Gps => fixes.next().map(|fix| Event::Gps(*fix)),
                Source::Baro => baro.next().map(|&(time, height_m)| Event::Baro { time, height_m }),
                Source::Magnetometer => magnetometer
                    .next()
                    .map(|&(time, field_gauss)| Event::Magnetometer { time, field_gauss }),
            }
        })
    }

    /// Whether `order` lists every event there is.
    fn has_order(&self) -> bool {
        let count = |of| self.order.iter().filter(|source| **source == of).count();
        count(Source::Imu) == self.imu.len()
            && count(Source::Gps) == self.fixes.len()
            && count(Source::Baro) == self.baro.len()
            && count(Source::Magnetometer) == self.magnetometer.len()
            && count(Source::AntennaHeading) == self.headings.len()
            && count(Source::Range) == self.ranges.len()
    }

    /// Runs the estimator over the log. `progress` is called with the number of inertial samples done.
    pub fn estimate(&self, config: &EstimatorConfig, mut progress: impl FnMut(usize)) -> Run {
        self.estimated(config, &mut progress)
    }

    // Compiled here once, and not with the filter for every caller's closure; as what follows.
    fn estimated(&self, config: &EstimatorConfig, progress: &mut dyn FnMut(usize)) -> Run {
        let mut estimator = Estimator::<Full, 28>::new(*config);
        self.run(config, progress, |event, run| {
            estimator.push(event, |notice| run.keep(notice));
            run.learned_by(estimator.filter());
            estimator.solution()
        })
    }

    /// Runs the estimator forward over the log, then smooths backward: every moment from the whole
    /// log, biases and all.
    ///
    /// A log whose heading is found only in motion is gone over again, the filter starting in the
    /// heading's sector, so that all of it is smoothed. Where alignment never ends or the heading is
    /// never found, nothing is smoothed: to choose a heading would be to guess, and to guess
    /// with confidence. `progress` is called with the number of inertial samples that the forward run
    /// under way has done.
    ///
    /// See [`Smoother`] for the method and the memory it takes, under 4 kB an inertial sample.
    pub fn smooth(&self, config: &EstimatorConfig, mut progress: impl FnMut(usize)) -> SmoothedRun {
        self.smoothed(config, &mut progress)
    }

    fn smoothed(&self, config: &EstimatorConfig, progress: &mut dyn FnMut(usize)) -> SmoothedRun {
        let (forward, mut smoother) = self.traced(config, None, progress);
        let aligned = forward.notices.iter().find_map(|notice| match notice {
            Notice::Aligned(alignment) => Some(*alignment),
            _ => None,
        });
        if let Some(alignment) = aligned.filter(|by| by.heading == HeadingSource::Unknown) {
            let found = forward.notices.iter().find_map(|notice| match notice {
                Notice::HeadingFound { sector, .. } => Some(*sector),
                _ => None,
            });
            let Some(sector) = found else {
                return SmoothedRun { forward, solutions: Vec::new() };
            };
            // The first trace starts where the search ended; its memory goes before the second's.
            drop(smoother);
            let start = HeadingSearch::sector_start(alignment.start, sector);
            smoother = self.traced(config, Some(start), progress).1;
        }
        SmoothedRun { forward, solutions: smoother.smooth() }
    }

    /// A forward run that leaves what the smoother needs; from `start` where one is given, else from
    /// the alignment's own.
    fn traced(
        &self,
        config: &EstimatorConfig,
        start: Option<Start>,
        progress: &mut dyn FnMut(usize),
    ) -> (Run, Smoother<Full, 28>) {
        let mut estimator = Estimator::<Full, 28>::new(*config);
        let mut smoother = Smoother::with_capacity(self.imu.len());
        let run = self.run(config, progress, |event, run| {
            let mut aligned = false;
            estimator.push_traced(event, &mut smoother, |notice| {
                aligned |= matches!(notice, Notice::Aligned(_));
                run.keep(notice);
            });
            if let Some(start) = start.filter(|_| aligned) {
                estimator.begin_at(&start);
            }
            if let (Event::Imu(_), Some(filter)) = (event, estimator.filter()) {
                smoother.sampled(filter);
                run.learned_by(Some(filter));
            }
            estimator.solution()
        });
        (run, smoother)
    }

    /// Gives every event to `push`, and keeps the solution it returns for an inertial sample.
    fn run(
        &self,
        config: &EstimatorConfig,
        progress: &mut dyn FnMut(usize),
        mut push: impl FnMut(&Event, &mut Run) -> Option<Solution>,
    ) -> Run {
        let solutions = Vec::with_capacity(self.imu.len());
        let mut run = Run { config: *config, solutions, ..Run::default() };
        let mut samples = 0;
        for event in self.events() {
            let solution = push(&event, &mut run);
            if let Event::Imu(_) = event {
                samples += 1;
                progress(samples);
                run.solutions.extend(solution);
            }
        }
        run
    }
}

/// The delay of the fixes beyond the declared latency, s, and its one-sigma.
fn gps_offset(filter: &Ekf<Full, 28>) -> (f64, f64) {
    let state = Full::GPS_DELAY.unwrap_or_default();
    (filter.parameter(state), filter.covariance().variance(state).max(0.0).sqrt())
}
