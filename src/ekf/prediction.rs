//! What a sample of the inertial unit did to the filter.

use core::error::Error;
use core::fmt;

/// What a sample of the inertial unit did to the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Prediction {
    /// State and covariance were advanced by one step.
    Stepped,
    /// The interval before the sample is longer than the configured gap: it was integrated as one
    /// step, and the covariance opened by the motion it may have hidden.
    BridgedGap {
        /// Length of the interval, s.
        length_s: f64,
    },
    /// The covariance was reset; the state goes on from where it was, at the time of the sample.
    Reset(ResetCause),
}

/// Why the covariance was reset: attitude, velocity and position are opened so wide that the next
/// fixes decide; biases keep their estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ResetCause {
    /// The interval before the sample is longer than a minute, too long to be bridged.
    LongGap {
        /// Length of the interval, s.
        length_s: f64,
    },
    /// The step would have led to where NED does not exist, or beyond 10 km/s; it was not taken.
    Diverged,
    /// The attitude was wrong, by what the fixes say of the force that the unit felt: it was aligned anew.
    Misaligned {
        /// By how much what the body takes for up was off, rad.
        off_rad: f64,
    },
}

/// Why a sample of the inertial unit was refused; it changed nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImuFault {
    /// A component is NaN, infinite or beyond what units measure.
    NotFinite,
    /// Not later than the sample before.
    NotLater,
    /// Every reading the same as before, in a unit that vibrates: it was not measuring.
    Stuck,
    /// Every reading on the straight line of those before, in a unit that vibrates: a logger made it up where samples
    /// were missing.
    Interpolated,
}

impl fmt::Display for Prediction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stepped => f.write_str("one step"),
            Self::BridgedGap { length_s } => write!(f, "none for {length_s:.3} s: bridged"),
            Self::Reset(cause) => cause.fmt(f),
        }
    }
}

impl fmt::Display for ResetCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LongGap { length_s } => write!(f, "none for {length_s:.3} s: covariance reset"),
            Self::Diverged => f.write_str("it would lead off the Earth: covariance reset"),
            Self::Misaligned { off_rad } => {
                write!(f, "{:.0}° off upright by the fixes: aligned anew", off_rad.to_degrees())
            }
        }
    }
}

impl fmt::Display for ImuFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "not finite: passed over",
            Self::NotLater => "not later than the sample before: passed over",
            Self::Stuck => "the same readings as before: passed over",
            Self::Interpolated => "made up between others, on a straight line: passed over",
        })
    }
}

impl Error for ImuFault {}
