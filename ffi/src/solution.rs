//! The estimator's solution and covariance in the caller's structures.

use hovernav::ekf::Solution as CoreSolution;
use hovernav::frames::Vector;
use hovernav::scalar::Scalar;

use crate::access::{object, output};
use crate::object::Hovernav;
use crate::status::Status;

/// Position, velocity and attitude at one moment, corrected for biases, with one-sigmas. Position and velocity are
/// those of the reference point of the configured lever arms.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Solution {
    /// Time of the inertial sample of the solution, ns.
    pub time_ns: i64,
    /// Geodetic latitude, WGS-84, degrees, north positive.
    pub latitude_deg: f64,
    /// Longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// Velocity over ground north, east, down, m/s.
    pub velocity_ned_mps: [f64; 3],
    /// Velocity in body axes: u, v, w, m/s.
    pub velocity_body_mps: [f64; 3],
    /// Attitude as a quaternion w, x, y, z that turns body axes into north, east, down.
    pub body_to_ned: [f64; 4],
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Heading, rad, clockwise from true north.
    pub yaw_rad: f64,
    /// Angular rate p, q, r, body axes, rad/s.
    pub angular_rate_radps: [f64; 3],
    /// One-sigma of position north, east, down, m.
    pub position_sigma_m: [f64; 3],
    /// One-sigma of velocity north, east, down, m/s.
    pub velocity_sigma_mps: [f64; 3],
    /// One-sigma of roll, pitch, yaw, rad.
    pub attitude_sigma_rad: [f64; 3],
    /// Gyro bias, body axes, rad/s.
    pub gyro_bias_radps: [f64; 3],
    /// Accelerometer bias, body axes, m/s^2.
    pub accel_bias_mps2: [f64; 3],
    /// One-sigma of the gyro bias, rad/s.
    pub gyro_bias_sigma_radps: [f64; 3],
    /// One-sigma of the accelerometer bias, m/s^2.
    pub accel_bias_sigma_mps2: [f64; 3],
}

impl<T: Scalar> From<&CoreSolution<T>> for Solution {
    /// Converts each number separately: a conversion of the whole solution to `f64` would need one more copy.
    fn from(core: &CoreSolution<T>) -> Self {
        let body_to_ned = core.body_to_ned.cast::<f64>();
        let velocity_mps = core.velocity_mps.cast::<f64>();
        let angles = body_to_ned.euler();
        let [x, y, z, w] = body_to_ned.quaternion().to_array();
        Self {
            time_ns: core.time.nanoseconds(),
            latitude_deg: core.position.latitude_deg(),
            longitude_deg: core.position.longitude_deg(),
            height_m: core.position.height_m,
            velocity_ned_mps: velocity_mps.to_array(),
            velocity_body_mps: (body_to_ned.inverse() * velocity_mps).to_array(),
            body_to_ned: [w, x, y, z],
            roll_rad: angles.roll_rad,
            pitch_rad: angles.pitch_rad,
            yaw_rad: angles.yaw_rad,
            angular_rate_radps: wide(core.angular_rate_radps),
            position_sigma_m: wide(core.position_sigma_m),
            velocity_sigma_mps: wide(core.velocity_sigma_mps),
            attitude_sigma_rad: core.attitude_sigma_rad.map(Scalar::wide),
            gyro_bias_radps: wide(core.gyro_bias_radps),
            accel_bias_mps2: wide(core.accel_bias_mps2),
            gyro_bias_sigma_radps: wide(core.gyro_bias_sigma_radps),
            accel_bias_sigma_mps2: wide(core.accel_bias_sigma_mps2),
        }
    }
}

fn wide<F, T: Scalar>(vector: Vector<F, T>) -> [f64; 3] {
    vector.to_array().map(Scalar::wide)
}

/// Gives the solution at the last inertial sample; HOVERNAV_STATUS_NOT_YET until alignment has ended.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_get_solution(
    nav: *mut Hovernav,
    solution: *mut Solution,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(solution) };
    Status::of(nav.and_then(|nav| {
        let slot = slot?;
        // By reference: the solution is large, and each copy takes time.
        let Some(solution) = &nav.flight.estimator.solution() else { return Err(Status::NotYet) };
        slot.write(Solution::from(solution));
        Ok(())
    }))
}

/// Number of elements in the matrix of hovernav_get_covariance().
pub const HOVERNAV_COVARIANCE: usize = 81;

/// Gives the joint covariance, 9 x 9, row by row, HOVERNAV_COVARIANCE numbers. Its rows are the attitude error (a small
/// rotation, rad), the velocity error (m/s) and the position error (m) of the inertial unit, each north, east, down.
/// HOVERNAV_STATUS_NOT_YET until alignment and a search for the heading, if any, have ended.
///
/// # Safety
/// Pointers follow the rules of the crate; `covariance` points to room for HOVERNAV_COVARIANCE numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_get_covariance(
    nav: *mut Hovernav,
    covariance: *mut f64,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(covariance.cast::<[[f64; 9]; 9]>()) };
    Status::of(nav.and_then(|nav| {
        let slot = slot?;
        let p = nav.flight.estimator.filter().ok_or(Status::NotYet)?.covariance();
        slot.write(core::array::from_fn(|row| core::array::from_fn(|column| p.entry(row, column))));
        Ok(())
    }))
}
