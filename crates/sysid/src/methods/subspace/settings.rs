//! How to run one pass, and what it gives.

use nalgebra::DVector;

use crate::methods::innovation::InnovationModel;

/// How the projection of the future on the past is weighted before its singular values are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weighting {
    /// No weight: the oblique projection itself. Van Overschee & De Moor's N4SID.
    N4sid,
    /// Without what the future inputs explain. Verhaegen's MOESP with past inputs and outputs.
    Moesp,
    /// As [`Weighting::Moesp`], each direction of the future in units of its own scatter: Larimore's
    /// canonical variate analysis. The singular values are canonical correlations.
    Cva,
}

/// How to run one pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubspaceSettings {
    /// States; `None` lets the singular values decide.
    pub order: Option<usize>,
    /// Samples of past and of future in each projection. More than the order is needed; `None` takes twice
    /// the order, at least ten and at most what the record allows.
    pub horizon: Option<usize>,
    /// The weighting.
    pub weighting: Weighting,
    /// Whether inputs act on outputs within the same sample. A plant measured at the moment its
    /// input changes has none.
    pub feedthrough: bool,
    /// Whether the plant is known to be stable: where noise or drift pushes a pole outside the unit
    /// circle, all poles are then drawn in until it is just inside.
    pub stable: bool,
}

/// Horizon where neither it nor an order is asked for.
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

/// What one pass found.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The model, with the gain of its innovations.
    pub model: InnovationModel,
    /// The state at the first sample.
    pub initial_state: DVector<f64>,
    /// Singular values of the weighted projection, falling: where they drop, the order ends.
    pub singular_values: Vec<f64>,
    /// How B, D and the initial state were found.
    pub input_fit: InputFit,
}

/// On which output B, D and the initial state were fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputFit {
    /// On the simulated output.
    Simulation,
    /// On the one-step prediction, since the plant is unstable and its simulation runs away.
    Prediction,
}
