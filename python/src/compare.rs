//! `compare`: differences between solutions.

use std::path::PathBuf;

use hovernav_dataset::Trajectory;
use hovernav_formats::{Comparison, NamedTrajectory};
use hovernav_pages::compare::{ComparisonPage, MAX_SOLUTIONS};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::analysis::{axes_of, path_of};
use crate::error::{Error, Result};
use crate::log::from_json;
use crate::pages;
use crate::solution::Solution;

/// The differences between solutions. Made by `hovernav.compare`.
#[pyclass(frozen, name = "Comparison", module = "hovernav")]
pub struct PyComparison(Comparison);

#[pymethods]
impl PyComparison {
    /// The content of `summary.json` of `hovernav compare`: `differences`, a list with `solution`, `less` and for each
    /// axis the `rmse`, `median`, `p95` and `max` of `difference`; `warnings`.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &self.0.to_json().to_string())
    }

    /// Write the report page: the differences, and all solutions in each figure.
    ///
    /// Raises
    /// ------
    /// LogError
    ///     If the file cannot be written.
    fn report(&self, py: Python<'_>, path: PathBuf) -> Result<()> {
        py.detach(|| pages::write(&ComparisonPage::new(&self.0).page(), &path))
    }

    /// The report page in a frame, for a notebook.
    fn _repr_html_(&self, py: Python<'_>) -> Result<String> {
        py.detach(|| pages::framed(&ComparisonPage::new(&self.0).page()))
    }

    fn __repr__(&self) -> String {
        let names: Vec<&str> = self.0.trajectories.iter().map(|one| &*one.name).collect();
        format!("<Comparison of {}>", names.join(", "))
    }
}

/// Compare solutions with each other, as `hovernav compare` does.
///
/// Parameters
/// ----------
/// *solutions : Solution or path
///     Two to four. A path is a `solution.csv`, an output directory of `hovernav estimate`, a TUM or EuRoC file, or a
///     directory with a mapping.
/// names : sequence of str, optional
///     A name for each solution. Default: the names of the logs and files.
/// align : bool
///     Rotate the other solutions about the vertical and translate them to the first solution, by least squares.
/// axes : str
///     Axes of trajectories in local metres: "enu" with a forward-left-up body, "ned" with forward-right-down.
///
/// Raises
/// ------
/// LogError
///     If a file cannot be read, or two solutions do not overlap in time.
#[pyfunction]
#[pyo3(signature = (*solutions, names=None, align=false, axes="enu"))]
pub fn compare(
    py: Python<'_>,
    solutions: &Bound<'_, PyTuple>,
    names: Option<Vec<String>>,
    align: bool,
    axes: &str,
) -> Result<PyComparison> {
    let axes = axes_of(axes)?;
    let count = solutions.len();
    if !(2..=MAX_SOLUTIONS).contains(&count) {
        return Err(Error::Config(format!(
            "solutions: found {count}, expected 2 to {MAX_SOLUTIONS}"
        )));
    }
    if let Some(names) = names.as_ref().filter(|names| names.len() != count) {
        return Err(Error::Config(format!("names: found {}, expected {count}", names.len())));
    }
    let mut opened = Vec::with_capacity(count);
    for (index, side) in solutions.iter().enumerate() {
        let mut one = match side.cast::<Solution>() {
            Ok(solution) => named(solution.get(), index),
            Err(_) => {
                let path = path_of(&side, "solutions")?;
                py.detach(|| NamedTrajectory::open(&path, axes))?
            }
        };
        if let Some(name) = names.as_ref().and_then(|names| names.get(index)) {
            one.name.clone_from(name);
        }
        opened.push(one);
    }
    Ok(PyComparison(py.detach(|| Comparison::of(opened, align))?))
}

/// A solution in memory, with the name of its log.
fn named(solution: &Solution, index: usize) -> NamedTrajectory {
    let log = &solution.flown().log.dataset.manifest.name;
    let is_smoothed = solution.flown().judged.summary.smoothed;
    NamedTrajectory {
        name: if is_smoothed { format!("{log}, smoothed") } else { log.clone() },
        // The name with a number distinguishes two solutions of the same log.
        source: format!("{log} ({})", index + 1).into(),
        trajectory: Trajectory::of_solutions(solution.states().to_vec()),
    }
}
