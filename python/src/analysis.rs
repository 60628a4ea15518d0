//! `score`, `inject` and `allan`.

use std::path::PathBuf;
use std::sync::Arc;

use hovernav_dataset::columns::RATES;
use hovernav_dataset::{LocalAxes, Trajectory, allan_deviation, median_interval_s};
use hovernav_formats::{Options, Scoring, open_trajectory};
use hovernav_sim::faults::{self, Fault};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::columns::{split, table, vector};
use crate::error::{self, Error, Result};
use crate::estimate::log_of;
use crate::log::{PyLog, from_json};
use crate::solution::Solution;

/// Errors of a trajectory against a reference, as `hovernav score --json` prints them: `error`, for each axis the
/// `rmse`, `median`, `p95` and `max`; `within_3_sigma` and `error_over_sigma` if the solution has one-sigmas;
/// `warnings`.
///
/// Parameters
/// ----------
/// solution : Solution or path
///     A path is a `solution.csv`, an output directory of `hovernav estimate`, a TUM or EuRoC file, or a directory with
///     a mapping.
/// reference : Solution or path
///     A path may also be a dataset directory with a `reference.csv`, or such a file.
/// align : bool
///     Rotate the solution about the vertical and translate it, by least squares.
/// axes : str
///     Axes of trajectories in local metres: "enu" with a forward-left-up body, "ned" with forward-right-down.
/// skip_s : float, optional
///     Ignore this many seconds after the first solution. Default: 0, or `[reference] skip_s` of a dataset.
///
/// Raises
/// ------
/// LogError
///     If a file cannot be read, or solution and reference do not overlap in time.
#[pyfunction]
#[pyo3(signature = (solution, reference, *, align=false, axes="enu", skip_s=None))]
pub fn score<'py>(
    solution: &Bound<'py, PyAny>,
    reference: &Bound<'py, PyAny>,
    align: bool,
    axes: &str,
    skip_s: Option<f64>,
) -> Result<Bound<'py, PyAny>> {
    let axes = axes_of(axes)?;
    if let Some(skip_s) = skip_s.filter(|&skip_s| !(skip_s >= 0.0 && skip_s.is_finite())) {
        return Err(Error::Config(format!("skip_s: found {skip_s}, expected seconds from 0 on")));
    }
    let (py, scoring) = (solution.py(), Scoring { align, origin: None, axes, skip_s });
    let (solution, reference) = (side(solution, "solution")?, side(reference, "reference")?);
    let scored = py.detach(|| {
        let name = solution.name();
        let trajectory = solution.open(axes)?;
        let scored = match &reference {
            Side::Path(path) => scoring.against(trajectory, &name, path)?,
            Side::Solution(..) => scoring.against_trajectory(
                trajectory,
                &name,
                reference.open(axes)?,
                &reference.name(),
            )?,
        };
        Ok::<_, Error>(scored.to_json(&name, &reference.name()).to_string())
    })?;
    Ok(from_json(py, &scored)?)
}

/// One of the two trajectories of a comparison.
enum Side {
    Path(PathBuf),
    Solution(Py<Solution>),
}

impl Side {
    fn name(&self) -> PathBuf {
        match self {
            Self::Path(path) => path.clone(),
            Self::Solution(_) => "solution".into(),
        }
    }

    fn open(&self, axes: LocalAxes) -> Result<Trajectory> {
        Ok(match self {
            Self::Path(path) => open_trajectory(path, axes)?,
            Self::Solution(solution) => Trajectory::of_solutions(solution.get().states().to_vec()),
        })
    }
}

fn side(side: &Bound<'_, PyAny>, name: &str) -> Result<Side> {
    if let Ok(solution) = side.cast::<Solution>() {
        return Ok(Side::Solution(solution.clone().unbind()));
    }
    Ok(Side::Path(path_of(side, name)?))
}

/// The path of a trajectory, for an argument `name` that accepts a Solution or a path.
pub fn path_of(side: &Bound<'_, PyAny>, name: &str) -> PyResult<PathBuf> {
    side.extract().map_err(|_| {
        let kind = side.get_type();
        PyTypeError::new_err(format!("{name}: found {kind}, expected a Solution or a path"))
    })
}

/// Axes of trajectories in local metres.
pub fn axes_of(axes: &str) -> Result<LocalAxes> {
    match axes {
        "enu" => Ok(LocalAxes::EnuFlu),
        "ned" => Ok(LocalAxes::NedFrd),
        _ => Err(Error::Config(format!("axes: found \"{axes}\", expected enu or ned"))),
    }
}

/// Copy a log and add faults, as `hovernav inject` does. The reference of the log is also the reference of the copy.
///
/// Parameters
/// ----------
/// log : Log or path
/// faults : str or sequence of str
///     NAME[=VALUE][@[START][:DURATION]], with times in seconds of the log's clock, such as "glitch-step=60@100:15".
///     Omitted times are random, from the seed. `hovernav inject --fault list` prints all names.
/// seed : int
///     Seed of random times, directions and noise: the same seed gives the same log.
///
/// Raises
/// ------
/// FaultError
///     For an unknown fault, or a fault of a sensor or time that the log lacks.
/// LogError
///     If the log cannot be read.
#[pyfunction]
#[pyo3(signature = (log, faults, *, seed=1))]
pub fn inject(
    py: Python<'_>,
    log: &Bound<'_, PyAny>,
    faults: &Bound<'_, PyAny>,
    seed: u64,
) -> Result<PyLog> {
    let names: Vec<String> = match faults.extract::<String>() {
        Ok(one) => vec![one],
        Err(_) => faults.extract()?,
    };
    let faults = names.iter().map(|name| name.parse::<Fault>().map_err(Error::Fault));
    let faults = faults.collect::<Result<Vec<Fault>>>()?;
    let log = log_of(log)?;
    let log = log.get();
    py.detach(|| {
        let scratch = tempfile::tempdir().map_err(|error| error::scratch(&error))?;
        let name = log.path.file_name().unwrap_or(log.path.as_os_str());
        let (clean, faulty) = (scratch.path().join("clean"), scratch.path().join(name));
        let source = if log.path.is_dir() { log.path.as_path() } else { clean.as_path() };
        if source == clean {
            log.log.dataset.write(&clean, &[])?;
        }
        faults::Log::open(source)?.with_faults(&faults, seed)?.write(&faulty)?;
        let made = PyLog::open(faulty, &Options::default())?;
        Ok(PyLog { scratch: Some(Arc::new(scratch)), ..made })
    })
}

/// Overlapping Allan deviation of an inertial unit at rest, at about ten averaging times per decade.
///
/// Parameters
/// ----------
/// readings : Log, path, or array of shape (n,)
///     A log at rest, or evenly spaced readings of one axis.
/// rate_hz : float, optional
///     Rate of the readings of an array; not for a log.
///
/// Returns
/// -------
/// Table
///     `tau_s` and `deviation`, in the unit of the readings. For a log, `tau_s` and one column for each axis, such as
///     `gyro_x_radps` and `accel_z_mps2`. White noise of density N is N/sqrt(tau).
///
/// Raises
/// ------
/// ArrayError
///     For fewer than two readings, readings that are not finite, and a log with gaps.
#[pyfunction]
#[pyo3(signature = (readings, *, rate_hz=None))]
pub fn allan<'py>(
    py: Python<'py>,
    readings: &Bound<'py, PyAny>,
    rate_hz: Option<f64>,
) -> Result<Bound<'py, PyAny>> {
    let rejected = |words: String| Err(Error::Array(words));
    let is_log = readings.cast::<PyLog>().is_ok() || readings.extract::<PathBuf>().is_ok();
    if is_log {
        if rate_hz.is_some() {
            return rejected("rate_hz: found a rate for a log, which has its own times".into());
        }
        let log = log_of(readings)?;
        let log = log.get();
        let columns = py.detach(|| of_log(log))?;
        return Ok(table(py, columns)?);
    }
    let Some(rate_hz) = rate_hz.filter(|&rate_hz| rate_hz > 0.0 && rate_hz.is_finite()) else {
        return rejected(
            "rate_hz: found no rate above 0, expected that of the readings, Hz".into(),
        );
    };
    let readings = vector(readings, "readings")?;
    let readings: Vec<f64> = readings.as_array().iter().copied().collect();
    if let Some(row) = readings.iter().position(|reading| !reading.is_finite()) {
        return rejected(format!("readings: row {row}: a value is missing or not finite"));
    }
    let points = py.detach(|| allan_deviation(&readings, 1.0 / rate_hz));
    if points.is_empty() {
        return rejected(format!("readings: found {}, expected at least 2", readings.len()));
    }
    let rows = points.iter().map(|point| [point.tau_s, point.deviation]);
    Ok(table(py, split(["tau_s", "deviation"], rows))?)
}

/// Largest ratio of an interval between samples to the median interval; a longer interval is a gap.
const EVEN: f64 = 1.5;

fn of_log(log: &PyLog) -> Result<Vec<(&'static str, Vec<f64>)>> {
    let (samples, name) = (&log.log.dataset.imu, log.path.display());
    let times: Vec<_> = samples.iter().map(|sample| sample.time).collect();
    let Some(interval_s) = median_interval_s(&times) else {
        return Err(Error::Array(format!(
            "{name}: found {} samples, expected at least 2",
            times.len()
        )));
    };
    if let Some(gap) = times.windows(2).find(|pair| pair[1] - pair[0] > EVEN * interval_s) {
        let (length_s, after) = (gap[1] - gap[0], gap[0]);
        return Err(Error::Array(format!(
            "{name}: found a gap of {length_s:.3} s after {after}, expected even samples"
        )));
    }
    let mut before = times[0].offset_by(-interval_s);
    let rows: Vec<[f64; 6]> = samples
        .iter()
        .map(|sample| {
            let mean = sample.motion.mean_rates(sample.time - before);
            before = sample.time;
            let ([p, q, r], [x, y, z]) =
                (mean.angular_rate_radps.to_array(), mean.specific_force_mps2.to_array());
            [p, q, r, x, y, z]
        })
        .collect();
    let mut columns = Vec::new();
    for (name, readings) in split(RATES, rows.into_iter()) {
        let points = allan_deviation(&readings, interval_s);
        if columns.is_empty() {
            columns.push(("tau_s", points.iter().map(|point| point.tau_s).collect()));
        }
        columns.push((name, points.iter().map(|point| point.deviation).collect()));
    }
    Ok(columns)
}
