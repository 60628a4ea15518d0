//! The comparison with GPS velocity held from fix to fix.

use hovernav_log::Dataset;
use hovernav_sysid::helicopter::{Identification, IdentifyError};

use super::super::words::bounds_in_words;
use super::histories::{histories, runs_of};
use crate::page::{Section, Table, TableRow};

/// The identification from held GPS velocity.
pub fn compared(
    dataset: &Dataset,
    found: &Identification,
    held: Result<&Identification, &IdentifyError>,
) -> Section {
    let section = Section::new(
        "held-gps",
        "The same from held GPS velocity",
        "What the estimator's velocity is worth: the same search on the same test points, fed with \
         the receiver's own velocity, each fix held until the next, as was done before. Its flight \
         curves are what it was given, so its fits count against those steps; its parameters stand \
         beside the others in the table above.",
    );
    let held = match held {
        Ok(held) => held,
        Err(error) => return section.with(vec![format!("Nothing could be identified: {error}")]),
    };
    let runs = runs_of(held);
    let mut section = section.with(side_by_side(found, held));
    if !held.warnings.is_empty() {
        section = section.with(held.warnings.clone());
    }
    histories(dataset, held, &runs).fold(section, Section::with)
}

/// Fits and noise floors of both, with what bounds both.
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
