//! Measurements of a rangefinder and of a second antenna.

use hovernav::event::{Event, RangeReading};
use hovernav::gps::AntennaHeading;
use hovernav::time::Time;

use crate::access::object;
use crate::object::Hovernav;
use crate::status::Status;

fn known(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// Passes a distance to the ground, m, along the beam of the rangefinder to the estimator. The distance is valid at
/// `time_ns`, and `sigma_m` is its one-sigma, m. `quality` is the sensor's quality figure, from 0 (invalid) to 1.
/// `sigma_m` or `quality` is NaN if the sensor does not report it.
///
/// HOVERNAV_STATUS_NOT_BUILT if the library was built without height-aids.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_range(
    nav: *mut Hovernav,
    time_ns: i64,
    range_m: f64,
    sigma_m: f64,
    quality: f64,
) -> Status {
    let time = Time::from_nanoseconds(time_ns);
    let reading = RangeReading { time, range_m, sigma_m: known(sigma_m), quality: known(quality) };
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    Status::of(nav.and_then(|nav| nav.flight.push_height(&Event::Range(reading))))
}

/// Passes the heading of two GPS antennas to the estimator. The heading is the direction from the first antenna to the
/// second, clockwise from true north, rad, valid at `time_ns`. `sigma_rad` is its one-sigma, rad, and `length_m` is the
/// measured length of the baseline, m. `sigma_rad` or `length_m` is NaN if the receiver does not report it.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_antenna_heading(
    nav: *mut Hovernav,
    time_ns: i64,
    heading_rad: f64,
    sigma_rad: f64,
    length_m: f64,
) -> Status {
    let time = Time::from_nanoseconds(time_ns);
    let heading = AntennaHeading::new(time, heading_rad, known(sigma_rad));
    let heading = AntennaHeading { length_m: known(length_m), ..heading };
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    Status::of(nav.map(|nav| nav.flight.push(&Event::AntennaHeading(heading))))
}
