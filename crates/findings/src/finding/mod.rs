//! Findings: what happened, to which sensor, when, how much and why.

mod harm;
mod kind;
mod sensor;

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;

use hovernav::ekf::Aid;
use serde::Serialize;

pub use harm::Harm;
pub use kind::FindingKind;
pub use sensor::Sensor;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// For information.
    Info,
    /// The solution is worse, or may be.
    Warning,
    /// The log cannot be estimated as it is, or it contradicts the solution.
    Error,
}

/// Event in a log or in a run over it, with one plain sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Start, s on the log's clock.
    pub start_s: f64,
    /// End, s on the log's clock; equal to the start for an event without duration.
    pub end_s: f64,
    /// Sensor concerned.
    pub sensor: Sensor,
    /// Kind of event.
    pub kind: FindingKind,
    /// Severity.
    pub severity: Severity,
    /// Number of samples or fixes concerned.
    pub count: usize,
    /// Harm to the solution; `None` until the run is judged, and without a solution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub harm: Option<Harm>,
    /// One sentence with sensor, time, size and cause.
    pub words: String,
}

impl Finding {
    /// A warning about one sample or fix, with its span, s on the log's clock, and its sentence.
    #[must_use]
    pub fn warning(
        sensor: Sensor,
        kind: FindingKind,
        (start_s, end_s): (f64, f64),
        words: impl Into<String>,
    ) -> Self {
        let (severity, count, words) = (Severity::Warning, 1, words.into());
        Self { start_s, end_s, sensor, kind, severity, count, harm: None, words }
    }

    /// This finding with another severity.
    #[must_use]
    pub fn severity(self, severity: Severity) -> Self {
        Self { severity, ..self }
    }

    /// This finding, about `count` samples or fixes.
    #[must_use]
    pub fn of(self, count: usize) -> Self {
        Self { count, ..self }
    }

    /// Whether the finding is a warning or an error.
    #[must_use]
    pub fn is_warning(&self) -> bool {
        self.severity >= Severity::Warning
    }

    /// Whether the finding names an error of the clocks, or of the set-up of a sensor that the estimator cannot do
    /// without: the cause of others.
    fn is_cause(&self) -> bool {
        let is_setup = self.kind == FindingKind::SetUp && !can_be_ignored(self.sensor);
        is_setup || self.kind == FindingKind::ClockRate
    }

    /// Order of importance, the most important first: by severity, causes first, then by harm. Of findings with equal
    /// harm, the shorter span comes first, because it states the time better. Without a harm, the longer span comes
    /// first.
    #[must_use]
    pub fn by_harm(&self, other: &Self) -> Ordering {
        let size = |finding: &Self| finding.harm.map_or(-1.0, |harm| harm.size);
        let length_s = |finding: &Self| finding.end_s - finding.start_s;
        let by_length = length_s(self).total_cmp(&length_s(other));
        let by_length = if self.harm.is_some() { by_length } else { by_length.reverse() };
        let by_cause = other.is_cause().cmp(&self.is_cause());
        let by_severity = other.severity.cmp(&self.severity).then(by_cause);
        by_severity.then(size(other).total_cmp(&size(self))).then(by_length)
    }
}

/// Aids that the estimator can do without, with their names in a [`SetupFinding`] and in `[aiding]`.
pub(crate) const AIDS: [(Aid, Sensor, &str); 4] = [
    (Aid::Magnetometer, Sensor::Magnetometer, "magnetometer"),
    (Aid::Baro, Sensor::Barometer, "baro"),
    (Aid::SecondAntenna, Sensor::SecondAntenna, "second_antenna"),
    (Aid::Attitude, Sensor::UnitAttitude, "attitude"),
];

/// Impossible or unlikely property of a log, with its likely cause and its remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupFinding {
    /// Sensor concerned.
    pub sensor: Sensor,
    /// Whether the property is certainly wrong. The log is then rejected, or estimated without the sensor if that [can
    /// be ignored](Self::can_be_ignored).
    pub is_certain: bool,
    /// Found and expected values, with sizes.
    pub found: String,
    /// Likely mistake.
    pub cause: String,
    /// Remedy: the setting or text to write, and where; empty if there is no short one.
    pub mend: String,
}

impl fmt::Display for SetupFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.sensor, self.found, self.cause)?;
        if !self.mend.is_empty() {
            write!(f, "; {}", self.mend)?;
        }
        Ok(())
    }
}

impl SetupFinding {
    /// Whether the estimator can do without the sensor: an aid, or the receiver's velocity.
    #[must_use]
    pub fn can_be_ignored(&self) -> bool {
        can_be_ignored(self.sensor)
    }

    /// This set-up finding as a finding over a log from `start_s` to `end_s`.
    #[must_use]
    pub fn finding(&self, start_s: f64, end_s: f64) -> Finding {
        let is_error = self.is_certain && !self.can_be_ignored();
        let severity = if is_error { Severity::Error } else { Severity::Warning };
        let span_s = (start_s, end_s);
        Finding::warning(self.sensor, FindingKind::SetUp, span_s, self.to_string())
            .severity(severity)
    }
}

/// Whether the estimator can do without `sensor`.
fn can_be_ignored(sensor: Sensor) -> bool {
    sensor == Sensor::GpsVelocity || AIDS.iter().any(|(_, aid, _)| *aid == sensor)
}

/// Largest number of sentences of one kind; further findings are only counted.
const LISTED: usize = 3;

/// The warnings among `findings` as sentences, in order of time. For each sensor and kind the three most harmful are
/// listed, with the number of the others.
#[must_use]
pub fn sentences(findings: &[Finding]) -> Vec<String> {
    // Ordered by name, so that findings with the same start are in alphabetical order.
    let mut kinds: BTreeMap<(&str, &str), Vec<&Finding>> = BTreeMap::new();
    for finding in findings.iter().filter(|finding| finding.is_warning()) {
        kinds.entry((finding.sensor.name(), finding.kind.name())).or_default().push(finding);
    }
    let mut told: Vec<(f64, String)> = Vec::new();
    for mut of_kind in kinds.into_values() {
        of_kind.sort_by(|a, b| a.by_harm(b));
        let others = of_kind.split_off(of_kind.len().min(LISTED));
        told.extend(of_kind.iter().map(|finding| (finding.start_s, finding.words.clone())));
        if let [first, ..] = &others[..] {
            let start_s = others.iter().map(|other| other.start_s).fold(f64::INFINITY, f64::min);
            let end_s = others.iter().map(|other| other.end_s).fold(f64::NEG_INFINITY, f64::max);
            let (sensor, kind, count) = (first.sensor, first.kind, others.len());
            told.push((
                start_s,
                format!("{sensor}: {kind} {count} more times from {start_s:.1} to {end_s:.1} s"),
            ));
        }
    }
    told.sort_by(|a, b| a.0.total_cmp(&b.0));
    told.into_iter().map(|(_, sentence)| sentence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_happened_often_is_reported_three_times_and_counted() {
        let finding = |start_s: f64, length_s: f64, severity| {
            let (span_s, words) = ((start_s, start_s + length_s), format!("outage at {start_s}"));
            Finding::warning(Sensor::Gps, FindingKind::Outage, span_s, words).severity(severity)
        };
        let mut findings: Vec<Finding> =
            (0..20).map(|k| finding(f64::from(k), 0.125, Severity::Warning)).collect();
        findings[7].end_s = 9.0;
        findings[9].severity = Severity::Info;
        let told = sentences(&findings);
        assert_eq!(told.len(), 4);
        assert!(told.contains(&"outage at 7".to_owned()));
        assert!(told.contains(&"gps: outage 16 more times from 2.0 to 19.1 s".to_owned()));
    }
}
