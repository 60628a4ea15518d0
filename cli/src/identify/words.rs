//! An identification in words, for the page and the terminal. No fit without its bounds.

use std::fmt::Write as _;
use std::path::Path;

use hovernav_sysid::helicopter::Identification;
use hovernav_sysid::methods::prediction_error::Status;

use super::summary::Summary;
use crate::page::Fact;

impl Summary {
    /// The facts of the run, for the page and the terminal.
    pub fn facts(&self) -> Vec<Fact> {
        let count = |purpose| self.test_points.iter().filter(|p| p.used_for == purpose).count();
        let mut facts = self.estimate.facts();
        facts.push(Fact::new("model", format!("{}, continuous in time", self.model)));
        facts.push(Fact::new(
            "test points found / fitted / held back",
            format!(
                "{} / {} / {}",
                self.test_points.len(),
                count("estimation"),
                count("validation")
            ),
        ));
        facts.push(Fact::new("sample period", format!("{:.4} s", self.sample_period_s)));
        if !self.tones_hz.is_empty() {
            let tones: Vec<String> = self.tones_hz.iter().map(|hz| format!("{hz:.1}")).collect();
            facts.push(Fact::new("vibration notched out", format!("{} Hz", tones.join(", "))));
        }
        let result = &self.result;
        let end = if result.converged { "converged" } else { "not converged" };
        facts.push(Fact::new("search", format!("{} linearisations, {end}", result.iterations)));
        facts
    }
}

/// What the terminal shows.
pub fn in_words(
    summary: &Summary,
    found: &Identification,
    held: Option<&Identification>,
    out: &Path,
) -> String {
    let mut text = format!("{:<40} {}\n", "verdict", summary.verdict);
    for reason in &summary.reasons {
        let _ = writeln!(text, "{:<40} {reason}", "");
    }
    for fact in summary.facts() {
        let _ = writeln!(text, "{:<40} {}", fact.label, fact.value);
    }
    let fit = found.fit();
    let on = if found.validation.is_some() { "held-back" } else { "fitted" };
    let _ = writeln!(
        text,
        "\n{:<12} {:>9} {:>12} {:>12} {:>14}",
        "output", "fit %", "noise floor", "residual", "held GPS fit %"
    );
    for channel in fit.channels().0 {
        let mut channels = held.into_iter().flat_map(|held| held.fit().channels().0);
        let other = channels.find(|other| other.name == channel.name);
        let other = other.map_or_else(|| "–".into(), |other| format!("{:.1}", other.percent));
        let _ = writeln!(
            text,
            "{:<12} {:>9.1} {:>12.1} {:>12.4} {:>14}",
            channel.name, channel.percent, channel.floor_percent, channel.residual_rms, other
        );
    }
    let window_s = fit.window_s();
    let _ = writeln!(text, "(free runs of {window_s:.1} s over {on} test points)");
    let _ = writeln!(text, "bounds of the parameters, 1σ: {}\n", bounds_in_words(found));
    let _ = writeln!(
        text,
        "{:<10} {:>11} {:<10} {:>10} {:>8} {:>14}",
        "parameter", "value", "unit", "bound 1σ", "bound %", "insensitivity %"
    );
    for estimate in found.parameters() {
        let _ =
            write!(text, "{:<10} {:>11.4} {:<10} ", estimate.name, estimate.value, estimate.unit);
        let _ = if estimate.is_estimated() {
            let on_limit = if estimate.status == Status::OnBound { "  on its limit" } else { "" };
            writeln!(
                text,
                "{:>10.4} {:>8.1} {:>14.1}{on_limit}",
                estimate.bound,
                estimate.bound_percent(),
                estimate.insensitivity_percent()
            )
        } else {
            writeln!(text, "{:>10}", estimate.status.name())
        };
    }
    for (one, other, value) in found.strong_correlations(0.9) {
        let _ = writeln!(text, "correlation of {one} and {other}: {value:.3}");
    }
    let _ = writeln!(text);
    for warning in summary.warnings() {
        let _ = writeln!(text, "warning: {warning}");
    }
    let wall_s = summary.estimate.wall_s;
    let _ = writeln!(text, "{:<40} {} ({wall_s:.3} s)", "written", out.display());
    text
}

/// The few numbers to see first: a fit never without the bounds behind it.
pub fn headlines(found: &Identification, summary: &Summary) -> Vec<Fact> {
    let fit = found.fit();
    let channels = fit.channels().0.iter();
    let fits = channels.map(|channel| format!("{} {:.0}", channel.name, channel.percent));
    let over = if found.validation.is_some() { "held-back flight" } else { "fitted flight" };
    let fits = fits.collect::<Vec<_>>().join(" · ");
    vec![
        Fact::new("verdict", summary.verdict.to_string()),
        Fact::new(&format!("fit, %, free runs of {:.1} s over {over}", fit.window_s()), fits),
        Fact::new("bounds of the parameters, 1σ", bounds_in_words(found)),
    ]
}

/// The bounds without which a fit says nothing, in a few words.
pub fn bounds_in_words(found: &Identification) -> String {
    found.bounds().map_or_else(
        || "none: nothing was estimated".into(),
        |bounds| {
            format!(
                "median ±{:.1} %, worst ±{:.1} % ({})",
                bounds.median_percent, bounds.worst_percent, bounds.worst
            )
        },
    )
}
