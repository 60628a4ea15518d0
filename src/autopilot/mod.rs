//! Hover control: from the filter's solution to the positions of the sticks. The last stage of the flight core.
//!
//! [`HoverAutopilot`] is the hybrid controller of Paw (2005), chapter 6, doi:10.32657/10356/47095, at the loop's own
//! rate. A PID controls heave. A linear-quadratic regulator with integral action controls yaw and holds the heading.
//! Another regulator controls roll and pitch from p, q, φ, θ, u, v. Guidance feeds these loops from set-points of
//! position, velocity and heading. Degraded modes replace these loops when the estimate is poor, and the pilot can
//! override the autopilot.
//!
//! Everything here is plain data and bounded arithmetic: no allocation, no panic, no clock of its own. Gains come
//! from a design at the same sample period. [`HoverConfig::check`] rejects a configuration that cannot fly.

mod check;
mod config;
mod engagement;
mod excitation;
mod guidance;
mod hover;
mod limits;
mod maneuver;
mod matrix;
mod mode;
mod pid;
mod programme;
mod readiness;
mod regulator;
mod steering;
mod supervisor;
mod transfer;
mod trim;

pub use check::ConfigError;
pub use config::{Gains, HoverConfig};
pub use engagement::{Engagement, EngagementChange};
pub use excitation::{Excitation, ExcitationAbort, ExcitationError, ExcitationLimits};
pub use guidance::{GuidanceConfig, SetPoint, SetPointError};
pub use hover::{HoverAutopilot, Inputs, Outputs};
pub use limits::{FARTHEST_PILOT, StickLimits};
pub use maneuver::Maneuver;
pub use mode::{Mode, Reason, Transition};
pub use pid::{Pid, PidGains};
pub(crate) use programme::ProgrammeFlight;
pub use programme::{ExcitationProgramme, ProgrammeChange, TestInput};
pub use readiness::{Check, Checked, Observed, Readiness, ReadinessLimits};
pub use regulator::{Regulator, RegulatorGains};
pub use steering::{Steering, SteeringConfig};
pub use transfer::TransferConfig;
pub use trim::Trim;
