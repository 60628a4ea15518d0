//! What an estimator tells of.

use super::super::measurement::{Aid, Report, Unusable};
use super::super::prediction::{ImuFault, ResetCause};
use crate::frames::{Body, Vector};
use crate::imu::Suspicion;
use crate::ins::Alignment;
use crate::time::Time;

/// Something worth telling that came of an event.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Notice {
    /// Alignment ended; the first solution is there.
    Aligned(Alignment),
    /// The heading, unknown at the start or hidden by a gap in the samples, is found.
    HeadingFound {
        /// When.
        time: Time,
        /// Turn from the heading at which the search started to the one found, clockwise, rad: see
        /// [`HeadingSearch::turned_start`](crate::ekf::HeadingSearch::turned_start).
        turn_rad: f64,
        /// One-sigma of the heading, rad.
        sigma_rad: f64,
    },
    /// The heading was wrong, by what the fixes say, and was replaced. The unit's own heading or the
    /// magnetometer that led there is not used until it agrees again.
    HeadingReset {
        /// When.
        time: Time,
        /// By how much it was turned, clockwise, rad.
        turn_rad: f64,
        /// One-sigma of the heading from now on, rad.
        sigma_rad: f64,
    },
    /// The heading is further off than its one-sigma allows, by what the fixes say: it is less sure now, and
    /// so is what gives it.
    HeadingDoubted {
        /// When.
        time: Time,
        /// By how much it would have to turn, clockwise, rad.
        off_rad: f64,
        /// One-sigma of that, rad.
        sigma_rad: f64,
    },
    /// The magnetic field has come off what is usual, in strength, dip or direction: a current or iron is nearby.
    /// What gives the heading by it is less sure until the field is back.
    FieldDisturbed {
        /// When.
        time: Time,
        /// By which share of its strength.
        share: f64,
        /// One-sigma of what this makes of the heading that it gives, rad.
        sigma_rad: f64,
        /// Whether it was told before, and has stood so for so long that either field may be the Earth's: the heading
        /// itself is less sure from now on.
        lasts: bool,
    },
    /// The magnetic field is what is usual again.
    FieldUsual {
        /// When.
        time: Time,
        /// Whether it has not come back, but stood elsewhere for so long that this is the usual now.
        changed: bool,
    },
    /// The antenna does not stand where its lever arm says, by what turns show; from now on it is taken to stand where
    /// it was found. Told again when that has become far surer.
    AntennaElsewhere {
        /// When.
        time: Time,
        /// From where the lever arm says to where it was found, level parts alone, m.
        offset_m: Vector<Body>,
        /// One-sigma of each part, m.
        sigma_m: f64,
    },
    /// The vehicle rolls on wheels, by what fixes have shown: where they are absent it is held to move neither to the
    /// side nor up from its road. Of layouts with [`WHEELS`](crate::ekf::layout::Layout::WHEELS) alone.
    OnWheels {
        /// When.
        time: Time,
        /// One-sigma of its velocity across, m/s.
        sigma_mps: f64,
    },
    /// It does not, or no longer: it is not held to a road.
    OffWheels {
        /// When.
        time: Time,
    },
    /// Alignment has everything but a heading, and waits for one: nothing gives it, and this
    /// estimator has no search for it.
    HeadingMissing {
        /// When.
        time: Time,
    },
    /// A measurement was compared: accepted, refused or reopened, axis by axis.
    Updated(Report),
    /// A measurement could not be compared at all. An aid that the configuration leaves out is not
    /// told of.
    NotUsed {
        /// When the measurement was true.
        time: Time,
        /// What was measured.
        aid: Aid,
        /// Why it was not used: see [`Unusable::is_fault`].
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
        /// Why.
        cause: ResetCause,
    },
    /// Inertial samples begin to stand at full scale, or to shake far beyond what is usual: they are
    /// used with the uncertainty that this leaves, and under a blow the force is held at what it was before. Told once until a second has passed without.
    SampleSuspect {
        /// The sample's time.
        time: Time,
        /// What is known against it.
        suspicion: Suspicion,
    },
    /// An inertial sample was refused.
    SampleRefused {
        /// The sample's time.
        time: Time,
        /// Why.
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

    /// Of a measurement whose `report` lies where it was written.
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
