//! Notices: events that an estimator reports.

use crate::ekf::outcome::prediction::{ImuFault, ResetCause};
use crate::ekf::outcome::report::{Aid, Report, Unusable};
use crate::frames::{Body, Vector};
use crate::imu::Suspicion;
use crate::ins::Alignment;
use crate::setup::SetupFault;
use crate::time::Time;

/// An event that the estimator reports.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Notice {
    /// Alignment ended; the first solution is available.
    Aligned(Alignment),
    /// A heading was found that was unknown at the start or hidden by a gap in the samples.
    HeadingFound {
        /// Time of the event.
        time: Time,
        /// Turn from the heading at which the search started to the one found, clockwise, rad: see
        /// [`HeadingSearch::turned_start`](crate::ekf::HeadingSearch::turned_start).
        turn_rad: f64,
        /// One-sigma of the heading, rad.
        sigma_rad: f64,
    },
    /// The first samples or fixes show a likely mistake in units, signs or axes. The estimator continues; its solution
    /// cannot be trusted.
    SetupSuspect {
        /// Time of the event.
        time: Time,
        /// The likely mistake.
        fault: SetupFault,
    },
    /// The heading was inconsistent with the fixes, and was replaced. The sensor that caused it, the inertial unit's
    /// own heading or the magnetometer, is not used until it agrees again.
    HeadingReset {
        /// Time of the event.
        time: Time,
        /// Change of the heading, clockwise, rad.
        turn_rad: f64,
        /// One-sigma of the heading from now on, rad.
        sigma_rad: f64,
    },
    /// The filter's heading differs from the heading that the fixes show by more than its one-sigma allows. The
    /// one-sigmas of the filter's heading and of the heading sensor are enlarged.
    HeadingSuspect {
        /// Time of the event.
        time: Time,
        /// Difference, clockwise, rad: the turn that would correct the heading.
        off_rad: f64,
        /// One-sigma of that difference, rad.
        sigma_rad: f64,
    },
    /// The magnetic field differs from the usual one in strength, dip or direction: a current or iron is nearby.
    /// Magnetic headings are less accurate until the field returns.
    MagneticFieldDisturbed {
        /// Time of the event.
        time: Time,
        /// Change, as a fraction of the field's strength.
        share: f64,
        /// One-sigma of the resulting heading error, rad.
        sigma_rad: f64,
        /// Whether a disturbance reported before still lasts. The usual or the present field may then be the Earth's.
        /// From now on the filter's own heading is less certain too.
        lasts: bool,
    },
    /// The magnetic field is as usual again.
    MagneticFieldUsual {
        /// Time of the event.
        time: Time,
        /// Whether the field did not return: the changed field has been constant for long enough to become the usual
        /// one.
        changed: bool,
    },
    /// Turns show that the antenna is not at its lever arm. From now on the filter uses the estimated position. The
    /// notice repeats when the estimate has become far more certain.
    AntennaOffsetFound {
        /// Time of the event.
        time: Time,
        /// From the configured to the estimated position of the antenna, horizontal components only, m.
        offset_m: Vector<Body>,
        /// One-sigma of each component, m.
        sigma_m: f64,
    },
    /// The vehicle rolls on wheels, as declared or as the fixes show. While fixes are absent, the filter holds its
    /// sideways and upward velocity relative to the road at zero. Only for layouts with
    /// [`WHEELS`](crate::ekf::layout::Layout::WHEELS).
    WheelConstraintOn {
        /// Time of the event.
        time: Time,
        /// One-sigma of the velocity across the direction of travel, m/s.
        sigma_mps: f64,
    },
    /// The vehicle does not roll on wheels: the filter does not constrain its motion to a road.
    WheelConstraintOff {
        /// Time of the event.
        time: Time,
    },
    /// Alignment waits for a heading only: no sensor gives one, and this estimator has no heading search.
    HeadingMissing {
        /// Time of the event.
        time: Time,
    },
    /// A measurement was compared: accepted, rejected, or used for a reset of the filter, axis by axis.
    Updated(Report),
    /// A measurement could not be compared at all. Aids that the configuration switches off are not reported.
    NotUsed {
        /// The measurement's time of validity.
        time: Time,
        /// The kind of measurement.
        aid: Aid,
        /// The reason: see [`Unusable::is_fault`].
        reason: Unusable,
    },
    /// An inertial sample ended a gap, which was bridged.
    GapBridged {
        /// The sample's time.
        time: Time,
        /// Length of the gap, s.
        length_s: f64,
    },
    /// An inertial sample led to a reset of the covariance.
    CovarianceReset {
        /// The sample's time.
        time: Time,
        /// The cause.
        cause: ResetCause,
    },
    /// Inertial samples reach full scale, or vibrate far beyond the usual. They are used with a larger uncertainty;
    /// during a shock the specific force is held at its last value. The notice repeats only after a second without
    /// suspect samples.
    SampleSuspect {
        /// The sample's time.
        time: Time,
        /// Suspected faults of the sample.
        suspicion: Suspicion,
    },
    /// An inertial sample was rejected.
    SampleRejected {
        /// The sample's time.
        time: Time,
        /// The cause.
        fault: ImuFault,
    },
}

impl Notice {
    pub(super) fn of_update(time: Time, aid: Aid, result: Result<Report, Unusable>) -> Self {
        match result {
            Ok(report) => Self::Updated(report),
            Err(reason) => Self::NotUsed { time, aid, reason },
        }
    }

    /// [`of_update`](Self::of_update), from a report by reference: another copy of it costs a thousand instructions.
    pub(super) fn of_report(
        time: Time,
        aid: Aid,
        result: Result<(), Unusable>,
        report: &Report,
    ) -> Self {
        match result {
            Ok(()) => Self::Updated(*report),
            Err(reason) => Self::NotUsed { time, aid, reason },
        }
    }
}
