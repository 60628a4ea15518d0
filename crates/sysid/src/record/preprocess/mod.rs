//! Preparation of a record: zero-phase filters, trim, segments and consistency checks.
//!
//! [`check_inputs`](crate::methods::excitation::check_inputs) checks that the inputs excite the system independently.
//! [`check_kinematics`] checks that attitude, rates and velocity are kinematically consistent. Both report their
//! findings with numbers; a model fitted in spite of them would be precise and wrong.

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

/// Reasons why a signal cannot be prepared.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PreprocessError {
    /// The cut-off of a low-pass is not between zero and half the sample rate.
    #[error("cut-off {cutoff_hz} Hz is not between 0 and half the sample rate of {rate_hz} Hz")]
    Cutoff {
        /// The requested cut-off, Hz.
        cutoff_hz: f64,
        /// The sample rate, Hz.
        rate_hz: f64,
    },
    /// An unsupported filter order.
    #[error("found a filter order of {order}, expected 1 to {largest}")]
    FilterOrder {
        /// The requested order.
        order: usize,
        /// The largest order.
        largest: usize,
    },
    /// Too few samples.
    #[error("found {samples} samples, expected more than {needed} for {what}")]
    TooShort {
        /// The operation.
        what: &'static str,
        /// Number of samples.
        samples: usize,
        /// Largest number of samples that is still too small.
        needed: usize,
    },
    /// Times that do not increase, or values that are not finite.
    #[error(
        "sample {sample}: time {time_s} s, value {value}: expected increasing times and finite values"
    )]
    Sample {
        /// Index of the invalid sample.
        sample: usize,
        /// Time of the invalid sample, s.
        time_s: f64,
        /// Value of the invalid sample.
        value: f64,
    },
    /// A gap too long to bridge.
    #[error("no samples from {from_s} s for {gap_s} s, longer than the {longest_s} s to bridge")]
    Gap {
        /// Time of the last sample before the gap, s.
        from_s: f64,
        /// Length of the gap, s.
        gap_s: f64,
        /// Longest gap that may be bridged, s.
        longest_s: f64,
    },
    /// The sample period is not above 0 or not finite.
    #[error("invalid sample period of {period_s} s")]
    Period {
        /// The period, s.
        period_s: f64,
    },
    /// The record is invalid.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
}
