//! Notices of the estimator, stored until the caller reads them.

use hovernav::ekf::{
    Aid as CoreAid, Channel as CoreChannel, ImuFault, Innovation as CoreInnovation,
    Notice as CoreNotice, ResetCause, Unusable, Verdict as CoreVerdict,
};
use hovernav::time::Time;

use crate::access::{object, output};
use crate::object::Hovernav;
use crate::setup::SetupFault;
use crate::status::Status;

/// Kind of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum NoticeKind {
    /// Alignment ended; the first solution is available. `sigma`: one-sigma of its heading, rad.
    Aligned = 0,
    /// The estimator has found the heading, which was unknown at the start. `sigma`: one-sigma of the heading, rad.
    HeadingFound = 1,
    /// The heading was wrong and was replaced. `value`: change of the heading, rad; `sigma`: one-sigma of the new
    /// heading, rad.
    HeadingReset = 2,
    /// Alignment is complete except for a heading.
    HeadingMissing = 3,
    /// The filter compared a measurement with the estimate, axis by axis: see `axes`.
    Updated = 4,
    /// The filter did not use a measurement: see `aid` and `reason`.
    NotUsed = 5,
    /// An inertial sample ended a gap, which the estimator bridged. `value`: length of the gap, s.
    GapBridged = 6,
    /// The covariance was reset. `value`: the length of the gap that caused it, s, else 0.
    CovarianceReset = 7,
    /// Inertial samples start to saturate, or their vibration is far above its usual level.
    SampleSuspect = 8,
    /// An inertial sample was rejected: see `reason`.
    SampleRefused = 9,
    /// The heading error exceeds its one-sigma, which was increased. `value`: heading correction indicated by the
    /// fixes, rad; `sigma`: one-sigma of the correction, rad.
    HeadingDoubted = 10,
    /// An event unknown to this header.
    Other = 11,
    /// The magnetic field differs from its usual value: a current or iron is nearby. `value`: difference as a fraction
    /// of the field's strength; `sigma`: one-sigma of the resulting error of the magnetic heading, rad.
    FieldDisturbed = 12,
    /// The magnetic field is at its usual value again. `value`: 0 if the field returned, 1 if it stayed changed and
    /// became the new usual value.
    FieldUsual = 13,
    /// The position of the antenna differs from the configured lever arm; the estimator uses the estimated position
    /// instead. `value`: distance between the two positions, m; `sigma`: one-sigma of each horizontal component, m.
    AntennaElsewhere = 14,
    /// The vehicle rolls on wheels: without fixes its velocity across the road is constrained. `sigma`: one-sigma of
    /// this velocity, m/s. Only with the feature `height-aids`.
    OnWheels = 15,
    /// The vehicle no longer rolls on wheels: the constraint of its velocity across the road has ended.
    OffWheels = 16,
    /// The first samples or fixes show a likely mistake in units, signs or axes; the solution cannot be trusted.
    /// `value`: a HovernavSetupFault, whose text is hovernav_setup_fault_text(); `sigma`: the mean specific force,
    /// m/s^2, the turn reported by the gyros in half a second, rad, or the unit of the velocity, m/s; else 0.
    SetupSuspect = 17,
}

/// Sources of measurements besides the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Aid {
    /// The notice does not concern a source of measurements.
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
    /// A sensor of the caller: hovernav_measure().
    Own = 7,
}

/// Reason why a measurement or a sample was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum UnusedReason {
    /// The measurement or sample was used.
    None = 0,
    /// A value is not finite, or beyond the measurable range.
    NotFinite = 1,
    /// The measurement is older than the filter's history.
    TooOld = 2,
    /// The measurement is later than the inertial samples.
    AheadOfImu = 3,
    /// The reading repeats the previous one, although the vehicle moves.
    Repeated = 4,
    /// The measurement is too soon after the previous one to add information at its noise; no fault.
    TooSoon = 5,
    /// The filter has no state for the measurement; no fault.
    NoState = 6,
    /// The heading is still unknown; no fault.
    HeadingUnknown = 7,
    /// A sample that is not later than the previous one.
    NotLater = 8,
    /// A sample equal to the previous one to the bit, or an unchanged distance although the vehicle moves: the sensor
    /// does not measure.
    Stuck = 9,
    /// A reason unknown to this header.
    Other = 10,
    /// A distance out of the rangefinder's range, or marked as invalid by the sensor; no fault.
    OutOfRange = 11,
    /// The beam of the rangefinder points away from the ground; no fault.
    TooTilted = 12,
    /// The measured baseline is longer or shorter than the mounted baseline.
    WrongBaseline = 13,
    /// A heading of two antennas that points in the opposite direction.
    Reversed = 14,
    /// A sample that a logger interpolated linearly between others.
    Interpolated = 15,
    /// An attitude whose change differs from the turn measured by the gyros.
    TurnsOtherwise = 16,
    /// A single reading of the magnetic field that differs from the earlier readings.
    Outlier = 17,
    /// A magnetic field whose horizontal component is too small: vertical or zero.
    FieldTooSteep = 18,
    /// Roll and pitch after a gap are not yet accurate enough to level the magnetic field; no fault.
    NotLevelled = 19,
    /// The barometer repeated its previous reading; no fault.
    NothingNew = 20,
    /// The estimator has not aligned yet; no fault.
    NotAligned = 21,
}

/// Quantity compared in one axis of an update.
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
    /// Velocity of a vehicle on wheels across its road, to the right, m/s.
    WheelsRight = 18,
    /// Velocity of a vehicle on wheels normal to its road, down, m/s.
    WheelsDown = 19,
    /// A row of a sensor of the caller, in the unit of the row.
    Own = 20,
}

/// Outcome of one axis of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Verdict {
    /// The axis corrected the state.
    Accepted = 0,
    /// The innovation is outside the gate; the state is unchanged.
    Rejected = 1,
    /// Accepted after a lockout: the filter was reset to the measurement.
    Reopened = 2,
}

/// One axis of an update.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Innovation {
    /// The quantity compared.
    pub channel: Channel,
    /// The outcome.
    pub verdict: Verdict,
    /// Measured minus predicted, in the channel's unit.
    pub innovation: f64,
    /// Predicted one-sigma of the innovation, in the channel's unit.
    pub sigma: f64,
}

/// Largest number of axes in one update.
pub const HOVERNAV_AXES: usize = 6;

/// A notice of the estimator.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Notice {
    /// Kind of the notice; it determines which other fields count.
    pub kind: NoticeKind,
    /// Source of the measurement.
    pub aid: Aid,
    /// Reason why the measurement or sample was not used.
    pub reason: UnusedReason,
    /// Number of valid entries in `axes`.
    pub axis_count: u32,
    /// Time of the event, ns.
    pub time_ns: i64,
    /// Number whose meaning depends on the kind: see HovernavNoticeKind.
    pub value: f64,
    /// Number whose meaning depends on the kind: see HovernavNoticeKind.
    pub sigma: f64,
    /// The axes of an update, in the order of their processing.
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
        CoreChannel::Own(_) => Channel::Own,
    }
}

const fn axis(core: &CoreInnovation) -> Innovation {
    Innovation {
        channel: channel(core.channel),
        verdict: match core.verdict {
            CoreVerdict::Accepted => Verdict::Accepted,
            CoreVerdict::Rejected => Verdict::Rejected,
            CoreVerdict::Reset => Verdict::Reopened,
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
        CoreAid::Own => Aid::Own,
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
        Unusable::BaselineReversed => UnusedReason::Reversed,
        Unusable::InconsistentWithGyros => UnusedReason::TurnsOtherwise,
        Unusable::Outlier => UnusedReason::Outlier,
        Unusable::HorizontalFieldTooWeak => UnusedReason::FieldTooSteep,
        Unusable::NotLevelled => UnusedReason::NotLevelled,
        Unusable::RepeatedReading => UnusedReason::NothingNew,
        Unusable::TooSoon => UnusedReason::TooSoon,
        Unusable::NoState => UnusedReason::NoState,
        Unusable::NotAligned => UnusedReason::NotAligned,
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
            CoreNotice::SetupSuspect { time, ref fault } => {
                let (fault, sigma) = SetupFault::of(fault);
                let value = f64::from(fault as u32);
                Self { value, sigma, ..Self::at(NoticeKind::SetupSuspect, time) }
            }
            CoreNotice::HeadingFound { time, sigma_rad, .. } => {
                Self { sigma: sigma_rad, ..Self::at(NoticeKind::HeadingFound, time) }
            }
            CoreNotice::HeadingReset { time, turn_rad, sigma_rad } => Self {
                value: turn_rad,
                sigma: sigma_rad,
                ..Self::at(NoticeKind::HeadingReset, time)
            },
            CoreNotice::HeadingSuspect { time, off_rad, sigma_rad } => Self {
                value: off_rad,
                sigma: sigma_rad,
                ..Self::at(NoticeKind::HeadingDoubted, time)
            },
            CoreNotice::MagneticFieldDisturbed { time, share, sigma_rad, .. } => Self {
                value: share,
                sigma: sigma_rad,
                ..Self::at(NoticeKind::FieldDisturbed, time)
            },
            CoreNotice::AntennaOffsetFound { time, offset_m, sigma_m } => Self {
                value: offset_m.norm(),
                sigma: sigma_m,
                ..Self::at(NoticeKind::AntennaElsewhere, time)
            },
            CoreNotice::WheelConstraintOn { time, sigma_mps } => {
                Self { sigma: sigma_mps, ..Self::at(NoticeKind::OnWheels, time) }
            }
            CoreNotice::WheelConstraintOff { time } => Self::at(NoticeKind::OffWheels, time),
            CoreNotice::MagneticFieldUsual { time, changed } => Self {
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
            CoreNotice::SampleRejected { time, fault: why } => {
                Self { reason: fault(why), ..Self::at(NoticeKind::SampleRefused, time) }
            }
            _ => Self::at(NoticeKind::Other, Time::ZERO),
        }
    }
}

/// Gives the oldest unread notice and removes it; HOVERNAV_STATUS_NOT_YET when all are read. The queue stores twelve
/// notices, more than one measurement can cause. After each push call it until it returns HOVERNAV_STATUS_NOT_YET.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_next_notice(nav: *mut Hovernav, notice: *mut Notice) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(notice) };
    Status::of(nav.and_then(|nav| {
        let slot = slot?;
        let notice = nav.flight.notices.pop().ok_or(Status::NotYet)?;
        slot.write(Notice::from(&notice));
        Ok(())
    }))
}

/// Gives the number of unread notices that newer notices overwrote.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_lost_notices(nav: *mut Hovernav, lost: *mut u32) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(lost) };
    Status::of(nav.and_then(|nav| {
        slot?.write(nav.flight.notices.lost());
        Ok(())
    }))
}
