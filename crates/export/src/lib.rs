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

/// What is written.
#[derive(Clone, Copy, Debug)]
pub struct Export<'a> {
    /// What it is called in files that have a place for it.
    pub name: &'a str,
    /// The solutions, in time order.
    pub solutions: &'a [Solution],
}

impl Export<'_> {
    /// Writes it to `out` as `format`.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn write(
        &self,
        format: ExportFormat,
        out: &mut (impl Write + Send),
    ) -> Result<(), ExportError> {
        match format {
            #[cfg(feature = "parquet")]
            ExportFormat::Parquet => parquet_file::write(self, out)?,
            #[cfg(not(feature = "parquet"))]
            ExportFormat::Parquet => return Err(ExportError::LeftOut(format)),
            ExportFormat::Kml => kml::write(self, out)?,
            ExportFormat::Gpx => gpx::write(self, out)?,
            ExportFormat::Pos => pos::write(self, out)?,
            ExportFormat::Tum => trajectory::write_tum(self, out)?,
            ExportFormat::Euroc => trajectory::write_euroc(self, out)?,
            ExportFormat::Mcap => mcap_file::write(self, out)?,
        }
        out.flush()?;
        Ok(())
    }
}
