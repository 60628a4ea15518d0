//! The comparison with GPS velocity held between fixes.

use hovernav_dataset::Dataset;
use hovernav_sysid::helicopter::{Identification, IdentifyError};

use super::super::words::bounds_in_words;
use super::histories::{histories, runs_of};
use hovernav_pages::{Section, Table, TableRow};

/// The identification from held GPS velocity.
pub fn compared(
    dataset: &Dataset,
    found: &Identification,
    held: Result<&Identification, &IdentifyError>,
) -> Section {
    let section = Section::new(
        "held-gps",
        "Identification from held GPS velocity",
        "A check of the benefit of the estimated velocity: the same search on the same test points, but with the \
         receiver\u{2019}s velocity, each fix held until the next. The flight curves here show this stepped input, so \
         the fits refer to the steps. The parameters are in the table above, next to the others.",
    );
    let held = match held {
        Ok(held) => held,
        Err(error) => return section.with(vec![format!("The identification failed: {error}")]),
    };
    let runs = runs_of(held);
    let mut section = section.with(side_by_side(found, held));
    if !held.warnings.is_empty() {
        section = section.with(held.warnings.clone());
    }
    histories(dataset, held, &runs).fold(section, Section::with)
}

/// Fits and noise floors of both identifications, with the parameter bounds of both.
fn side_by_side(found: &Identification, held: &Identification) -> Table {
    let rows = found.fit().channels().0.iter().map(|channel| {
        let percent = |value: f64| format!("{value:.1} %");
        let mut numbers = vec![percent(channel.percent), percent(channel.floor_percent)];
        let other = held.fit().channels().0.iter().find(|other| other.name == channel.name);
        numbers.extend(match other {
            Some(other) => [percent(other.percent), percent(other.floor_percent)],
            None => ["–".into(), "–".into()],
        });
        TableRow::new(channel.name.clone(), numbers)
    });
    Table {
        caption: format!(
            "Bounds (1σ) from the estimator's velocity: {}; from held GPS velocity: {}",
            bounds_in_words(found),
            bounds_in_words(held)
        ),
        heads: ["", "Fit", "Noise floor", "Held GPS: fit", "Held GPS: noise floor"]
            .map(Into::into)
            .into(),
        rows: rows.collect(),
    }
}
