//! The estimator over a log of any format: wrong aids are ignored, the solution is scored.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::Path;

use crate::format::Format;
use crate::log::Log;
use crate::summary::{OutageDrift, RunSummary};
use hovernav::ekf::{EstimatorConfig, Solution};
use hovernav::ins::HeadingSource;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, LogError, Outage, Reference};
use hovernav_findings::{
    Finding, SetupFinding, check_fitness, findings, ignore, ignore_inconsistent,
};
use hovernav_replay::{Keep, Run, estimate_each, smooth_keeping, thin};
use hovernav_score::{Apart, Score, innovations, outage_drift, score};

/// Changes of a log for one estimation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Changes<'a> {
    /// Whether [`Dataset::configure`] has overridden settings of the log.
    pub configured: bool,
    /// Spans in which the GPS is ignored.
    pub outages: &'a [Outage],
    /// Largest rate of the GPS, Hz; `None` keeps the rate of the log.
    pub gps_rate_hz: Option<f64>,
}

impl Changes<'_> {
    /// Whether the solution differs from the one computed in flight.
    #[cfg(feature = "record")]
    fn any(&self) -> bool {
        self.configured || !self.outages.is_empty() || self.gps_rate_hz.is_some()
    }
}

/// One pass of the estimator over a dataset.
#[derive(Debug)]
pub struct Pass {
    /// The forward run.
    pub run: Run,
    /// The smoothed solutions, thinned as by [`thin`]; empty if nothing was smoothed.
    pub smoothed: Vec<Solution>,
    /// Spans where the fixes contradict the smoothed solution.
    pub denied: Vec<Finding>,
}

impl Pass {
    /// Runs the estimator over `dataset`, and the smoother if `smooth`. `progress` receives the number of inertial
    /// samples done in the current run, forward or backward, `each` every solution: the smoothed ones, or if nothing
    /// could be smoothed, those of the filter.
    ///
    /// # Errors
    /// The first error of `progress` or `each`, which ends the pass.
    pub fn over<E>(
        dataset: &Dataset,
        config: &EstimatorConfig,
        keep: Keep,
        smooth: bool,
        progress: impl Fn(usize) -> Result<(), E>,
        mut each: impl FnMut(&Solution) -> Result<(), E>,
    ) -> Result<Self, E> {
        let failure = RefCell::new(None);
        let step = |done: usize| {
            let mut failure = failure.borrow_mut();
            if failure.is_none() {
                *failure = progress(done).err();
            }
            if failure.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        if smooth {
            let run = smooth_keeping(dataset, config, keep, &step);
            if let Some(error) = failure.take() {
                return Err(error);
            }
            let run = run.unwrap_or_default();
            if !run.solutions.is_empty() {
                run.solutions.iter().try_for_each(each)?;
                let smoothed = thin(run.solutions);
                let denied = run.inconsistent.iter().map(Finding::from).collect();
                return Ok(Self { run: run.forward, smoothed, denied });
            }
        }
        // If `progress` reports an error, the next solution ends the run.
        let forward = |done| {
            let _ = step(done);
        };
        let run = estimate_each(dataset, config, keep, forward, |solution| {
            failure.take().map_or_else(|| each(solution), Err)
        })?;
        if let Some(error) = failure.take() {
            return Err(error);
        }
        Ok(Self { run, smoothed: Vec::new(), denied: Vec::new() })
    }

    /// The smoothed solutions if there are any, otherwise those of the filter.
    #[must_use]
    pub fn solutions(&self) -> &[Solution] {
        if self.smoothed.is_empty() { &self.run.solutions } else { &self.smoothed }
    }
}

/// The estimator's result for a log.
#[derive(Debug)]
pub struct Estimated {
    /// The settings of the passes.
    pub config: EstimatorConfig,
    /// The last pass.
    pub pass: Pass,
    /// Sensors that were ignored, because their readings are impossible or contradict the fixes.
    pub ignored: Vec<SetupFinding>,
}

/// An [`Estimated`] log with its errors and its summary.
#[derive(Debug)]
pub struct Judged {
    /// The summary, without its wall time.
    pub summary: RunSummary,
    /// The reference, if the log has one.
    pub reference: Option<Reference>,
    /// The score against the reference.
    pub score: Option<Score>,
}

impl Log {
    /// Estimates the log, read from `path`, with `changes`. `pass` runs the filter, usually by [`Pass::over`]. If
    /// the first pass shows that a heading sensor contradicts the fixes, `pass` runs again without that sensor, unless
    /// `once`. A flight record has no second pass: its replay has the sensors of the flight.
    ///
    /// # Errors
    /// [`check_fitness`] and [`Dataset::settings`]; [`LogError::Unusable`] if the alignment did not end; the
    /// errors of `pass`.
    pub fn estimate<E: From<LogError>>(
        &mut self,
        path: &Path,
        changes: &Changes<'_>,
        once: bool,
        mut pass: impl FnMut(&Dataset, &EstimatorConfig, Keep) -> Result<Pass, E>,
    ) -> Result<Estimated, E> {
        let dataset = &mut self.dataset;
        // A dataset directory without fixes lacks gps.csv; an error then names that file.
        let source = match self.format {
            Format::Dataset if dataset.fixes.is_empty() => path.join("gps.csv"),
            _ => path.to_path_buf(),
        };
        let denied_aids = check_fitness(dataset, &source)?;
        let leaves_out = self.format != Format::Record;
        let mut ignored = if leaves_out { ignore(dataset, denied_aids) } else { Vec::new() };
        let config = dataset.settings()?;
        dataset.withhold(changes.outages, changes.gps_rate_hz);

        // All solutions of a flight record stay in memory, because each of them is compared.
        let keep = if leaves_out { Keep::Thinned } else { Keep::All };
        let mut flown = pass(dataset, &config, keep)?;
        if leaves_out && !once {
            let without = ignore_inconsistent(dataset, &config, &flown.run);
            if !without.is_empty() {
                flown = pass(dataset, &config, keep)?;
                ignored.extend(without);
            }
        }
        if flown.run.solutions.is_empty() {
            let reason = format!(
                "no solution: alignment found no fix with {} s of inertial samples before it{}",
                config.alignment.duration_s,
                match config.alignment.heading {
                    Some(HeadingSource::Course) => {
                        let speed_mps = config.alignment.course_speed_mps;
                        format!(", at {speed_mps} m/s or faster for its course")
                    }
                    _ => String::new(),
                }
            );
            return Err(LogError::Unusable { path: path.to_path_buf(), reason }.into());
        }
        Ok(Estimated { config, pass: flown, ignored })
    }

    /// Scores and summarises the result for the log, read from `path`. `smooth` is whether smoothing was requested.
    ///
    /// # Errors
    /// An unreadable reference, and a log file that changed since it was opened.
    pub fn judge(
        &self,
        path: &Path,
        changes: &Changes<'_>,
        smooth: bool,
        estimated: &Estimated,
    ) -> Result<Judged, LogError> {
        let (dataset, pass) = (&self.dataset, &estimated.pass);
        let (run, solutions) = (&pass.run, pass.solutions());
        let mut moments: Vec<Time> =
            run.solutions.iter().chain(&pass.smoothed).map(|solution| solution.time).collect();
        moments.sort_unstable();
        let reference = match self.format {
            // A directory with a mapping may contain a reference, too.
            Format::Dataset | Format::Text if path.is_dir() => {
                Reference::open_at(path, &dataset.manifest, &moments)?
            }
            _ => None,
        };
        let span = dataset.sample_span();
        let first_imu = span.map_or(Time::ZERO, |(first, _)| first);
        let scored = reference.as_ref().map(|reference| score(solutions, reference, first_imu));
        let apart = match (&reference, &scored, &self.onboard) {
            (Some(reference), Some(scored), _) => {
                Some(Apart::of_reference(solutions, reference, scored.from))
            }
            (_, _, Some(onboard)) => Some(onboard.apart(solutions)),
            _ => None,
        };
        let drifts = drifts(solutions, changes.outages, span, reference.as_ref());

        let mut summary = RunSummary::new(path, dataset, run, !pass.smoothed.is_empty());
        let mut findings = findings(dataset, run);
        dataset.ensure_read()?;
        findings.extend(pass.denied.clone());
        if let Some((first, last)) = span {
            let of_log = |ignored: &SetupFinding| ignored.finding(first.seconds(), last.seconds());
            findings.extend(estimated.ignored.iter().map(of_log));
        }
        summary.set_findings(findings, solutions, apart.as_ref());
        if smooth && pass.smoothed.is_empty() {
            let warning = "not smoothed, because the heading was not found: the solution uses past measurements only";
            summary.warnings.push(warning.into());
        }
        summary.warnings.extend(reference.iter().flat_map(|reference| reference.warnings.clone()));
        #[cfg(feature = "record")]
        if let Some(record) = &self.record
            && !record.solutions.is_empty()
            && !changes.any()
        {
            summary.reproduction = Some(record.reproduced_by(&run.solutions).into());
        }
        summary.set_scores(scored.as_ref(), drifts);
        let innovations = innovations(run);
        if let Some(onboard) = &self.onboard {
            summary.onboard = onboard.difference(solutions);
            summary.onboard_innovations = onboard.innovation_sizes(&innovations);
        }
        summary.conclude(&innovations);
        Ok(Judged { summary, reference, score: scored })
    }
}

fn drifts(
    solutions: &[Solution],
    outages: &[Outage],
    span: Option<(Time, Time)>,
    reference: Option<&Reference>,
) -> Vec<OutageDrift> {
    outages
        .iter()
        .map(|outage| OutageDrift {
            start_s: outage.start.seconds(),
            duration_s: outage.duration_s,
            is_outside: span.is_some_and(|(first, last)| {
                outage.start > last || outage.start.offset_by(outage.duration_s) < first
            }),
            max_horizontal_m: reference.and_then(|reference| {
                outage_drift(solutions, reference, outage.start, outage.duration_s)
            }),
        })
        .collect()
}
