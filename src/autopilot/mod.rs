//! Hover control: from what the filter says to where the sticks go. The flight core's last link.
//!
//! [`HoverAutopilot`] is the hybrid of Paw (2005), chapter 6, doi:10.32657/10356/47095, at the
//! loop's own rate: a PID on heave, a linear-quadratic regulator with integral action on yaw with
//! heading hold, another on roll and pitch over p, q, φ, θ, u, v. Position, velocity and heading
//! set-points stand above them, degraded modes below, and the pilot on top.
//!
//! Everything here is plain data and bounded arithmetic: no allocation, no panic, no clock of its
//! own. Gains come from a design at the same sample period; [`HoverConfig::check`] refuses what
//! cannot fly.

mod check;
mod config;
mod engagement;
mod excitation;
mod guidance;
mod health;
mod hover;
mod limits;
mod maneuver;
mod matrix;
mod mode;
mod monitor;
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
pub use health::{Distrust, Doubt, Health, HealthLimits, Trust};
pub use hover::{HoverAutopilot, Inputs, Outputs};
pub use limits::{FARTHEST_PILOT, StickLimits};
pub use maneuver::Maneuver;
pub use mode::{Mode, Reason, Transition};
pub use monitor::HealthMonitor;
pub use pid::{Pid, PidGains};
pub(crate) use programme::ProgrammeFlight;
pub use programme::{ExcitationProgramme, ProgrammeChange, TestInput};
pub use readiness::{Check, Checked, Observed, Readiness, ReadinessLimits};
pub use regulator::{Regulator, RegulatorGains};
pub use steering::{Steering, SteeringConfig};
pub use transfer::TransferConfig;
pub use trim::Trim;
