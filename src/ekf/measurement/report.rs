//! What became of a measurement.

use core::error::Error;
use core::fmt;

use super::super::innovation::{Innovation, Verdict};

/// What happened to the axes of one measurement, in the order they were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    axes: [Option<Innovation>; 6],
    pub(super) covariance_reset: bool,
    pub(super) biases_doubted: bool,
    pub(super) contradicts: bool,
    pub(super) walked_m: f32,
}

impl Report {
    /// The innovations, each with its verdict. Each is what was left after the axes before it, so
    /// they are uncorrelated, and their normalised squares add up to the fix's own.
    pub fn innovations(&self) -> impl Iterator<Item = &Innovation> {
        self.axes.iter().flatten()
    }

    /// Whether any axis corrected the state.
    #[must_use]
    pub fn any_accepted(&self) -> bool {
        self.innovations().any(|axis| axis.verdict != Verdict::Rejected)
    }

    /// Whether any axis was refused.
    #[must_use]
    pub fn any_rejected(&self) -> bool {
        self.innovations().any(|axis| axis.verdict == Verdict::Rejected)
    }

    /// Whether the filter had to be reopened for any axis.
    #[must_use]
    pub fn any_reopened(&self) -> bool {
        self.innovations().any(|axis| axis.verdict == Verdict::Reopened)
    }

    /// Whether the correction would have led to an invalid state or covariance, so that it was not
    /// applied and the covariance was reset: see [`ResetCause`](crate::ekf::ResetCause).
    #[must_use]
    pub const fn covariance_was_reset(&self) -> bool {
        self.covariance_reset
    }

    /// Whether the fixes of the last seconds lean to one side, so that the biases of the inertial unit may have
    /// stepped and were opened.
    #[must_use]
    pub const fn biases_were_doubted(&self) -> bool {
        self.biases_doubted
    }

    /// How far, m, the places of fixes have walked away from the velocity that they tell; `None` where they do not.
    ///
    /// # Source
    /// Equation (K25) of docs/equations.md.
    #[must_use]
    pub fn walked_m(&self) -> Option<f64> {
        (self.walked_m > 0.0).then_some(f64::from(self.walked_m))
    }

    /// Whether it was rejected because the receiver contradicts itself: no motion explains its last readings.
    ///
    /// # Source
    /// Equation (K15) of docs/equations.md.
    #[must_use]
    pub const fn contradicts_itself(&self) -> bool {
        self.contradicts
    }

    /// Notes that the filter was opened for it, each axis by as much as it was `off`.
    pub(super) fn was_taken(&mut self, off: impl IntoIterator<Item = f64>) {
        for (axis, off) in self.axes.iter_mut().flatten().zip(off) {
            (axis.innovation, axis.verdict) = (off, Verdict::Reopened);
        }
    }

    pub(super) fn push(&mut self, innovation: Innovation) {
        if let Some(slot) = self.axes.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(innovation);
        }
    }
}

/// Why a measurement could not be compared at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unusable {
    /// A value is NaN or infinite, or the place is none.
    NotFinite,
    /// Older than the filter's history.
    TooOld,
    /// Later than the inertial samples by more than two of their intervals.
    AheadOfImu,
    /// The same place and velocity as the fix before, though moving: the receiver repeats itself.
    Repeated,
    /// Sooner after the last use than the reference's own noise allows to be worth anything.
    TooSoon,
    /// The layout has no state for it.
    NoState,
    /// The heading is still searched for, with nothing but fixes.
    HeadingUnknown,
    /// A distance outside what the rangefinder can measure, or one that the sensor itself does not vouch for.
    OutOfRange,
    /// The beam of the rangefinder leads too far away from straight down.
    TooTilted,
    /// The same distance to the last bit, though the vehicle has moved: the rangefinder repeats itself.
    Stuck,
    /// Two antennas further apart, or closer, than they are mounted: a wrong ambiguity.
    WrongBaseline,
    /// A heading of two antennas that points the other way, as with the antennas exchanged.
    Reversed,
    /// An attitude that turns otherwise than the gyros: frozen, late, smoothed, or led astray by accelerations.
    TurnsOtherwise,
    /// A magnetic field off what it was in this one reading alone so far: a spike, or the first of a disturbance.
    Outlier,
    /// A magnetic field with hardly a level part, vertical or none at all: it tells no heading.
    FieldTooSteep,
    /// After a gap roll and pitch are not yet known well enough to level a magnetic field.
    NotLevelled,
    /// The barometer's reading before again: a logger writes more often than the barometer measures.
    NothingNew,
}

impl Unusable {
    /// Whether it says that something is wrong. A reading that comes too soon, before there is a
    /// heading or a level, from out of a rangefinder's reach, for which the filter has no state, or that a logger has
    /// written twice, is left out by design.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        match self {
            Self::NotFinite | Self::TooOld | Self::AheadOfImu | Self::Repeated => true,
            Self::Stuck | Self::WrongBaseline | Self::Reversed | Self::TurnsOtherwise => true,
            Self::Outlier | Self::FieldTooSteep => true,
            Self::TooSoon | Self::NoState | Self::HeadingUnknown => false,
            Self::OutOfRange | Self::TooTilted | Self::NotLevelled | Self::NothingNew => false,
        }
    }
}

/// What measures beside the inertial unit.
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
        })
    }
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "no place, or not finite",
            Self::TooOld => "older than the filter's memory",
            Self::Repeated => "the fix before again, though moving",
            Self::AheadOfImu => "ahead of the inertial samples",
            Self::TooSoon => "too soon after the last to be worth anything",
            Self::NoState => "the filter has no state for it",
            Self::HeadingUnknown => "the heading is still searched for",
            Self::OutOfRange => "out of the sensor's reach, or not valid",
            Self::TooTilted => "the beam leads away from the ground",
            Self::Stuck => "the same distance again, though moving",
            Self::WrongBaseline => "the antennas are not so far apart",
            Self::Reversed => "the other way round, as with antennas exchanged",
            Self::TurnsOtherwise => "it turns otherwise than the gyros",
            Self::Outlier => "off what the others are",
            Self::FieldTooSteep => "a field without a level part tells no heading",
            Self::NotLevelled => "roll and pitch are not known yet after a gap",
            Self::NothingNew => "the reading before again",
        })
    }
}

impl Error for Unusable {}
