//! Before any fit: filters that shift nothing, trim, segments, and the questions a record must
//! answer first.
//!
//! [`check_inputs`](crate::methods::excitation::check_inputs) asks whether the inputs tell apart what they are to tell apart,
//! [`check_kinematics`] whether attitude, rates and velocity are those of one body. What they find
//! is named, with numbers; a model fitted past such findings would be precise and wrong.

mod butterworth;
mod kinematics;
mod polynomial_velocity;
mod resample;
mod segment;
mod zero_phase;

pub use butterworth::{LowPass, Section};
pub use kinematics::{
    KinematicChannels, KinematicFault, KinematicReport, Relation, check_kinematics,
};
pub use polynomial_velocity::polynomial_velocity;
pub use resample::{resample, uniform};
pub use segment::{SegmentSettings, excited_segments, filtered};

use thiserror::Error;

use crate::record::experiment::ExperimentError;

/// Why a signal could not be prepared.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PreprocessError {
    /// A low-pass needs its cut-off between zero and half the sample rate.
    #[error("cut-off {cutoff_hz} Hz is not between 0 and half the sample rate of {rate_hz} Hz")]
    Cutoff {
        /// The cut-off asked for, Hz.
        cutoff_hz: f64,
        /// The sample rate, Hz.
        rate_hz: f64,
    },
    /// A filter order that cannot be built.
    #[error("a filter of order {order}: between 1 and {largest} can be built")]
    FilterOrder {
        /// The order asked for.
        order: usize,
        /// The largest.
        largest: usize,
    },
    /// Too few samples.
    #[error("{samples} samples are too few for {what}; more than {needed} are needed")]
    TooShort {
        /// For what.
        what: &'static str,
        /// Samples there are.
        samples: usize,
        /// One fewer than needed.
        needed: usize,
    },
    /// Times that do not rise, or values that are not finite.
    #[error("sample {sample}: time {time_s} s, value {value}: times must rise, all must be finite")]
    Sample {
        /// Its index.
        sample: usize,
        /// Its time, s.
        time_s: f64,
        /// Its value.
        value: f64,
    },
    /// A gap too long to bridge.
    #[error("no samples from {from_s} s for {gap_s} s, longer than the {longest_s} s to bridge")]
    Gap {
        /// The last sample before it, s.
        from_s: f64,
        /// Its length, s.
        gap_s: f64,
        /// The longest that may be bridged, s.
        longest_s: f64,
    },
    /// A period that is not positive and finite, or other than asked for.
    #[error("a sample period of {period_s} s")]
    Period {
        /// The period, s.
        period_s: f64,
    },
    /// The record itself.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
}
