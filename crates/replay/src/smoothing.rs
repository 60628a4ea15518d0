//! Smoothing of a recorded flight: the estimator forward, then backward.
//!
//! The smoother needs ten times the memory of a sample for each sample. So the filter runs over the log twice. The
//! first run stores only the filter at the start of every block of samples. Then the filter runs over each block again,
//! from the last block to the first. After each block, the smoother goes back over it at once.

use std::cell::Cell;
use std::mem::size_of;
use std::ops::ControlFlow;

use crate::inconsistent::{InconsistentSpan, inconsistent_spans};
use crate::kept::Keep;
use crate::run::{self, Run, is_of};
use hovernav::ekf::layout::Full;
use hovernav::ekf::{
    Adjoint, Estimator, EstimatorConfig, HeadingSearch, Notice, Smoother, Solution, Trace,
};
use hovernav::event::Event;
use hovernav::ins::{Alignment, HeadingSource, Start};
use hovernav_dataset::{Dataset, Events};

/// Result of a forward run and its smoothing.
#[derive(Clone, Debug, Default)]
pub struct SmoothedRun {
    /// The filter's own solutions.
    pub forward: Run,
    /// The smoothed solutions, at the times of the forward run's; empty if nothing could be smoothed, see
    /// [`smooth`].
    pub solutions: Vec<Solution>,
    /// Spans whose smoothed solutions were inconsistent with the fixes. The filter's own solutions replace them.
    pub inconsistent: Vec<InconsistentSpan>,
}

/// Smallest number of samples of a block, for which the smoother needs 16 MB.
const MIN_BLOCK: usize = 4096;
/// One-sigma, rad (15°), of a heading that was found later and is used at the start: the gyros have drifted since.
const START_SIGMA_RAD: f64 = 0.26;
/// Largest memory of the smoother for one sample, bytes.
const TRACE: usize = 4096;

/// State of the filter before a block of events.
struct Checkpoint<'a> {
    estimator: Estimator<Full, 28>,
    events: Events<'a>,
}

/// Runs the estimator forward over the log, then smooths backward, so that every solution uses the whole log for
/// states and biases.
///
/// If the heading is found only in motion, the log is run again from a start turned to that heading. So the whole
/// log is smoothed. Nothing is smoothed if alignment never ends or the heading is never found: any chosen heading
/// would be arbitrary. `progress` receives the number of inertial samples done in the current run, forward or
/// backward, and can end the smoothing: the result is then `None`. `keep` selects the solutions of the forward run
/// that stay in memory.
///
/// Where the fixes are inconsistent with the smoothed path, the filter's own solutions replace it, with a finding.
/// At either end of the replacement, the path steps by the size of the inconsistency.
///
/// See [`Smoother`] for the method, [`smoothing_bytes`] for the memory.
pub fn smooth_keeping(
    dataset: &Dataset,
    config: &EstimatorConfig,
    keep: Keep,
    mut progress: impl FnMut(usize) -> ControlFlow<()>,
) -> Option<SmoothedRun> {
    smoothed(dataset, config, keep, &mut progress)
}

/// [`smooth_keeping`] with every solution of the forward run.
pub fn smooth(
    dataset: &Dataset,
    config: &EstimatorConfig,
    mut progress: impl FnMut(usize),
) -> SmoothedRun {
    let endless = &mut |done| {
        progress(done);
        ControlFlow::Continue(())
    };
    smoothed(dataset, config, Keep::All, endless).unwrap_or_default()
}

/// Memory for smoothing in addition to the log itself, bytes: a solution of every sample, the checkpoints, and the
/// smoother's data of one block.
#[must_use]
pub fn smoothing_bytes(dataset: &Dataset) -> u64 {
    let (samples, block) = (dataset.sample_count(), block_of(dataset));
    let checkpoint = size_of::<Estimator<Full, 28>>() + 1024;
    let bytes = samples * size_of::<Solution>()
        + samples.min(block) * TRACE
        + (samples / block + 1) * checkpoint;
    bytes as u64
}

/// Samples in a block, for the least total memory of checkpoints and one block's trace.
fn block_of(dataset: &Dataset) -> usize {
    let balanced = (dataset.sample_count() * size_of::<Estimator<Full, 28>>() / TRACE).isqrt();
    balanced.max(MIN_BLOCK)
}

fn smoothed(
    dataset: &Dataset,
    config: &EstimatorConfig,
    keep: Keep,
    progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Option<SmoothedRun> {
    let mut checkpoints = Vec::new();
    let forward = checkpointed(dataset, config, keep, None, progress, &mut checkpoints)?;
    let aligned = forward.notices.iter().find_map(|notice| match notice {
        Notice::Aligned(alignment) => Some(*alignment),
        _ => None,
    });
    let (mut start, mut second) = (None, None);
    if let Some(alignment) = aligned.filter(|by| by.heading == HeadingSource::Unknown) {
        let found = forward.notices.iter().find_map(|notice| match notice {
            Notice::HeadingFound { turn_rad, .. } => Some(*turn_rad),
            _ => None,
        });
        let Some(turn_rad) = found else {
            return Some(SmoothedRun { forward, ..SmoothedRun::default() });
        };
        let Alignment { start: aligned, axis, .. } = alignment;
        start = Some(HeadingSearch::turned_start(aligned, axis, turn_rad, START_SIGMA_RAD));
        checkpoints.clear();
        let again = checkpointed(dataset, config, Keep::Thinned, start, progress, &mut checkpoints);
        second = Some(again?);
    }
    let mut solutions = Vec::with_capacity(dataset.sample_count());
    let mut after = Adjoint::default();
    let (block, mut done) = (block_of(dataset), 0);
    while let Some(Checkpoint { mut estimator, events }) = checkpoints.pop() {
        let mut smoother = Smoother::<Full, 28>::with_capacity(block.min(dataset.sample_count()));
        let mut samples = 0;
        for event in events {
            if matches!(event, Event::Imu(_)) {
                if samples == block {
                    break;
                }
                (samples, done) = (samples + 1, done + 1);
                if progress(done).is_break() {
                    return None;
                }
            }
            push(&mut estimator, &event, start, &mut smoother, |_| ());
            if let Some(filter) = estimator.filter()
                && is_of(&event, filter.state().time)
            {
                smoother.sampled(filter);
            }
        }
        solutions.extend(smoother.smooth_before(&mut after).into_iter().rev());
    }
    solutions.reverse();
    let spans = inconsistent_spans(dataset, second.as_ref().unwrap_or(&forward), &solutions);
    if !spans.is_empty() {
        put_forward(dataset, config, &spans, &mut solutions);
    }
    Some(SmoothedRun { forward, solutions, inconsistent: spans })
}

/// Replaces the solutions in these spans by those of a forward run.
fn put_forward(
    dataset: &Dataset,
    config: &EstimatorConfig,
    spans: &[InconsistentSpan],
    solutions: &mut [Solution],
) {
    let mut estimator = Estimator::<Full, 28>::new(*config);
    for event in dataset.events() {
        estimator.push(&event, |_| ());
        let Event::Imu(sample) = event else { continue };
        if spans.iter().any(|span| span.covers(sample.time))
            && let Some(solution) = estimator.solution()
            && let Ok(at) = solutions.binary_search_by_key(&solution.time, |s| s.time)
        {
            solutions[at] = solution;
        }
    }
}

/// Runs the filter forward and stores a checkpoint before the first sample of every block. The run begins from
/// `start` if given, otherwise from the alignment's own start. `None` if `progress` ended it.
fn checkpointed<'a>(
    dataset: &'a Dataset,
    config: &EstimatorConfig,
    keep: Keep,
    start: Option<Start>,
    progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    checkpoints: &mut Vec<Checkpoint<'a>>,
) -> Option<Run> {
    let is_ended = Cell::new(false);
    let step = &mut |done| is_ended.set(is_ended.get() || progress(done).is_break());
    let mut estimator = Estimator::<Full, 28>::new(*config);
    let (mut events, block) = (dataset.events(), block_of(dataset));
    checkpoints.push(Checkpoint { estimator: estimator.clone(), events: events.clone() });
    let mut samples = 0;
    let run = run::over(dataset, config, keep, step, |event, run| {
        if is_ended.get() {
            return ControlFlow::Break(());
        }
        let is_sample = matches!(event, Event::Imu(_));
        if is_sample && samples == block {
            let (estimator, events) = (estimator.clone(), events.clone());
            checkpoints.push(Checkpoint { estimator, events });
            samples = 0;
        }
        events.next();
        samples += usize::from(is_sample);
        push(&mut estimator, event, start, &mut (), |notice| run.keep(notice));
        if is_sample && let Some(filter) = estimator.filter() {
            run.learned_by(Some(filter));
        }
        ControlFlow::Continue(estimator.solution().filter(|solution| is_of(event, solution.time)))
    });
    (!is_ended.get()).then_some(run)
}

/// Passes `event` to the estimator, which continues from `start`, if given, once it is aligned.
fn push(
    estimator: &mut Estimator<Full, 28>,
    event: &Event,
    start: Option<Start>,
    trace: &mut impl Trace<f64, 28>,
    mut notify: impl FnMut(Notice),
) {
    let mut aligned = false;
    estimator.push_traced(event, trace, |notice| {
        aligned |= matches!(notice, Notice::Aligned(_));
        notify(notice);
    });
    if let Some(start) = start.filter(|_| aligned) {
        estimator.begin_at(&start);
    }
}
