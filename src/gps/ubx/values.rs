//! Checks the values of the messages and converts them to values of a fix.

use super::message::{CalendarTime, Position, Pvt, known_dilution};
use crate::frames::{Ned, Vector};
use crate::gps::receiver_fix::{Horizontal, known_sigma, plausible_height, plausible_velocity};
use crate::gps::receiver_time::days_since_1970;
use crate::gps::{Correction, ReceiverFix, ReceiverTime};
use crate::time::Time;

/// An impossible value.
pub(super) struct Impossible;

/// The fix of a NAV-PVT whose status reports a fix.
pub(super) fn pvt_fix(pvt: &Pvt, arrival: Time) -> Result<ReceiverFix, Impossible> {
    let Position { latitude_deg, longitude_deg, .. } = pvt.position;
    let mut fix = ReceiverFix::new(arrival, horizontal(latitude_deg, longitude_deg)?);
    fix.time = pvt_time(pvt);
    set_heights(&mut fix, &pvt.position)?;
    let [north, east, down] = plausible_velocity(pvt.velocity.ned_mps).ok_or(Impossible)?;
    fix.set_horizontal_velocity(north, east);
    fix.down_velocity_mps = Some(down);
    fix.velocity_sigma_mps = on_all_axes(pvt.velocity.sigma_mps);
    fix.satellites = Some(pvt.satellites);
    fix.dilution.position = known_dilution(pvt.position_dilution);
    fix.dimension = pvt.status.dimension();
    fix.correction = Some(match pvt.status {
        status if status.is_rtk_fixed() => Correction::RtkFixed,
        status if status.is_rtk_float() => Correction::RtkFloat,
        status if status.is_differential() => Correction::Differential,
        _ => Correction::None,
    });
    Ok(fix)
}

/// Sets both heights and the one-sigma of position.
pub(super) fn set_heights(fix: &mut ReceiverFix, position: &Position) -> Result<(), Impossible> {
    fix.height_m = Some(height(position.height_m)?);
    fix.altitude_msl_m = Some(height(position.altitude_msl_m)?);
    let (across, up) = (position.horizontal_sigma_m, position.vertical_sigma_m);
    fix.position_sigma_m = known_sigma(Vector::new(across, across, up));
    Ok(())
}

/// GPS time of a NAV-PVT, which has no week: the week follows from its date.
fn pvt_time(pvt: &Pvt) -> Option<ReceiverTime> {
    let time_of_week_ns = u64::from(pvt.time_of_week_ms) * 1_000_000;
    day_and_time_ns(&pvt.utc)
        .and_then(|(day, time_ns)| {
            ReceiverTime::from_week_time_and_utc(time_of_week_ns, day, time_ns)
        })
        .or_else(|| gps_time(None, pvt.time_of_week_ms, 0, None))
}

/// Day since the start of 1970 and nanoseconds since its midnight, in UTC; `None` where the receiver marks it as
/// invalid or it is impossible.
fn day_and_time_ns(utc: &CalendarTime) -> Option<(i32, i64)> {
    let CalendarTime { year, month, day, hour, minute, second, nanosecond, is_valid } = *utc;
    if !is_valid || hour >= 24 || minute >= 60 || second >= 60 {
        return None;
    }
    let day = days_since_1970(year.into(), month.into(), day.into())?;
    let seconds = u32::from(hour) * 3_600 + u32::from(minute) * 60 + u32::from(second);
    Some((day, i64::from(seconds) * 1_000_000_000 + i64::from(nanosecond)))
}

pub(super) fn gps_time(
    week: Option<i16>,
    time_of_week_ms: u32,
    fraction_ns: i32,
    leap_seconds: Option<i8>,
) -> Option<ReceiverTime> {
    let leap_seconds = leap_seconds.and_then(|leap| u8::try_from(leap).ok());
    Some(ReceiverTime::of_gps(week, time_of_week_ms, fraction_ns, leap_seconds))
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
