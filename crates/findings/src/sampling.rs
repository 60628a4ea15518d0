//! Sample rates that inertial navigation requires.

use hovernav::imu::Motion;

/// Required sample rates, by the form of the samples.
///
/// # Example
/// ```
/// use hovernav_findings::SampleRates;
///
/// assert!(SampleRates::INCREMENTS.least_hz < SampleRates::RATES.least_hz);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRates {
    /// Rate below which a log is rejected, Hz.
    pub least_hz: f64,
    /// Rate below which the solution is poor and a warning is given, Hz.
    pub poor_hz: f64,
}

impl SampleRates {
    /// Required rates for angular rates and specific forces, which lose the motion between two samples. A small
    /// helicopter rolls and pitches at up to 3 Hz. Six samples a cycle integrate that motion with an error of a tenth.
    /// So every second sample of a 33 Hz inertial unit is too few. Eight samples a cycle give a twentieth, which is the
    /// 25 Hz of slow autopilot logs with a fast clock.
    pub const RATES: Self = Self { least_hz: 18.0, poor_hz: 24.0 };
    /// Required rates for increments of angle and velocity, which contain all motion since the previous sample, except
    /// coning and sculling. One sample may be lost: two and a half samples fit within the filter's gap limit of a
    /// quarter of a second.
    pub const INCREMENTS: Self = Self { least_hz: 10.0, poor_hz: 24.0 };

    /// Required rates for samples in the form of `motion`.
    #[must_use]
    pub const fn of(motion: &Motion) -> Self {
        match motion {
            Motion::Rates { .. } => Self::RATES,
            Motion::Increments { .. } => Self::INCREMENTS,
        }
    }
}
