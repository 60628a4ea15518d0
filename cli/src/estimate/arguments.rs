//! Arguments of `hovernav estimate`.

use std::path::PathBuf;

use super::columns::ColumnsArgument;
use super::export::ExportArgument;
use crate::arguments::{OutageWindow, Sensors};
use crate::emit::Form;

#[derive(clap::Args)]
pub struct Arguments {
    /// Dataset directories, flight records or logs of any other format; with several logs, a table lists all of them
    #[arg(required = true)]
    pub(super) log: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) sensors: Sensors,
    /// Directory to write [default: out/NAME]; with several logs, the parent of their directories
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Settings file that overrides the log's dataset.toml, in the same format
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// Smooth the solution: run backwards over the whole log too, so that each solution also uses later measurements
    #[arg(long)]
    pub(super) smooth: bool,
    /// Ignore the GPS from START on for DURATION, in seconds of the log's clock; may be repeated
    #[arg(long, value_name = "START:DURATION", allow_hyphen_values = true)]
    pub(super) outage: Vec<OutageWindow>,
    /// Reduce the GPS to at most this rate
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(super) gps_rate: Option<f64>,
    /// Also write the solution in this format: parquet, kml, gpx, pos, tum, euroc, mcap; may be repeated. With `-` in
    /// addition, the one FORMAT goes to standard output
    #[arg(long, value_name = "FORMAT", value_delimiter = ',')]
    pub(super) export: Vec<ExportArgument>,
    /// Add columns at the end of solution.csv: quaternion, local, covariance
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',')]
    pub(super) columns: Vec<ColumnsArgument>,
    /// Largest output rate of solution.csv and the exports [default: every inertial sample; KML and GPX at most 5 Hz]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(super) rate: Option<f64>,
    /// Also write the estimator's configuration in this form, for programs that read no files; may be repeated
    #[arg(long, value_name = "FORM", value_delimiter = ',')]
    pub(super) emit: Vec<Form>,
    /// Do not write report.html
    #[arg(long)]
    pub(super) no_report: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|&value: &f64| value.is_finite() && value > 0.0)
        .ok_or_else(|| format!("found \"{text}\", expected a number of hertz above 0"))
}
