//! Clipping: samples at the end of a sensor's range.

use super::judged::Judged;
use super::spans::{Span, Spans, when};
use crate::finding::{Finding, FindingKind, Sensor};
use crate::rates::{AXES, Rates};
use hovernav::earth::STANDARD_GRAVITY_MPS2;

/// Longest time, s, between two clipped samples of one event.
const APART_S: f64 = 10.0;

/// Detector of samples at full scale, by axis. A first pass finds the levels at which readings pile up, a second one
/// the samples there.
pub(super) struct Ends {
    axes: [End; 6],
    /// Number of samples seen in the second pass.
    seen: usize,
}

/// Detector for one axis.
struct End {
    /// Known range, rad/s or m/s²; zero if unknown.
    known: f64,
    /// Largest absolute reading.
    largest: f64,
    is_marked: bool,
    low: Extreme,
    high: Extreme,
    /// Levels, low and high, at which readings pile up; known from the second pass on.
    scale: [Option<f64>; 2],
    spans: Spans,
    /// Indices of the first and last sample of each span.
    within: Vec<(usize, usize)>,
}

impl Ends {
    pub fn of(log: &Judged<'_>) -> Self {
        let model = &log.run.config.ekf.imu;
        let end = |axis: usize| End {
            known: if axis < 3 { model.gyro_range_radps } else { model.accel_range_mps2 },
            largest: 0.0,
            is_marked: false,
            low: Extreme::of(-1.0),
            high: Extreme::of(1.0),
            scale: [None; 2],
            spans: Spans::apart(APART_S),
            within: Vec::new(),
        };
        Self { axes: std::array::from_fn(end), seen: 0 }
    }

    pub fn look(&mut self, at: &Rates) {
        for (axis, (end, value)) in self.axes.iter_mut().zip(at.six()).enumerate() {
            end.largest = end.largest.max(value.abs());
            end.is_marked |= marked(at, axis);
            end.low.push(value);
            end.high.push(value);
        }
    }

    /// Ends the first pass. Returns whether a second pass can find anything.
    pub fn looked(&mut self) -> bool {
        for end in &mut self.axes {
            end.scale = [end.low.pile(), end.high.pile()];
        }
        self.axes
            .iter()
            .any(|end| end.is_marked || end.scale != [None; 2] || end.is_beyond_known(end.largest))
    }

    pub fn look_again(&mut self, at: &Rates) {
        let index = self.seen;
        self.seen += 1;
        for (axis, (end, value)) in self.axes.iter_mut().zip(at.six()).enumerate() {
            let is_clipped = match end.is_marked {
                true => marked(at, axis),
                false => end.scale.contains(&Some(value)) || end.is_beyond_known(value.abs()),
            };
            if !is_clipped {
                continue;
            }
            end.spans.push((at.time.seconds(), value.abs()));
            end.within.resize(end.spans.found.len(), (index, index));
            if let Some((_, last)) = end.within.last_mut() {
                *last = index;
            }
        }
    }

    pub fn find(self, findings: &mut Vec<Finding>) {
        for (axis, end) in self.axes.into_iter().enumerate() {
            for (span, (first, last)) in end.spans.found.into_iter().zip(end.within) {
                let Span { start_s, end_s, count, largest } = span;
                // A marked sample is a mean of raw readings of which at least one was clipped.
                let level = if end.is_marked {
                    "full scale, as the unit itself marks".to_owned()
                } else if axis < 3 {
                    format!("its full scale of {:.0} °/s", largest.to_degrees())
                } else {
                    format!(
                        "its full scale of {largest:.1} m/s² ({:.2} g)",
                        largest / STANDARD_GRAVITY_MPS2
                    )
                };
                let words = format!(
                    "{} clipped at {level} {}: {count} samples, {:.1} % of that time; larger values are lost",
                    AXES[axis],
                    when(start_s, end_s),
                    100.0 * count as f64 / (last - first + 1) as f64
                );
                findings.push(
                    Finding::warning(
                        Sensor::InertialUnit,
                        FindingKind::Clipping,
                        (start_s, end_s),
                        words,
                    )
                    .of(count),
                );
            }
        }
    }
}

impl End {
    fn is_beyond_known(&self, size: f64) -> bool {
        self.known > 0.0 && size >= 0.998 * self.known
    }
}

/// Extreme value of an axis to one side, the value next to it, and the number of times each occurred.
struct Extreme {
    side: f64,
    end: f64,
    next: f64,
    at_end: usize,
    at_next: usize,
    /// Number of times that the extreme was reached from another value.
    visits: usize,
    last: Option<f64>,
}

impl Extreme {
    const fn of(side: f64) -> Self {
        let none = f64::NEG_INFINITY;
        Self { side, end: none, next: none, at_end: 0, at_next: 0, visits: 0, last: None }
    }

    fn push(&mut self, value: f64) {
        let value = self.side * value;
        let last = self.last.replace(value);
        if value > self.end {
            (self.next, self.at_next) = (self.end, self.at_end);
            (self.end, self.at_end, self.visits) = (value, 0, 0);
        } else if value > self.next && value < self.end {
            (self.next, self.at_next) = (value, 0);
        }
        if value == self.end {
            self.at_end += 1;
            self.visits += usize::from(last.is_some_and(|last| last != value));
        } else if value == self.next {
            self.at_next += 1;
        }
    }

    /// The extreme value if readings pile up there repeatedly, as happens only at the end of a range; otherwise `None`.
    fn pile(&self) -> Option<f64> {
        /// Smallest number of readings at an end of the range.
        const PILED: usize = 6;
        /// Smallest number of times that the readings reach this end from another value.
        const VISITS: usize = 3;
        let is_end =
            self.at_end >= PILED && self.visits >= VISITS && self.at_end >= 4 * self.at_next;
        is_end.then_some(self.side * self.end)
    }
}

fn marked(at: &Rates, axis: usize) -> bool {
    if axis < 3 { at.clipped.gyro[axis] } else { at.clipped.accel[axis - 3] }
}
