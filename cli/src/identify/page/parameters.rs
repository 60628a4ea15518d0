//! The parameters with their bounds, and the fit beside them.

use hovernav_sysid::helicopter::Identification;
use hovernav_sysid::methods::prediction_error::Estimate;

use super::super::words::{bounds_in_words, early_sticks, level, meaning};
use crate::page::{Level, Section, Table, TableRow, digits};

/// Fits beside what noise alone would allow, with the parameters' bounds in the caption.
pub fn fits(found: &Identification, held: Option<&Identification>) -> Table {
    let fit = found.fit();
    let rows = fit.channels().0.iter().map(|channel| {
        let mut channels = held.into_iter().flat_map(|held| held.fit().channels().0);
        let other = channels.find(|other| other.name == channel.name);
        TableRow::new(
            channel.name.clone(),
            vec![
                format!("{:.1} %", channel.percent),
                format!("{:.1} %", channel.floor_percent),
                digits(channel.residual_rms),
                other.map_or_else(|| "–".into(), |other| format!("{:.1} %", other.percent)),
            ],
        )
    });
    Table {
        caption: format!(
            "Fit of free runs of {:.1} s, what a perfect model would reach in the mean of flights with the \
             noise that was found, residual (RMS), and the fit from held GPS velocity. A fit above the \
             noise floor says that these seconds were calmer than the flight. Bounds of the parameters (1σ): {}",
            fit.window_s(),
            bounds_in_words(found)
        ),
        heads: ["", "Fit", "Noise floor", "Residual", "Held GPS"].map(Into::into).into(),
        rows: rows.collect(),
    }
}

/// A share of a value; of zero there is none.
fn percent(value: f64) -> String {
    if value.is_finite() { format!("{value:.1} %") } else { "–".into() }
}

/// What was found, and how sure it is; `held` is the same from held GPS velocity.
pub fn parameters(found: &Identification, held: Option<&Identification>) -> Section {
    let held = |name: &str| held?.identified.estimates.get(name);
    let rows = found.parameters().iter().map(|estimate| {
        let mut numbers =
            vec![meaning(&estimate.name).into(), digits(estimate.value), estimate.unit.clone()];
        numbers.extend(if estimate.is_estimated() {
            [
                format!("±{}", digits(estimate.bound)),
                percent(estimate.bound_percent()),
                percent(estimate.insensitivity_percent()),
            ]
        } else {
            [estimate.status.name().to_owned(), "–".into(), "–".into()]
        });
        numbers.push(held(&estimate.name).map_or_else(|| "–".into(), in_short));
        let judged = Some(level(found.grade_of(estimate))).filter(|level| *level > Level::Good);
        TableRow { judged, ..TableRow::new(estimate.name.clone(), numbers) }
    });
    let heads = [
        "",
        "What it is",
        "Value",
        "Unit",
        "Bound (1σ)",
        "Bound",
        "Insensitivity",
        "From held GPS velocity",
    ];
    let table = Table {
        caption: "Continuous-time derivatives per full stick. Those marked ! are to be taken with care, those marked ✗ not \
                  to be flown by"
            .into(),
        heads: heads.map(Into::into).into(),
        rows: rows.collect(),
    };
    let pairs = found.strong_correlations(LEAST_CORRELATION);
    let table_of_pairs = Table {
        caption: format!(
            "Correlations above {LEAST_CORRELATION} in size; beyond 0.9 the data cannot tell the two apart"
        ),
        heads: ["Pair", "Correlation"].map(Into::into).into(),
        rows: pairs
            .iter()
            .map(|(one, other, value)| {
                TableRow::new(format!("{one}, {other}"), vec![format!("{value:.3}")])
            })
            .collect(),
    };
    let section = Section::new(
        "parameters",
        "Parameters",
        "What was found, how far chance alone may have moved it (Cramér–Rao, one sigma, widened for \
         correlated innovations), and how far it could move alone before the fit would notice \
         (insensitivity). Below the table what was left out of the model, and why.",
    )
    .with(table);
    let section = if pairs.is_empty() { section } else { section.with(table_of_pairs) };
    let section = match early_sticks(found) {
        Some(early) => section.with(vec![early]),
        None => section,
    };
    match found.identified.log.is_empty() {
        true => section.with(vec!["No parameter was dropped.".to_owned()]),
        false => section.with(found.identified.log.clone()),
    }
}

/// Correlations smaller than this get no line.
const LEAST_CORRELATION: f64 = 0.7;

fn in_short(estimate: &Estimate) -> String {
    if estimate.is_estimated() {
        format!("{} ±{}", digits(estimate.value), digits(estimate.bound))
    } else {
        format!("{} ({})", digits(estimate.value), estimate.status.name())
    }
}
