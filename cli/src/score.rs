//! `hovernav score`: errors of a trajectory against a reference.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::str::FromStr;

use hovernav::earth::Geodetic;
use hovernav_dataset::Alignment;
use hovernav_formats::{Scoring, open_trajectory};
use hovernav_score::{Axis, Score, Statistics};

use crate::arguments::{AxesArgument, finite};
use crate::memory;
use crate::output::{self, Working};

#[derive(clap::Args)]
pub struct Arguments {
    /// A solution.csv, an output directory of estimate, a TUM or EuRoC trajectory, or a directory that init made for
    /// other files
    solution: PathBuf,
    /// A reference.csv, a dataset directory with a reference.csv, or a trajectory as above
    reference: PathBuf,
    /// Align the solution with the reference: rotate about the vertical and translate, by least squares
    #[arg(long)]
    align: bool,
    /// Origin of a trajectory in local metres: degrees, degrees, metres above the ellipsoid [default: from the first
    /// line of a TUM file that hovernav wrote]
    #[arg(
        long,
        value_name = "LAT,LON,HEIGHT",
        allow_hyphen_values = true,
        conflicts_with = "align"
    )]
    origin: Option<Place>,
    /// Axes of trajectories in local metres: enu with a forward-left-up body, ned with a forward-right-down body
    #[arg(long, value_enum, default_value_t = AxesArgument::Enu)]
    axes: AxesArgument,
    /// Ignore this many seconds after the first solution [default: 0, or `[reference] skip_s` of a dataset directory,
    /// counted from its first inertial sample]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    skip: Option<f64>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A position on Earth.
#[derive(Clone, Copy)]
pub struct Place(Geodetic);

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
        let place = match numbers.as_deref() {
            Some(&[latitude_deg, longitude_deg, height_m]) => {
                Geodetic::from_degrees(latitude_deg, longitude_deg, height_m)
            }
            _ => None,
        };
        place.map(Self).ok_or_else(|| {
            format!("found \"{text}\", expected LAT,LON,HEIGHT in degrees, degrees and metres")
        })
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let found = finite(text).filter(|&seconds| seconds >= 0.0);
    found.ok_or_else(|| format!("found \"{text}\", expected a number of seconds from 0 on"))
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let working = Working::on("scoring");
    let axes = arguments.axes.into();
    let solution =
        open_trajectory(&arguments.solution, axes).map_err(memory::in_terms_of_features)?;
    let scoring = Scoring {
        align: arguments.align,
        origin: arguments.origin.map(|Place(origin)| origin),
        axes,
        skip_s: arguments.skip,
    };
    let scored = scoring
        .against(solution, &arguments.solution, &arguments.reference)
        .map_err(memory::in_terms_of_features)?;
    drop(working);
    if arguments.json {
        return output::print_json(&scored.to_json(&arguments.solution, &arguments.reference));
    }
    output::print(in_words(&scored.score, scored.aligned));
    for warning in &scored.warnings {
        output::warn(warning);
    }
    Ok(())
}

fn in_words(found: &Score, aligned: Option<Alignment>) -> String {
    let mut text = String::new();
    if let Some(Alignment { yaw_rad, moments, rms_m }) = aligned {
        let _ = writeln!(
            text,
            "aligned with the reference: rotated by {:.3}°, residual {rms_m:.3} m rms over {moments} samples",
            yaw_rad.to_degrees()
        );
    }
    if let Some(known) = found.heading_known {
        let _ = writeln!(
            text,
            "heading becomes known at {:.1} s, {:.1} s after the start: attitude is scored from then on",
            known.seconds(),
            known - found.from
        );
    }
    let _ = writeln!(
        text,
        "{:<18} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10} {:>8}",
        "error", "rmse", "median", "p95", "max", "samples", "inside 3σ", "error/σ"
    );
    for axis in Axis::ALL.iter().filter_map(|axis| found.axis(*axis)) {
        let Statistics { rmse, median, p95, max } = axis.statistics;
        let inside =
            axis.within_3_sigma.map_or("–".into(), |share| format!("{:.1} %", 100.0 * share));
        let ratio = axis.error_over_sigma.map_or("–".into(), |ratio| format!("{ratio:.2}"));
        let (name, samples) = (axis.axis.name(), axis.samples);
        let _ = writeln!(
            text,
            "{name:<18} {rmse:>9.3} {median:>9.3} {p95:>9.3} {max:>9.3} {samples:>9} {inside:>10} {ratio:>8}"
        );
    }
    text
}
