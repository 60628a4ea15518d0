//! The page that `hovernav estimate` leaves beside its solution: one file that needs nothing else.
//!
//! [`Report`] borrows what is to be shown; [`write()`] draws it. Only what depends on the plots is
//! worked out here; every number of the estimate comes from the library.

mod consistency;
mod decimate;
mod flight;
mod innovations;
mod page;
mod series;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use anyhow::Context as _;
use hovernav::earth::Geodetic;
use hovernav::ekf::{Innovation, Solution};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::time::Time;

/// What the page of an estimate shows. A slice may be empty: its figures then say so, or, for what
/// is optional (`smoothed`, `reference`, `errors`, `error_table`), are left out.
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
    /// Start and duration, in s, of the stretches without GPS.
    pub outages: &'a [(Time, f64)],
    /// The filter's solution.
    pub solutions: &'a [Solution],
    /// The smoother's solution.
    pub smoothed: &'a [Solution],
    /// The fixes, as received.
    pub fixes: &'a [Fix],
    /// What became of each scalar update, in the order in which the filter took them.
    pub innovations: &'a [Innovation],
    /// The reference.
    pub reference: &'a [ReferenceSample],
    /// Estimate less reference.
    pub errors: &'a [ErrorSample],
    /// The errors in numbers.
    pub error_table: &'a [ErrorRow],
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

/// The reference at one moment, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSample {
    pub time: Time,
    pub position: Option<Geodetic>,
    pub velocity_mps: Option<Vector<Ned>>,
    pub attitude: Option<EulerAngles>,
}

impl ReferenceSample {
    /// u, v, w: the velocity in body axes, m/s, where velocity and attitude are known.
    fn velocity_body_mps(&self) -> Option<Vector<Body>> {
        Some(Rotation::from_euler(self.attitude?).inverse() * self.velocity_mps?)
    }
}

/// Estimate less reference at a moment of the reference, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorSample {
    pub time: Time,
    /// North, east, down, m.
    pub position_m: [Option<f64>; 3],
    /// North, east, down, m/s.
    pub velocity_mps: [Option<f64>; 3],
    /// Roll, pitch, yaw, each in (−180, 180].
    pub attitude_deg: [Option<f64>; 3],
}

/// The size of the error of one quantity, in `unit`.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorRow {
    pub quantity: String,
    pub unit: &'static str,
    /// Root of the mean square.
    pub rmse: f64,
    /// Of the size without sign.
    pub median: f64,
    /// 95th percentile of the size without sign.
    pub p95: f64,
    /// Largest size without sign.
    pub max: f64,
}

/// Writes the page to `path`, over what may stand there.
///
/// # Errors
/// When the file cannot be written; the error names it.
pub fn write(path: &Path, report: &Report<'_>) -> anyhow::Result<()> {
    let page = flight::page(report);
    let written = File::create(path).and_then(|file| {
        let mut out = BufWriter::new(file);
        page.write_to(&mut out)?;
        out.flush()
    });
    written.with_context(|| format!("cannot write the report {}", path.display()))
}
