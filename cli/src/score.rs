//! `hovernav score`: errors of a trajectory against a reference.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context as _, bail, ensure};
use hovernav::earth::Geodetic;
use hovernav::time::Time;
use hovernav_log::{
    Alignment, Axis, AxisScore, Dataset, LocalAxes, Reference, Score, Statistics, Trajectory, score,
};
use serde_json::{Value, json};

use crate::arguments::{AxesArgument, finite, open_trajectory};
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
    let mut solution = open_trajectory(&arguments.solution, axes)?;
    let mut reference = Comparison::open(&arguments.reference, axes)?;
    let mut aligned = None;
    if arguments.align {
        if let Comparison::Trajectory(trajectory) = &mut reference {
            trajectory.place(&NOWHERE);
        }
    } else if let Some(Place(origin)) = arguments.origin {
        solution.place(&origin);
        if let Comparison::Trajectory(trajectory) = &mut reference {
            trajectory.place(&origin);
        }
    } else if solution.is_placed() && reference.is_placed() {
        solution.place_as_named();
        if let Comparison::Trajectory(trajectory) = &mut reference {
            trajectory.place_as_named();
        }
    } else {
        let is_local = match &reference {
            Comparison::Trajectory(trajectory) => trajectory.is_local(),
            Comparison::Dataset(..) => false,
        };
        ensure!(
            solution.is_local() == is_local,
            "{}: found {}, unlike the reference: expected --align, or --origin LAT,LON,HEIGHT",
            arguments.solution.display(),
            if is_local { "geographic positions" } else { "local metres without an origin" }
        );
        solution.place(&NOWHERE);
        if let Comparison::Trajectory(trajectory) = &mut reference {
            trajectory.place(&NOWHERE);
        }
    }
    let (mut reference, mut begin) = match reference {
        Comparison::Dataset(reference, begin) => (reference, begin),
        Comparison::Trajectory(trajectory) => (Reference::of_trajectory(&trajectory), None),
    };
    if arguments.align {
        let alignment = solution.align(&reference);
        aligned = Some(alignment.with_context(|| no_overlap(arguments))?);
    }
    if let Some(skip_s) = arguments.skip {
        (reference.skip_s, begin) = (skip_s, None);
    }
    let Some(first) = solution.solutions.first() else { bail!(no_overlap(arguments)) };
    let found = score(&solution.solutions, &reference, begin.unwrap_or(first.time));
    ensure!(!found.axes.is_empty(), no_overlap(arguments));
    let warnings = [solution.warnings, reference.warnings].concat();
    drop(working);
    if arguments.json {
        return output::print_json(&in_json(arguments, &found, aligned, &warnings));
    }
    output::print(in_words(&found, aligned));
    for warning in &warnings {
        output::say(format_args!("warning: {warning}"));
    }
    Ok(())
}

fn no_overlap(arguments: &Arguments) -> String {
    format!(
        "{}: found no time in common with {}. Do they use the same clock?",
        arguments.solution.display(),
        arguments.reference.display()
    )
}

/// Origin of local coordinates where both sides are local and have no origin. Any origin gives the same errors.
const NOWHERE: Geodetic = Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 };

/// The reference side of a comparison.
#[allow(clippy::large_enum_variant, reason = "a run has only one")]
enum Comparison {
    /// A reference, and the start of its dataset, from which `skip_s` is counted.
    Dataset(Reference, Option<Time>),
    Trajectory(Trajectory),
}

impl Comparison {
    fn open(path: &Path, axes: LocalAxes) -> anyhow::Result<Self> {
        let file = path.join("reference.csv");
        if !path.is_dir() || !file.exists() {
            return open_trajectory(path, axes).map(Self::Trajectory);
        }
        // The lever arms in dataset.toml identify the point whose motion the reference describes.
        let (manifest, _) = Dataset::manifest_of(path)?;
        let reference = Reference::open(path, &manifest)?;
        let reference = reference.with_context(|| format!("{}: not there", file.display()))?;
        Ok(Self::Dataset(reference, Dataset::first_sample_of(path)?))
    }

    fn is_placed(&self) -> bool {
        match self {
            Self::Dataset(..) => true,
            Self::Trajectory(trajectory) => trajectory.is_placed(),
        }
    }
}

fn in_json(
    arguments: &Arguments,
    found: &Score,
    aligned: Option<Alignment>,
    warnings: &[String],
) -> Value {
    let error: serde_json::Map<String, Value> =
        found.axes.iter().map(|axis| (axis.axis.name().into(), json!(axis.statistics))).collect();
    let of_axes = |pick: fn(&AxisScore) -> Option<f64>| -> serde_json::Map<String, Value> {
        let known = found.axes.iter().filter_map(|axis| Some((axis, pick(axis)?)));
        known.map(|(axis, value)| (axis.axis.name().into(), json!(value))).collect()
    };
    let samples = found.axes.iter().map(|axis| axis.samples).max();
    json!({
        "tool": "hovernav",
        "version": env!("CARGO_PKG_VERSION"),
        "input": arguments.solution.display().to_string(),
        "reference": arguments.reference.display().to_string(),
        "samples": samples,
        "from_s": found.from.seconds(),
        "heading_known_s": found.heading_known.map(|time| time.seconds()),
        "aligned": aligned.map(|aligned| json!({
            "yaw_deg": aligned.yaw_rad.to_degrees(),
            "moments": aligned.moments,
            "rms_m": aligned.rms_m,
        })),
        "error": error,
        "within_3_sigma": of_axes(|axis| axis.within_3_sigma),
        "error_over_sigma": of_axes(|axis| axis.error_over_sigma),
        "warnings": warnings,
    })
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
