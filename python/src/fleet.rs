//! The page of a fleet, for `hovernav.cluster`.

use std::path::PathBuf;

use hovernav_pages::Level;
use hovernav_pages::fleet::{Fleet, FleetLog, FleetPage};
use pyo3::prelude::*;

use crate::error::{Error, Result};
use crate::pages;

/// The logs of a fleet, one after another.
#[pyclass(name = "_Fleet", module = "hovernav._hovernav")]
#[derive(Default)]
pub struct PyFleet(Fleet);

#[pymethods]
impl PyFleet {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Add a log. `verdict` is the verdict on its solution; `None` without a solution.
    fn add(
        &mut self,
        path: String,
        vehicle: String,
        duration_s: f64,
        verdict: Option<&str>,
        kinds: Vec<String>,
        reason: String,
    ) -> Result<()> {
        let level = verdict.map(|name| {
            let level = Level::ALL.into_iter().find(|level| level.name() == name);
            level.ok_or_else(|| {
                Error::Config(format!("verdict: found \"{name}\", expected good, care or bad"))
            })
        });
        let level = level.transpose()?;
        self.0.push(FleetLog { path, vehicle, duration_s, level, kinds, reason });
        Ok(())
    }

    /// Numbers of logs with the verdicts good, care and bad, and of logs without a solution.
    #[getter]
    fn counts(&self) -> [usize; 4] {
        self.0.counts()
    }

    /// Write the report page, with `warnings` about the run.
    fn report(&self, path: PathBuf, warnings: Vec<String>) -> Result<()> {
        pages::write(&FleetPage::new(&self.0, &warnings).page(), &path)
    }

    /// The report page in a frame, for a notebook.
    fn framed(&self, warnings: Vec<String>) -> Result<String> {
        pages::framed(&FleetPage::new(&self.0, &warnings).page())
    }
}
