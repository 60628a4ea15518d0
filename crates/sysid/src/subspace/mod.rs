//! Subspace identification: a state-space model from data alone, without a start value.
//!
//! The future outputs are projected on the past; the space they span is the extended observability
//! matrix, whose shift structure gives A and C. B, D and the initial state then come from least
//! squares on the simulated output, so the model is as good as it can be at what it will be asked:
//! to run free.
//!
//! [`identify`] is one pass, some milliseconds. [`refine()`] goes on from there by prediction or
//! output error, and [`search`] tries several passes and keeps what holds on data set aside.
//!
//! Source: P. Van Overschee & B. De Moor, *Subspace Identification for Linear Systems* (1996),
//! chapters 4 and 5; L. Ljung, *System Identification*, 2nd ed., section 10.6.

mod balance;
mod gain;
mod input_fit;
mod projection;
mod realization;
mod refine;
mod responses;
mod scales;
mod search;

pub use input_fit::fit_initial_state;
pub use refine::{Criterion, RefineSettings, Refined, refine};
pub use search::{Candidate, Search, SearchSettings, Way, search};

use nalgebra::DVector;
use thiserror::Error;

use super::experiment::Experiment;
use super::linear::InnovationModel;
use projection::Projection;
use scales::Scales;

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
    /// Samples of past and of future in each projection. More than the order is needed.
    pub horizon: usize,
    /// The weighting.
    pub weighting: Weighting,
    /// Whether inputs act on outputs within the same sample. A plant measured at the moment its
    /// input changes has none.
    pub feedthrough: bool,
    /// Whether the plant is known to be stable: where noise or drift pushes a pole outside the unit
    /// circle, all poles are then drawn in until it is just inside.
    pub stable: bool,
}

impl Default for SubspaceSettings {
    fn default() -> Self {
        Self {
            order: None,
            horizon: 10,
            weighting: Weighting::Cva,
            feedthrough: true,
            stable: false,
        }
    }
}

/// Why no model came out.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SubspaceError {
    /// The record is too short for the horizon.
    #[error(
        "experiment `{experiment}`: {samples} samples are too few for a horizon of {horizon}; \
         {needed} are needed"
    )]
    TooShort {
        /// The experiment's name.
        experiment: String,
        /// Samples there are.
        samples: usize,
        /// The horizon asked for.
        horizon: usize,
        /// The fewest samples that horizon works with.
        needed: usize,
    },
    /// The order does not fit the horizon.
    #[error(
        "order {order} does not fit a horizon of {horizon}: between 1 and {largest} can be found"
    )]
    Order {
        /// States asked for.
        order: usize,
        /// The horizon.
        horizon: usize,
        /// Most states the horizon can show.
        largest: usize,
    },
    /// An input moves too little, or only as other inputs do.
    #[error(
        "experiment `{experiment}`: input `{input}` does not excite: it is constant, too smooth, or \
         a combination of the other inputs"
    )]
    NotExciting {
        /// The experiment's name.
        experiment: String,
        /// The input.
        input: String,
    },
    /// An output never changes.
    #[error("experiment `{experiment}`: output `{output}` is constant")]
    ConstantOutput {
        /// The experiment's name.
        experiment: String,
        /// The output.
        output: String,
    },
    /// The arithmetic broke down.
    #[error("experiment `{experiment}`: {step} has no finite result")]
    Breakdown {
        /// The experiment's name.
        experiment: String,
        /// Which step.
        step: &'static str,
    },
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

/// One pass of subspace identification over `experiment`, which should be about its trim
/// ([`Experiment::about`]).
///
/// # Errors
/// [`SubspaceError`] where the record is too short, an input does not excite, an output never moves
/// or the order does not fit.
///
/// # Example
/// ```
/// use hovernav_sysid::Experiment;
/// use hovernav_sysid::subspace::{SubspaceSettings, identify};
/// use nalgebra::DMatrix;
///
/// // A lag driven by a signal that never repeats.
/// let inputs = DMatrix::from_fn(400, 1, |k, _| (0.1 * (k * k) as f64).sin());
/// let mut outputs = DMatrix::zeros(400, 1);
/// for k in 1..400 {
///     outputs[(k, 0)] = 0.9 * outputs[(k - 1, 0)] + 0.5 * inputs[(k - 1, 0)];
/// }
/// let names = |name: &str| vec![name.to_owned()];
/// let lag = Experiment::new("lag", 0.03, names("u"), names("y"), inputs, outputs)?;
/// let settings = SubspaceSettings { order: Some(1), ..SubspaceSettings::default() };
/// let found = identify(&lag, &settings)?;
/// assert!((found.model.system.a[(0, 0)] - 0.9).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn identify(
    experiment: &Experiment,
    settings: &SubspaceSettings,
) -> Result<Identified, SubspaceError> {
    let scales = Scales::of(experiment)?;
    let unit = scales.applied(experiment);
    let projection = Projection::of(&unit, settings.horizon, settings.weighting)?;
    let order = match settings.order {
        Some(order) => order,
        None => order_from(&projection.singular_values, projection.largest_order()),
    };
    let mut found = realization::realize(&unit, &projection, order, settings)?;
    scales.restore(&mut found.model);
    Ok(found)
}

/// The number of singular values above the middle, on a logarithmic scale, between the largest and
/// the smallest: those of the plant stand out from those of the noise. At least 1, at most
/// `largest`.
fn order_from(singular_values: &[f64], largest: usize) -> usize {
    let top = singular_values.first().copied().unwrap_or(0.0);
    // Rounding is not noise: a noise-free record would put the middle at nothing.
    let floor = 1e-12 * top;
    let bottom = singular_values.last().copied().unwrap_or(0.0).max(floor);
    let middle = (top * bottom).sqrt();
    singular_values.iter().filter(|&&value| value > middle).count().clamp(1, largest.max(1))
}
