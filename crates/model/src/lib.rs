//! Vehicle models for simulation and design: a nonlinear helicopter, and linear models as data.
//!
//! [`helicopter::Helicopter`] is a rigid body in six degrees of freedom. It has a tip-path-plane rotor with a
//! stabilizer bar, a tail rotor with a rate gyro, fins and a fuselage. It is trimmed and linearised about hover or slow
//! flight.
//!
//! [`StateSpace`] is a linear model: matrices, the names and units of its signals, and its time domain. It is read from
//! and written to `model.toml`; [`shipped`] contains three models. [`LinearAirframe`] simulates a linear hover model
//! with the full rigid-body kinematics. [`hover`] builds the structures of hover models of small helicopters.

mod airframe;
mod error;
mod file;
mod flyable;
mod frequency;
pub mod helicopter;
pub mod hover;
pub mod linalg;
mod linear;
mod matlab;
mod modes;
mod parameter;
mod pattern;
mod real;
pub mod shipped;
mod signal;
mod signs;
mod state_space;
mod verdict;

pub use airframe::{AirframeError, LinearAirframe};
pub use error::ModelError;
pub use flyable::{IDENTIFIED, Unflyable};
pub use frequency::FrequencySweep;
pub use linear::{LinearModel, TimeDomain};
pub use modes::{Mode, Modes};
pub use nalgebra;
pub use parameter::{Parameter, Slope};
pub use pattern::StepTakenForRate;
pub use signal::Signal;
pub use signs::{DerivativeRole, KnownSign, WrongSign};
pub use state_space::StateSpace;
pub use verdict::{Grade, Verdict};
