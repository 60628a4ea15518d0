//! Drift of the solution in windows without GPS, each window evaluated separately.
//!
//! Up to the first ignored fix of a window, a run with the window equals a run without it. One pass over the log
//! therefore leaves a copy of the estimator at the start of each window. Each copy then runs over its window without
//! the fixes. The result equals that of a whole run with this one window, to the bit. `hovernav estimate` with several
//! `--outage` runs all windows in one pass. The ignored fixes of one window then change the learned sensor errors of
//! the filter before a later window.

use std::iter::once;

use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig, Solution};
use hovernav::event::Event;
use hovernav_dataset::{Dataset, Outage, Reference};
use hovernav_score::{Axis, outage_drift, score};
use rayon::prelude::*;

/// Drift of the solution in a window without GPS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Largest horizontal distance from the reference, m.
    pub horizontal_m: f64,
    /// Root mean square of the error divided by its one-sigma, north and east.
    pub over_sigma: Option<f64>,
}

/// Drift in each of the `outages`, each evaluated as if it were the only one. `None` where solution or reference does
/// not cover the outage.
#[must_use]
pub fn drifts(
    dataset: &Dataset,
    config: &EstimatorConfig,
    reference: &Reference,
    outages: &[Outage],
) -> Vec<Option<Drift>> {
    let mut order: Vec<usize> = (0..outages.len()).collect();
    order.sort_by_key(|&index| outages[index].start);
    let mut waiting = order.into_iter().peekable();
    let mut estimator = Estimator::<Full, 28>::new(*config);
    let mut events = dataset.events();
    let mut forks = Vec::new();
    while let Some(event) = events.next() {
        while let Some(index) = waiting.next_if(|&index| begins(&outages[index], &event)) {
            forks.push((index, estimator.clone(), once(event).chain(events.clone())));
        }
        if waiting.peek().is_none() {
            break;
        }
        estimator.push(&event, |_| ());
    }
    let flown: Vec<_> = forks
        .into_par_iter()
        .map(|(index, estimator, events)| {
            let solutions = within(&outages[index], estimator, events);
            (index, drift(&solutions, reference, &outages[index]))
        })
        .collect();
    let mut drifts = vec![None; outages.len()];
    for (index, drift) in flown {
        drifts[index] = drift;
    }
    drifts
}

/// Whether `event` is the first event that belongs to a window: a sample within or after it, or a fix to ignore.
fn begins(outage: &Outage, event: &Event) -> bool {
    match event {
        Event::Imu(sample) => sample.time >= outage.start,
        Event::Gps(fix) => outage.covers(fix.time),
        _ => false,
    }
}

/// The solutions from the start of `outage` to its end, without the fixes of the window.
fn within(
    outage: &Outage,
    mut estimator: Estimator<Full, 28>,
    events: impl Iterator<Item = Event>,
) -> Vec<Solution> {
    let end = outage.start.offset_by(outage.duration_s);
    let mut solutions = Vec::new();
    for event in events {
        match event {
            Event::Gps(fix) if outage.covers(fix.time) => continue,
            Event::Imu(sample) if sample.time > end => break,
            _ => estimator.push(&event, |_| ()),
        }
        // A rejected sample leaves the state unchanged.
        let of_sample = |solution: &Solution| matches!(event, Event::Imu(sample) if sample.time == solution.time);
        solutions.extend(estimator.solution().filter(of_sample));
    }
    solutions
}

fn drift(solutions: &[Solution], reference: &Reference, outage: &Outage) -> Option<Drift> {
    let horizontal_m = outage_drift(solutions, reference, outage.start, outage.duration_s)?;
    let scored = score(solutions, reference, outage.start.offset_by(-reference.skip_s));
    let square = |axis| Some(scored.axis(axis)?.error_over_sigma?.powi(2));
    let squares = square(Axis::North).zip(square(Axis::East));
    Some(Drift { horizontal_m, over_sigma: squares.map(|(n, e)| ((n + e) / 2.0).sqrt()) })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use hovernav::time::Time;
    use hovernav_replay::estimate;

    use super::*;

    #[test]
    fn a_window_flown_alone_gives_the_bits_of_a_whole_flight_without_its_fixes() {
        let heli = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../datasets/heli-hover");
        let mut dataset = Dataset::open(&heli).unwrap();
        let config = dataset.settings().unwrap();
        let reference = Reference::open(&heli, &dataset.manifest).unwrap().unwrap();
        // Windows overlap, are not in order of time, and one starts between two samples.
        let outages = [(150.0, 10.0), (61.017, 15.0), (160.0, 10.0)]
            .map(|(start_s, duration_s)| Outage { start: Time::from_seconds(start_s), duration_s });
        let drifts = drifts(&dataset, &config, &reference, &outages);
        for (outage, drift) in outages.iter().zip(drifts) {
            let mut whole = dataset.clone();
            whole.withhold(&[*outage], None);
            assert!(whole.fixes.len() < dataset.fixes.len());
            let run = estimate(&whole, &config, |_| {});
            let expected =
                outage_drift(&run.solutions, &reference, outage.start, outage.duration_s).unwrap();
            assert_eq!(drift.unwrap().horizontal_m.to_bits(), expected.to_bits());
        }
    }
}
