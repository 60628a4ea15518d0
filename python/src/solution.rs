//! `Solution` and `State`: the results of the estimator.

use std::path::PathBuf;

use hovernav::ekf::{Estimator, Solution as CoreState};
use hovernav_dataset::{Outage, SOLUTION_COLUMNS, solution_row};
use hovernav_findings::Finding as CoreFinding;
use hovernav_formats::{Estimated, Judged, Log};
use hovernav_pages::flight::LogPage;
use hovernav_score::{Level, Verdict};
use numpy::{PyArray1, PyArray2, PyArrayMethods as _};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PySlice;

use crate::columns::{table, time};
use crate::error::{Error, Result};
use crate::log::from_json;
use crate::pages;

/// Index of the first column of each quantity in a row of `solution.csv`.
mod place {
    pub const POSITION: usize = 1;
    pub const VELOCITY_NED: usize = 4;
    pub const ATTITUDE: usize = 7;
    pub const VELOCITY_BODY: usize = 10;
    pub const ANGULAR_RATE: usize = 13;
    pub const POSITION_SIGMA: usize = 16;
    pub const VELOCITY_SIGMA: usize = 19;
    pub const ATTITUDE_SIGMA: usize = 22;
    pub const GYRO_BIAS: usize = 25;
    pub const ACCEL_BIAS: usize = 28;
}

/// The attitude from body to NED as a unit quaternion: w, x, y, z.
fn quaternion(state: &CoreState) -> [f64; 4] {
    let [x, y, z, w] = state.body_to_ned.quaternion().to_array();
    let sign = if w < 0.0 { -1.0 } else { 1.0 };
    [w, x, y, z].map(|part| sign * part)
}

/// The solution at one moment, at the point that `[solution] point` names, by default the centre of gravity.
#[pyclass(frozen, module = "hovernav")]
pub struct State(pub CoreState);

impl State {
    fn three<'py>(&self, py: Python<'py>, first: usize) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &solution_row(&self.0)[first..first + 3])
    }
}

#[pymethods]
impl State {
    /// Time, s on the clock of the log.
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time.seconds()
    }

    /// Latitude, °, north positive.
    #[getter]
    fn latitude_deg(&self) -> f64 {
        self.0.position.latitude_deg()
    }

    /// Longitude, °, east positive.
    #[getter]
    fn longitude_deg(&self) -> f64 {
        self.0.position.longitude_deg()
    }

    /// Height above the ellipsoid, m.
    #[getter]
    fn height_m(&self) -> f64 {
        self.0.position.height_m
    }

    /// Velocity north, east, down, m/s, shape (3,).
    #[getter]
    fn velocity_ned_mps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::VELOCITY_NED)
    }

    /// Velocity u, v, w in body axes, m/s, shape (3,).
    #[getter]
    fn velocity_body_mps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::VELOCITY_BODY)
    }

    /// Roll, pitch and yaw, °, shape (3,).
    #[getter]
    fn attitude_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::ATTITUDE)
    }

    /// Attitude from body to NED as a unit quaternion w, x, y, z with w not negative, shape (4,).
    #[getter]
    fn quaternion<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &quaternion(&self.0))
    }

    /// Angular rate p, q, r, corrected for bias, rad/s, shape (3,).
    #[getter]
    fn angular_rate_radps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::ANGULAR_RATE)
    }

    /// One-sigma of position, north, east, down, m, shape (3,).
    #[getter]
    fn position_sigma_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::POSITION_SIGMA)
    }

    /// One-sigma of velocity, north, east, down, m/s, shape (3,).
    #[getter]
    fn velocity_sigma_mps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::VELOCITY_SIGMA)
    }

    /// One-sigma of roll, pitch and yaw, °, shape (3,).
    #[getter]
    fn attitude_sigma_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::ATTITUDE_SIGMA)
    }

    /// Estimated gyro bias, rad/s, shape (3,).
    #[getter]
    fn gyro_bias_radps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::GYRO_BIAS)
    }

    /// Estimated accelerometer bias, m/s², shape (3,).
    #[getter]
    fn accel_bias_mps2<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.three(py, place::ACCEL_BIAS)
    }

    fn __repr__(&self) -> String {
        let row = solution_row(&self.0);
        let [north, east, down] = self.0.velocity_mps.to_array();
        format!(
            "<State at {:.3} s: {:.7}° {:.7}° {:.2} m, velocity NED {north:.2} {east:.2} {down:.2} m/s, \
             roll {:.1}° pitch {:.1}° yaw {:.1}°>",
            row[0], row[1], row[2], row[3], row[7], row[8], row[9]
        )
    }
}

/// An event in a log or in the estimation, described in one sentence.
#[pyclass(frozen, get_all, module = "hovernav")]
pub struct Finding {
    /// Start, s on the clock of the log.
    start_s: f64,
    /// End, s; the start for an event without duration.
    end_s: f64,
    /// Sensor that the event concerns.
    sensor: String,
    /// Kind of event.
    kind: String,
    /// `info`, `warning` or `error`.
    severity: String,
    /// Number of samples or fixes that the event concerns.
    count: usize,
    /// Harm to the solution, by which findings are ranked. It is the largest ratio of error to one-sigma, or without an
    /// independent solution the growth of the one-sigma. `None` without a solution in the span.
    harm: Option<f64>,
    /// The event in words: sensor, time, size and cause.
    words: String,
}

impl From<&CoreFinding> for Finding {
    fn from(finding: &CoreFinding) -> Self {
        Self {
            start_s: finding.start_s,
            end_s: finding.end_s,
            sensor: finding.sensor.to_string(),
            kind: finding.kind.to_string(),
            severity: format!("{:?}", finding.severity).to_lowercase(),
            count: finding.count,
            harm: finding.harm.map(|harm| harm.size),
            words: finding.words.clone(),
        }
    }
}

#[pymethods]
impl Finding {
    fn __repr__(&self) -> String {
        format!("<{}: {}>", self.severity, self.words)
    }
}

/// The estimator's solution over a flight: one row per inertial sample from the end of the alignment on.
///
/// Arrays are read-only views with n rows; `solution[i]` is one `State`, and `frame()` a data frame. Position and
/// velocity are those of the point that `[solution] point` names, by default the centre of gravity.
#[pyclass(frozen, module = "hovernav")]
pub struct Solution {
    states: Vec<CoreState>,
    /// All rows of `solution.csv`, shape (n, 31), computed at the first use.
    rows: PyOnceLock<Py<PyArray2<f64>>>,
    flown: Flown,
}

/// The log of a solution, and all results of the estimation.
pub struct Flown {
    /// The log, with the settings and without the measurements that the solution lacks.
    pub log: Log,
    /// The log's file or directory.
    pub path: PathBuf,
    /// Results of the estimator's passes over the log.
    pub estimated: Estimated,
    /// The summary and the score.
    pub judged: Judged,
    /// Spans in which the GPS was ignored.
    pub outages: Vec<Outage>,
}

impl Solution {
    /// Creates a solution from the `states` of a flight.
    pub fn new(states: Vec<CoreState>, flown: Flown) -> Self {
        Self { states, rows: PyOnceLock::new(), flown }
    }

    /// The log and all results of the estimation.
    pub fn flown(&self) -> &Flown {
        &self.flown
    }

    fn findings(&self) -> &[CoreFinding] {
        &self.flown.judged.summary.findings
    }

    fn judged(&self) -> Option<&Verdict> {
        self.flown.judged.summary.verdict.as_ref()
    }

    fn smoothed(&self) -> bool {
        self.flown.judged.summary.smoothed
    }

    fn page(&self) -> Result<LogPage<'_>> {
        let Flown { log, estimated, judged, outages, .. } = &self.flown;
        Ok(LogPage::new(log, estimated, judged, outages)?)
    }

    /// The states, in order of time.
    pub fn states(&self) -> &[CoreState] {
        &self.states
    }

    fn rows<'py>(&self, py: Python<'py>) -> PyResult<&Bound<'py, PyArray2<f64>>> {
        let rows = self.rows.get_or_try_init(py, || {
            let shape = [self.states.len(), SOLUTION_COLUMNS.len()];
            let flat: Vec<f64> = py.detach(|| self.states.iter().flat_map(solution_row).collect());
            let rows = PyArray1::from_vec(py, flat).reshape(shape)?;
            rows.call_method1("setflags", (false,))?;
            Ok::<_, PyErr>(rows.unbind())
        })?;
        Ok(rows.bind(py))
    }

    fn column<'py>(&self, py: Python<'py>, column: usize) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py)?.get_item((PySlice::full(py), column))
    }

    fn three<'py>(&self, py: Python<'py>, first: usize) -> PyResult<Bound<'py, PyAny>> {
        let columns = PySlice::new(py, first as isize, first as isize + 3, 1);
        self.rows(py)?.get_item((PySlice::full(py), columns))
    }
}

#[pymethods]
impl Solution {
    /// Times, s on the clock of the log, shape (n,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, 0)
    }

    /// Latitude, °, north positive, shape (n,).
    #[getter]
    fn latitude_deg<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, place::POSITION)
    }

    /// Longitude, °, east positive, shape (n,).
    #[getter]
    fn longitude_deg<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, place::POSITION + 1)
    }

    /// Height above the ellipsoid, m, shape (n,).
    #[getter]
    fn height_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.column(py, place::POSITION + 2)
    }

    /// Velocity north, east, down, m/s, shape (n, 3).
    #[getter]
    fn velocity_ned_mps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::VELOCITY_NED)
    }

    /// Velocity u, v, w in body axes, m/s, shape (n, 3).
    #[getter]
    fn velocity_body_mps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::VELOCITY_BODY)
    }

    /// Roll, pitch and yaw, °, shape (n, 3).
    #[getter]
    fn attitude_deg<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::ATTITUDE)
    }

    /// Attitude from body to NED as unit quaternions w, x, y, z with w not negative, shape (n, 4).
    #[getter]
    fn quaternion<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let flat: Vec<f64> = self.states.iter().flat_map(quaternion).collect();
        PyArray1::from_vec(py, flat).reshape([self.states.len(), 4])
    }

    /// Angular rate p, q, r, corrected for bias, rad/s, shape (n, 3).
    #[getter]
    fn angular_rate_radps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::ANGULAR_RATE)
    }

    /// One-sigma of position, north, east, down, m, shape (n, 3).
    #[getter]
    fn position_sigma_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::POSITION_SIGMA)
    }

    /// One-sigma of velocity, north, east, down, m/s, shape (n, 3).
    #[getter]
    fn velocity_sigma_mps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::VELOCITY_SIGMA)
    }

    /// One-sigma of roll, pitch and yaw, °, shape (n, 3).
    #[getter]
    fn attitude_sigma_deg<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::ATTITUDE_SIGMA)
    }

    /// Estimated gyro bias, rad/s, shape (n, 3).
    #[getter]
    fn gyro_bias_radps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::GYRO_BIAS)
    }

    /// Estimated accelerometer bias, m/s², shape (n, 3).
    #[getter]
    fn accel_bias_mps2<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.three(py, place::ACCEL_BIAS)
    }

    /// Whether every state also uses later measurements.
    #[getter]
    fn is_smoothed(&self) -> bool {
        self.smoothed()
    }

    /// "good", "care" or "bad": the worse of the verdicts on the findings and on the consistency of the filter, as on
    /// the report page.
    #[getter]
    fn verdict(&self) -> &'static str {
        self.judged().map_or(Level::Good, |verdict| verdict.level).name()
    }

    /// The main reasons why the verdict is not better, one sentence each.
    #[getter]
    fn reasons(&self) -> Vec<String> {
        self.judged().map(|verdict| verdict.reasons.clone()).unwrap_or_default()
    }

    /// Events in the log and in the estimation, in order of time, including the warnings.
    #[getter]
    #[pyo3(name = "findings")]
    fn all_findings(&self) -> Vec<Finding> {
        self.findings().iter().map(Finding::from).collect()
    }

    /// Counts, alignment, warnings and, if the log has a reference, errors: the content of `summary.json`.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let json = serde_json::to_string(&self.flown.judged.summary);
        from_json(py, &json.map_err(|error| Error::Array(error.to_string()))?)
    }

    /// Write the report page of the flight, the `report.html` of `hovernav estimate`: map, motion, biases, innovations,
    /// raw samples, vibration and, if the log has a reference, errors.
    ///
    /// Raises
    /// ------
    /// LogError
    ///     If the file cannot be written.
    fn report(&self, py: Python<'_>, path: PathBuf) -> Result<()> {
        py.detach(|| pages::write(&self.page()?.page(), &path))
    }

    /// The report page in a frame, for a notebook.
    fn _repr_html_(&self, py: Python<'_>) -> Result<String> {
        py.detach(|| pages::framed(&self.page()?.page()))
    }

    /// The columns of `solution.csv`, unrounded.
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        solution_table(py, &self.states)
    }

    /// The columns of `solution.csv`, unrounded, as a pandas data frame.
    fn frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py)?.call_method0("frame")
    }

    /// Covariance of the solution at the last sample not later than `time_s`: position north, east, down (m), velocity
    /// (m/s), roll, pitch and yaw (rad), shape (9, 9).
    ///
    /// The filter stores only its latest covariance, so this method runs the filter again up to that moment.
    ///
    /// Raises
    /// ------
    /// ArrayError
    ///     For a time before the first solution, and for a smoothed solution, which has one-sigmas only.
    fn covariance<'py>(&self, py: Python<'py>, time_s: f64) -> Result<Bound<'py, PyArray2<f64>>> {
        if self.smoothed() {
            let words =
                "covariance: a smoothed solution has one-sigmas only; estimate with smooth=False";
            return Err(Error::Array(words.into()));
        }
        let until = time(time_s)?;
        let found = py.detach(|| {
            let mut estimator = Box::new(Estimator::new(self.flown.estimated.config));
            let mut events = self.flown.log.dataset.events().peekable();
            let last = self.states.iter().rev().find(|state| state.time <= until)?.time;
            while estimator.solution().is_none_or(|solution| solution.time < last) {
                estimator.push(&events.next()?, |_| ());
            }
            Some(estimator.filter()?.solution_covariance())
        });
        let found = found.ok_or_else(|| {
            let first_s = self.states.first().map_or(f64::NAN, |state| state.time.seconds());
            Error::Array(format!(
                "covariance: found {time_s} s, expected a time from {first_s} s on"
            ))
        })?;
        let rows: Vec<Vec<f64>> = found.iter().map(|row| row.to_vec()).collect();
        PyArray2::from_vec2(py, &rows).map_err(|error| Error::Array(error.to_string()))
    }

    /// Errors against `reference`: see `hovernav.score`.
    #[pyo3(signature = (reference, *, align=false, skip_s=None))]
    fn score<'py>(
        slf: &Bound<'py, Self>,
        reference: &Bound<'py, PyAny>,
        align: bool,
        skip_s: Option<f64>,
    ) -> Result<Bound<'py, PyAny>> {
        crate::analysis::score(slf.as_any(), reference, align, "enu", skip_s)
    }

    fn __len__(&self) -> usize {
        self.states.len()
    }

    fn __getitem__(&self, index: isize) -> PyResult<State> {
        let count = self.states.len() as isize;
        let place = if index < 0 { index + count } else { index };
        let state = usize::try_from(place).ok().and_then(|place| self.states.get(place));
        state.map(|state| State(*state)).ok_or_else(|| {
            PyIndexError::new_err(format!(
                "found index {index}, expected {} to {}",
                -count,
                count - 1
            ))
        })
    }

    fn __repr__(&self) -> String {
        let span = match (self.states.first(), self.states.last()) {
            (Some(first), Some(last)) => format!(
                "{} states from {:.2} s to {:.2} s",
                self.states.len(),
                first.time.seconds(),
                last.time.seconds()
            ),
            _ => "empty".into(),
        };
        let kind = if self.smoothed() { "smoothed, " } else { "" };
        let warnings = self.findings().iter().filter(|finding| finding.is_warning()).count();
        format!("<Solution: {kind}{span}, {warnings} warnings>")
    }
}

/// The columns of `solution.csv` for `states`, unrounded.
pub fn solution_table<'py>(py: Python<'py>, states: &[CoreState]) -> PyResult<Bound<'py, PyAny>> {
    let columns = crate::columns::split(SOLUTION_COLUMNS, states.iter().map(solution_row));
    table(py, columns)
}
