//! The error-state Kalman filter. A room imports only rooms above it in this list:
//!
//! | room | contents |
//! |---|---|
//! | `settings` | error models of the sensors, gates, switches of the mechanisms |
//! | `kernel` | arithmetic: error states, covariance, recent motion |
//! | `outcome` | what a prediction or an update reports |
//! | `watch` | monitors, a file each: they learn noise and find faults |
//! | `gate` | rejection of measurements, and resets |
//! | `heading_search` | heading from motion: twelve hypotheses |
//! | `filter` | the state, its prediction and its correction |
//! | `output` | solution, solution without steps, smoother |
//! | `measurement` | a file per sensor, and the update that they share |
//! | `estimator` | alignment, heading search and filter behind one call |

mod estimator;
mod filter;
mod gate;
mod heading_search;
mod kernel;
mod measurement;
mod outcome;
mod output;
mod settings;
mod watch;

pub use estimator::{Estimator, Notice};
pub use filter::Ekf;
pub use heading_search::{HeadingMethod, HeadingSearch, NoHeadingSearch};
pub use kernel::trace::Trace;
pub use kernel::{covariance, layout};
pub use measurement::{Expected, Measurement, Row, Rows, WrongRows, check_derivatives};
pub use outcome::innovation::{Channel, Innovation, Verdict};
pub use outcome::prediction::{ImuFault, Prediction, ResetCause};
pub use outcome::report::{Aid, Report, Unusable};
#[doc(hidden)]
pub use output::learned::Learned;
#[cfg(feature = "alloc")]
pub use output::smoother::{Adjoint, Smoother};
pub use output::solution::Solution;
pub use output::stepless::SteplessSolution;
pub use settings::config::{
    AntennaHeadingModel, AttitudeModel, BaroModel, EkfConfig, GateConfig, GpsModel, ImuModel,
    MagnetometerModel, RangeModel,
};
pub use settings::estimator_config::{Aiding, EstimatorConfig, Rangefinder};
pub use settings::mechanisms::Mechanisms;
pub use settings::setting::{OutOfRange, Setting};
pub use settings::vehicle_kind::VehicleKind;

/// The fifteen base states, in `f64`.
pub type BaseEkf = Ekf<layout::Base, 16>;

/// The filter of the command line, with the blocks of [`layout::Full`], in `f64`.
pub type FullEkf = Ekf<layout::Full, 28>;
