//! What sensors measured, from the caller's structures to events.

use hovernav::earth::Geodetic;
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Vector};
use hovernav::gps::Fix as CoreFix;
use hovernav::imu::{ClippedAxes, ImuSample as CoreSample, Motion};
use hovernav::time::Time;

use crate::access::{borrowed, input, object};
use crate::object::Hovernav;
use crate::status::Status;

/// In HovernavImuSample.has: gyro and accel are integrals since the sample before.
pub const HOVERNAV_IMU_INCREMENTS: u32 = 1;
/// In HovernavImuSample.has: the unit's own attitude is there.
pub const HOVERNAV_IMU_ATTITUDE: u32 = 2;
/// In HovernavImuSample.has: the magnetic field is there.
pub const HOVERNAV_IMU_MAGNETIC_FIELD: u32 = 4;

/// One sample of the inertial unit, body axes forward, right, down.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct ImuSample {
    /// When the rates were sampled, or the increments ended, ns.
    pub time_ns: i64,
    /// HOVERNAV_IMU_ flags added up; 0 for rates and nothing else.
    pub has: u32,
    /// Angular rate, rad/s; as an increment its integral, rad.
    pub gyro: [f64; 3],
    /// Specific force, m/s^2 (level and at rest z is -9.81); as an increment its integral, m/s.
    pub accel: [f64; 3],
    /// The unit's own roll, rad.
    pub roll_rad: f64,
    /// The unit's own pitch, rad.
    pub pitch_rad: f64,
    /// The unit's own yaw, rad, from north clockwise.
    pub yaw_rad: f64,
    /// Magnetic field, gauss.
    pub magnetic_field_gauss: [f64; 3],
}

/// In HovernavFix.has: one-sigma of position is there.
pub const HOVERNAV_FIX_POSITION_SIGMA: u32 = 1;
/// In HovernavFix.has: velocity north and east is there.
pub const HOVERNAV_FIX_HORIZONTAL_VELOCITY: u32 = 2;
/// In HovernavFix.has: velocity down is there.
pub const HOVERNAV_FIX_DOWN_VELOCITY: u32 = 4;
/// In HovernavFix.has: one-sigma of velocity is there.
pub const HOVERNAV_FIX_VELOCITY_SIGMA: u32 = 8;
/// In HovernavFix.has: the height was held or assumed, so that neither it nor the velocity down counts.
pub const HOVERNAV_FIX_TWO_DIMENSIONAL: u32 = 16;

/// A satellite fix: of the antenna, at the time it was true (its arrival less its latency), on the
/// clock of the inertial samples.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Fix {
    /// When it was true, ns.
    pub time_ns: i64,
    /// HOVERNAV_FIX_ flags added up; 0 for a position and nothing else.
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
            clipped: ClippedAxes::NONE,
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

/// Takes in a sample of the inertial unit. A sample that the estimator cannot use (not finite, not
/// later than the one before) is told of by a notice, as everything that comes of it. After a gap the
/// estimator goes on however long it was: a time that is wrong and far ahead is taken for one, and every
/// sample up to it refused; hovernav_get_health() then finds the estimate stale, and the object has to be
/// created anew.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_imu(nav: *mut Hovernav, sample: *const ImuSample) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let sample = unsafe { borrowed(sample) };
    Status::of(nav.and_then(|nav| {
        let event = &sample?.event()?;
        nav.flight.push(event);
        Ok(())
    }))
}

/// Takes in a fix. One that is later than the last inertial sample, by up to 10 s, waits for the sample
/// after it. Velocities and one-sigmas that cannot be are told of by a notice, and so is a time that is not of
/// the samples' clock.
///
/// HOVERNAV_STATUS_OUT_OF_RANGE for what is no place on Earth: not finite, latitude beyond 90 degrees,
/// longitude beyond 360, height beyond 100 km. HOVERNAV_STATUS_UNKNOWN_CODE for a flag that is none.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_fix(nav: *mut Hovernav, fix: *const Fix) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let fix = unsafe { borrowed(fix) };
    Status::of(nav.and_then(|nav| {
        let event = &fix?.event()?;
        nav.flight.push(event);
        Ok(())
    }))
}

/// Takes in a barometric height above any fixed level, m, up, true at `time_ns`; up to 100 km, else it is told
/// of by a notice.
///
/// HOVERNAV_STATUS_NOT_BUILT where the library was built without height-aids.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_baro(
    nav: *mut Hovernav,
    time_ns: i64,
    height_m: f64,
) -> Status {
    let time = Time::from_nanoseconds(time_ns);
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    Status::of(nav.and_then(|nav| nav.flight.push_height(&Event::Baro { time, height_m })))
}

/// Takes in the field of a magnetometer apart from the inertial unit, three components in body axes,
/// gauss, true at `time_ns`. Its length does not count.
///
/// # Safety
/// Pointers as the crate's rules say; `field_gauss` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_magnetometer(
    nav: *mut Hovernav,
    time_ns: i64,
    field_gauss: *const f64,
) -> Status {
    let time = Time::from_nanoseconds(time_ns);
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise: three numbers.
    let field = unsafe { input(field_gauss.cast::<[f64; 3]>()) };
    Status::of(nav.and_then(|nav| {
        let field_gauss = Vector::from(field?);
        nav.flight.push(&Event::Magnetometer { time, field_gauss });
        Ok(())
    }))
}

/// Takes in the speed of the rotor, turns a second, Hz, as it is now: the notch follows it from the next sample on. 0,
/// a rotor that stands, leaves the notch where it is.
///
/// HOVERNAV_STATUS_NO_NOTCH where the configuration has none; HOVERNAV_STATUS_OUT_OF_RANGE for a speed that is not
/// finite, negative, or 10000 Hz and more.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_rotor_speed(nav: *mut Hovernav, rotor_hz: f64) -> Status {
    // SAFETY: the caller's promise.
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
