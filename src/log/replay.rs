//! A recorded flight through the estimator.

use super::dataset::Dataset;
use crate::ekf::layout::Full;
use crate::ekf::{Estimator, EstimatorConfig, Notice, Solution, Trace};
use crate::event::Event;
use crate::time::Time;

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
    /// One solution per inertial sample from the end of alignment on.
    pub solutions: Vec<Solution>,
    /// What was worth telling, in order.
    pub notices: Vec<Notice>,
}

impl Dataset {
    /// Leaves out the fixes within `outages`, and thins the rest to at most `rate_hz`.
    pub fn withhold(&mut self, outages: &[Outage], rate_hz: Option<f64>) {
        self.fixes.retain(|fix| !outages.iter().any(|outage| outage.covers(fix.time)));
        if let Some(rate_hz) = rate_hz {
            // A tenth of the interval forgives the jitter of the receiver's clock.
            let interval_s = 0.9 / rate_hz;
            let mut last: Option<Time> = None;
            self.fixes.retain(|fix| {
                let keep = last.is_none_or(|last| fix.time - last >= interval_s);
                if keep {
                    last = Some(fix.time);
                }
                keep
            });
        }
    }

    /// How many fixes come before the first inertial sample, of no use to anyone.
    #[must_use]
    pub fn fixes_before_imu(&self) -> usize {
        let first = self.imu.first().map_or(Time::ZERO, |sample| sample.time);
        self.fixes.iter().take_while(|fix| fix.time < first).count()
    }

    /// Everything the sensors said, in order of arrival: a fix arrives its latency after it is true.
    pub fn events(&self) -> impl Iterator<Item = Event> + '_ {
        let latency_s = self.manifest.gps.latency_s;
        let mut imu = self.imu.iter().peekable();
        let mut fixes = self.fixes.iter().peekable();
        let mut baro = self.baro.iter().peekable();
        let mut magnetometer = self.magnetometer.iter().peekable();
        std::iter::from_fn(move || {
            let last = Time::from_nanoseconds(i64::MAX);
            let times = [
                imu.peek().map_or(last, |sample| sample.time),
                fixes.peek().map_or(last, |fix| fix.time.offset_by(latency_s)),
                baro.peek().map_or(last, |(time, _)| *time),
                magnetometer.peek().map_or(last, |(time, _)| *time),
            ];
            let (first, _) = times.iter().enumerate().min_by_key(|(_, time)| **time)?;
            match first {
                0 => imu.next().map(|sample| Event::Imu(*sample)),
                1 => fixes.next().map(|fix| Event::Gps(*fix)),
                2 => baro.next().map(|&(time, height_m)| Event::Baro { time, height_m }),
                _ => magnetometer
                    .next()
                    .map(|&(time, field_gauss)| Event::Magnetometer { time, field_gauss }),
            }
        })
    }

    /// Runs the estimator over the log. `progress` hears how many inertial samples are done.
    pub fn estimate(&self, config: &EstimatorConfig, progress: impl FnMut(usize)) -> Run {
        let estimator = Estimator::<Full, 26>::new(*config);
        self.run(estimator, &mut (), progress)
    }

    /// Runs a given estimator over the log, watched by `trace`.
    pub(super) fn run(
        &self,
        mut estimator: Estimator<Full, 26>,
        trace: &mut impl Trace<f64, 26>,
        mut progress: impl FnMut(usize),
    ) -> Run {
        let mut run = Run { solutions: Vec::with_capacity(self.imu.len()), ..Run::default() };
        let mut samples = 0;
        for event in self.events() {
            estimator.push_traced(&event, trace, |notice| run.notices.push(notice));
            if let Event::Imu(_) = event {
                samples += 1;
                progress(samples);
                run.solutions.extend(estimator.solution());
            }
        }
        run
    }
}
