//! `estimate`: the estimator over a log.

use std::path::PathBuf;
use std::time::Instant;

use hovernav::time::Time;
use hovernav_dataset::Outage;
use hovernav_formats::{Changes, Options, Pass};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::log::PyLog;
use crate::settings::Settings;
use crate::solution::{Flown, Solution};

/// Number of samples between two calls of `progress` and between two checks for Ctrl-C.
const SAMPLES_A_STEP: usize = 4096;

/// Run the estimator over a flight, as `hovernav estimate` does. The numbers are equal to the bit.
///
/// Parameters
/// ----------
/// log : Log or path
///     A path is opened as by `hovernav.read`.
/// smooth : bool
///     Also run backwards over the flight, so that every solution also uses later measurements.
/// config : path or dict, optional
///     Settings that override those of the log, in the form of `dataset.toml`, for example
///     `{"gps": {"antenna_lever_arm_m": [0.1, 0.0, -0.2]}}`.
/// outages : sequence of (start_s, duration_s)
///     Spans in which the GPS is ignored, in seconds of the log's clock.
/// gps_rate_hz : float, optional
///     Reduce the GPS to at most this rate.
/// progress : callable, optional
///     Called repeatedly, from this thread, with the number of completed samples in the current pass (forward or
///     backward) and the total number.
///
/// Raises
/// ------
/// LogError
///     If the log cannot be read, or the alignment does not end.
/// SetupError
///     If the readings of the log are impossible with its units, axes or clocks: the message names the likely mistake.
/// ConfigError
///     If a setting has the wrong type or is out of range. An unknown key causes a warning in the solution.
#[pyfunction]
#[pyo3(signature = (log, *, smooth=false, config=None, outages=Vec::new(), gps_rate_hz=None, progress=None))]
pub fn estimate(
    py: Python<'_>,
    log: &Bound<'_, PyAny>,
    smooth: bool,
    config: Option<&Bound<'_, PyAny>>,
    outages: Vec<[f64; 2]>,
    gps_rate_hz: Option<f64>,
    progress: Option<Py<PyAny>>,
) -> Result<Solution> {
    let started = Instant::now();
    let log = log_of(log)?;
    let settings = config.map(Settings::of).transpose()?;
    let outages = outages_of(outages)?;
    if let Some(rate_hz) = gps_rate_hz.filter(|&rate_hz| !(rate_hz > 0.0 && rate_hz.is_finite())) {
        return Err(Error::Config(format!("gps_rate_hz: found {rate_hz}, expected above 0")));
    }
    let (mut read, path) = (log.get().log.clone(), log.get().path.clone());
    py.detach(move || {
        if let Some(settings) = &settings {
            read.dataset.configure_with(&settings.text, settings.name())?;
        }
        let configured = settings.is_some();
        let changes = Changes { configured, outages: &outages, gps_rate_hz };
        let mut states = Vec::new();
        let estimated = read.estimate(&path, &changes, false, |dataset, config, keep| {
            states.clear();
            let total = dataset.sample_count();
            let step = |done: usize| match done.is_multiple_of(SAMPLES_A_STEP) {
                true => call(progress.as_ref(), done, total).map_err(Error::Python),
                false => Ok(()),
            };
            Pass::over(dataset, config, keep, smooth, step, |solution| {
                states.push(*solution);
                Ok(())
            })
        })?;
        let mut judged = read.judge(&path, &changes, smooth, &estimated)?;
        judged.summary.wall_s = started.elapsed().as_secs_f64();
        if progress.is_some() {
            let total = read.dataset.sample_count();
            call(progress.as_ref(), total, total)?;
        }
        Ok(Solution::new(
            states,
            Flown { log: read, path, estimated, judged, outages: outages.clone() },
        ))
    })
}

/// Reports the progress and checks for Ctrl-C.
pub fn call(progress: Option<&Py<PyAny>>, done: usize, total: usize) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        match progress {
            Some(progress) => progress.call1(py, (done, total)).map(drop),
            None => Ok(()),
        }
    })
}

/// Spans without GPS, each from a start and a duration.
pub fn outages_of(spans: Vec<[f64; 2]>) -> Result<Vec<Outage>> {
    spans.into_iter().map(outage).collect()
}

/// The span without GPS from `start_s` on.
fn outage([start_s, duration_s]: [f64; 2]) -> Result<Outage> {
    let start = Time::try_from_seconds(start_s);
    match start.filter(|_| duration_s > 0.0 && duration_s.is_finite()) {
        Some(start) => Ok(Outage { start, duration_s }),
        None => Err(Error::Config(format!(
            "outages: found ({start_s}, {duration_s}), expected a start and a duration in seconds"
        ))),
    }
}

/// The `log` itself, or the log at the path `log`.
pub fn log_of<'py>(log: &Bound<'py, PyAny>) -> Result<Bound<'py, PyLog>> {
    if let Ok(log) = log.cast::<PyLog>() {
        return Ok(log.clone());
    }
    let path: PathBuf = log.extract().map_err(|_| {
        PyTypeError::new_err(format!("log: found {}, expected a Log or a path", log.get_type()))
    })?;
    let read = log.py().detach(|| PyLog::open(path, &Options::default()))?;
    Ok(Bound::new(log.py(), read)?)
}
