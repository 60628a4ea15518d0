//! `campaign`: many simulated flights.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use hovernav_dataset::LogError;
use hovernav_pages::campaign::CampaignPage;
use hovernav_sim::campaign::{
    Campaign, CampaignResult, Cell, Column, Measure, Outcome, PERCENTILES, count, percentile,
    percentiles_csv, results_csv,
};
use hovernav_toml::write_whole;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::table_of;
use crate::control::{Autopilot, Model, model_error};
use crate::error::{Error, Result};
use crate::estimate::call;
use crate::pages;

/// Many simulated flights and their results. Made by `hovernav.campaign`.
#[pyclass(frozen, name = "Campaign", module = "hovernav")]
pub struct PyCampaign {
    campaign: Campaign,
    results: Vec<CampaignResult>,
}

#[pymethods]
impl PyCampaign {
    /// Number of flights with each outcome: `hovered`, `degraded`, `not_engaged`, `crashed`.
    #[getter]
    fn outcomes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let outcomes = PyDict::new(py);
        for outcome in Outcome::ALL {
            outcomes.set_item(outcome.name(), count(&self.results, outcome, None))?;
        }
        Ok(outcomes)
    }

    /// Percentiles of each measure over all flights that lasted until the evaluation, such as
    /// `percentiles["vn_error_rms_mps"]["p95"]`.
    #[getter]
    fn percentiles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for measure in &Measure::ALL {
            all.set_item(measure.name, by_name(py, measure.percentiles(&self.results, None))?)?;
        }
        Ok(all)
    }

    /// The columns of `results.csv`, one row per flight. `seed` has integers; `outcome`, `sensors` and `jam` have text.
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let columns = PyDict::new(py);
        for column in Column::all(&self.campaign) {
            columns.set_item(&*column.name, values(py, &column, &self.results)?)?;
        }
        table_of(&columns)
    }

    /// The columns of `results.csv` as a pandas data frame.
    fn frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py)?.call_method0("frame")
    }

    /// Write `results.csv`, `percentiles.csv` and `report.html`, the same bytes as `hovernav campaign`, to a directory,
    /// which is created if necessary.
    ///
    /// Raises
    /// ------
    /// LogError
    ///     If the files cannot be written.
    fn write(&self, py: Python<'_>, directory: PathBuf) -> Result<()> {
        py.detach(|| {
            std::fs::create_dir_all(&directory).map_err(LogError::io(&directory))?;
            for (name, text) in [
                ("results.csv", results_csv(&self.campaign, &self.results)),
                ("percentiles.csv", percentiles_csv(&self.results)),
            ] {
                let path = directory.join(name);
                write_whole(&path, text).map_err(LogError::io(&path))?;
            }
            pages::write(&self.page().page(), &directory.join("report.html"))
        })
    }

    /// Write the report page: outcomes, distributions and causes.
    ///
    /// Raises
    /// ------
    /// LogError
    ///     If the file cannot be written.
    fn report(&self, py: Python<'_>, path: PathBuf) -> Result<()> {
        py.detach(|| pages::write(&self.page().page(), &path))
    }

    /// The report page in a frame, for a notebook.
    fn _repr_html_(&self, py: Python<'_>) -> Result<String> {
        py.detach(|| pages::framed(&self.page().page()))
    }

    fn __len__(&self) -> usize {
        self.results.len()
    }

    fn __repr__(&self) -> String {
        let found = Outcome::ALL.map(|outcome| (count(&self.results, outcome, None), outcome));
        let named = found.into_iter().filter(|(count, _)| *count > 0);
        let named: Vec<String> =
            named.map(|(count, outcome)| format!("{count} {}", outcome.name())).collect();
        format!("<Campaign of {} flights: {}>", self.results.len(), named.join(", "))
    }
}

impl PyCampaign {
    fn page(&self) -> CampaignPage<'_> {
        CampaignPage::new(&self.campaign, &self.results, &[])
    }
}

/// The values of a column as an array of numbers or texts.
fn values<'py>(
    py: Python<'py>,
    column: &Column,
    results: &[CampaignResult],
) -> PyResult<Bound<'py, PyAny>> {
    let (mut seeds, mut names, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    for result in results {
        match column.of(result) {
            Cell::Seed(seed) => seeds.push(seed),
            Cell::Name(name) => names.push(name),
            Cell::Number(value) => numbers.push(value),
        }
    }
    if !seeds.is_empty() {
        Ok(PyArray1::from_vec(py, seeds).into_any())
    } else if !names.is_empty() {
        py.import("numpy")?.call_method1("array", (names,))
    } else {
        Ok(PyArray1::from_vec(py, numbers).into_any())
    }
}

/// The percentiles of a column of `results.csv`, by name; NaN values are ignored.
#[pyfunction]
pub fn _percentiles<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let values: Vec<f64> = values.as_array().iter().copied().collect();
    let found = py.detach(|| PERCENTILES.map(|p| percentile(&values, f64::from(p) / 100.0)));
    by_name(py, found)
}

/// Percentiles by name, such as `p95`.
fn by_name(py: Python<'_>, values: [f64; PERCENTILES.len()]) -> PyResult<Bound<'_, PyDict>> {
    let named = PyDict::new(py);
    for (p, value) in PERCENTILES.into_iter().zip(values) {
        named.set_item(format!("p{p}"), value)?;
    }
    Ok(named)
}

/// Names of the measured columns.
pub const MEASURES: [&str; Measure::ALL.len()] = {
    let mut names = [""; Measure::ALL.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = Measure::ALL[index].name;
        index += 1;
    }
    names
};

/// Number of flights between two calls of `progress` and between two checks for Ctrl-C.
const FLIGHTS_A_STEP: usize = 32;

/// Simulate many closed-loop flights, each with random airframe, wind, sensors and GPS, as `hovernav campaign` does.
/// The numbers are equal to the bit. All processor cores are used.
///
/// Parameters
/// ----------
/// model : Model
///     Airframes are drawn from its covariance, if it has one. The simulated helicopter is the 60-class one.
/// autopilot : Autopilot
/// flights : int
/// seed : int
///     Seed of the first flight; each further flight has the next seed. A flight depends on its own seed only.
/// duration_s : float
///     Duration of each flight, 30 to 3600.
/// wind_mps : float
///     Largest steady wind, 0 to 20; gusts are a quarter of the wind.
/// outages, power_loss, jams : float
///     Fractions of the flights with a GPS outage of 5 to 20 s, with an engine stop, and with a jammed servo.
/// fuel_kg : float
///     Fuel in a full tank, 0 to 2; a flight starts with a random amount.
/// progress : callable, optional
///     Called repeatedly, from this thread, with the number of completed flights and the total number.
///
/// Raises
/// ------
/// ConfigError
///     If a value is out of range.
/// ModelError
///     If a flight is not possible.
#[pyfunction]
#[pyo3(signature = (model, autopilot, *, flights=200, seed=1, duration_s=60.0, wind_mps=5.0, outages=0.25,
                    power_loss=0.0, jams=0.0, fuel_kg=0.4, progress=None))]
#[expect(clippy::too_many_arguments, reason = "named in Python")]
pub fn campaign(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    autopilot: &Bound<'_, Autopilot>,
    flights: u64,
    seed: u64,
    duration_s: f64,
    wind_mps: f64,
    outages: f64,
    power_loss: f64,
    jams: f64,
    fuel_kg: f64,
    progress: Option<Py<PyAny>>,
) -> Result<PyCampaign> {
    within("flights", flights, &(1..=100_000_000))?;
    within("seed", seed, &(0..=u64::MAX / 2))?;
    within("duration_s", duration_s, &(30.0..=3600.0))?;
    within("wind_mps", wind_mps, &(0.0..=20.0))?;
    within("outages", outages, &(0.0..=1.0))?;
    within("power_loss", power_loss, &(0.0..=1.0))?;
    within("jams", jams, &(0.0..=1.0))?;
    within("fuel_kg", fuel_kg, &(0.0..=2.0))?;
    let mut campaign = Campaign::of_model(&model.get().0, autopilot.get().config);
    campaign.duration_s = duration_s;
    campaign.max_wind_mps = wind_mps;
    campaign.outage_share = outages;
    campaign.power_loss_share = power_loss;
    campaign.jam_share = jams;
    campaign.fuel_kg = fuel_kg;
    let seeds: Vec<u64> = Campaign::seeds(seed, flights, 1, 1).collect();
    let mut results = Vec::with_capacity(seeds.len());
    for some in seeds.chunks(FLIGHTS_A_STEP) {
        call(progress.as_ref(), results.len(), seeds.len())?;
        let flown = py.detach(|| campaign.fly_all(some, || ()));
        results.extend(flown.map_err(|error| model_error(format!("{error}: {}", error.source)))?);
    }
    call(progress.as_ref(), results.len(), seeds.len())?;
    Ok(PyCampaign { campaign, results })
}

/// Rejects a `value` outside `range`, and NaN.
fn within<T: PartialOrd + Display>(name: &str, value: T, range: &RangeInclusive<T>) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = (range.start(), range.end());
    Err(Error::Config(format!("{name}: found {value}, expected {low} to {high}")))
}
