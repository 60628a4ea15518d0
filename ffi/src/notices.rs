//! What came of the measurements, kept until the caller asks.

use hovernav::ekf::{
    Aid as CoreAid, Channel as CoreChannel, ImuFault, Innovation as CoreInnovation,
    Notice as CoreNotice, ResetCause, Unusable, Verdict as CoreVerdict,
};
use hovernav::time::Time;

use crate::access::{object, output};
use crate::object::Hovernav;
use crate::status::Status;

/// What a notice tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum NoticeKind {
    /// Alignment ended; the first solution is there. `sigma`: of its heading, rad.
    Aligned = 0,
    /// The heading, unknown at the start, is found. `sigma`: one-sigma of it, rad.
    HeadingFound = 1,
    /// The heading was wrong and was replaced. `value`: the turn, rad; `sigma`: one-sigma, rad.
    HeadingReset = 2,
    /// Alignment lacks nothing but a heading, and waits for one.
    HeadingMissing = 3,
    /// A measurement was compared, axis by axis: see `axes`.
    Updated = 4,
    /// A measurement could not be compared: see `aid` and `reason`.
    NotUsed = 5,
    /// An inertial sample ended a gap, which was bridged. `value`: its length, s.
    GapBridged = 6,
    /// The covariance was reset. `value`: the length of the gap that caused it, s, else 0.
    CovarianceReset = 7,
    /// Inertial samples begin to stand at full scale, or to shake far beyond what is usual.
    SampleSuspect = 8,
    /// An inertial sample was refused: see `reason`.
    SampleRefused = 9,
    /// The heading is further off than its one-sigma allows, and is less sure now. `value`: the turn that
    /// the fixes ask for, rad; `sigma`: its one-sigma, rad.
    HeadingDoubted = 10,
    /// Something that this header does not know.
    Other = 11,
    /// The magnetic field has come off what is usual: a current or iron is nearby. `value`: by which share of its
    /// strength; `sigma`: one-sigma of what this makes of the heading that goes by it, rad.
    FieldDisturbed = 12,
    /// The magnetic field is what is usual again. `value`: 0 where it is back, 1 where it has stayed changed for so long
    /// that this is the usual now.
    FieldUsual = 13,
    /// The antenna does not stand where its lever arm says, and is taken to stand where it was found. `value`: how far
    /// off, m; `sigma`: one-sigma of each level part, m.
    AntennaElsewhere = 14,
    /// The vehicle rolls on wheels: where fixes are absent it is held to its road. `sigma`: one-sigma of its velocity
    /// across, m/s. With the feature `height-aids` alone.
    OnWheels = 15,
    /// It is off its wheels, and not held to a road.
    OffWheels = 16,
}

/// What measures beside the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Aid {
    /// The notice is not of an aid.
    None = 0,
    /// GPS position and velocity.
    Gps = 1,
    /// The inertial unit's own attitude.
    Attitude = 2,
    /// The magnetometer.
    Magnetometer = 3,
    /// The barometer.
    Baro = 4,
    /// The rangefinder.
    Rangefinder = 5,
    /// The second antenna.
    SecondAntenna = 6,
}

/// Why a measurement or a sample was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum UnusedReason {
    /// It was used.
    None = 0,
    /// A value is not finite, or beyond what can be measured.
    NotFinite = 1,
    /// Older than the filter's history.
    TooOld = 2,
    /// Later than the inertial samples.
    AheadOfImu = 3,
    /// The same as before, though moving.
    Repeated = 4,
    /// Sooner than its own noise allows to be worth anything; no fault.
    TooSoon = 5,
    /// The filter has no state for it; no fault.
    NoState = 6,
    /// The heading is still searched for; no fault.
    HeadingUnknown = 7,
    /// A sample not later than the one before.
    NotLater = 8,
    /// A sample that repeats the one before to the bit, or a distance that stays the same though the vehicle
    /// moves: the sensor was not measuring.
    Stuck = 9,
    /// A reason that this header does not know.
    Other = 10,
    /// A distance out of the rangefinder's reach, or that the sensor does not vouch for; no fault.
    OutOfRange = 11,
    /// The beam of the rangefinder leads away from the ground; no fault.
    TooTilted = 12,
    /// Two antennas further apart, or closer, than they are mounted.
    WrongBaseline = 13,
    /// A heading of two antennas that points the other way.
    Reversed = 14,
    /// A sample that a logger has made up between others, on a straight line.
    Interpolated = 15,
    /// An attitude that turns otherwise than the gyros.
    TurnsOtherwise = 16,
    /// A magnetic field off what it was in one reading alone so far.
    Outlier = 17,
    /// A magnetic field with hardly a level part, vertical or none at all.
    FieldTooSteep = 18,
    /// After a gap roll and pitch are not yet known well enough to level a magnetic field; no fault.
    NotLevelled = 19,
    /// The barometer's reading before again; no fault.
    NothingNew = 20,
}

/// What an axis of an update compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Channel {
    /// Antenna position north, m.
    PositionNorth = 0,
    /// Antenna position east, m.
    PositionEast = 1,
    /// Antenna position down, m.
    PositionDown = 2,
    /// Antenna velocity north, m/s.
    VelocityNorth = 3,
    /// Antenna velocity east, m/s.
    VelocityEast = 4,
    /// Antenna velocity down, m/s.
    VelocityDown = 5,
    /// Roll, rad.
    Roll = 6,
    /// Pitch, rad.
    Pitch = 7,
    /// Heading, rad.
    Yaw = 8,
    /// Barometric height, m, up.
    BaroHeight = 9,
    /// Angular rate of a vehicle at rest, forward, rad/s.
    RestRateX = 10,
    /// Angular rate of a vehicle at rest, right, rad/s.
    RestRateY = 11,
    /// Angular rate of a vehicle at rest, down, rad/s.
    RestRateZ = 12,
    /// Velocity of a vehicle at rest, north, m/s.
    RestVelocityNorth = 13,
    /// Velocity of a vehicle at rest, east, m/s.
    RestVelocityEast = 14,
    /// Velocity of a vehicle at rest, down, m/s.
    RestVelocityDown = 15,
    /// Distance to the ground, m.
    Range = 16,
    /// Heading of two antennas, rad.
    BaselineHeading = 17,
    /// Velocity of a vehicle on wheels across its road, right, m/s.
    WheelsRight = 18,
    /// Velocity of a vehicle on wheels up or down from its road, down, m/s.
    WheelsDown = 19,
}

/// What became of an axis of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Verdict {
    /// It corrected the state.
    Accepted = 0,
    /// Outside the gate; the state is untouched.
    Rejected = 1,
    /// The filter had locked itself out and was reopened to take it.
    Reopened = 2,
}

/// One axis of an update.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Innovation {
    /// What was compared.
    pub channel: Channel,
    /// What became of it.
    pub verdict: Verdict,
    /// Measured less predicted, in the channel's unit.
    pub innovation: f64,
    /// Its predicted one-sigma, in the channel's unit.
    pub sigma: f64,
}

/// Most axes of one update.
pub const HOVERNAV_AXES: usize = 6;

/// Something worth telling that came of a measurement.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Notice {
    /// What it tells, and so which of the fields below count.
    pub kind: NoticeKind,
    /// Of which aid.
    pub aid: Aid,
    /// Why it was not used.
    pub reason: UnusedReason,
    /// How many of `axes` there are.
    pub axis_count: u32,
    /// When, ns.
    pub time_ns: i64,
    /// As the kind says.
    pub value: f64,
    /// As the kind says.
    pub sigma: f64,
    /// The axes of an update, in the order they were taken.
    pub axes: [Innovation; HOVERNAV_AXES],
}

const fn channel(channel: CoreChannel) -> Channel {
    match channel {
        CoreChannel::PositionNorth => Channel::PositionNorth,
        CoreChannel::PositionEast => Channel::PositionEast,
        CoreChannel::PositionDown => Channel::PositionDown,
        CoreChannel::VelocityNorth => Channel::VelocityNorth,
        CoreChannel::VelocityEast => Channel::VelocityEast,
        CoreChannel::VelocityDown => Channel::VelocityDown,
        CoreChannel::Roll => Channel::Roll,
        CoreChannel::Pitch => Channel::Pitch,
        CoreChannel::Yaw => Channel::Yaw,
        CoreChannel::BaroHeight => Channel::BaroHeight,
        CoreChannel::Range => Channel::Range,
        CoreChannel::BaselineHeading => Channel::BaselineHeading,
        CoreChannel::RestRateX => Channel::RestRateX,
        CoreChannel::RestRateY => Channel::RestRateY,
        CoreChannel::RestRateZ => Channel::RestRateZ,
        CoreChannel::RestVelocityNorth => Channel::RestVelocityNorth,
        CoreChannel::RestVelocityEast => Channel::RestVelocityEast,
        CoreChannel::RestVelocityDown => Channel::RestVelocityDown,
        CoreChannel::WheelsRight => Channel::WheelsRight,
        CoreChannel::WheelsDown => Channel::WheelsDown,
    }
}

const fn axis(core: &CoreInnovation) -> Innovation {
    Innovation {
        channel: channel(core.channel),
        verdict: match core.verdict {
            CoreVerdict::Accepted => Verdict::Accepted,
            CoreVerdict::Rejected => Verdict::Rejected,
            CoreVerdict::Reopened => Verdict::Reopened,
        },
        innovation: core.innovation,
        sigma: core.sigma,
    }
}

const fn aid(aid: CoreAid) -> Aid {
    match aid {
        CoreAid::Gps => Aid::Gps,
        CoreAid::Attitude => Aid::Attitude,
        CoreAid::Magnetometer => Aid::Magnetometer,
        CoreAid::Baro => Aid::Baro,
        CoreAid::Rangefinder => Aid::Rangefinder,
        CoreAid::SecondAntenna => Aid::SecondAntenna,
        _ => Aid::None,
    }
}

const fn unusable(reason: Unusable) -> UnusedReason {
    match reason {
        Unusable::NotFinite => UnusedReason::NotFinite,
        Unusable::TooOld => UnusedReason::TooOld,
        Unusable::AheadOfImu => UnusedReason::AheadOfImu,
        Unusable::Repeated => UnusedReason::Repeated,
        Unusable::OutOfRange => UnusedReason::OutOfRange,
        Unusable::TooTilted => UnusedReason::TooTilted,
        Unusable::Stuck => UnusedReason::Stuck,
        Unusable::WrongBaseline => UnusedReason::WrongBaseline,
        Unusable::Reversed => UnusedReason::Reversed,
        Unusable::TurnsOtherwise => UnusedReason::TurnsOtherwise,
        Unusable::Outlier => UnusedReason::Outlier,
        Unusable::FieldTooSteep => UnusedReason::FieldTooSteep,
        Unusable::NotLevelled => UnusedReason::NotLevelled,
        Unusable::NothingNew => UnusedReason::NothingNew,
        Unusable::TooSoon => UnusedReason::TooSoon,
        Unusable::NoState => UnusedReason::NoState,
        Unusable::HeadingUnknown => UnusedReason::HeadingUnknown,
        _ => UnusedReason::Other,
    }
}

const fn fault(fault: ImuFault) -> UnusedReason {
    match fault {
        ImuFault::NotFinite => UnusedReason::NotFinite,
        ImuFault::NotLater => UnusedReason::NotLater,
        ImuFault::Stuck => UnusedReason::Stuck,
        ImuFault::Interpolated => UnusedReason::Interpolated,
        _ => UnusedReason::Other,
    }
}

const NO_AXIS: Innovation = Innovation {
    channel: Channel::PositionNorth,
    verdict: Verdict::Rejected,
    innovation: 0.0,
    sigma: 0.0,
};

impl Notice {
    const fn at(kind: NoticeKind, time: Time) -> Self {
        Self {
            kind,
            aid: Aid::None,
            reason: UnusedReason::None,
            axis_count: 0,
            time_ns: time.nanoseconds(),
            value: 0.0,
            sigma: 0.0,
            axes: [NO_AXIS; HOVERNAV_AXES],
        }
    }
}

impl From<&CoreNotice> for Notice {
    fn from(core: &CoreNotice) -> Self {
        match *core {
            CoreNotice::Aligned(ref alignment) => {
                let start = &alignment.start;
                let sigma = start.attitude_sigma_rad.z();
                Self { sigma, ..Self::at(NoticeKind::Aligned, start.state.time) }
            }
            CoreNotice::HeadingFound { time, sigma_rad, .. } => {
                Self { sigma: sigma_rad, ..Self::at(NoticeKind::HeadingFound, time) }
            }
            CoreNotice::HeadingReset { time, turn_rad, sigma_rad } => Self {
                value: turn_rad,
                sigma: sigma_rad,
                ..Self::at(NoticeKind::HeadingReset, time)
            },
            CoreNotice::HeadingDoubted { time, off_rad, sigma_rad } => Self {
                value: off_rad,
                sigma: sigma_rad,
                ..Self::at(NoticeKind::HeadingDoubted, time)
            },
            CoreNotice::FieldDisturbed { time, share, sigma_rad, .. } => Self {
                value: share,
                sigma: sigma_rad,
                ..Self::at(NoticeKind::FieldDisturbed, time)
            },
            CoreNotice::AntennaElsewhere { time, offset_m, sigma_m } => Self {
                value: offset_m.norm(),
                sigma: sigma_m,
                ..Self::at(NoticeKind::AntennaElsewhere, time)
            },
            CoreNotice::OnWheels { time, sigma_mps } => {
                Self { sigma: sigma_mps, ..Self::at(NoticeKind::OnWheels, time) }
            }
            CoreNotice::OffWheels { time } => Self::at(NoticeKind::OffWheels, time),
            CoreNotice::FieldUsual { time, changed } => Self {
                value: f64::from(u8::from(changed)),
                ..Self::at(NoticeKind::FieldUsual, time)
            },
            CoreNotice::HeadingMissing { time } => Self::at(NoticeKind::HeadingMissing, time),
            CoreNotice::Updated(ref report) => {
                let mut notice = Self::at(NoticeKind::Updated, Time::ZERO);
                for (slot, innovation) in notice.axes.iter_mut().zip(report.innovations()) {
                    *slot = axis(innovation);
                    notice.axis_count += 1;
                    notice.time_ns = innovation.time.nanoseconds();
                }
                notice
            }
            CoreNotice::NotUsed { time, aid: core_aid, reason } => Self {
                aid: aid(core_aid),
                reason: unusable(reason),
                ..Self::at(NoticeKind::NotUsed, time)
            },
            CoreNotice::GapBridged { time, length_s } => {
                Self { value: length_s, ..Self::at(NoticeKind::GapBridged, time) }
            }
            CoreNotice::CovarianceReset { time, cause } => {
                let value =
                    if let ResetCause::LongGap { length_s } = cause { length_s } else { 0.0 };
                Self { value, ..Self::at(NoticeKind::CovarianceReset, time) }
            }
            CoreNotice::SampleSuspect { time, .. } => Self::at(NoticeKind::SampleSuspect, time),
            CoreNotice::SampleRefused { time, fault: why } => {
                Self { reason: fault(why), ..Self::at(NoticeKind::SampleRefused, time) }
            }
            _ => Self::at(NoticeKind::Other, Time::ZERO),
        }
    }
}

/// Gives the oldest notice that waits and removes it; HOVERNAV_STATUS_NOT_YET when all are read. Twelve
/// wait at most, more than one measurement can cause: call it after each push until then.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_next_notice(nav: *mut Hovernav, notice: *mut Notice) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let place = unsafe { output(notice) };
    Status::of(nav.and_then(|nav| {
        let place = place?;
        let notice = nav.flight.notices.pop().ok_or(Status::NotYet)?;
        place.write(Notice::from(&notice));
        Ok(())
    }))
}

/// Gives how many notices gave way to newer ones unread.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_lost_notices(nav: *mut Hovernav, lost: *mut u32) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let place = unsafe { output(lost) };
    Status::of(nav.and_then(|nav| {
        place?.write(nav.flight.notices.lost());
        Ok(())
    }))
}
