//! Harm of an event to the solution.

use serde::Serialize;

/// Harm to the solution in the span of a finding, and in the second after it.
///
/// Errors are differences from an independent solution: the reference, otherwise that of the onboard estimator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Harm {
    /// Largest position error, m; `None` without an independent solution in the span.
    pub position_m: Option<f64>,
    /// Largest velocity error, m/s; `None` without an independent solution in the span.
    pub velocity_mps: Option<f64>,
    /// Largest ratio of an error in position or velocity, on one axis, to its one-sigma at that time. The one-sigma
    /// includes that of the independent solution. `None` without an independent solution in the span.
    pub one_sigmas: Option<f64>,
    /// Largest ratio of the one-sigma of position or velocity to its value at the start of the span, at least 1.
    pub growth: f64,
    /// Size by which findings are ranked: [`one_sigmas`](Self::one_sigmas), otherwise [`growth`](Self::growth), at times
    /// that no much shorter finding explains.
    #[serde(skip)]
    pub size: f64,
}

impl Harm {
    /// Harm of a reset of the position by `off_m`, at a one-sigma of `sigma_m`: the error before the reset.
    #[must_use]
    pub fn of_reset(off_m: f64, sigma_m: f64) -> Self {
        let one_sigmas = off_m / sigma_m;
        Self {
            position_m: Some(off_m),
            velocity_mps: None,
            one_sigmas: Some(one_sigmas),
            growth: 1.0,
            size: one_sigmas,
        }
    }
}
