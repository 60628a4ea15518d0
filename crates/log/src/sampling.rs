//! How often an inertial unit has to be sampled to navigate by it.

use hovernav::imu::Motion;

/// How many inertial samples a second there have to be, by what a sample is.
///
/// # Example
/// ```
/// use hovernav_log::SampleRates;
///
/// assert!(SampleRates::INCREMENTS.least_hz < SampleRates::RATES.least_hz);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRates {
    /// A log of fewer is refused, Hz.
    pub least_hz: f64,
    /// The solution of fewer is poor, and a warning says so, Hz.
    pub poor_hz: f64,
}

impl SampleRates {
    /// Of angular rates and specific forces, which lose what happens between two samples. A small helicopter rolls
    /// and pitches at up to 3 Hz, and six samples a cycle integrate that to a tenth: every second sample of a unit
    /// of 33 Hz is too few. Eight do to a twentieth, which is what slow autopilots log at 25 Hz, a clock that runs
    /// fast included.
    pub const RATES: Self = Self { least_hz: 18.0, poor_hz: 24.0 };
    /// Of increments of angle and velocity, which hold all that happened since the sample before, but for coning
    /// and sculling within it. Two and a half samples have to fit within the quarter of a second above which the
    /// filter takes an interval for a gap, so that one may be lost without a word.
    pub const INCREMENTS: Self = Self { least_hz: 10.0, poor_hz: 24.0 };

    /// Those for samples that are of the form of `motion`.
    #[must_use]
    pub const fn of(motion: &Motion) -> Self {
        match motion {
            Motion::Rates { .. } => Self::RATES,
            Motion::Increments { .. } => Self::INCREMENTS,
        }
    }
}
