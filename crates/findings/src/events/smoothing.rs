//! Spans of a smoothed path with which the fixes are inconsistent.

use crate::finding::{Finding, FindingKind, Sensor};
use hovernav_replay::InconsistentSpan;

impl From<&InconsistentSpan> for Finding {
    fn from(span: &InconsistentSpan) -> Self {
        let (start_s, end_s) = (span.start.seconds(), span.end.seconds());
        let words = format!(
            "smoothing rejected from {start_s:.1} to {end_s:.1} s: the velocities of the fixes are off the smoothed \
             path by {:.1} one-sigmas; either they are wrong, or the filter had diverged and was reset; the filter's \
             own solution is used there",
            span.sigmas
        );
        Self::warning(Sensor::Filter, FindingKind::SmoothingRejected, (start_s, end_s), words)
            .of(span.fixes)
    }
}
