//! The Python package hovernav: it translates between NumPy and the library, and computes nothing.

mod analysis;
mod arrays;
mod campaign;
mod columns;
mod compare;
mod control;
mod error;
mod estimate;
mod estimator;
mod fleet;
mod log;
mod pages;
mod settings;
mod solution;

use pyo3::prelude::*;

/// The compiled part of the package.
#[pymodule]
mod _hovernav {
    #[pymodule_export]
    use crate::analysis::{allan, inject, score};
    #[pymodule_export]
    use crate::campaign::{_percentiles, PyCampaign, campaign};
    #[pymodule_export]
    use crate::compare::{PyComparison, compare};
    #[pymodule_export]
    use crate::control::{Autopilot, Model, design, identify, simulate};
    #[pymodule_export]
    use crate::estimate::estimate;
    #[pymodule_export]
    use crate::estimator::{Estimator, Notice};
    #[pymodule_export]
    use crate::fleet::PyFleet;
    #[pymodule_export]
    use crate::log::{PyLog, read};
    #[pymodule_export]
    use crate::settings::_settings_json;
    #[pymodule_export]
    use crate::solution::{Finding, Solution, State};

    /// Names of the columns of `results.csv` that are measured.
    #[pymodule_export]
    const _MEASURES: [&str; 22] = crate::campaign::MEASURES;

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "the name that Python packages have")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
