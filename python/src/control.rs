//! `identify`, `design` and `simulate`: a model from a flight, an autopilot from the model, and simulated flights.

use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

use hovernav::autopilot::HoverConfig;
use hovernav::earth::Geodetic;
use hovernav_design::CheckedDesign;
use hovernav_design::hover::{HoverDesign, Wanted};
use hovernav_findings::{check_fitness, ensure_possible};
use hovernav_formats::Options;
use hovernav_model::{StateSpace, TimeDomain, shipped};
use hovernav_replay::smooth;
use hovernav_sim::campaign::SensorGrade;
use hovernav_sim::{FlightConfig, FlightEvent};
use hovernav_sysid::helicopter::{
    FlightRecord, FrequencyDomain, ModelStructure, Request, Velocity, identify as fit,
    solutions_for,
};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{self, Error, Result};
use crate::estimate::{log_of, outages_of};
use crate::log::PyLog;
use crate::settings::Settings;

/// A linear model of a helicopter near its hover: x' = A x + B u, in SI units and per full stick. Made by
/// `hovernav.identify`, or from a file by `Model.open`.
#[pyclass(frozen, module = "hovernav")]
pub struct Model(pub StateSpace);

/// An error of a model or an autopilot.
pub fn model_error(error: impl Display) -> Error {
    Error::Model(error.to_string())
}

fn matrix<'py>(
    py: Python<'py>,
    rows: usize,
    columns: usize,
    at: impl Fn(usize, usize) -> f64,
) -> Bound<'py, PyArray2<f64>> {
    let array = PyArray2::zeros(py, [rows, columns], false);
    let mut filled = numpy::PyArrayMethods::readwrite(&array);
    for ((row, column), value) in filled.as_array_mut().indexed_iter_mut() {
        *value = at(row, column);
    }
    drop(filled);
    array
}

#[pymethods]
impl Model {
    /// The model in a file `model.toml`, or one that hovernav includes: "thesis", "raptor60" or "r50".
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     If the model does not exist or is not valid.
    #[staticmethod]
    fn open(path: PathBuf) -> Result<Self> {
        shipped::open(&path.to_string_lossy()).map(Self).map_err(model_error)
    }

    /// Name of the vehicle.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Names of the states, in order.
    #[getter]
    fn states(&self) -> Vec<String> {
        self.0.states().iter().map(|signal| signal.name.clone()).collect()
    }

    /// Names of the inputs, in order.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.0.inputs().iter().map(|signal| signal.name.clone()).collect()
    }

    /// The matrix A, shape (states, states).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let a = self.0.a();
        matrix(py, a.nrows(), a.ncols(), |row, column| a[(row, column)])
    }

    /// The matrix B, shape (states, inputs).
    #[getter]
    fn b<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let b = self.0.b();
        matrix(py, b.nrows(), b.ncols(), |row, column| b[(row, column)])
    }

    /// The matrix C, shape (outputs, states).
    #[getter]
    fn c<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let c = self.0.c();
        matrix(py, c.nrows(), c.ncols(), |row, column| c[(row, column)])
    }

    /// The matrix D, shape (outputs, inputs).
    #[getter]
    fn d<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let d = self.0.d();
        matrix(py, d.nrows(), d.ncols(), |row, column| d[(row, column)])
    }

    /// Names of the outputs, in order.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.0.outputs().iter().map(|signal| signal.name.clone()).collect()
    }

    /// The model as a `control.StateSpace` of python-control. The delays and lags of the inputs are not included:
    /// `parameters` has them, as tau_lat and lag_lat, s.
    ///
    /// Raises
    /// ------
    /// ImportError
    ///     If python-control is not installed.
    fn to_control<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let names = PyDict::new(py);
        names.set_item("states", self.states())?;
        names.set_item("inputs", self.inputs())?;
        names.set_item("outputs", self.outputs())?;
        let matrices = (self.a(py), self.b(py), self.c(py), self.d(py));
        if let TimeDomain::Discrete { period_s } = self.0.time() {
            names.set_item("dt", period_s)?;
        }
        py.import("control")?.call_method("ss", matrices, Some(&names))
    }

    /// The model as a MATLAB script that defines `model`, an `ss` object with names, units and delays.
    fn to_matlab(&self) -> String {
        self.0.to_matlab()
    }

    /// The identified parameters by name: stability derivatives, delays and lags.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parameters = PyDict::new(py);
        for parameter in self.0.parameters() {
            parameters.set_item(&parameter.name, parameter.value)?;
        }
        Ok(parameters)
    }

    /// "good", "care" or "do not fly"; `None` for a model without a verdict.
    #[getter]
    fn verdict(&self) -> Option<&'static str> {
        self.0.verdict().map(|verdict| verdict.grade.name())
    }

    /// Reasons why the verdict is not better, one sentence each.
    #[getter]
    fn reasons(&self) -> Vec<String> {
        self.0.verdict().map(|verdict| verdict.reasons.clone()).unwrap_or_default()
    }

    /// Write the file `model.toml`, which `hovernav design` reads.
    fn write(&self, path: PathBuf) -> Result<()> {
        self.0.write(&path).map_err(model_error)
    }

    fn __repr__(&self) -> String {
        let verdict = self.verdict().unwrap_or("no verdict");
        let (states, inputs) = (self.0.states().len(), self.0.inputs().len());
        format!("<Model {}: {states} states, {inputs} inputs, {verdict}>", self.0.name())
    }
}

/// Identify a helicopter from a flight with test inputs on the sticks, as `hovernav identify` does.
///
/// Parameters
/// ----------
/// log : Log or path
///     A flight with `controls`.
/// structure : str or path, optional
///     Structure of the model: a name, or a TOML file; `hovernav identify --list` prints both. By default "hybrid", or
///     "multirotor" for a vehicle whose rotors do not flap. Without GPS it is "rates".
/// speed_mps : float, optional
///     Forward speed of the flight to identify from, m/s. By default that of the structure: hover.
/// config : path or dict, optional
///     Settings that override those of the log.
///
/// Returns
/// -------
/// Model
///     Read its `verdict` and `reasons` before use: a model that must not be flown is also returned.
///
/// Raises
/// ------
/// ModelError
///     If no model can be identified; the message states the reason.
#[pyfunction]
#[pyo3(signature = (log, *, structure=None, speed_mps=None, config=None))]
pub fn identify(
    py: Python<'_>,
    log: &Bound<'_, PyAny>,
    structure: Option<PathBuf>,
    speed_mps: Option<f64>,
    config: Option<&Bound<'_, PyAny>>,
) -> Result<Model> {
    let parsed = structure.map(|own| own.to_string_lossy().parse::<ModelStructure>());
    let structure = parsed.transpose().map_err(|why| Error::Config(format!("structure: {why}")))?;
    let settings = config.map(Settings::of).transpose()?;
    let log = log_of(log)?;
    let log = log.get();
    py.detach(|| {
        let mut dataset = log.log.dataset.clone();
        if let Some(settings) = &settings {
            dataset.configure_with(&settings.text, settings.name())?;
        }
        let named = |why: &dyn Display| Error::Model(format!("{}: {why}", log.path.display()));
        if dataset.controls.is_empty() {
            return Err(named(&"found no sticks, and identification needs the pilot's inputs"));
        }
        if dataset.fixes.is_empty() {
            ensure_possible(&dataset, &log.path)?;
        } else {
            check_fitness(&dataset, &log.path)?;
        }
        let settings = dataset.settings()?;
        let smoothed = smooth(&dataset, &settings, |_| ()).solutions;
        let solutions = solutions_for(&dataset, structure.as_ref(), smoothed);
        if solutions.is_empty() {
            return Err(named(
                &"no solution to identify from: alignment found no fix or no heading",
            ));
        }
        let found =
            fit(&dataset, &solutions, Request { structure, speed_mps }, Velocity::Estimated)
                .map_err(|why| named(&why))?;
        let flight = FlightRecord::new(&dataset, &solutions, Velocity::Estimated)
            .map_err(|why| named(&why))?;
        let frequency = FrequencyDomain::of(&found, &flight);
        let verdict = found.verdict(frequency.as_ref().ok());
        let vehicle = found.vehicle().map_err(|why| named(&why))?;
        Ok(Model(vehicle.with_source(&found.source(&dataset.manifest.name)).with_verdict(verdict)))
    })
}

/// The gains of a hover autopilot. Made by `hovernav.design`, or from a file by `Autopilot.open`.
#[pyclass(frozen, module = "hovernav")]
pub struct Autopilot {
    /// The gains and limits.
    pub config: HoverConfig,
    remark: String,
}

#[pymethods]
impl Autopilot {
    /// The autopilot in a file `autopilot.toml`.
    ///
    /// Raises
    /// ------
    /// ModelError
    ///     If the file cannot be read or is not valid.
    #[staticmethod]
    fn open(path: PathBuf) -> Result<Self> {
        let config = hovernav_record::read_autopilot(&path).map_err(model_error)?;
        Ok(Self { config, remark: String::new() })
    }

    /// Period of the loop, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.config.period_s
    }

    /// Write the file `autopilot.toml`, which `hovernav fly` reads.
    fn write(&self, path: PathBuf) -> Result<()> {
        hovernav_record::write_autopilot(&self.config, &path, &self.remark).map_err(model_error)
    }

    fn __repr__(&self) -> String {
        format!("<Autopilot at {:.2} Hz>", 1.0 / self.config.period_s)
    }
}

/// Design a hover autopilot for a model, as `hovernav design` does. A search finds the weights of the design.
///
/// Parameters
/// ----------
/// model : Model
///     The vehicle in hover.
/// at : sequence of Model, optional
///     The vehicle in forward flight. The gains keep their margins from hover to the fastest of these models, and the
///     autopilot may fly at its speed.
///
/// Raises
/// ------
/// ModelError
///     If the model must not be flown or lacks axes needed for hover, or if the loops are unstable.
#[pyfunction]
#[pyo3(signature = (model, *, at=vec![]))]
pub fn design(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    at: Vec<Bound<'_, Model>>,
) -> Result<Autopilot> {
    let model = &model.get().0;
    let ahead: Vec<StateSpace> = at.iter().map(|own| own.get().0.clone()).collect();
    for model in ahead.iter().chain([model]) {
        if let Some(why) = model.unflyable() {
            return Err(Error::Model(format!("{}: {why}", model.name())));
        }
    }
    py.detach(|| {
        let search = HoverDesign::for_model(model).searched(model, &ahead, &Wanted::default());
        let named = |why: &dyn Display| Error::Model(format!("{}: {why}", model.name()));
        let design = search.map_err(|why| named(&why))?.design;
        let checked = CheckedDesign::new(model.clone(), design).map_err(|why| named(&why))?;
        let checked = checked.with_forward(&ahead).map_err(|why| named(&why))?;
        if let Some((mode, _)) = checked.modes.iter().find(|(_, margins)| margins.is_none()) {
            return Err(named(&format!("the loops are unstable in the mode {}", mode.name())));
        }
        let config = checked.autopilot();
        let remark = format!("Designed by hovernav for {}.", model.name());
        Ok(Autopilot { config, remark })
    })
}

/// Simulate a flight of the 60-class helicopter: sensors, gusts, servos, estimator and autopilot in closed loop.
///
/// Parameters
/// ----------
/// autopilot : Autopilot
/// duration_s : float
/// seed : int
///     Seed of all gusts and sensor errors: the same seed gives the same flight.
/// sensors : str
///     Grade of the sensors: "thesis", "modern" or "poor".
/// start : (latitude_deg, longitude_deg, height_m)
/// heading_deg : float
///     Heading at the start, from true north.
/// outages : sequence of (start_s, duration_s)
///     Spans without GPS.
/// test_points : float, optional
///     Size of the steps that a pilot flies on each stick in turn, from 30 s on, 10 s apart, for a flight to identify
///     from.
///
/// Returns
/// -------
/// Log
///     The measurements, with the truth as its reference: `hovernav.estimate(log).summary["error"]`.
///
/// Raises
/// ------
/// ModelError
///     If the autopilot or the flight is not possible.
#[pyfunction]
#[pyo3(signature = (autopilot, *, duration_s=120.0, seed=1, sensors="thesis", start=[1.3521, 103.8198, 50.0],
                    heading_deg=60.0, outages=Vec::new(), test_points=None))]
#[expect(clippy::too_many_arguments, reason = "named in Python")]
pub fn simulate(
    py: Python<'_>,
    autopilot: &Bound<'_, Autopilot>,
    duration_s: f64,
    seed: u64,
    sensors: &str,
    start: [f64; 3],
    heading_deg: f64,
    outages: Vec<[f64; 2]>,
    test_points: Option<f64>,
) -> Result<PyLog> {
    if !(1.0..=86_400.0).contains(&duration_s) {
        return Err(Error::Config(format!(
            "duration_s: found {duration_s}, expected 1 to 86400 s"
        )));
    }
    let mut config = FlightConfig::new(autopilot.get().config);
    let grade = SensorGrade::ALL.into_iter().find(|grade| grade.name() == sensors);
    let grade = grade.ok_or_else(|| {
        Error::Config(format!("sensors: found \"{sensors}\", expected thesis, modern or poor"))
    })?;
    (config.dmu, config.gps) = grade.sensors();
    let [latitude_deg, longitude_deg, height_m] = start;
    let place = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m);
    let place = place.filter(|place| place.is_navigable() && heading_deg.is_finite());
    config.start_at(place.ok_or_else(|| {
        let expected = "expected degrees, degrees and metres of a position on Earth, and a heading";
        Error::Config(format!("start: found {start:?} and heading {heading_deg}, {expected}"))
    })?);
    config.heading_rad = heading_deg.to_radians();
    config.dmu.rate_hz = 1.0 / config.autopilot.period_s;
    config.duration_s = duration_s;
    config.seed = seed;
    for outage in outages_of(outages)? {
        let start_s = outage.start.seconds();
        config.gps.outages_s.push(start_s..start_s + outage.duration_s);
    }
    if let Some(size) = test_points {
        if !(0.0..=1.0).contains(&size) {
            return Err(Error::Config(format!("test_points: found {size}, expected 0 to 1")));
        }
        // A pilot flies test points. An autopilot that uses estimates would react to every fix.
        config.feedback = hovernav_sim::Feedback::Truth;
        config.events = FlightEvent::test_points(30.0, size);
    }
    py.detach(|| {
        let (dataset, truth) = config.fly().map_err(model_error)?.dataset();
        let scratch = tempfile::tempdir().map_err(|error| error::scratch(&error))?;
        let path = scratch.path().join("simulated");
        dataset.write(&path, &truth)?;
        let log = PyLog::open(path, &Options::default())?;
        Ok(PyLog { scratch: Some(Arc::new(scratch)), ..log })
    })
}
