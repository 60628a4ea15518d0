//! Sensors of the caller: a function of the caller compares their readings.

use core::ffi::c_void;

use hovernav::ekf::{
    Aid, Expected as CoreExpected, Measurement, Notice as CoreNotice, Row as CoreRow, Rows,
};
use hovernav::frames::{Body, Vector};
use hovernav::time::Time;

use crate::access::{input, object, optional};
use crate::notices::Notice;
use crate::object::Hovernav;
use crate::status::Status;

/// Motion of a sensor at the time of a reading, as predicted by the filter.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Expected {
    /// Time of the reading, ns.
    pub time_ns: i64,
    /// Geodetic latitude of the sensor, WGS-84, degrees, north positive.
    pub latitude_deg: f64,
    /// Longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// Velocity of the sensor over ground north, east, down, m/s.
    pub velocity_ned_mps: [f64; 3],
    /// Velocity of the sensor over ground in body axes, m/s.
    pub velocity_body_mps: [f64; 3],
    /// Attitude as a quaternion w, x, y, z that turns body axes into north, east, down.
    pub body_to_ned: [f64; 4],
    /// Angular rate p, q, r relative to inertial space, body axes, rad/s.
    pub angular_rate_radps: [f64; 3],
}

/// Largest number of rows, one per measured quantity, for one reading of a sensor of the caller.
pub const HOVERNAV_ROWS: usize = 6;

/// One measured quantity in any unit: its residual, and the derivatives of the expected value with respect to the
/// motion of the sensor. All numbers are finite: residual and sigma at most 1e9, derivatives at most 1e6, sigma at
/// least 1e-9.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Row {
    /// Measured value minus expected value.
    pub residual: f64,
    /// One-sigma of the measurement's white error.
    pub sigma: f64,
    /// Derivative of the expected value with respect to the position north, east, down, per m.
    pub by_position: [f64; 3],
    /// Derivative of the expected value with respect to the velocity north, east, down, per m/s.
    pub by_velocity: [f64; 3],
    /// Derivative of the expected value with respect to a small rotation of the body about north, east, down, per rad.
    pub by_attitude: [f64; 3],
    /// Derivative of the expected value with respect to the velocity in body axes, per m/s. It replaces `by_velocity`
    /// and `by_attitude`, or adds to them.
    pub by_velocity_body: [f64; 3],
    /// Derivative of the expected value with respect to the angular rate about the body axes, per rad/s.
    pub by_angular_rate: [f64; 3],
}

/// Function of the caller that compares a reading with the expected motion. It writes one row for each measured
/// quantity to `rows` and returns the number of rows, or 0 to reject the reading. `rows` has room for HOVERNAV_ROWS
/// rows and is zero before the call. The function must not use the object. `context` is the field of HovernavOwnSensor.
pub type Compare = Option<
    unsafe extern "C" fn(expected: *const Expected, rows: *mut Row, context: *mut c_void) -> u32,
>;

/// A sensor of the caller.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct OwnSensor {
    /// Function that compares a reading; must not be null.
    pub compare: Compare,
    /// Pointer passed to `compare`, for example to the reading; may be null.
    pub context: *mut c_void,
    /// Position of the sensor relative to the reference point of the lever arms, body axes, m.
    pub lever_arm_m: [f64; 3],
}

impl From<&CoreExpected> for Expected {
    fn from(core: &CoreExpected) -> Self {
        let [x, y, z, w] = core.body_to_ned.quaternion().to_array();
        Self {
            time_ns: core.time.nanoseconds(),
            latitude_deg: core.position.latitude_deg(),
            longitude_deg: core.position.longitude_deg(),
            height_m: core.position.height_m,
            velocity_ned_mps: core.velocity_mps.to_array(),
            velocity_body_mps: core.velocity_body_mps().to_array(),
            body_to_ned: [w, x, y, z],
            angular_rate_radps: core.angular_rate_radps.to_array(),
        }
    }
}

impl Row {
    fn core(&self, expected: &CoreExpected) -> CoreRow {
        let row = CoreRow::new(self.residual, self.sigma)
            .with_velocity_body(expected, self.by_velocity_body.into());
        row.with_velocity(row.velocity + self.by_velocity.into())
            .with_attitude(row.attitude + self.by_attitude.into())
            .with_position(self.by_position.into())
            .with_angular_rate(self.by_angular_rate.into())
    }
}

/// A sensor of the caller whose function is not null.
struct Callable {
    compare: unsafe extern "C" fn(*const Expected, *mut Row, *mut c_void) -> u32,
    context: *mut c_void,
    lever_arm_m: Vector<Body>,
}

impl Measurement for Callable {
    fn compare(&self, expected: &CoreExpected, rows: &mut Rows) {
        let motion = Expected::from(expected);
        let mut written = [Row::default(); HOVERNAV_ROWS];
        // SAFETY: the caller of hovernav_measure guarantees a function for a motion, room for the rows and the context.
        let count =
            unsafe { (self.compare)(&raw const motion, written.as_mut_ptr(), self.context) };
        if count as usize > HOVERNAV_ROWS {
            // A residual of NaN makes the filter reject the reading and report the reason.
            rows.push(CoreRow::new(f64::NAN, 1.0));
        }
        for row in written.iter().take(count as usize) {
            rows.push(row.core(expected));
        }
    }

    fn lever_arm_m(&self) -> Vector<Body> {
        self.lever_arm_m
    }
}

/// Fuses a reading of the caller's own sensor, valid at `time_ns`: up to 0.5 s before the last inertial sample, and up
/// to 0.1 s after it. Calls `sensor->compare` once, if the reading can be compared. All its rows are accepted or
/// rejected together; a rejected reading never resets the filter.
///
/// The outcome is written to `notice`, which may be null, and is not stored for hovernav_next_notice():
/// HOVERNAV_NOTICE_KIND_UPDATED, or HOVERNAV_NOTICE_KIND_NOT_USED with its reason.
///
/// # Safety
/// Pointers follow the rules of the crate; `sensor->compare` is a function that follows the rules of HovernavCompare.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_measure(
    nav: *mut Hovernav,
    time_ns: i64,
    sensor: *const OwnSensor,
    notice: *mut Notice,
) -> Status {
    let time = Time::from_nanoseconds(time_ns);
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let sensor = unsafe { input(sensor) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { optional(notice) };
    Status::of(nav.and_then(|nav| {
        let (OwnSensor { compare, context, lever_arm_m }, slot) = (sensor?, slot?);
        let compare = compare.ok_or(Status::NullPointer)?;
        let reading = Callable { compare, context, lever_arm_m: lever_arm_m.into() };
        let notice = match nav.flight.measure(&reading, time) {
            Ok(report) => CoreNotice::Updated(report),
            Err(reason) => CoreNotice::NotUsed { time, aid: Aid::Own, reason },
        };
        if let Some(slot) = slot {
            slot.write(Notice::from(&notice));
        }
        Ok(())
    }))
}
