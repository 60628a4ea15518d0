//! The messages' values, checked and turned into a fix's.

use chrono::{NaiveDate, NaiveTime};
use ublox::GnssFixType;
use ublox::nav_dop::NavDopRef;
use ublox::nav_pvt::common::{NavPvtFlags, NavPvtValidFlags};
use ublox::nav_pvt::proto23::NavPvtRef;

use crate::frames::{Ned, Vector};
use crate::gps::receiver_fix::{Horizontal, known_sigma, plausible_height, plausible_velocity};
use crate::gps::{Correction, DilutionOfPrecision, Dimension, ReceiverFix, ReceiverTime};
use crate::time::Time;

/// A value that cannot be.
pub(super) struct Impossible;

/// The fix of a NAV-PVT that claims to be one.
pub(super) fn whole(pvt: &NavPvtRef<'_>, arrival: Time) -> Result<ReceiverFix, Impossible> {
    let mut fix = ReceiverFix::new(arrival, horizontal(pvt.latitude(), pvt.longitude())?);
    fix.time = pvt_time(pvt);
    fix.height_m = Some(height(pvt.height_above_ellipsoid())?);
    fix.altitude_msl_m = Some(height(pvt.height_msl())?);
    let (across, up) = (pvt.horizontal_accuracy(), pvt.vertical_accuracy());
    fix.position_sigma_m = known_sigma(Vector::new(across, across, up));
    let ned = [pvt.vel_north(), pvt.vel_east(), pvt.vel_down()];
    let [north, east, down] = plausible_velocity(ned).ok_or(Impossible)?;
    fix.set_horizontal_velocity(north, east);
    fix.down_velocity_mps = Some(down);
    fix.velocity_sigma_mps = on_all_axes(pvt.speed_accuracy());
    fix.satellites = Some(pvt.num_satellites());
    fix.dilution.position = dilution(pvt.pdop());
    fix.dimension = dimension(pvt.fix_type());
    fix.correction = Some(match pvt.flags() {
        flags if flags.contains(NavPvtFlags::CARR_SOLN_FIXED) => Correction::RtkFixed,
        flags if flags.contains(NavPvtFlags::CARR_SOLN_FLOAT) => Correction::RtkFloat,
        flags if flags.contains(NavPvtFlags::DIFF_SOLN) => Correction::Differential,
        _ => Correction::None,
    });
    Ok(fix)
}

/// The week, which NAV-PVT does not give, from its date.
fn pvt_time(pvt: &NavPvtRef<'_>) -> Option<ReceiverTime> {
    let time_of_week_ns = u64::from(pvt.itow()) * 1_000_000;
    let known = NavPvtValidFlags::VALID_DATE | NavPvtValidFlags::VALID_TIME;
    let utc = || {
        let date =
            NaiveDate::from_ymd_opt(pvt.year().into(), pvt.month().into(), pvt.day().into())?;
        let time = NaiveTime::from_hms_opt(pvt.hour().into(), pvt.min().into(), pvt.sec().into())?;
        let seconds = date.and_time(time).and_utc().timestamp();
        seconds.checked_mul(1_000_000_000)?.checked_add(pvt.nanosec().into())
    };
    Some(pvt.valid())
        .filter(|valid| valid.contains(known))
        .and_then(|_| utc())
        .and_then(|utc_ns| ReceiverTime::from_week_time_and_utc(time_of_week_ns, utc_ns))
        .or_else(|| gps_time(None, pvt.itow(), 0, None))
}

pub(super) fn gps_time(
    week: Option<i16>,
    time_of_week_ms: u32,
    fraction_ns: i32,
    leap_seconds: Option<i8>,
) -> Option<ReceiverTime> {
    const WEEK_NS: i64 = 604_800_000_000_000;
    let time_of_week_ns = i64::from(time_of_week_ms) * 1_000_000 + i64::from(fraction_ns);
    // The fraction may reach back across the week's start.
    let week = week.map(|week| i64::from(week) + time_of_week_ns.div_euclid(WEEK_NS));
    Some(ReceiverTime::Gps {
        week: week.and_then(|week| u16::try_from(week).ok()),
        time_of_week_ns: u64::try_from(time_of_week_ns.rem_euclid(WEEK_NS)).ok()?,
        leap_seconds: leap_seconds.and_then(|leap| u8::try_from(leap).ok()),
    })
}

pub(super) fn is_usable(fix_type: GnssFixType, good: bool) -> bool {
    good && dimension(fix_type).is_some()
}

pub(super) fn dimension(fix_type: GnssFixType) -> Option<Dimension> {
    match fix_type {
        GnssFixType::Fix2D => Some(Dimension::TwoD),
        GnssFixType::Fix3D | GnssFixType::GPSPlusDeadReckoning => Some(Dimension::ThreeD),
        _ => None,
    }
}

pub(super) fn horizontal(latitude_deg: f64, longitude_deg: f64) -> Result<Horizontal, Impossible> {
    let possible = libm::fabs(longitude_deg) <= 180.0;
    Horizontal::new(latitude_deg.to_radians(), longitude_deg.to_radians())
        .filter(|_| possible)
        .ok_or(Impossible)
}

pub(super) fn height(height_m: f64) -> Result<f64, Impossible> {
    plausible_height(height_m).ok_or(Impossible)
}

pub(super) fn on_all_axes(sigma: f64) -> Option<Vector<Ned>> {
    known_sigma(Vector::new(sigma, sigma, sigma))
}

pub(super) fn dilutions(dilutions: &NavDopRef<'_>) -> DilutionOfPrecision {
    DilutionOfPrecision {
        position: dilution(dilutions.position_dop()),
        horizontal: dilution(dilutions.horizontal_dop()),
        vertical: dilution(dilutions.vertical_dop()),
    }
}

/// A dilution; 99.99 stands for none.
pub(super) fn dilution(value: impl Into<f64>) -> Option<f64> {
    Some(value.into()).filter(|value| *value > 0.0 && *value < 99.9)
}
