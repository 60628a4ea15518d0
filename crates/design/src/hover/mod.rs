//! Gains of the hover autopilot from a model, at the loop's own sample period.
//!
//! The plant of the design is that of the digital loop. It is the model's exact step over one period, behind lagging
//! servos and one sample of delay. Each regulator minimises Σ e^(2αkT)(yᵀQy + zᵀQᵢz + uᵀRu) over that plant with
//! integral action z. Its properties therefore hold for the digital loop itself.
//!
//! ```
//! use hovernav_design::hover::HoverDesign;
//! use hovernav_model::shipped;
//!
//! let design = HoverDesign::default();
//! let model = shipped::raptor60();
//! let gains = design.synthesise(&model)?;
//! let margins = design.close(&model, &gains)?.margins()?;
//! for channel in &margins.channels {
//!     assert!(channel.phase.is_none_or(|phase| phase.margin.to_degrees() > 45.0));
//! }
//! # Ok::<(), hovernav_design::DesignError>(())
//! ```

mod closed_loop;
mod config;
mod estimator;
mod evolution;
mod forward;
mod gusts;
mod limited;
mod perturbation;
mod plant;
mod proven;
mod regulator;
mod required;
mod sampled;
mod search;
mod synthesis;
mod uncertainty;

pub use closed_loop::{Cut, FlightMode};
pub use config::{AttitudeWeights, HeavePoles, HoverDesign, RollPitchWeights, YawWeights};
pub use estimator::EstimatorLag;
pub use forward::{ForwardFlight, ForwardPoint};
pub use gusts::{GustResponse, Gusts};
pub use proven::ProvenRadius;
pub use required::PerturbedStability;
pub use sampled::{SampledMode, SampledRobustness};
pub use search::{Search, Wanted};
