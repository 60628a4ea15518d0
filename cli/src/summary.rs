//! The summary of a run in words, for the page and the terminal.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use hovernav_formats::{AlignmentSummary, InnovationSizes, RunSummary};
use hovernav_log::{Axis, Statistics};

use crate::page::Fact;

/// The summary of a filter run in words.
pub trait InWords {
    /// The facts of the run for the table of the page.
    fn facts(&self) -> Vec<Fact>;

    /// The headline numbers.
    fn headlines(&self) -> Vec<Fact>;

    /// Root mean square of the horizontal error, m, and of the velocity error, m/s; `None` without a reference.
    fn row_errors(&self) -> [Option<f64>; 2];

    /// The text for the terminal.
    fn in_words(&self, out: &Path) -> String;
}

impl InWords for RunSummary {
    fn facts(&self) -> Vec<Fact> {
        let mut facts = vec![
            Fact::new("input", &self.input),
            Fact::new("duration", format!("{:.1} s", self.duration_s)),
            Fact::new("inertial samples", self.imu_samples),
            Fact::new(
                "fixes used / rejected / unusable",
                format!(
                    "{} / {} / {}",
                    self.gps_fixes_used, self.gps_fixes_rejected, self.gps_fixes_unusable
                ),
            ),
        ];
        if let Some(alignment) = &self.alignment {
            facts.push(Fact::new("alignment", alignment_in_words(alignment)));
        }
        for outage in &self.outages {
            let span = format!("outage {} s for {} s", outage.start_s, outage.duration_s);
            let drift = match outage.max_horizontal_m {
                Some(drift) => format!("drifted {drift:.2} m"),
                None if outage.is_outside => "outside the log: no fix was ignored".into(),
                None => "not covered by a reference".into(),
            };
            facts.push(Fact { label: span, value: drift });
        }
        if let Some(Statistics { median, max, .. }) = self.outage_drift_m {
            let words = format!("{median:.2} m median, {max:.2} m worst");
            facts.push(Fact { label: "drift in outages".into(), value: words });
        }
        facts.extend(self.notes.iter().map(|note| Fact::new("note", note.clone())));
        facts
    }

    fn headlines(&self) -> Vec<Fact> {
        let Some(error) = &self.error else { return Vec::new() };
        let mut headlines = Vec::new();
        for (label, axes, unit) in [
            ("velocity RMSE n / e / d", ["vn_mps", "ve_mps", "vd_mps"], "m/s"),
            ("attitude RMSE roll / pitch / yaw", ["roll_deg", "pitch_deg", "yaw_deg"], "°"),
        ] {
            let numbers: Vec<String> = axes
                .iter()
                .filter_map(|axis| Some(format!("{:.3}", error.get(axis)?.rmse)))
                .collect();
            if !numbers.is_empty() {
                headlines.push(Fact::new(label, format!("{} {unit}", numbers.join(" / "))));
            }
        }
        headlines
    }

    fn row_errors(&self) -> [Option<f64>; 2] {
        let rmse = |axis: &str| Some(self.error.as_ref()?.get(axis)?.rmse);
        let velocity = ["vn_mps", "ve_mps", "vd_mps"].map(rmse);
        let squares = velocity.into_iter().map(|rmse| Some(rmse? * rmse?)).sum::<Option<f64>>();
        [rmse("horizontal_m"), squares.map(f64::sqrt)]
    }

    fn in_words(&self, out: &Path) -> String {
        let mut text = String::new();
        for fact in self.facts() {
            let _ = writeln!(text, "{:<32} {}", fact.label, fact.value);
        }
        if let Some(error) = &self.error {
            write_sizes(&mut text, "error", error);
        }
        if let Some(onboard) = &self.onboard {
            write_sizes(
                &mut text,
                &format!("difference from onboard {}", onboard.name),
                &onboard.difference,
            );
        }
        if !self.onboard_innovations.is_empty() {
            write_innovations(&mut text, &self.onboard_innovations);
        }
        #[cfg(feature = "record")]
        if let Some(reproduction) = &self.reproduction {
            let _ = writeln!(text, "{}", reproduction.in_words());
        }
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {warning}");
        }
        let _ = writeln!(text, "{:<32} {} ({:.3} s)", "written", out.display(), self.wall_s);
        text
    }
}

/// A table of error statistics, one row per axis.
fn write_sizes(text: &mut String, title: &str, sizes: &BTreeMap<&'static str, Statistics>) {
    let _ = writeln!(text, "{title:<32} {:>9} {:>9} {:>9} {:>9}", "rmse", "median", "p95", "max");
    for axis in Axis::ALL {
        if let Some(Statistics { rmse, median, p95, max }) = sizes.get(axis.name()) {
            let name = axis.name();
            let _ = writeln!(text, "  {name:<30} {rmse:>9.3} {median:>9.3} {p95:>9.3} {max:>9.3}");
        }
    }
}

/// The innovations of the onboard estimator next to ours: root mean square, and normalised mean square.
fn write_innovations(text: &mut String, sizes: &BTreeMap<&'static str, InnovationSizes>) {
    let _ = writeln!(
        text,
        "{:<32} {:>9} {:>9} {:>9} {:>9}",
        "innovations, onboard and ours", "rms", "ours", "nis", "ours"
    );
    let number = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.3}"));
    for (name, InnovationSizes { onboard, ours }) in sizes {
        // Angles are shown in degrees.
        let (name, scale) = match name.strip_suffix("_rad") {
            Some(name) => (format!("{name}_deg"), 180.0 / std::f64::consts::PI),
            None => ((*name).to_owned(), 1.0),
        };
        let _ = writeln!(
            text,
            "  {name:<30} {:>9.3} {:>9} {:>9} {:>9}",
            scale * onboard.rms,
            number(ours.map(|ours| scale * ours.rms)),
            number(onboard.mean_square),
            number(ours.and_then(|ours| ours.mean_square)),
        );
    }
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
