//! The outcome of a measurement.

use core::error::Error;
use core::fmt;

use super::innovation::{Innovation, Verdict};
use crate::time::Time;

/// The outcome for the axes of one measurement, in the order in which they were fused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    axes: [Option<Innovation>; 6],
    pub(in crate::ekf) covariance_reset: bool,
    pub(in crate::ekf) biases_opened: bool,
    pub(in crate::ekf) contradicts: bool,
    pub(in crate::ekf) position_drift_m: f32,
}

impl Report {
    /// The innovations, each with its verdict. Each innovation is computed after the update with the earlier axes. The
    /// innovations are therefore uncorrelated: the sum of their normalised squares is that of the whole fix.
    pub fn innovations(&self) -> impl Iterator<Item = &Innovation> {
        self.axes.iter().flatten()
    }

    /// Time of validity of the measurement; `None` without innovations.
    #[must_use]
    pub fn time(&self) -> Option<Time> {
        self.innovations().next().map(|axis| axis.time)
    }

    /// Whether any axis corrected the state.
    #[must_use]
    pub fn any_accepted(&self) -> bool {
        self.innovations().any(|axis| axis.verdict != Verdict::Rejected)
    }

    /// Whether any axis was rejected.
    #[must_use]
    pub fn any_rejected(&self) -> bool {
        self.innovations().any(|axis| axis.verdict == Verdict::Rejected)
    }

    /// Whether the filter was reset to the measurement in any axis.
    #[must_use]
    pub fn any_reset(&self) -> bool {
        self.innovations().any(|axis| axis.verdict == Verdict::Reset)
    }

    /// Whether the correction would have led to an invalid state or covariance. Then the correction was not applied and
    /// the covariance was reset: see [`ResetCause`](crate::ekf::ResetCause).
    #[must_use]
    pub const fn covariance_was_reset(&self) -> bool {
        self.covariance_reset
    }

    /// Whether the filter raised the variance of the inertial biases at this fix. The recent innovations indicated a
    /// step of a bias.
    #[must_use]
    pub const fn bias_variance_was_raised(&self) -> bool {
        self.biases_opened
    }

    /// Drift, m, of the positions of fixes away from their own velocity; `None` without a drift.
    ///
    /// # Source
    /// Equation (K25) of docs/equations.md.
    #[must_use]
    pub fn position_drift_m(&self) -> Option<f64> {
        (self.position_drift_m > 0.0).then_some(f64::from(self.position_drift_m))
    }

    /// Whether the fix was rejected because the receiver contradicts itself: no motion explains its last readings.
    ///
    /// # Source
    /// Equation (K15) of docs/equations.md.
    #[must_use]
    pub const fn contradicts_itself(&self) -> bool {
        self.contradicts
    }

    /// Notes that the filter was reset to this measurement, with the innovations `off`.
    pub(in crate::ekf) fn was_fused(&mut self, off: impl IntoIterator<Item = f64>) {
        for (axis, off) in self.axes.iter_mut().flatten().zip(off) {
            (axis.innovation, axis.verdict) = (off, Verdict::Reset);
        }
    }

    pub(in crate::ekf) fn push(&mut self, innovation: Innovation) {
        if let Some(slot) = self.axes.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(innovation);
        }
    }
}

/// Reason why a measurement could not be compared at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unusable {
    /// A value is NaN, infinite or impossible, the position is invalid, or the baseline of two antennas is nearly
    /// vertical.
    NotFinite,
    /// Older than the filter's history.
    TooOld,
    /// Too far ahead of the inertial samples; the limit depends on the sensor, 0.1 to 10 s.
    AheadOfImu,
    /// The same position and velocity as the previous fix during motion: the receiver repeats itself.
    Repeated,
    /// Too soon after the last used reading: the noise of the reference hides any difference.
    TooSoon,
    /// The layout has no state for this sensor.
    NoState,
    /// The estimator has not aligned yet: there is no motion to compare with.
    NotAligned,
    /// The heading is unknown: its search continues, with fixes alone.
    HeadingUnknown,
    /// A distance outside the rangefinder's range, or one that the sensor itself marks as invalid.
    OutOfRange,
    /// The beam of the rangefinder points too far away from straight down.
    TooTilted,
    /// The same distance bit for bit although the vehicle has moved: the rangefinder repeats itself.
    Stuck,
    /// Two antennas further apart, or closer, than mounted: the receiver's carrier-phase ambiguity is wrong.
    WrongBaseline,
    /// A heading of two antennas that points the opposite way, as with the antennas exchanged.
    BaselineReversed,
    /// An attitude that does not turn with the gyros: frozen, late, smoothed, or disturbed by accelerations.
    InconsistentWithGyros,
    /// A single reading of the magnetic field that differs from the usual: a spike, or the start of a disturbance.
    Outlier,
    /// A magnetic field with hardly a horizontal part, or without strength: it determines no heading.
    HorizontalFieldTooWeak,
    /// After a gap, roll and pitch are still too uncertain to level a magnetic field.
    NotLevelled,
    /// A repeated reading of the barometer: a logger writes more often than the barometer measures.
    RepeatedReading,
}

impl Unusable {
    /// Whether the reason is a fault. A reading that comes too soon, or before heading, roll and pitch are known, is
    /// not a fault. Neither is a reading beyond a rangefinder's range, without a state in the filter, or repeated by a
    /// logger.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        !matches!(
            self,
            Self::TooSoon
                | Self::NoState
                | Self::NotAligned
                | Self::HeadingUnknown
                | Self::OutOfRange
                | Self::TooTilted
                | Self::NotLevelled
                | Self::RepeatedReading
        )
    }
}

/// Sensors in addition to the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Aid {
    /// GPS position and velocity.
    Gps,
    /// The inertial unit's own attitude.
    Attitude,
    /// The magnetometer.
    Magnetometer,
    /// The barometer.
    Baro,
    /// The rangefinder that looks at the ground.
    Rangefinder,
    /// The second antenna of the GPS.
    SecondAntenna,
    /// A user's own sensor, a [`Measurement`](crate::ekf::Measurement).
    Own,
}

impl fmt::Display for Aid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gps => "fix",
            Self::Attitude => "attitude",
            Self::Magnetometer => "magnetic field",
            Self::Baro => "barometric height",
            Self::Rangefinder => "distance to the ground",
            Self::SecondAntenna => "heading of two antennas",
            Self::Own => "own sensor",
        })
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "not finite, or an impossible value",
            Self::TooOld => "older than the filter's history",
            Self::Repeated => "a repeated fix although the vehicle moves",
            Self::AheadOfImu => "ahead of the inertial samples",
            Self::TooSoon => "too soon after the previous one",
            Self::NoState => "the filter has no state for it",
            Self::NotAligned => "the estimator has not aligned yet",
            Self::HeadingUnknown => "the heading is still unknown",
            Self::OutOfRange => "outside the sensor's range, or marked invalid",
            Self::TooTilted => "the beam points away from the ground",
            Self::Stuck => "a repeated distance although the vehicle moves",
            Self::WrongBaseline => "the baseline differs from the mounted one",
            Self::BaselineReversed => "points backwards: are the antennas exchanged?",
            Self::InconsistentWithGyros => "it turns unlike the gyros",
            Self::Outlier => "differs from the other readings",
            Self::HorizontalFieldTooWeak => {
                "a field without a horizontal part, so without a heading"
            }
            Self::NotLevelled => "roll and pitch are still unknown after a gap",
            Self::RepeatedReading => "a repeated reading",
        })
    }
}

impl Error for Unusable {}
