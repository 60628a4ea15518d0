//! An identification in words, for the page and the terminal. A fit is always shown with the parameter bounds.

use std::fmt::Write as _;
use std::path::Path;

use hovernav_model::Grade;
use hovernav_sysid::helicopter::{FrequencyDomain, Identification, PairCost};
use hovernav_sysid::methods::frequency::FrequencyError;
use hovernav_sysid::methods::prediction_error::Status;

use super::summary::Summary;
use hovernav_pages::{Fact, Level, Verdict, flight};

impl Summary {
    /// The facts of the run, for the page and the terminal.
    pub fn facts(&self) -> Vec<Fact> {
        let count = |purpose| self.test_points.iter().filter(|p| p.used_for == purpose).count();
        let mut facts = flight::facts(&self.estimate);
        facts.push(Fact::new("model", format!("{}, continuous in time", self.model)));
        facts.push(Fact::new(
            "test points found / fitted / for validation",
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
            facts.push(Fact::new(
                "vibration removed by notches",
                format!("{} Hz", tones.join(", ")),
            ));
        }
        if self.dead_bands.iter().any(|dead_band| *dead_band > 0.0) {
            let dead_bands = self.dead_bands.map(|dead_band| format!("{dead_band:.4}"));
            facts.push(Fact::new("dead bands of the servos", dead_bands.join(", ")));
        }
        let result = &self.result;
        let end = if result.converged { "converged" } else { "not converged" };
        facts.push(Fact::new("search", format!("{} linearisations, {end}", result.iterations)));
        facts
    }
}

/// A percentage of a parameter's value in digits; a dash if the value is zero.
fn percent(of_value: f64) -> String {
    if of_value.is_finite() { format!("{of_value:.1}") } else { "–".into() }
}

/// The text for the terminal.
pub fn in_words(
    summary: &Summary,
    found: &Identification,
    held: Option<&Identification>,
    frequency: Result<&FrequencyDomain, &FrequencyError>,
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
    let on = if found.validation.is_some() { "validation" } else { "fitted" };
    let _ =
        write!(text, "\n{:<12} {:>9} {:>12} {:>12}", "output", "fit %", "noise floor", "residual");
    text += if held.is_some() { "  held GPS fit %\n" } else { "\n" };
    for channel in fit.channels().0 {
        let mut channels = held.into_iter().flat_map(|held| held.fit().channels().0);
        let other = channels.find(|other| other.name == channel.name);
        let other = other.map_or_else(String::new, |other| format!("  {:>14.1}", other.percent));
        let _ = writeln!(
            text,
            "{:<12} {:>9.1} {:>12.1} {:>12.4}{other}",
            channel.name, channel.percent, channel.floor_percent, channel.residual_rms
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
                "{:>10.4} {:>8} {:>14}{on_limit}",
                estimate.bound,
                percent(estimate.bound_percent()),
                percent(estimate.insensitivity_percent())
            )
        } else {
            writeln!(text, "{:>10}", estimate.status.name())
        };
    }
    if let Some(early) = early_sticks(found) {
        let _ = writeln!(text, "{early}");
    }
    for (one, other, value) in found.strong_correlations(0.9) {
        let _ = writeln!(text, "correlation of {one} and {other}: {value:.3}");
    }
    if let Ok(frequency) = frequency {
        text.push_str(&both_in_words(frequency));
    }
    let _ = writeln!(text);
    for warning in summary.warnings() {
        let _ = writeln!(text, "warning: {warning}");
    }
    let wall_s = summary.estimate.wall_s;
    let _ = writeln!(text, "{:<40} {} ({wall_s:.3} s)", "written", out.display());
    text
}

/// Parameters from both methods side by side, and the cost of each model against the measured responses.
fn both_in_words(found: &FrequencyDomain) -> String {
    let mut text = format!(
        "\n{:<10} {:>22} {:>22} {:>11}\n",
        "parameter", "time domain", "frequency domain", "sigma apart"
    );
    for own in &found.parameters {
        let shown = |(value, bound): (f64, f64)| format!("{value:.4} ± {bound:.4}");
        let (time, frequency) = (shown(own.time), shown(own.frequency));
        let mark = if own.disagrees() { "  disagree" } else { "" };
        let _ = writeln!(
            text,
            "{:<10} {time:>22} {frequency:>22} {:>11.1}{mark}",
            own.name,
            own.apart()
        );
    }
    if !found.untold.is_empty() {
        let _ = writeln!(text, "not determined by the responses: {}", found.untold.join(", "));
    }
    let _ = writeln!(
        text,
        "\n{:<22} {:>11} {:>11} {:>16}",
        "cost J of response", "frequencies", "time domain", "frequency domain"
    );
    for PairCost { stick, output, points, time, frequency } in &found.costs {
        let name = format!("{stick} to {output}");
        let _ = writeln!(text, "{name:<22} {points:>11} {time:>11.1} {frequency:>16.1}");
    }
    text
}

/// The verdict at the top of the page.
pub fn verdict(summary: &Summary) -> Verdict {
    let words = match summary.verdict {
        Grade::Good => "Good: suitable for a control design.",
        Grade::Care => "Usable with care: read the reasons before a control design.",
        Grade::DoNotFly => "Do not fly an autopilot based on this model.",
    };
    Verdict { level: level(summary.verdict), words: words.into(), reasons: summary.reasons.clone() }
}

/// The page level of a grade.
pub const fn level(grade: Grade) -> Level {
    match grade {
        Grade::Good => Level::Good,
        Grade::Care => Level::Care,
        Grade::DoNotFly => Level::Bad,
    }
}

/// The meaning of a parameter in words; empty for unknown names.
pub fn meaning(name: &str) -> &'static str {
    const MEANINGS: [(&str, &str); 44] = [
        ("Nr", "yaw damping"),
        ("Nped", "yaw by pedal"),
        ("Ncol", "yaw by collective"),
        ("Nv", "yaw by sideways speed"),
        ("Zw", "heave damping"),
        ("Zcol", "heave by collective"),
        ("Xu", "drag forward"),
        ("Yv", "drag sideways"),
        ("Lu", "roll by forward speed"),
        ("Lv", "roll by sideways speed"),
        ("Mu", "pitch by forward speed"),
        ("Mv", "pitch by sideways speed"),
        ("Lp", "roll damping"),
        ("Lq", "roll by pitch rate"),
        ("Mp", "pitch by roll rate"),
        ("Mq", "pitch damping"),
        ("Llat", "roll by lateral stick"),
        ("Llon", "roll by longitudinal stick"),
        ("Mlat", "pitch by lateral stick"),
        ("Mlon", "pitch by longitudinal stick"),
        ("tau_f", "time constant of the rotor\u{2019}s flapping"),
        ("Ab", "flapping back by flapping sideways"),
        ("Ba", "flapping sideways by flapping back"),
        ("Alon", "flapping by longitudinal stick"),
        ("Blat", "flapping by lateral stick"),
        ("Lb", "roll by flapping: the rotor\u{2019}s spring"),
        ("Ma", "pitch by flapping: the rotor\u{2019}s spring"),
        ("Ac", "flapping back by the bar"),
        ("Bd", "flapping sideways by the bar"),
        ("tau_s", "time constant of the bar"),
        ("Clon", "bar by longitudinal stick"),
        ("Dlat", "bar by lateral stick"),
        ("tau_lat", "delay of the lateral stick"),
        ("tau_lon", "delay of the longitudinal stick"),
        ("tau_col", "delay of the collective"),
        ("tau_ped", "delay of the pedal"),
        ("lag_lat", "lag of the lateral servo"),
        ("lag_lon", "lag of the longitudinal servo"),
        ("lag_col", "lag of the collective\u{2019}s servo"),
        ("lag_ped", "lag of the tail servo"),
        ("tau_gust", "time constant of gusts along the ground"),
        ("tau_gust_w", "time constant of vertical gusts"),
        ("tau_vh", "time constant of horizontal velocity errors"),
        ("tau_vv", "time constant of vertical velocity errors"),
    ];
    MEANINGS.iter().find(|(own, _)| *own == name).map_or("", |(_, meaning)| meaning)
}

/// Explains negative delays; `None` if there is no negative delay.
pub fn early_sticks(found: &Identification) -> Option<String> {
    let inputs = found.identified.structure.inputs.iter();
    let early: Vec<String> = inputs
        .filter_map(|input| {
            let delay_s = found.identified.delay(input)?.value;
            (delay_s < 0.0).then(|| format!("{input} {:.0} ms", -1e3 * delay_s))
        })
        .collect();
    (!early.is_empty()).then(|| {
        format!(
            "A negative delay does not mean that the vehicle responds before the stick moves. The stick moved \
             earlier than the sample that recorded its position ({}). This happens if a stick moves between samples \
             and the last value is recorded.",
            early.join(", ")
        )
    })
}

/// The headline numbers: the fit, always with the parameter bounds.
pub fn headlines(found: &Identification) -> Vec<Fact> {
    let fit = found.fit();
    let channels = fit.channels().0.iter();
    let fits = channels.map(|channel| format!("{} {:.0}", channel.name, channel.percent));
    let over = if found.validation.is_some() { "validation flight" } else { "fitted flight" };
    let fits = fits.collect::<Vec<_>>().join(" · ");
    vec![
        Fact::new(&format!("fit, %, free runs of {:.1} s over {over}", fit.window_s()), fits),
        Fact::new("bounds of the parameters, 1σ", bounds_in_words(found)),
    ]
}

/// The parameter bounds, without which a fit is meaningless, in a few words.
pub fn bounds_in_words(found: &Identification) -> String {
    found.bounds().map_or_else(
        || "no parameter was estimated".into(),
        |bounds| {
            let worst = match bounds.worst_percent {
                worst if worst.is_finite() => format!("worst ±{worst:.1} % ({})", bounds.worst),
                _ => format!("worst {}, estimated as zero", bounds.worst),
            };
            format!("median ±{:.1} %, {worst}", bounds.median_percent)
        },
    )
}
