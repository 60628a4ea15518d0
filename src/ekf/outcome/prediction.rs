//! The effect of an inertial sample on the filter.

use core::error::Error;
use core::fmt;

/// The effect of an inertial sample on the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Prediction {
    /// State and covariance were advanced by one sample interval.
    Stepped,
    /// The interval before the sample is longer than the configured gap. The state coasted over it, and the covariance
    /// was widened by the motion that the gap may have hidden.
    BridgedGap {
        /// Length of the interval, s.
        length_s: f64,
    },
    /// The covariance was reset; the state continues unchanged at the time of the sample.
    Reset(ResetCause),
}

/// Cause of a reset of the covariance. The variances of attitude, velocity and position become so large that the next
/// fixes determine these states; biases keep their estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ResetCause {
    /// The interval before the sample is longer than a minute, too long to be bridged.
    LongGap {
        /// Length of the interval, s.
        length_s: f64,
    },
    /// The mechanization step would have led to a position without NED axes, or to a speed beyond 10 km/s; it was
    /// skipped.
    Diverged,
    /// The attitude was inconsistent with the specific force according to the fixes, and was aligned again.
    Misaligned {
        /// Error of the up direction, rad.
        off_rad: f64,
    },
}

/// Reason why an inertial sample was rejected. The sample changed neither estimates nor covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImuFault {
    /// A component is NaN, infinite or beyond the range of inertial units.
    NotFinite,
    /// Not later than the previous sample.
    NotLater,
    /// More than a minute after the previous sample, and no other sample with such a time came right before it.
    FarAhead,
    /// All readings are the same as before, in an inertial unit that vibrates: it did not measure.
    Stuck,
    /// All readings lie on the straight line of the previous ones, in an inertial unit that vibrates: a logger
    /// interpolated missing samples.
    Interpolated,
}

impl fmt::Display for ResetCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LongGap { length_s } => {
                write!(f, "no samples for {length_s:.3} s: covariance reset")
            }
            Self::Diverged => f.write_str("impossible position or velocity: covariance reset"),
            Self::Misaligned { off_rad } => {
                write!(f, "{:.0}° off according to the fixes: aligned again", off_rad.to_degrees())
            }
        }
    }
}

impl fmt::Display for ImuFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "not finite, or impossibly large",
            Self::NotLater => "not later than the previous sample",
            Self::FarAhead => {
                "more than a minute after the previous sample, without another one to confirm it"
            }
            Self::Stuck => "identical to the previous sample, so not measured",
            Self::Interpolated => "on a straight line with other samples, so not measured",
        })
    }
}

impl Error for ImuFault {}
