//! The error-state Kalman filter.

pub mod covariance;
pub mod layout;
mod level_force;

mod antenna;
mod attitude_watch;
mod barometer;
mod bias_shift;
mod config;
mod correction;
mod datasheet;
mod estimator;
mod estimator_config;
mod excess;
mod field_watch;
mod filter;
mod gate;
mod ground;
mod heading_memory;
mod heading_revision;
mod heading_search;
mod history;
mod innovation;
mod learned;
mod measurement;
mod mechanisms;
mod motion_sum;
mod net_turn;
mod position_scatter;
mod prediction;
mod process;
mod rectification;
mod self_contradiction;
mod setting;
#[cfg(feature = "alloc")]
mod smoother;
mod solution;
mod stepless;
mod trace;
mod unknown_heading;
mod vehicle_kind;
mod wheels;

use crate::matrix::square;
use crate::scalar;
pub use config::{
    AntennaHeadingModel, AttitudeModel, BaroModel, EkfConfig, GateConfig, GpsModel, ImuModel,
    MagnetometerModel, RangeModel,
};
pub use estimator::{Estimator, Notice};
pub use estimator_config::{Aiding, EstimatorConfig, Rangefinder};
pub use filter::Ekf;
pub use heading_search::{HeadingMethod, HeadingSearch, NoHeadingSearch};
pub use innovation::{Channel, Innovation, Verdict};
#[doc(hidden)]
pub use learned::Learned;
pub use measurement::{
    Aid, Expected, Measurement, Report, Row, Rows, Unusable, WrongRows, check_derivatives,
};
pub use mechanisms::Mechanisms;
pub use prediction::{ImuFault, Prediction, ResetCause};
pub use setting::{OutOfRange, Setting};
#[cfg(feature = "alloc")]
pub use smoother::{Adjoint, Smoother};
pub use solution::Solution;
pub use stepless::SteplessSolution;
pub use trace::Trace;
pub use vehicle_kind::VehicleKind;

/// The fifteen base states, in `f64`.
pub type BaseEkf = Ekf<layout::Base, 16>;

/// The filter of the command line, with the blocks of [`layout::Full`], in `f64`.
pub type FullEkf = Ekf<layout::Full, 28>;

/// Conversion to single precision, for quantities whose own errors are larger than its rounding.
fn single<T: scalar::Scalar>(value: T) -> f32 {
    value.wide() as f32
}

/// Square root by the double-precision routine, which the program contains anyway.
fn root(of: f32) -> f32 {
    scalar::Scalar::sqrt(f64::from(of)) as f32
}
