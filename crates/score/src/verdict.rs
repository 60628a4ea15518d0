//! Verdict on a solution, in words.

use std::collections::HashSet;

use hovernav::ekf::Innovation;
use serde::Serialize;

use crate::consistency::pooled;
use crate::level::Level;
use hovernav_dataset::is_clock_step;
use hovernav_findings::{Finding, FindingKind, Severity};

/// Largest number of reasons in a verdict.
const NAMED: usize = 3;

/// A verdict with its main reasons, plain text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// The reliability.
    pub level: Level,
    /// The verdict in one sentence.
    pub words: String,
    /// The main reasons, worst first, one sentence each.
    pub reasons: Vec<String>,
}

impl Verdict {
    /// The verdict on a run, by the worst of its findings and by the consistency of its `innovations`. Causes come
    /// first: `warnings` on steps of a clock, then the set-up. Effects follow, worst first: findings by harm, then
    /// innovations in the filter's order. Without any, the other `warnings` decide.
    #[must_use]
    pub fn of_run(findings: &[Finding], warnings: &[String], innovations: &[Innovation]) -> Self {
        // A step of the clock may harm all that follows, and no finding measures the harm.
        let steps = warnings.iter().filter(|warning| is_clock_step(warning));
        let mut causes: Vec<(Level, String)> =
            steps.map(|warning| (Level::Care, warning.clone())).collect();
        let mut effects = Vec::new();
        let mut worst: Vec<&Finding> = findings.iter().filter(|one| one.is_warning()).collect();
        worst.sort_by(|a, b| a.by_harm(b));
        // Only the worst finding of each sensor and kind is named. So a cause is named next to its effect.
        let mut named = HashSet::new();
        worst.retain(|finding| named.insert((finding.sensor.name(), finding.kind.name())));
        for finding in worst {
            let is_error = finding.severity == Severity::Error;
            let level = if is_error { Level::Bad } else { Level::Care };
            let is_cause = matches!(finding.kind, FindingKind::SetUp | FindingKind::ClockRate);
            let reasons = if is_cause { &mut causes } else { &mut effects };
            reasons.push((level, finding.words.clone()));
        }
        for (name, pooled) in pooled(innovations) {
            let (level, words) = pooled.judged();
            if level > Level::Good {
                let (low, high) = pooled.interval;
                let mean = pooled.mean;
                let words = format!(
                    "{name} innovations {words}: mean square {mean:.2}, expected {low:.2} to {high:.2}"
                );
                effects.push((level, words));
            }
        }
        effects.sort_by_key(|(level, _)| std::cmp::Reverse(*level));
        let mut reasons = causes;
        reasons.extend(effects);
        if reasons.is_empty() {
            reasons.extend(warnings.iter().map(|warning| (Level::Care, warning.clone())));
        }
        let level = reasons.iter().map(|(level, _)| *level).max().unwrap_or(Level::Good);
        let words = match level {
            Level::Good => "Good: no finding against this solution.",
            Level::Care => "With care: usable, but read the findings.",
            Level::Bad => "Do not rely on this solution before the findings are resolved.",
        };
        reasons.truncate(NAMED);
        let reasons = reasons.into_iter().map(|(_, words)| words).collect();
        Self { level, words: words.into(), reasons }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::ekf::Channel;
    use hovernav::ekf::Verdict::Accepted;
    use hovernav::time::Time;
    use hovernav_findings::{Harm, Sensor};

    fn finding(kind: FindingKind, severity: Severity, length_s: f64, words: &str) -> Finding {
        Finding::warning(Sensor::Gps, kind, (1.0, 1.0 + length_s), words).severity(severity)
    }

    fn harm(one_sigmas: Option<f64>, growth: f64) -> Option<Harm> {
        let size = one_sigmas.unwrap_or(growth);
        Some(Harm { position_m: None, velocity_mps: None, one_sigmas, growth, size })
    }

    #[test]
    fn the_worst_finding_decides_and_is_named_first() {
        let findings = [
            finding(FindingKind::Outage, Severity::Info, 1.0, "of no matter"),
            finding(FindingKind::Outage, Severity::Warning, 1.0, "an outage"),
            finding(FindingKind::SetUp, Severity::Error, 1.0, "axes turned over"),
        ];
        let verdict = Verdict::of_run(&findings, &["a warning".into()], &[]);
        assert_eq!(verdict.level, Level::Bad);
        assert_eq!(verdict.reasons, ["axes turned over", "an outage"]);
        let verdict = Verdict::of_run(&findings[..1], &[], &[]);
        assert_eq!((verdict.level, verdict.reasons.len()), (Level::Good, 0));
        let verdict = Verdict::of_run(&findings[..1], &["a warning".into()], &[]);
        assert_eq!((verdict.level, &*verdict.reasons[0]), (Level::Care, "a warning"));
    }

    #[test]
    fn a_step_of_the_clock_and_an_error_of_the_set_up_come_before_their_effects() {
        let findings = [
            finding(FindingKind::TimeOffset, Severity::Warning, 1.0, "time offset"),
            finding(FindingKind::SetUp, Severity::Warning, 100.0, "gyros of the wrong sign"),
        ];
        let step = "gps.csv: line 7: the clock goes back by 3.000 s".to_owned();
        let verdict = Verdict::of_run(&findings, &["other".into(), step.clone()], &[]);
        assert_eq!(verdict.reasons, [&step, "gyros of the wrong sign", "time offset"]);
        // Innovations fifty times too large: an effect, although it decides the level.
        let innovations: Vec<Innovation> = (0..200)
            .map(|k| Innovation {
                time: Time::from_seconds(f64::from(k)),
                channel: Channel::VelocityNorth,
                innovation: if k % 2 == 0 { 50.0 } else { -50.0 },
                sigma: 1.0,
                verdict: Accepted,
            })
            .collect();
        let verdict = Verdict::of_run(&findings, &[], &innovations);
        assert_eq!(verdict.level, Level::Bad);
        assert_eq!(verdict.reasons[0], "gyros of the wrong sign");
        assert!(verdict.reasons[1].contains("innovations"), "{:?}", verdict.reasons);
    }

    #[test]
    fn harm_outranks_length_and_each_kind_is_named_once() {
        let harmed = |kind, length_s, harm, words| Finding {
            harm,
            ..finding(kind, Severity::Warning, length_s, words)
        };
        let findings = [
            harmed(FindingKind::Vibration, 300.0, harm(Some(2.0), 1.0), "long and harmless"),
            harmed(FindingKind::Rejected, 2.0, harm(Some(3.0), 1.0), "short"),
            harmed(FindingKind::Rejected, 3.4, harm(Some(30.0), 1.0), "short and harmful"),
            harmed(FindingKind::Outage, 4.0, harm(None, 8.0), "grown"),
            harmed(FindingKind::Gap, 4.0, harm(Some(1.0), 90.0), "covered by its one-sigma"),
        ];
        let verdict = Verdict::of_run(&findings, &[], &[]);
        assert_eq!(verdict.level, Level::Care);
        assert_eq!(verdict.reasons, ["short and harmful", "grown", "long and harmless"]);
    }
}
