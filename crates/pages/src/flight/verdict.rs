//! The verdict on a solution in words, without a reference.

use hovernav_log::consistency::PooledInnovations;
use hovernav_log::{Finding, Severity};

use super::{consistency, innovations};
use crate::{Level, Verdict};

/// Number of findings at the top of the page.
const NAMED: usize = 3;

/// The verdict on a run: the worst of its findings and of its consistency.
pub fn of_run(
    findings: &[Finding],
    warnings: &[String],
    consistency: &[(&str, PooledInnovations)],
) -> Verdict {
    let mut points: Vec<(Level, String)> = Vec::new();
    for (name, pooled) in consistency {
        let (level, words) = consistency::in_words(pooled);
        if level > Level::Good {
            let (low, high) = pooled.interval;
            points.push((
                level,
                format!(
                    "{name} innovations {words}: mean square {:.2}, expected {low:.2} to {high:.2}",
                    pooled.mean
                ),
            ));
        }
    }
    let mut worst: Vec<&Finding> = findings.iter().filter(|finding| finding.is_warning()).collect();
    let length = |finding: &Finding| finding.end_s - finding.start_s;
    worst.sort_by(|a, b| b.severity.cmp(&a.severity).then_with(|| length(b).total_cmp(&length(a))));
    points.extend(worst.iter().map(|finding| {
        let level = if finding.severity == Severity::Error { Level::Bad } else { Level::Care };
        (level, finding.words.clone())
    }));
    if points.is_empty() && !warnings.is_empty() {
        points.extend(warnings.iter().map(|warning| (Level::Care, warning.clone())));
    }
    points.sort_by_key(|(level, _)| std::cmp::Reverse(*level));
    let level = points.first().map_or(Level::Good, |(level, _)| *level);
    let words = match level {
        Level::Good => "Good: no finding against this solution.",
        Level::Care => "With care: usable, but read the findings.",
        Level::Bad => "Do not rely on this solution before the findings are resolved.",
    };
    points.truncate(NAMED);
    Verdict {
        level,
        words: words.into(),
        points: points.into_iter().map(|(_, words)| words).collect(),
    }
}

/// The verdict on the data of a page.
pub fn of(data: &super::FlightData<'_>) -> Option<Verdict> {
    if data.solutions.is_empty() {
        return None;
    }
    Some(of_run(data.findings, data.warnings, &innovations::pooled(data.innovations)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav_log::{FindingKind, Sensor};

    fn pooled(mean: f64) -> PooledInnovations {
        PooledInnovations { mean, interval: (0.97, 1.03), share_inside: 0.95 }
    }

    #[test]
    fn the_worst_finding_decides_and_is_named_first() {
        let finding = |severity, words: &str| Finding {
            start_s: 1.0,
            end_s: 2.0,
            sensor: Sensor::Gps,
            kind: FindingKind::Outage,
            severity,
            count: 1,
            words: words.into(),
        };
        let findings = [
            finding(Severity::Info, "of no matter"),
            finding(Severity::Warning, "an outage"),
            finding(Severity::Error, "axes turned over"),
        ];
        let verdict = of_run(&findings, &[], &[("Attitude", pooled(1.4))]);
        assert_eq!((verdict.level, &*verdict.points[0]), (Level::Bad, "axes turned over"));
        assert_eq!(verdict.points.len(), 3);
        let verdict =
            of_run(&findings[..1], &[], &[("Position", pooled(1.0)), ("Attitude", pooled(0.2))]);
        assert_eq!((verdict.level, verdict.points.len()), (Level::Good, 0));
    }
}
