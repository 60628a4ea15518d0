//! What kind of thing a finding is.

use std::fmt;

use serde::{Serialize, Serializer};

/// What kind of thing a finding is. When each is a warning stands in `docs/warnings.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FindingKind {
    /// No fix for longer than is usual.
    Outage,
    /// An aid's readings pause, end early or begin late.
    ReadingsAbsent,
    /// The filter refused readings, off what it expected.
    Refused,
    /// The filter refused readings until it gave way and took them.
    FilterReopened,
    /// Successive fixes that no motion explains.
    ContradictsItself,
    /// Places of fixes walk away from the receiver's own velocity.
    PlaceWalks,
    /// An attitude or heading that a gap in the inertial samples had hidden was taken as it came.
    TakenAnew,
    /// The receiver states smaller one-sigmas than its fixes scatter by.
    Understated,
    /// Fixes repeat the one before.
    FrozenFix,
    /// A barometer repeats itself while the height changes.
    Frozen,
    /// Heights of fixes repeat while the position moves, or were never there.
    HeightHeld,
    /// Fixes without a velocity, or without its vertical part.
    VelocityAbsent,
    /// Fixes before the first inertial sample.
    FixesTooEarly,
    /// Fixes hold at other times than their time stamps and the declared latency say.
    TimeOffset,
    /// The clocks of samples and fixes do not run at one rate.
    ClockRate,
    /// The antenna stands elsewhere than its lever arm says.
    LeverArm,
    /// The vehicle rolls on wheels.
    OnWheels,
    /// Inertial samples are missing over one span.
    Gap,
    /// Inertial samples are missing here and there, throughout.
    SamplesLost,
    /// The filter was reset, or aligned anew.
    Reset,
    /// The whole inertial unit, or a rangefinder, repeats its readings.
    Stuck,
    /// Single axes of the inertial unit repeat their readings.
    StuckAxis,
    /// Inertial samples that are not finite, or beyond what units measure.
    NotANumber,
    /// Inertial samples that a logger has drawn along a straight line.
    Interpolated,
    /// Inertial samples no later than the one before.
    TimeStamps,
    /// An axis reached the end of its range.
    Clipping,
    /// A blow far beyond the usual vibration.
    Shock,
    /// How strong the vibration is that the samples cannot follow.
    Vibration,
    /// A bias of the inertial unit changed at once.
    BiasStep,
    /// The magnetic field is not the Earth's alone.
    MagneticDisturbance,
    /// Single readings of a magnetic field off those before and after.
    Spikes,
    /// The unit's own attitude turns otherwise than its gyros.
    AttitudeUnlikeGyros,
    /// The heading was unknown, then found in motion.
    HeadingFound,
    /// The fixes denied the heading, and it was turned to what they say.
    HeadingReset,
    /// The fixes doubted the heading without denying it.
    HeadingInDoubt,
    /// The heading was never found.
    HeadingUnknown,
    /// The distance to the ground jumped.
    StepOfGround,
    /// Two antennas further apart, or closer, than they are mounted.
    WrongBaseline,
    /// A heading of two antennas that points backwards.
    Reversed,
    /// Readings that could not be compared: not finite, too old, ahead of the inertial samples, or a magnetic field
    /// without a level part.
    Unusable,
    /// The fixes deny the smoothed path, and the filter's own solution stands there.
    SmoothingDenied,
    // The last: `ALL` takes its length from it.
    /// What the set-up says cannot be, or hardly.
    SetUp,
}

impl FindingKind {
    /// All of them, in the order of their declaration.
    pub const ALL: [Self; Self::SetUp as usize + 1] = [
        Self::Outage,
        Self::ReadingsAbsent,
        Self::Refused,
        Self::FilterReopened,
        Self::ContradictsItself,
        Self::PlaceWalks,
        Self::TakenAnew,
        Self::Understated,
        Self::FrozenFix,
        Self::Frozen,
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
        Self::HeadingInDoubt,
        Self::HeadingUnknown,
        Self::StepOfGround,
        Self::WrongBaseline,
        Self::Reversed,
        Self::Unusable,
        Self::SmoothingDenied,
        Self::SetUp,
    ];

    /// What it is called, in `summary.json` and in sentences. Programs go by it: it never changes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Outage => "outage",
            Self::ReadingsAbsent => "readings absent",
            Self::Refused => "refused",
            Self::FilterReopened => "filter reopened",
            Self::ContradictsItself => "contradicts itself",
            Self::PlaceWalks => "place walks",
            Self::TakenAnew => "taken anew",
            Self::Understated => "understated",
            Self::FrozenFix => "frozen fix",
            Self::Frozen => "frozen",
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
            Self::HeadingInDoubt => "heading in doubt",
            Self::HeadingUnknown => "heading unknown",
            Self::StepOfGround => "step of the ground",
            Self::WrongBaseline => "wrong baseline",
            Self::Reversed => "reversed",
            Self::Unusable => "unusable",
            Self::SmoothingDenied => "smoothing denied",
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
