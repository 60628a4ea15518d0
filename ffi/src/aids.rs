//! What a rangefinder and a second antenna say.

use hovernav::event::{Event, RangeReading};
use hovernav::gps::AntennaHeading;
use hovernav::time::Time;

use crate::access::object;
use crate::object::Hovernav;
use crate::status::Status;

fn known(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// Takes in a distance to the ground along the beam of the rangefinder, m, true at `time_ns`. `sigma_m`
/// is its one-sigma, m, and `quality` how good the sensor takes it to be, from 0, not valid, to 1; NaN where it does
/// not tell.
///
/// HOVERNAV_STATUS_NOT_BUILT where the library was built without height-aids.
///
/// # Safety
/// Pointers as the crate's rules say.
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
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    Status::of(nav.and_then(|nav| nav.flight.push_height(&Event::Range(reading))))
}

/// Takes in the heading of two GPS antennas, from the first to the second, clockwise from true north,
/// rad, true at `time_ns`. `sigma_rad` is its one-sigma, rad, and `length_m` the length of the baseline as found, m;
/// NaN where the receiver does not tell.
///
/// # Safety
/// Pointers as the crate's rules say.
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
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    Status::of(nav.map(|nav| nav.flight.push(&Event::AntennaHeading(heading))))
}
