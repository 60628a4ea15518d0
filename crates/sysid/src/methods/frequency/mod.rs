//! Identification in the frequency domain: responses with their coherence, and models fitted at coherent frequencies.
//!
//! A chirp-z transform gives any band at any resolution from windows of any length. Long windows, for low frequencies,
//! and short ones, with many averages, can therefore be combined point by point. Each response is conditioned on the
//! other inputs. Where a controller moves the inputs, the movement injected on top of it is the reference.
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

/// Reason for a missing frequency response, or for a missing fit to it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FrequencyError {
    /// The band is empty, reversed or beyond half the sample rate.
    #[error(
        "cannot place {points} frequencies from {first_hz} Hz to {last_hz} Hz at a sample rate of {rate_hz} Hz"
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
    /// The window is longer than every record, or contains too few samples.
    #[error("a window of {window} samples does not fit records of up to {longest}")]
    Window {
        /// Length of the window, samples.
        window: usize,
        /// Length of the longest record, samples.
        longest: usize,
    },
    /// Experiments with different signals or periods, or no experiments.
    #[error("experiments of one response need the same signals and period: {reason}")]
    Experiments {
        /// Description of the difference.
        reason: String,
    },
    /// An input does not move independently of the others at a frequency.
    #[error("input `{input}` does not move independently of the others at {frequency_hz} Hz")]
    DependentInputs {
        /// The input.
        input: String,
        /// The frequency, Hz.
        frequency_hz: f64,
    },
    /// Too few coherent points.
    #[error("{points} points of coherence above {least} cannot determine {parameters} parameters")]
    TooFewPoints {
        /// Number of points with a coherence above the limit.
        points: usize,
        /// Smallest coherence of a usable point.
        least: f64,
        /// Number of parameters to determine.
        parameters: usize,
    },
    /// The model is undefined or not finite at the initial parameters.
    #[error("the model gives no finite response of {outputs} × {inputs} at the start values")]
    Start {
        /// Outputs expected.
        outputs: usize,
        /// Inputs expected.
        inputs: usize,
    },
}
