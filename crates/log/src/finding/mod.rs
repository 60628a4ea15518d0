//! A finding: what happened to which sensor, when, how badly and why.

mod kind;
mod sensor;

use std::collections::BTreeMap;
use std::fmt;

use hovernav::ekf::Aid;
use serde::Serialize;

pub use kind::FindingKind;
pub use sensor::Sensor;

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Good to know.
    Info,
    /// The solution is worse for it, or may be.
    Warning,
    /// It cannot be estimated like this.
    Error,
}

/// Something found in a log or in a run over it, in one plain sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// When it began, s on the log's clock.
    pub start_s: f64,
    /// When it ended, s; the start again where it took no time.
    pub end_s: f64,
    /// Whose it is.
    pub sensor: Sensor,
    /// What kind of thing it is.
    pub kind: FindingKind,
    /// How much it matters.
    pub severity: Severity,
    /// How many samples or fixes it concerns.
    pub count: usize,
    /// Sensor, time, size and cause in one sentence.
    pub words: String,
}

impl Finding {
    /// Whether it deserves a second look.
    #[must_use]
    pub fn is_warning(&self) -> bool {
        self.severity >= Severity::Warning
    }
}

/// What the estimator can do without, as a [`SetupFinding`] and as `[aiding]` name it.
pub(crate) const AIDS: [(Aid, Sensor, &str); 4] = [
    (Aid::Magnetometer, Sensor::Magnetometer, "magnetometer"),
    (Aid::Baro, Sensor::Barometer, "baro"),
    (Aid::SecondAntenna, Sensor::SecondAntenna, "second_antenna"),
    (Aid::Attitude, Sensor::UnitAttitude, "attitude"),
];

/// Something that cannot be, or can hardly be, as a log has it: what was found, what that looks like,
/// and how to mend it.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupFinding {
    /// Whose it is.
    pub sensor: Sensor,
    /// Whether it certainly cannot be: the log is then not to be estimated as it is, or not with what
    /// [can be left out](Self::can_be_left_out).
    pub is_certain: bool,
    /// What was found and what was expected, with sizes.
    pub found: String,
    /// The likely mistake.
    pub cause: String,
    /// What to write where; empty where nothing short would do.
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
    /// Whether the estimator can do without whose it is: an aid, or the receiver's velocity.
    #[must_use]
    pub fn can_be_left_out(&self) -> bool {
        self.sensor == Sensor::GpsVelocity
            || AIDS.iter().any(|(_, sensor, _)| *sensor == self.sensor)
    }

    /// The finding over a log from `start_s` to `end_s`.
    #[must_use]
    pub fn finding(&self, start_s: f64, end_s: f64) -> Finding {
        Finding {
            start_s,
            end_s,
            sensor: self.sensor,
            kind: FindingKind::SetUp,
            severity: if self.is_certain && !self.can_be_left_out() {
                Severity::Error
            } else {
                Severity::Warning
            },
            count: 1,
            words: self.to_string(),
        }
    }
}

/// Sentences of one kind before the rest is only counted.
const TOLD: usize = 3;

/// The warnings among `findings` as sentences, in order of time; of what happened often the longest
/// three and the number of the others.
#[must_use]
pub fn sentences(findings: &[Finding]) -> Vec<String> {
    // By name, so that of those that begin together the order is that of the alphabet.
    let mut kinds: BTreeMap<(&str, &str), Vec<&Finding>> = BTreeMap::new();
    for finding in findings.iter().filter(|finding| finding.is_warning()) {
        kinds.entry((finding.sensor.name(), finding.kind.name())).or_default().push(finding);
    }
    let mut told: Vec<(f64, String)> = Vec::new();
    for mut of_kind in kinds.into_values() {
        let length = |finding: &Finding| finding.end_s - finding.start_s;
        of_kind.sort_by(|a, b| length(b).total_cmp(&length(a)));
        let others = of_kind.split_off(of_kind.len().min(TOLD));
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
    fn what_happened_often_is_told_three_times_and_counted() {
        let finding = |start_s: f64, length_s: f64, severity| Finding {
            start_s,
            end_s: start_s + length_s,
            sensor: Sensor::Gps,
            kind: FindingKind::Outage,
            severity,
            count: 1,
            words: format!("outage at {start_s}"),
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
