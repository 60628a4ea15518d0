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
}

impl Harm {
    /// Size by which findings are ranked: [`one_sigmas`](Self::one_sigmas), otherwise [`growth`](Self::growth).
    #[must_use]
    pub fn size(&self) -> f64 {
        self.one_sigmas.unwrap_or(self.growth)
    }
}
