//! The parameters with their bounds, and the fit.

use hovernav_sysid::helicopter::Identification;
use hovernav_sysid::methods::prediction_error::Estimate;

use super::super::words::{bounds_in_words, early_sticks, level, meaning};
use hovernav_pages::{Level, Section, Table, TableRow, digits};

/// The fits next to the noise floors, with the parameter bounds in the caption.
pub fn fits(found: &Identification, held: Option<&Identification>) -> Table {
    let fit = found.fit();
    let rows = fit.channels().0.iter().map(|channel| {
        let mut channels = held.into_iter().flat_map(|held| held.fit().channels().0);
        let other = channels.find(|other| other.name == channel.name);
        let mut numbers = vec![
            format!("{:.1} %", channel.percent),
            format!("{:.1} %", channel.floor_percent),
            digits(channel.residual_rms),
        ];
        numbers.extend(other.map(|other| format!("{:.1} %", other.percent)));
        TableRow::new(channel.name.clone(), numbers)
    });
    let of_held = held.map(|_| "Held GPS");
    Table {
        caption: format!(
            "Fit of free runs of {:.1} s; fit that a perfect model would reach on average with the identified noise \
             (noise floor); residual (RMS). A fit above the noise floor means that \
             these seconds were calmer than the flight on average. Bounds of the parameters (1σ): {}",
            fit.window_s(),
            bounds_in_words(found)
        ),
        heads: ["", "Fit", "Noise floor", "Residual"]
            .into_iter()
            .chain(of_held)
            .map(Into::into)
            .collect(),
        rows: rows.collect(),
    }
}

/// A percentage with one decimal; a dash if it is not finite, as for a parameter of zero.
fn percent(value: f64) -> String {
    if value.is_finite() { format!("{value:.1} %") } else { "–".into() }
}

/// The parameters and their bounds; `held` is the identification from held GPS velocity.
pub fn parameters(found: &Identification, held: Option<&Identification>) -> Section {
    let of_held = held.map(|_| "From held GPS velocity");
    let in_held = |held: &Identification, name: &str| held.identified.estimates.get(name).cloned();
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
        numbers.extend(held.map(|held| {
            in_held(held, &estimate.name).as_ref().map_or_else(|| "–".into(), in_short)
        }));
        let judged = Some(level(found.grade_of(estimate))).filter(|level| *level > Level::Good);
        TableRow { judged, ..TableRow::new(estimate.name.clone(), numbers) }
    });
    let heads = ["", "Meaning", "Value", "Unit", "Bound (1σ)", "Bound", "Insensitivity"];
    let table = Table {
        caption: "Continuous-time derivatives per full stick. Use those marked ! with care; do not fly on \
                  those marked ✗"
            .into(),
        heads: heads.into_iter().chain(of_held).map(Into::into).collect(),
        rows: rows.collect(),
    };
    let pairs = found.strong_correlations(MIN_CORRELATION);
    let table_of_pairs = Table {
        caption: format!(
            "Correlations of magnitude above {MIN_CORRELATION}; above 0.9 the data cannot separate the two"
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
        "Identified values; their random error (Cramér–Rao bound, one sigma, widened for correlated innovations); \
         and the change of one parameter alone that would not visibly worsen the fit (insensitivity). The list \
         below the table names the dropped parameters, with reasons.",
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

/// Smallest magnitude of a correlation that is listed.
const MIN_CORRELATION: f64 = 0.7;

fn in_short(estimate: &Estimate) -> String {
    if estimate.is_estimated() {
        format!("{} ±{}", digits(estimate.value), digits(estimate.bound))
    } else {
        format!("{} ({})", digits(estimate.value), estimate.status.name())
    }
}
