//! Identification in the frequency domain: responses with their coherence, and models fitted where
//! the coherence is good.
//!
//! A chirp-z transform gives any band in any resolution from windows of any length, so that long
//! windows (low frequencies) and short ones (many averages) can be combined point by point. With
//! several inputs moving at once, each response is conditioned on the others; where a controller moves them,
//! on what was injected beside it.
//!
//! Source: M. Tischler & R. Remple, *Aircraft and Rotorcraft System Identification*, 2nd ed.,
//! chapters 7 to 11; J. Bendat & A. Piersol, *Random Data*, 4th ed., chapters 7 and 9.

mod chirp_z;
mod conditioning;
mod fit;
mod response;
mod spectrum;

pub use chirp_z::ChirpZ;
pub(crate) use fit::PHASE_WEIGHT;
pub use fit::{
    ResponseCosts, ResponseFit, ResponseFitSettings, Responses, fit_response, response_costs,
};
pub use response::{FrequencyResponse, ResponseSettings, frequency_response, joint_response};
pub use spectrum::{Band, Spectra, SpectrumSettings, Window, spectra};

use thiserror::Error;

/// Why there is no frequency response, or no fit to it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FrequencyError {
    /// The band is empty, reversed or beyond half the sample rate.
    #[error(
        "no {points} frequencies from {first_hz} Hz to {last_hz} Hz at a sample rate of {rate_hz} Hz"
    )]
    Band {
        /// First frequency, Hz.
        first_hz: f64,
        /// Last frequency, Hz.
        last_hz: f64,
        /// Number of frequencies.
        points: usize,
        /// The sample rate, Hz.
        rate_hz: f64,
    },
    /// The window does not fit any record, or holds next to nothing.
    #[error("a window of {window} samples does not fit records of up to {longest}")]
    Window {
        /// Its length in samples.
        window: usize,
        /// Samples of the longest record.
        longest: usize,
    },
    /// Experiments that do not go together, or none at all.
    #[error("experiments of one response need the same signals and period: {reason}")]
    Experiments {
        /// Which do not.
        reason: String,
    },
    /// An input cannot be told from the others at a frequency, or does not move there.
    #[error(
        "input `{input}` cannot be told from the others, or does not move, at {frequency_hz} Hz"
    )]
    DependentInputs {
        /// The input.
        input: String,
        /// The frequency, Hz.
        frequency_hz: f64,
    },
    /// Nothing coherent to fit.
    #[error("{points} points of coherence above {least} cannot determine {parameters} parameters")]
    TooFewPoints {
        /// Points above the limit.
        points: usize,
        /// The limit.
        least: f64,
        /// Parameters to determine.
        parameters: usize,
    },
    /// The model is not defined, or not finite, at the start.
    #[error("the model gives no finite response of {outputs} × {inputs} at the start values")]
    Start {
        /// Outputs expected.
        outputs: usize,
        /// Inputs expected.
        inputs: usize,
    },
}
