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

/// A format of exported solutions.
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
    /// All formats.
    pub const ALL: [Self; 7] =
        [Self::Parquet, Self::Kml, Self::Gpx, Self::Pos, Self::Tum, Self::Euroc, Self::Mcap];

    /// Name on the command line.
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

    /// Name of the file next to `solution.csv`.
    #[must_use]
    pub fn file_name(self) -> String {
        // The name must differ from that of the solution.
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

/// Why a solution was not exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file system or a pipe reported an error.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The time is before the start of the format's clock.
    #[error("found a time of {0} s, expected none before 0, where the format's clock begins")]
    BeforeZero(f64),
    /// The format is not in this build.
    #[error("{} is not in this build, which lacks the feature `{}`", .0.name(), .0.name())]
    MissingFeature(ExportFormat),
    /// The library that writes the format reported an error.
    #[error("{0}")]
    Library(String),
}

/// Output of an export.
type Out<'w> = Box<dyn Write + Send + 'w>;

/// A file of one format being written.
trait Sink {
    /// Adds a solution with a later time than the previous one.
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError>;
    /// Ends the file.
    fn finish(self: Box<Self>) -> Result<(), ExportError>;
}

/// Export of solutions to a file, one at a time, with bounded memory; KML stores the points of five solutions a second.
pub struct Export<'w> {
    sink: Box<dyn Sink + 'w>,
    /// Offset that is added to the times, ns.
    later_ns: i64,
}

impl<'w> Export<'w> {
    /// Begins a file of this `format`, titled `name` if the format has a title. Formats with dates use
    /// `utc_at_zero_ns`, the time in ns since the start of 1970 UTC at which the solutions' clock reads zero. It is 0
    /// for a clock that counts from then, or if unknown.
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
            ExportFormat::Parquet => return Err(ExportError::MissingFeature(format)),
            ExportFormat::Kml => Box::new(kml::Kml::new(name, out)?),
            ExportFormat::Gpx => Box::new(gpx::Gpx::new(name, out)?),
            ExportFormat::Pos => Box::new(pos::Pos::new(out)?),
            ExportFormat::Tum => Box::new(trajectory::Tum::new(out)),
            ExportFormat::Euroc => Box::new(trajectory::Euroc::new(out)?),
            ExportFormat::Mcap => Box::new(mcap_file::Mcap::new(out)?),
        };
        // The other formats keep the log's own clock, like the data with which they are compared.
        let is_dated = matches!(
            format,
            ExportFormat::Kml | ExportFormat::Gpx | ExportFormat::Pos | ExportFormat::Mcap
        );
        Ok(Self { sink, later_ns: if is_dated { utc_at_zero_ns } else { 0 } })
    }

    /// Adds a solution with a later time than the previous one.
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
    /// [`ExportError`]; for MCAP also without solutions.
    pub fn finish(self) -> Result<(), ExportError> {
        self.sink.finish()
    }
}
