//! Parts of a flight for which a model is valid.

use std::ops::Range;

use super::error::IdentifyError;
use super::flight::FlightRecord;
use crate::record::{Experiment, TestPoint};
use hovernav::frames::wrap_angle;

/// Shortest part of a flight that is used, s. A shorter part does not justify its own initial state and offsets.
pub(super) const MIN_S: f64 = 6.0;
/// Largest change of heading within which the mean wind counts as constant in body axes, rad.
const TURNED_RAD: f64 = 0.5;
/// Length of a piece of a flight without test points, s.
const PIECE_S: f64 = 10.0;

/// All parts of the flight in its condition, without the test points `held_back`.
pub(super) fn stretches(
    record: &FlightRecord,
    held_back: &[&TestPoint],
) -> Result<Vec<Experiment>, IdentifyError> {
    let held_back: Vec<Range<usize>> = held_back
        .iter()
        .map(|point| record.sample(point.start)..record.sample(point.end))
        .collect();
    let pieces = steady(record, |sample| held_back.iter().any(|range| range.contains(&sample)));
    let pieces = pieces.into_iter().map(|rows| {
        let mut piece = record.experiment.slice(rows.clone())?;
        piece.name = format!("flight from sample {}", rows.start);
        Ok(piece)
    });
    pieces.collect()
}

/// The flight in its condition in pieces of 10 s, each as a test point without a stick.
pub(super) fn pieces(record: &FlightRecord) -> Vec<TestPoint> {
    let length = (PIECE_S / record.experiment.period_s).round().max(1.0) as usize;
    let at = |sample: usize| record.start.offset_by(sample as f64 * record.experiment.period_s);
    let stretches = steady(record, |_| false).into_iter();
    let pieces = stretches.flat_map(|rows| {
        let whole = (rows.len() / length).max(1);
        (0..whole).map(move |piece| {
            let start = rows.start + piece * length;
            start..(start + length).min(rows.end)
        })
    });
    pieces
        .map(|rows| TestPoint {
            stick: None,
            first_step: at(rows.start),
            last_step: at(rows.end),
            start: at(rows.start),
            end: at(rows.end),
            steps: 0,
        })
        .collect()
}

/// Ranges of samples in the flight's condition with recorded data, without the samples that `omitted` accepts.
fn steady(record: &FlightRecord, omitted: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let experiment = &record.experiment;
    let least = (MIN_S / experiment.period_s) as usize;
    let at = |sample: usize| record.start.offset_by(sample as f64 * experiment.period_s);
    let is_known = |sample: usize| record.is_whole(at(sample), at(sample + 1));
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut first = None;
    for sample in 0..=experiment.samples() {
        let within = sample < experiment.samples()
            && is_known(sample)
            && record.holds(sample)
            && !omitted(sample);
        let turned = first.is_some_and(|first: usize| {
            let headings = record.heading_rad.get(sample).zip(record.heading_rad.get(first));
            headings.is_some_and(|(now, then)| wrap_angle(now - then).abs() > TURNED_RAD)
        });
        if let Some(start) = first.filter(|_| !within || turned) {
            if sample - start >= least {
                found.push(start..sample);
            }
            first = None;
        }
        if within && first.is_none() {
            first = Some(sample);
        }
    }
    found
}
