//! `Log`: the measurements of a flight.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hovernav::frames::{EulerAngles, Vector};
use hovernav::imu::Motion;
use hovernav_dataset::columns::{
    ALTITUDE, ATTITUDE, GPS, INCREMENTS, MAGNETIC, RATES, STICKS, TIME,
};
use hovernav_dataset::{LogError, StatedFix};
use hovernav_findings::Contents;
use hovernav_formats::{Log, Options};
use hovernav_toml::write_whole;
use pyo3::prelude::*;
use tempfile::TempDir;

use crate::columns::{read_only, split};
use crate::error::{Error, Result};

/// The measurements of a flight, each sensor as a table. Units and axes are those of the library: see the column names,
/// body axes are forward, right, down.
///
/// Made by `hovernav.read`, by `hovernav.inject`, or from arrays by `Log.from_arrays`. A log never changes: a function
/// that alters one returns another, and the arrays of its tables are read-only. Each use of a property builds the table
/// again, so keep it in a variable.
#[pyclass(frozen, name = "Log", module = "hovernav")]
pub struct PyLog {
    /// The log's data in memory.
    pub log: Log,
    /// The log's file or directory, for messages; a directory may contain a reference.
    pub path: PathBuf,
    /// The directory at `path`, if it is temporary.
    pub scratch: Option<Arc<TempDir>>,
}

impl PyLog {
    /// Opens the log at `path`; messages contain this path.
    pub fn open(path: PathBuf, options: &Options) -> Result<Self> {
        let log = hovernav_formats::open(&path, options)?;
        Ok(Self { log, path, scratch: None })
    }
}

/// Read a log: a dataset directory, a flight record, or a file of PX4 (ULog), ArduPilot (DataFlash), MAVLink (tlog),
/// ROS 2 (MCAP), a receiver's raw bytes, or text in columns with a mapping. The format follows from the content.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
/// imu, gps, magnetometer, baro : int, optional
///     Number of the sensor in the log. Default: the first sensor, unless another one has many more samples.
///
/// Raises
/// ------
/// LogError
///     If the log cannot be read; the message names the file and the line or byte.
/// ConfigError
///     If the log's `dataset.toml` is not valid.
#[pyfunction]
#[pyo3(signature = (path, *, imu=None, gps=None, magnetometer=None, baro=None))]
pub fn read(
    py: Python<'_>,
    path: PathBuf,
    imu: Option<usize>,
    gps: Option<usize>,
    magnetometer: Option<usize>,
    baro: Option<usize>,
) -> Result<PyLog> {
    let mut options = Options::default();
    (options.imu, options.gps, options.magnetometer, options.baro) = (imu, gps, magnetometer, baro);
    py.detach(|| PyLog::open(path, &options))
}

/// The values of a reading; NaN without a reading.
fn known<const N: usize>(values: Option<[f64; N]>) -> [f64; N] {
    values.unwrap_or([f64::NAN; N])
}

#[pymethods]
impl PyLog {
    /// The inertial samples: `t_s`, then rates `gyro_{x,y,z}_radps` and specific forces `accel_{x,y,z}_mps2`, or
    /// increments since the previous sample, `dtheta_{x,y,z}_rad` and `dvel_{x,y,z}_mps`. If measured, also the
    /// inertial unit's own attitude `roll_deg, pitch_deg, yaw_deg` and the magnetic field `mag_{x,y,z}_gauss`. Body
    /// axes.
    #[getter]
    fn imu<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let samples = &self.log.dataset.imu;
        let are_rates =
            samples.first().is_none_or(|sample| matches!(sample.motion, Motion::Rates { .. }));
        let motion = if are_rates { RATES } else { INCREMENTS };
        let mut columns = vec![(TIME, samples.iter().map(|s| s.time.seconds()).collect())];
        columns.extend(split(
            motion,
            samples.iter().map(|sample| {
                let (Motion::Rates { angular_rate_radps: gyro, specific_force_mps2: accel }
                | Motion::Increments { angle_rad: gyro, velocity_mps: accel }) = sample.motion;
                let ([p, q, r], [x, y, z]) = (gyro.to_array(), accel.to_array());
                [p, q, r, x, y, z]
            }),
        ));
        if samples.iter().any(|sample| sample.attitude.is_some()) {
            let attitudes = samples.iter().map(|s| known(s.attitude.map(EulerAngles::to_degrees)));
            columns.extend(split(ATTITUDE, attitudes));
        }
        if samples.iter().any(|sample| sample.magnetic_field_gauss.is_some()) {
            let field = |field: Option<Vector<_>>| known(field.map(Vector::to_array));
            columns.extend(split(MAGNETIC, samples.iter().map(|s| field(s.magnetic_field_gauss))));
        }
        read_only(py, columns)
    }

    /// The fixes, at the time of their arrival: `t_s, lat_deg, lon_deg, height_m` (ellipsoidal), `vn_mps, ve_mps,
    /// vd_mps`, one-sigma `sigma_{n,e,d}_m` and `sigma_{vn,ve,vd}_mps`, `satellites`; NaN where the receiver reports no
    /// value.
    #[getter]
    fn gps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let latency_s = self.log.dataset.manifest.gps.latency_s;
        let rows = self.log.dataset.fixes.iter().map(|fix| {
            let stated = StatedFix::of(fix);
            let ([lat, lon, height], [vn, ve, vd]) = (stated.position, stated.velocity_mps);
            let ([n, e, d], [svn, sve, svd]) = (stated.position_sigma_m, stated.velocity_sigma_mps);
            let height = if fix.two_dimensional { f64::NAN } else { height };
            let t_s = fix.time.offset_by(latency_s).seconds();
            [t_s, lat, lon, height, vn, ve, vd, n, e, d, svn, sve, svd, stated.satellites]
        });
        read_only(py, split(GPS, rows))
    }

    /// Barometric heights: `t_s, altitude_m`, above any fixed level.
    #[getter]
    fn baro<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.log.dataset.baro.iter().map(|(time, height_m)| [time.seconds(), *height_m]);
        read_only(py, split([TIME, ALTITUDE], rows))
    }

    /// Readings of a magnetometer outside the inertial unit: `t_s, mag_{x,y,z}_gauss`, body axes.
    #[getter]
    fn magnetometer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.log.dataset.magnetometer.iter().map(|(time, field)| {
            let [x, y, z] = field.to_array();
            [time.seconds(), x, y, z]
        });
        read_only(py, split([TIME, MAGNETIC[0], MAGNETIC[1], MAGNETIC[2]], rows))
    }

    /// The sticks: `t_s, lateral, longitudinal, collective, pedal`, each -1 to 1 about trim.
    #[getter]
    fn controls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.log.dataset.controls.iter().map(|(time, sticks)| {
            let [lateral, longitudinal, collective, pedal] = *sticks;
            [time.seconds(), lateral, longitudinal, collective, pedal]
        });
        read_only(py, split([TIME, STICKS[0], STICKS[1], STICKS[2], STICKS[3]], rows))
    }

    /// Name of the log.
    #[getter]
    fn name(&self) -> &str {
        &self.log.dataset.manifest.name
    }

    /// Description of the vehicle; empty if unknown.
    #[getter]
    fn vehicle(&self) -> &str {
        &self.log.dataset.manifest.vehicle
    }

    /// Repairs and skipped rows during reading, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.log.dataset.warnings.clone()
    }

    /// Choices and assumptions during reading, one sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.log.dataset.notes.clone()
    }

    /// Sensors, rates, spans and gaps, as `hovernav info --json` prints them.
    #[getter]
    fn info<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>> {
        let json = serde_json::to_string(&Contents::of(&self.log.dataset));
        Ok(from_json(py, &json.map_err(|error| Error::Array(error.to_string()))?)?)
    }

    /// Write the log as a dataset directory, which is created if necessary, with its reference if it has one.
    ///
    /// Raises
    /// ------
    /// LogError
    ///     If the directory cannot be written.
    fn write(&self, py: Python<'_>, directory: PathBuf) -> Result<()> {
        py.detach(|| {
            // The reference is read first, because the directory may be the log's own.
            let from = self.path.join("reference.csv");
            let reference = match self.path.is_dir() && from.exists() {
                true => Some(std::fs::read(&from).map_err(LogError::io(&from))?),
                false => None,
            };
            self.log.dataset.write(&directory, &[])?;
            if let Some(reference) = reference {
                let to = directory.join("reference.csv");
                write_whole(&to, reference).map_err(LogError::io(&to))?;
            }
            Ok(())
        })
    }

    /// A log from arrays of your own. Every table is a dictionary of arrays, or a data frame, with the columns of the
    /// properties of a log. The end of a column's name is its unit. Three columns may be one array of shape (n, 3),
    /// named without the axis: `gyro_radps, accel_mps2, dtheta_rad, dvel_mps, attitude_deg, mag_gauss` of the inertial
    /// unit, `velocity_mps, position_sigma_m, velocity_sigma_mps` (north, east, down) of the GPS, `mag_gauss` of the
    /// magnetometer.
    ///
    /// Parameters
    /// ----------
    /// imu : mapping
    ///     `t_s`, and rates with specific forces, or increments.
    /// gps : mapping
    ///     `t_s, lat_deg, lon_deg, height_m`; the other columns are optional, and NaN means unknown.
    /// axes : str
    ///     Directions of the axes x, y, z of `imu`, such as "frd" (forward, right, down) or "flu".
    /// baro, magnetometer, controls : mapping, optional
    ///     The magnetometer has the vehicle's axes forward, right, down; `axes` does not apply to it.
    /// config : path or dict, optional
    ///     Settings in the form of `dataset.toml`, such as lever arms and the accuracy of the sensors.
    ///
    /// Raises
    /// ------
    /// ArrayError
    ///     For wrong shapes, unknown columns, times that do not increase, and inertial samples with NaN or beyond any
    ///     vehicle's motion. Fixes without a position are skipped, and named in `warnings`.
    /// ConfigError
    ///     For unknown axes or an invalid setting.
    #[staticmethod]
    #[pyo3(signature = (imu, gps, *, axes, baro=None, magnetometer=None, controls=None, config=None))]
    fn from_arrays(
        imu: &Bound<'_, PyAny>,
        gps: &Bound<'_, PyAny>,
        axes: &str,
        baro: Option<&Bound<'_, PyAny>>,
        magnetometer: Option<&Bound<'_, PyAny>>,
        controls: Option<&Bound<'_, PyAny>>,
        config: Option<&Bound<'_, PyAny>>,
    ) -> Result<Self> {
        let tables = crate::arrays::Tables { imu, gps, baro, magnetometer, controls };
        let dataset = crate::arrays::dataset(&tables, axes, config)?;
        let log = Log::of_dataset(dataset);
        Ok(Self { log, path: Path::new("arrays").into(), scratch: None })
    }

    fn __repr__(&self) -> String {
        let dataset = &self.log.dataset;
        let span_s = dataset.sample_span().map_or(0.0, |(first, last)| last - first);
        format!(
            "<Log {}: {span_s:.1} s, {} inertial samples, {} fixes>",
            self.path.display(),
            dataset.imu.len(),
            dataset.fixes.len()
        )
    }
}

/// `json` as dictionaries and lists.
pub fn from_json<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}
