//! Settings and result of one pass.

use nalgebra::DVector;

use crate::methods::innovation::InnovationModel;

/// How the projection of the future on the past is weighted before its singular values are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weighting {
    /// No weight: the oblique projection itself. Van Overschee & De Moor's N4SID.
    N4sid,
    /// Projection without the part that the future inputs explain. Verhaegen's MOESP with past inputs and outputs.
    Moesp,
    /// As [`Weighting::Moesp`], normalised by the covariance of the future outputs without the part that future inputs
    /// explain. This is Larimore's canonical variate analysis. The singular values are canonical correlations.
    Cva,
}

/// Settings of one pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubspaceSettings {
    /// Number of states; `None` derives it from the singular values.
    pub order: Option<usize>,
    /// Number of past and of future samples in each projection; it must exceed the order. `None` takes twice the order,
    /// at least ten and at most what the record allows.
    pub horizon: Option<usize>,
    /// The weighting.
    pub weighting: Weighting,
    /// Whether inputs act on outputs within the same sample. They do not for a vehicle measured at the moment its input
    /// changes.
    pub feedthrough: bool,
    /// Whether the vehicle is known to be stable. Where noise or drift moves a pole outside the unit circle, all poles
    /// are then scaled until it is just inside.
    pub stable: bool,
}

/// Horizon where neither a horizon nor an order is given.
const USUAL_HORIZON: usize = 10;

impl SubspaceSettings {
    /// The horizon of a pass over `samples` samples of `signals` inputs and outputs.
    pub(super) fn horizon_for(&self, samples: usize, signals: usize) -> usize {
        let longest = samples / (2 * (signals + 1));
        let wanted = self.order.map_or(USUAL_HORIZON, |order| USUAL_HORIZON.max(2 * order));
        self.horizon.unwrap_or_else(|| wanted.min(longest.max(USUAL_HORIZON)))
    }
}

impl Default for SubspaceSettings {
    fn default() -> Self {
        Self {
            order: None,
            horizon: None,
            weighting: Weighting::Cva,
            feedthrough: true,
            stable: false,
        }
    }
}

/// Result of one pass.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The model, with the gain of its innovations.
    pub model: InnovationModel,
    /// The state at the first sample.
    pub initial_state: DVector<f64>,
    /// Singular values of the weighted projection in falling order. Values beyond the model's order are much smaller.
    pub singular_values: Vec<f64>,
    /// Criterion by which B, D and the initial state were fitted.
    pub input_fit: InputFit,
}

/// Output on which B, D and the initial state were fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputFit {
    /// The simulated output.
    Simulation,
    /// The one-step prediction, because the model is unstable and its simulation diverges.
    Prediction,
}
