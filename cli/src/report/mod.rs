//! The pages that commands leave beside their results, each one file that needs nothing else.
//!
//! A [`page::Page`] is made of sections, a section of figures, tables and notes; [`series`] says what
//! a figure draws. [`Report`] and [`write()`] are the page of `hovernav estimate`. Only what depends
//! on the plots is worked out here; every number comes from the library.

mod consistency;
mod decimate;
mod errors;
pub mod flight;
mod innovations;
mod motion;
pub mod page;
pub mod series;
#[cfg(test)]
mod tests;

use std::path::Path;

use hovernav::ekf::{Innovation, Solution};
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_log::{Outage, ReferenceMoment, Score};

/// What the page of an estimate shows. A slice may be empty: its figures then say so, or, for what
/// is optional (`smoothed`, `reference`, `score`), are left out.
///
/// Series are in order of time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report<'a> {
    /// The page's heading, plain text.
    pub title: &'a str,
    /// The few numbers to see first.
    pub headlines: &'a [Fact],
    /// The rest of what there is to say, as a table.
    pub facts: &'a [Fact],
    /// What went wrong or deserves a second look, plain text.
    pub warnings: &'a [String],
    /// The stretches for which GPS was withheld.
    pub outages: &'a [Outage],
    /// The filter's solution.
    pub solutions: &'a [Solution],
    /// The smoother's solution.
    pub smoothed: &'a [Solution],
    /// The fixes, as received.
    pub fixes: &'a [Fix],
    /// What became of each scalar update, in the order in which the filter took them.
    pub innovations: &'a [Innovation],
    /// The reference at moments of the solution.
    pub reference: &'a [(Time, ReferenceMoment)],
    /// How far the solution is from the reference.
    pub score: Option<&'a Score>,
}

/// A label and what there is to say under it, plain text with its unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    pub label: String,
    pub value: String,
}

impl Fact {
    /// A fact from anything that can be shown.
    pub fn new(label: &str, value: impl ToString) -> Self {
        Self { label: label.into(), value: value.to_string() }
    }
}

/// A number to four digits, as a person would write it; a dash where it is unknown.
pub fn digits(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    if value.abs() < 1e-4 {
        return format!("{value:.2e}");
    }
    let whole_digits = value.abs().log10().floor();
    format!("{value:.*}", (3.0 - whole_digits).clamp(0.0, 7.0) as usize)
}

/// Writes the page of an estimate to `path`, over what may stand there.
///
/// # Errors
/// When the file cannot be written; the error names it.
pub fn write(path: &Path, report: &Report<'_>) -> anyhow::Result<()> {
    flight::page(report).write(path)
}
