//! Kind of a finding.

use std::fmt;

use hovernav::dmu::PlausibilityFault;
use hovernav::ekf::{ImuFault, Notice, ResetCause};
use hovernav::sensors::SensorOutput;
use serde::{Serialize, Serializer};

/// Kind of a finding. `docs/warnings.md` lists when each is a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FindingKind {
    /// No fix for longer than usual.
    Outage,
    /// An aid's readings pause, end early or begin late.
    ReadingsAbsent,
    /// The filter rejected readings that differ from its prediction.
    Rejected,
    /// The filter rejected readings until it was reset to them.
    ResetToReadings,
    /// Successive fixes are inconsistent with any motion.
    ContradictsItself,
    /// Positions of fixes drift from the receiver's own velocity.
    PositionDrift,
    /// After a gap in the inertial samples, the filter was reset to the measured attitude or heading.
    ResetAfterGap,
    /// The receiver states one-sigmas that are smaller than the scatter of its fixes.
    Understated,
    /// Fixes repeat the previous one.
    FrozenFix,
    /// A barometer repeats its height while the vehicle's height changes.
    BarometerFrozen,
    /// Heights of fixes repeat while the position moves, or were never measured.
    HeightHeld,
    /// Fixes without a velocity, or without its vertical part.
    VelocityAbsent,
    /// Fixes before the first inertial sample.
    FixesTooEarly,
    /// Fixes are valid at other times than their time stamps and the declared latency.
    TimeOffset,
    /// The clocks of samples and fixes run at different rates.
    ClockRate,
    /// The antenna is not at its declared lever arm.
    LeverArm,
    /// The vehicle rolls on wheels.
    OnWheels,
    /// Inertial samples are missing over one span.
    Gap,
    /// Single inertial samples are missing throughout.
    SamplesLost,
    /// The filter was reset or aligned again.
    Reset,
    /// The inertial unit repeats the readings of all axes, or a rangefinder its distance.
    Stuck,
    /// Single axes of the inertial unit repeat their readings.
    StuckAxis,
    /// Inertial samples that are not finite, or beyond what inertial units measure.
    NotANumber,
    /// Inertial samples on a straight line: a logger interpolated them.
    Interpolated,
    /// Inertial samples whose times do not increase, or are far ahead.
    TimeStamps,
    /// An axis reached the end of its range.
    Clipping,
    /// A shock far beyond the usual vibration.
    Shock,
    /// Vibration that is too fast for the sample rate, with its strength.
    Vibration,
    /// Sudden change of a bias of the inertial unit.
    BiasStep,
    /// The magnetic field is not the Earth's alone.
    MagneticDisturbance,
    /// Single magnetic readings that differ from those before and after.
    Spikes,
    /// The attitude of the inertial unit turns differently from its gyros.
    AttitudeUnlikeGyros,
    /// The heading was unknown, then found in motion.
    HeadingFound,
    /// The heading was inconsistent with GPS and was turned to agree.
    HeadingReset,
    /// The heading was suspect according to GPS, but was not turned.
    HeadingSuspect,
    /// The heading was never found in the run.
    HeadingUnknown,
    /// The distance to the ground jumped.
    StepOfGround,
    /// The measured distance between the two antennas differs from the mounted one.
    WrongBaseline,
    /// A heading of two antennas that points backwards.
    Reversed,
    /// Readings that could not be compared: not finite, too old, ahead of the inertial samples, or a magnetic field
    /// without a horizontal part.
    Unusable,
    /// The reference or the onboard estimator contradicts the solution.
    Contradicted,
    /// The fixes are inconsistent with the smoothed path, so the filter's own solution replaces it.
    SmoothingRejected,
    // Keep this one last: the length of `ALL` depends on it.
    /// The set-up is wrong, or likely wrong.
    SetUp,
}

impl FindingKind {
    /// All kinds, in the order of their declaration.
    pub const ALL: [Self; Self::SetUp as usize + 1] = [
        Self::Outage,
        Self::ReadingsAbsent,
        Self::Rejected,
        Self::ResetToReadings,
        Self::ContradictsItself,
        Self::PositionDrift,
        Self::ResetAfterGap,
        Self::Understated,
        Self::FrozenFix,
        Self::BarometerFrozen,
        Self::HeightHeld,
        Self::VelocityAbsent,
        Self::FixesTooEarly,
        Self::TimeOffset,
        Self::ClockRate,
        Self::LeverArm,
        Self::OnWheels,
        Self::Gap,
        Self::SamplesLost,
        Self::Reset,
        Self::Stuck,
        Self::StuckAxis,
        Self::NotANumber,
        Self::Interpolated,
        Self::TimeStamps,
        Self::Clipping,
        Self::Shock,
        Self::Vibration,
        Self::BiasStep,
        Self::MagneticDisturbance,
        Self::Spikes,
        Self::AttitudeUnlikeGyros,
        Self::HeadingFound,
        Self::HeadingReset,
        Self::HeadingSuspect,
        Self::HeadingUnknown,
        Self::StepOfGround,
        Self::WrongBaseline,
        Self::Reversed,
        Self::Unusable,
        Self::Contradicted,
        Self::SmoothingRejected,
        Self::SetUp,
    ];

    /// Kind of a notice of the estimator; `None` for an ordinary update and an alignment.
    #[must_use]
    pub fn of_notice(notice: &Notice) -> Option<Self> {
        Some(match notice {
            Notice::Updated(report) if report.any_reset() => Self::ResetToReadings,
            Notice::Updated(report) if report.contradicts_itself() => Self::ContradictsItself,
            Notice::Updated(report) if report.any_rejected() => Self::Rejected,
            Notice::Updated(report) if report.position_drift_m().is_some() => Self::PositionDrift,
            Notice::SetupSuspect { .. } => Self::SetUp,
            Notice::HeadingFound { .. } => Self::HeadingFound,
            Notice::HeadingReset { .. } => Self::HeadingReset,
            Notice::HeadingSuspect { .. } => Self::HeadingSuspect,
            Notice::HeadingMissing { .. } => Self::HeadingUnknown,
            Notice::MagneticFieldDisturbed { .. } | Notice::MagneticFieldUsual { .. } => {
                Self::MagneticDisturbance
            }
            Notice::AntennaOffsetFound { .. } => Self::LeverArm,
            Notice::WheelConstraintOn { .. } | Notice::WheelConstraintOff { .. } => Self::OnWheels,
            Notice::NotUsed { .. } => Self::Unusable,
            Notice::GapBridged { .. }
            | Notice::CovarianceReset { cause: ResetCause::LongGap { .. }, .. } => Self::Gap,
            Notice::CovarianceReset { .. } => Self::Reset,
            Notice::SampleSuspect { suspicion, .. } if suspicion.clipped.any() => Self::Clipping,
            Notice::SampleSuspect { suspicion, .. } if suspicion.stuck.any() => Self::StuckAxis,
            Notice::SampleSuspect { .. } => Self::Shock,
            Notice::SampleRejected { fault, .. } => match fault {
                ImuFault::Stuck => Self::Stuck,
                ImuFault::NotFinite => Self::NotANumber,
                ImuFault::Interpolated => Self::Interpolated,
                _ => Self::TimeStamps,
            },
            _ => return None,
        })
    }

    /// Kind of a report of a sensor's driver; `None` for an ordinary packet or fix.
    #[must_use]
    pub fn of_sensor(output: &SensorOutput) -> Option<Self> {
        Some(match output {
            SensorOutput::DmuLost(..) => Self::Gap,
            SensorOutput::DmuImplausible(_, fault) => match fault {
                PlausibilityFault::Stuck { .. } => Self::Stuck,
                PlausibilityFault::Saturated { .. } | PlausibilityFault::BeyondRating { .. } => {
                    Self::Clipping
                }
                _ => Self::NotANumber,
            },
            SensorOutput::DmuClockFault(..) => Self::TimeStamps,
            SensorOutput::Fix(_, failures) if !failures.is_empty() => Self::Rejected,
            SensorOutput::FixWithoutHeight(_) => Self::Unusable,
            _ => return None,
        })
    }

    /// Name in `summary.json` and in sentences. Programs depend on it: it never changes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Outage => "outage",
            Self::ReadingsAbsent => "readings absent",
            Self::Rejected => "refused",
            Self::ResetToReadings => "filter reopened",
            Self::ContradictsItself => "contradicts itself",
            Self::PositionDrift => "place walks",
            Self::ResetAfterGap => "taken anew",
            Self::Understated => "understated",
            Self::FrozenFix => "frozen fix",
            Self::BarometerFrozen => "frozen",
            Self::HeightHeld => "height held",
            Self::VelocityAbsent => "velocity absent",
            Self::FixesTooEarly => "fixes too early",
            Self::TimeOffset => "time offset",
            Self::ClockRate => "clock rate",
            Self::LeverArm => "lever arm",
            Self::OnWheels => "on wheels",
            Self::Gap => "gap",
            Self::SamplesLost => "samples lost",
            Self::Reset => "reset",
            Self::Stuck => "stuck",
            Self::StuckAxis => "stuck axis",
            Self::NotANumber => "not a number",
            Self::Interpolated => "interpolated",
            Self::TimeStamps => "time stamps",
            Self::Clipping => "clipping",
            Self::Shock => "shock",
            Self::Vibration => "vibration",
            Self::BiasStep => "bias step",
            Self::MagneticDisturbance => "magnetic disturbance",
            Self::Spikes => "spikes",
            Self::AttitudeUnlikeGyros => "attitude unlike the gyros",
            Self::HeadingFound => "heading found",
            Self::HeadingReset => "heading reset",
            Self::HeadingSuspect => "heading in doubt",
            Self::HeadingUnknown => "heading unknown",
            Self::StepOfGround => "step of the ground",
            Self::WrongBaseline => "wrong baseline",
            Self::Reversed => "reversed",
            Self::Unusable => "unusable",
            Self::Contradicted => "solution contradicted",
            Self::SmoothingRejected => "smoothing denied",
            Self::SetUp => "set-up",
        }
    }
}

impl fmt::Display for FindingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for FindingKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
