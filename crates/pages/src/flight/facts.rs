//! The summary of a filter run in words and numbers.

use hovernav_formats::{AlignmentSummary, RunSummary};
use hovernav_score::Statistics;

use crate::Fact;

/// The facts of a run for the table of its page.
#[must_use]
pub fn facts(summary: &RunSummary) -> Vec<Fact> {
    let mut facts = vec![
        Fact::new("input", &summary.input),
        Fact::new("duration", format!("{:.1} s", summary.duration_s)),
        Fact::new("inertial samples", summary.imu_samples),
        Fact::new(
            "fixes used / rejected / unusable",
            format!(
                "{} / {} / {}",
                summary.gps_fixes_used, summary.gps_fixes_rejected, summary.gps_fixes_unusable
            ),
        ),
    ];
    if let Some(alignment) = &summary.alignment {
        facts.push(Fact::new("alignment", alignment_in_words(alignment)));
    }
    for outage in &summary.outages {
        let span = format!("outage {} s for {} s", outage.start_s, outage.duration_s);
        let drift = match outage.max_horizontal_m {
            Some(drift) => format!("drifted {drift:.2} m"),
            None if outage.is_outside => "outside the log: no fix was ignored".into(),
            None => "not covered by a reference".into(),
        };
        facts.push(Fact { label: span, value: drift });
    }
    if let Some(Statistics { median, max, .. }) = summary.outage_drift_m {
        let words = format!("{median:.2} m median, {max:.2} m worst");
        facts.push(Fact { label: "drift in outages".into(), value: words });
    }
    facts.extend(summary.notes.iter().map(|note| Fact::new("note", note.clone())));
    facts
}

/// The headline numbers of a run; empty without a reference.
#[must_use]
pub fn headlines(summary: &RunSummary) -> Vec<Fact> {
    let Some(error) = &summary.error else { return Vec::new() };
    let mut headlines = Vec::new();
    for (label, axes, unit) in [
        ("velocity RMSE n / e / d", ["vn_mps", "ve_mps", "vd_mps"], "m/s"),
        ("attitude RMSE roll / pitch / yaw", ["roll_deg", "pitch_deg", "yaw_deg"], "°"),
    ] {
        let numbers: Vec<String> =
            axes.iter().filter_map(|axis| Some(format!("{:.3}", error.get(axis)?.rmse))).collect();
        if !numbers.is_empty() {
            headlines.push(Fact::new(label, format!("{} {unit}", numbers.join(" / "))));
        }
    }
    headlines
}

fn alignment_in_words(alignment: &AlignmentSummary) -> String {
    let source = match (alignment.heading, alignment.heading_found_s) {
        ("unknown", Some(found_s)) => format!("heading found in motion at {found_s:.1} s"),
        ("unknown", None) => "heading not found".to_owned(),
        (source, _) => format!("heading from {source}"),
    };
    let rest = if alignment.at_rest { "at rest" } else { "in motion" };
    format!(
        "at {:.2} s, {rest}, roll and pitch {}, {source}, one sigma {:.1}°",
        alignment.end_s, alignment.attitude, alignment.heading_sigma_deg
    )
}
