//! Measurements of the sensors: from the caller's structures to events.

use hovernav::earth::Geodetic;
use hovernav::event::{BaroReading, Event, MagneticReading};
use hovernav::frames::{EulerAngles, Vector};
use hovernav::gps::Fix as CoreFix;
use hovernav::imu::{ImuAxes, ImuSample as CoreSample, Motion};
use hovernav::time::Time;

use crate::access::{borrowed, input, object};
use crate::object::Hovernav;
use crate::status::Status;

/// In HovernavImuSample.has: gyro and accel are integrals since the previous sample.
pub const HOVERNAV_IMU_INCREMENTS: u32 = 1;
/// In HovernavImuSample.has: the inertial unit's own attitude is present.
pub const HOVERNAV_IMU_ATTITUDE: u32 = 2;
/// In HovernavImuSample.has: the magnetic field is present.
pub const HOVERNAV_IMU_MAGNETIC_FIELD: u32 = 4;

/// One sample of the inertial unit, body axes forward, right, down.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct ImuSample {
    /// Time of the rates, or end of the increments, ns.
    pub time_ns: i64,
    /// Sum of HOVERNAV_IMU_ flags; 0 for rates only.
    pub has: u32,
    /// Angular rate, rad/s; with HOVERNAV_IMU_INCREMENTS its integral since the previous sample, rad.
    pub gyro: [f64; 3],
    /// Specific force, m/s^2 (level and at rest z is -9.81); with HOVERNAV_IMU_INCREMENTS its integral since the
    /// previous sample, m/s.
    pub accel: [f64; 3],
    /// Roll from the inertial unit's own attitude, rad.
    pub roll_rad: f64,
    /// Pitch from the inertial unit's own attitude, rad.
    pub pitch_rad: f64,
    /// Yaw from the inertial unit's own attitude, rad, clockwise from north.
    pub yaw_rad: f64,
    /// Magnetic field, gauss.
    pub magnetic_field_gauss: [f64; 3],
}

/// In HovernavFix.has: one-sigma of position is present.
pub const HOVERNAV_FIX_POSITION_SIGMA: u32 = 1;
/// In HovernavFix.has: velocity north and east is present.
pub const HOVERNAV_FIX_HORIZONTAL_VELOCITY: u32 = 2;
/// In HovernavFix.has: velocity down is present.
pub const HOVERNAV_FIX_DOWN_VELOCITY: u32 = 4;
/// In HovernavFix.has: one-sigma of velocity is present.
pub const HOVERNAV_FIX_VELOCITY_SIGMA: u32 = 8;
/// In HovernavFix.has: the receiver held or assumed the height, so that neither height nor down velocity counts.
pub const HOVERNAV_FIX_TWO_DIMENSIONAL: u32 = 16;

/// A satellite fix of the antenna. Its time is the time of validity (arrival minus latency), on the clock of the
/// inertial samples.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Fix {
    /// Time of validity, ns.
    pub time_ns: i64,
    /// Sum of HOVERNAV_FIX_ flags; 0 for a position only.
    pub has: u32,
    /// Geodetic latitude, WGS-84, degrees, north positive.
    pub latitude_deg: f64,
    /// Longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Height above the ellipsoid (not above the sea), m.
    pub height_m: f64,
    /// One-sigma of position north, east, down, m; above 0.
    pub position_sigma_m: [f64; 3],
    /// Velocity north, east, down, m/s.
    pub velocity_ned_mps: [f64; 3],
    /// One-sigma of velocity, m/s; above 0.
    pub velocity_sigma_mps: [f64; 3],
}

impl ImuSample {
    fn event(&self) -> Result<Event, Status> {
        const KNOWN: u32 =
            HOVERNAV_IMU_INCREMENTS | HOVERNAV_IMU_ATTITUDE | HOVERNAV_IMU_MAGNETIC_FIELD;
        if self.has & !KNOWN != 0 {
            return Err(Status::UnknownCode);
        }
        let has = |flag: u32| self.has & flag != 0;
        let motion = if has(HOVERNAV_IMU_INCREMENTS) {
            Motion::Increments { angle_rad: self.gyro.into(), velocity_mps: self.accel.into() }
        } else {
            Motion::Rates {
                angular_rate_radps: self.gyro.into(),
                specific_force_mps2: self.accel.into(),
            }
        };
        let Self { roll_rad, pitch_rad, yaw_rad, .. } = *self;
        Ok(Event::Imu(CoreSample {
            time: Time::from_nanoseconds(self.time_ns),
            motion,
            attitude: has(HOVERNAV_IMU_ATTITUDE).then_some(EulerAngles {
                roll_rad,
                pitch_rad,
                yaw_rad,
            }),
            magnetic_field_gauss: has(HOVERNAV_IMU_MAGNETIC_FIELD)
                .then_some(self.magnetic_field_gauss.into()),
            clipped: ImuAxes::NONE,
        }))
    }
}

impl Fix {
    fn event(&self) -> Result<Event, Status> {
        const KNOWN: u32 = 2 * HOVERNAV_FIX_TWO_DIMENSIONAL - 1;
        if self.has & !KNOWN != 0 {
            return Err(Status::UnknownCode);
        }
        let has = |flag: u32| self.has & flag != 0;
        let position = Geodetic::from_degrees(self.latitude_deg, self.longitude_deg, self.height_m)
            .ok_or(Status::OutOfRange)?;
        let [north, east, down] = self.velocity_ned_mps;
        Ok(Event::Gps(CoreFix {
            two_dimensional: has(HOVERNAV_FIX_TWO_DIMENSIONAL),
            position_sigma_m: has(HOVERNAV_FIX_POSITION_SIGMA)
                .then_some(self.position_sigma_m.into()),
            horizontal_velocity_mps: has(HOVERNAV_FIX_HORIZONTAL_VELOCITY).then_some([north, east]),
            down_velocity_mps: has(HOVERNAV_FIX_DOWN_VELOCITY).then_some(down),
            velocity_sigma_mps: has(HOVERNAV_FIX_VELOCITY_SIGMA)
                .then_some(self.velocity_sigma_mps.into()),
            ..CoreFix::at(Time::from_nanoseconds(self.time_ns), position)
        }))
    }
}

/// Passes a sample of the inertial unit to the estimator. A notice reports a sample that the estimator cannot use: not
/// finite, or not later than the previous sample. Notices report all other results too. The estimator bridges a gap of
/// any length. A wrong time far in the future therefore counts as a gap, and every sample up to this time is rejected.
/// In this case hovernav_get_health() reports the estimate as stale, and the object must be created again.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_imu(nav: *mut Hovernav, sample: *const ImuSample) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let sample = unsafe { borrowed(sample) };
    Status::of(nav.and_then(|nav| {
        let event = &sample?.event()?;
        nav.flight.push(event);
        Ok(())
    }))
}

/// Passes a fix to the estimator. A fix up to 10 s later than the last inertial sample waits for the next sample. A
/// notice reports impossible velocities and one-sigmas, and a time on a clock other than that of the samples.
///
/// HOVERNAV_STATUS_OUT_OF_RANGE for an invalid position: not finite, latitude beyond 90 degrees, longitude beyond
/// 360, height beyond 100 km. HOVERNAV_STATUS_UNKNOWN_CODE for an unknown flag.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_fix(nav: *mut Hovernav, fix: *const Fix) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let fix = unsafe { borrowed(fix) };
    Status::of(nav.and_then(|nav| {
        let event = &fix?.event()?;
        nav.flight.push(event);
        Ok(())
    }))
}

/// Passes a barometric height to the estimator: m, up, above any fixed level, valid at `time_ns`. A notice reports a
/// height beyond 100 km.
///
/// HOVERNAV_STATUS_NOT_BUILT if the library was built without height-aids.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_baro(
    nav: *mut Hovernav,
    time_ns: i64,
    height_m: f64,
) -> Status {
    let time = Time::from_nanoseconds(time_ns);
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    Status::of(
        nav.and_then(|nav| nav.flight.push_height(&Event::Baro(BaroReading::new(time, height_m)))),
    )
}

/// Passes the magnetic field of a magnetometer separate from the inertial unit to the estimator. `field_gauss` has
/// three components in body axes, gauss, valid at `time_ns`. Only its direction is used.
///
/// # Safety
/// Pointers follow the rules of the crate; `field_gauss` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_magnetometer(
    nav: *mut Hovernav,
    time_ns: i64,
    field_gauss: *const f64,
) -> Status {
    let time = Time::from_nanoseconds(time_ns);
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller guarantees three numbers.
    let field = unsafe { input(field_gauss.cast::<[f64; 3]>()) };
    Status::of(nav.and_then(|nav| {
        let field_gauss = Vector::from(field?);
        nav.flight.push(&Event::Magnetometer(MagneticReading::new(time, field_gauss)));
        Ok(())
    }))
}

/// Passes the current speed of the rotor to the notch: turns a second, Hz. The notch follows this speed from the next
/// sample on. At 0, a rotor at rest, the notch stays at its last frequency.
///
/// HOVERNAV_STATUS_NO_NOTCH if the configuration has no notch; HOVERNAV_STATUS_OUT_OF_RANGE for a speed that is not
/// finite, negative, or 10000 Hz and more.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_rotor_speed(nav: *mut Hovernav, rotor_hz: f64) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    Status::of(nav.and_then(|nav| {
        let notch = nav.flight.notch.as_mut().ok_or(Status::NoNotch)?;
        if !(0.0..1e4).contains(&rotor_hz) {
            return Err(Status::OutOfRange);
        }
        notch.set_frequency_hz(rotor_hz);
        Ok(())
    }))
}
