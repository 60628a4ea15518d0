#![doc = include_str!("../README.md")]

mod gpx;
mod kml;
mod local;
mod mcap_file;
#[cfg(feature = "parquet")]
mod parquet_file;
mod pos;
mod schemas;
mod text;
mod trajectory;

use std::io::{self, Write};
use std::str::FromStr;

use hovernav::ekf::Solution;
use hovernav::time::Time;

pub use mcap_file::LAYOUT;

/// A format that solutions are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ExportFormat {
    /// Apache Parquet: the columns of `solution.csv`.
    Parquet,
    /// KML 2.2 with Google's track extension.
    Kml,
    /// GPX 1.1.
    Gpx,
    /// RTKLIB's solution file.
    Pos,
    /// TUM's trajectory.
    Tum,
    /// EuRoC's ground truth.
    Euroc,
    /// MCAP with Foxglove's schemas in JSON.
    Mcap,
}

impl ExportFormat {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Parquet, Self::Kml, Self::Gpx, Self::Pos, Self::Tum, Self::Euroc, Self::Mcap];

    /// Its name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Kml => "kml",
            Self::Gpx => "gpx",
            Self::Pos => "pos",
            Self::Tum => "tum",
            Self::Euroc => "euroc",
            Self::Mcap => "mcap",
        }
    }

    /// The file beside `solution.csv`.
    #[must_use]
    pub fn file_name(self) -> String {
        // A second file of the same ending must not take the place of the solution.
        let ending = if self == Self::Euroc { "euroc.csv" } else { self.name() };
        format!("solution.{ending}")
    }
}

impl FromStr for ExportFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|format| format.name() == text).ok_or_else(|| {
            format!("found \"{text}\", expected {}", Self::ALL.map(Self::name).join(", "))
        })
    }
}

/// Why a solution was not written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file system or a pipe refused.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The format cannot hold a time before its clock began.
    #[error("found a time of {0} s, expected none before 0, where the format's clock begins")]
    BeforeZero(f64),
    /// The format is not in this build.
    #[error("{} is not in this build, which lacks the feature `{}`", .0.name(), .0.name())]
    LeftOut(ExportFormat),
    /// The library that writes the format refused.
    #[error("{0}")]
    Library(String),
}

/// Where a file goes.
type Out<'w> = Box<dyn Write + Send + 'w>;

/// A file of one format in the making.
trait Sink {
    /// Adds a solution, later than the one before.
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError>;
    /// Ends the file.
    fn finish(self: Box<Self>) -> Result<(), ExportError>;
}

/// A solution on its way to a file, moment by moment: no more than a stretch of it is in memory, of KML
/// the places of five moments a second.
pub struct Export<'w> {
    sink: Box<dyn Sink + 'w>,
    /// What is added to the times, ns.
    later_ns: i64,
}

impl<'w> Export<'w> {
    /// Begins a file of this `format`, called `name` where the format has a place for it. Formats that date their
    /// moments take `utc_at_zero_ns` for the time, ns since the start of 1970 UTC, at which the solutions' clock
    /// reads zero: 0 of a clock that counts from then itself, or of which it is not known.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn new(
        format: ExportFormat,
        name: &str,
        utc_at_zero_ns: i64,
        out: impl Write + Send + 'w,
    ) -> Result<Self, ExportError> {
        let out: Out<'w> = Box::new(out);
        let sink: Box<dyn Sink + 'w> = match format {
            #[cfg(feature = "parquet")]
            ExportFormat::Parquet => Box::new(parquet_file::Parquet::new(out)?),
            #[cfg(not(feature = "parquet"))]
            ExportFormat::Parquet => return Err(ExportError::LeftOut(format)),
            ExportFormat::Kml => Box::new(kml::Kml::new(name, out)?),
            ExportFormat::Gpx => Box::new(gpx::Gpx::new(name, out)?),
            ExportFormat::Pos => Box::new(pos::Pos::new(out)?),
            ExportFormat::Tum => Box::new(trajectory::Tum::new(out)),
            ExportFormat::Euroc => Box::new(trajectory::Euroc::new(out)?),
            ExportFormat::Mcap => Box::new(mcap_file::Mcap::new(out)?),
        };
        // The others have the log's own clock, which what they are compared with has, too.
        let is_dated = matches!(
            format,
            ExportFormat::Kml | ExportFormat::Gpx | ExportFormat::Pos | ExportFormat::Mcap
        );
        Ok(Self { sink, later_ns: if is_dated { utc_at_zero_ns } else { 0 } })
    }

    /// Adds a solution, later than the one before.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        let time = solution.time.nanoseconds().saturating_add(self.later_ns);
        self.sink.push(&Solution { time: Time::from_nanoseconds(time), ..*solution })
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`ExportError`]; of MCAP also where there was no solution.
    pub fn finish(self) -> Result<(), ExportError> {
        self.sink.finish()
    }
}
