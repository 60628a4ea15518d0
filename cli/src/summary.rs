//! The summary of a run in words, for the terminal.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use hovernav_formats::{InnovationSizes, RunSummary};
use hovernav_score::{Axis, Statistics};

use crate::output;
use hovernav_pages::flight::facts;

/// The summary of a filter run in words.
pub trait InWords {
    /// Root mean square of the horizontal error, m, and of the velocity error, m/s; `None` without a reference.
    fn row_errors(&self) -> [Option<f64>; 2];

    /// Writes the summary to standard output, and the warnings to standard error.
    fn say(&self, out: &Path);
}

impl InWords for RunSummary {
    fn row_errors(&self) -> [Option<f64>; 2] {
        let rmse = |axis: &str| Some(self.error.as_ref()?.get(axis)?.rmse);
        let velocity = ["vn_mps", "ve_mps", "vd_mps"].map(rmse);
        let squares = velocity.into_iter().map(|rmse| Some(rmse? * rmse?)).sum::<Option<f64>>();
        [rmse("horizontal_m"), squares.map(f64::sqrt)]
    }

    fn say(&self, out: &Path) {
        let mut text = String::new();
        let mut reasons: &[String] = &[];
        if let Some(verdict) = &self.verdict {
            reasons = &verdict.reasons;
            let _ = writeln!(text, "{}", verdict.words);
            for reason in reasons {
                let _ = writeln!(text, "  - {reason}");
            }
        }
        for fact in facts(self) {
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
        output::say_text(text);
        // Warnings in the verdict are not repeated.
        self.warnings.iter().filter(|warning| !reasons.contains(warning)).for_each(output::warn);
        output::say(format_args!("{:<32} {} ({:.3} s)", "written", out.display(), self.wall_s));
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

/// The innovations of the onboard estimator next to those of hovernav: root mean square, and normalised mean square.
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
