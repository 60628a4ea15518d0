//! Converts messages to samples, fixes and moments of the onboard estimator.

use super::frames::Frame;
use super::message::Message;
use crate::assembly::Assembly;
use crate::onboard::OnboardMoment;
use hovernav::earth::Geodetic;
use hovernav::event::RangeReading;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::glam::DQuat;
use hovernav::gps::AntennaHeading;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::{Dimensions, StatedFix, pressure_altitude_m};

/// The chosen sensors, and the state kept between messages.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// System and component whose messages are read.
    pub sender: (u8, u8),
    pub imu: Option<Message>,
    pub gps: Option<Message>,
    pub rangefinder: Option<Message>,
    /// Time from the validity of a fix to its message, s.
    pub latency_s: f64,
    /// Number of fixes whose only height is above mean sea level.
    pub without_ellipsoid: usize,
    /// UTC of the zero of the autopilot's clock, s since 1970.
    pub boot_s: Option<f64>,
    /// The clock at the first message, s.
    pub start_s: Option<f64>,
    /// Height of mean sea level above the ellipsoid, from the last fix, m.
    pub undulation_m: f64,
    pub last_fix: Option<Time>,
}

/// Clock value, s, above which the clock counts from 1970: no autopilot runs for 30 years.
const SINCE_1970_S: f64 = 1e9;
/// MAVLink's value for an unknown speed, 65535 cm/s.
const UNKNOWN_SPEED_MPS: f64 = 655.35;

impl Rows {
    /// Reads a frame.
    pub fn take(&mut self, frame: &Frame, to: &mut Assembly) {
        let Frame { message, sender, place, stamp_s, ref row } = *frame;
        if sender != self.sender {
            return;
        }
        let clock_s = match (message, self.boot_s) {
            (Message::Rangefinder, Some(boot_s)) => stamp_s - boot_s,
            (Message::Rangefinder, None) => return,
            _ => row[0],
        };
        let Some(time) = self.time(message, clock_s, stamp_s) else { return };
        match message {
            Message::SystemTime => {}
            Message::HighresImu
            | Message::RawImu
            | Message::ScaledImu
            | Message::ScaledImu2
            | Message::ScaledImu3 => {
                if self.imu == Some(message) {
                    imu(message, row, time, place, to);
                }
            }
            Message::GpsRaw | Message::Gps2Raw => {
                // The same fix may be sent repeatedly.
                if self.gps == Some(message) && self.last_fix != Some(time) {
                    self.last_fix = Some(time);
                    self.gps(row, time, place, to);
                }
            }
            Message::GlobalPosition => {
                let [_, lat, lon, alt_m, vn, ve, vd, ..] = *row;
                to.moment(OnboardMoment {
                    position: Geodetic::from_degrees(lat, lon, alt_m + self.undulation_m),
                    velocity_mps: Some(Vector::new(vn, ve, vd)),
                    ..OnboardMoment::at(time)
                });
            }
            Message::LocalPosition => {
                let velocity_mps = Some(Vector::new(row[1], row[2], row[3]));
                to.moment(OnboardMoment { velocity_mps, ..OnboardMoment::at(time) });
            }
            Message::Attitude => {
                let [_, roll_rad, pitch_rad, yaw_rad, ..] = *row;
                let angles = EulerAngles { roll_rad, pitch_rad, yaw_rad };
                let body_to_ned = angles.is_finite().then(|| Rotation::from_euler(angles));
                to.moment(OnboardMoment { body_to_ned, ..OnboardMoment::at(time) });
            }
            Message::AttitudeQuaternion => {
                let [_, w, x, y, z, ..] = *row;
                let body_to_ned = Some(Rotation::claim(DQuat::from_xyzw(x, y, z, w)));
                to.moment(OnboardMoment { body_to_ned, ..OnboardMoment::at(time) });
            }
            Message::ScaledPressure => {
                to.baro(place, time, pressure_altitude_m(row[1]).unwrap_or(f64::NAN));
            }
            Message::DistanceSensor | Message::Rangefinder => {
                if self.rangefinder == Some(message) {
                    distance(message, row, time, place, to);
                }
            }
            Message::RcChannels => {
                let stick = |pulse_us: f64| (pulse_us - 1500.0) / 500.0;
                let [_, roll, pitch, throttle, yaw, ..] = *row;
                // Forward stick is the short pulse.
                let sticks = [stick(roll), -stick(pitch), stick(throttle), stick(yaw)];
                to.controls("RC_CHANNELS", place, time, sticks);
            }
        }
    }

    /// The time of a message since the first message, on the autopilot's clock. Times since 1970 are converted with
    /// the offset of that clock.
    fn time(&mut self, message: Message, clock_s: f64, stamp_s: f64) -> Option<Time> {
        let boot_s = *self.boot_s.get_or_insert(match message {
            Message::GpsRaw | Message::Gps2Raw | Message::HighresImu | Message::RawImu
                if clock_s > SINCE_1970_S =>
            {
                clock_s
            }
            _ => stamp_s - clock_s,
        });
        let clock_s = if clock_s > SINCE_1970_S { clock_s - boot_s } else { clock_s };
        let start_s = *self.start_s.get_or_insert(clock_s);
        Time::try_from_seconds(clock_s - start_s)
    }

    fn gps(&mut self, row: &[f64], time: Time, place: u64, to: &mut Assembly) {
        let &[_, lat, lon, msl_m, speed_mps, course_deg, fix_type, satellites, ref more @ ..] = row
        else {
            return;
        };
        let &[ellipsoid_m, horizontal_m, vertical_m, speed_sigma, yaw_deg, ..] = more else {
            return;
        };
        // Yaw 0 means unknown; north is 360.
        if yaw_deg > 0.0 && yaw_deg <= 360.0 {
            let time = time.offset_by(-self.latency_s);
            to.heading(place, AntennaHeading::new(time, yaw_deg.to_radians(), None));
        }
        // Fields that MAVLink 1 does not send are zero.
        let has_ellipsoid = ellipsoid_m != 0.0;
        let height_m = if has_ellipsoid { ellipsoid_m } else { msl_m };
        let known = |value: f64, is_known: bool| if is_known { value } else { f64::NAN };
        let sigma = |sigma: [f64; 3]| sigma.map(|sigma| known(sigma, sigma > 0.0));
        let stated = StatedFix {
            dimensions: Dimensions::of_type(fix_type),
            position_sigma_m: sigma([horizontal_m, horizontal_m, vertical_m]),
            velocity_sigma_mps: sigma([speed_sigma; 3]),
            satellites: known(satellites, satellites < 255.0),
            ..StatedFix::at(Some(time.offset_by(-self.latency_s)), [lat, lon, height_m])
        };
        let course_deg = known(course_deg, course_deg <= 360.0);
        let speed_mps = known(speed_mps, speed_mps < UNKNOWN_SPEED_MPS);
        if !to.fix(place, stated.moving(speed_mps, course_deg.to_radians())) {
            return;
        }
        if has_ellipsoid {
            self.undulation_m = ellipsoid_m - msl_m;
        } else {
            self.without_ellipsoid += 1;
        }
    }
}

/// MAVLink's orientation of a downward sensor.
const DOWNWARD: f64 = 25.0;
/// MAVLink's value for an unknown variance, cm².
const UNKNOWN_VARIANCE: f64 = 255.0;
/// Quality of an invalid reading; 0 means an unknown quality.
const INVALID: f64 = 0.01;

fn distance(message: Message, row: &[f64], time: Time, place: u64, to: &mut Assembly) {
    if message == Message::Rangefinder {
        return to.range(place, RangeReading::new(time, row[1]));
    }
    let &[_, least_m, most_m, range_m, orientation, variance, quality, ..] = row else { return };
    if orientation != DOWNWARD {
        return;
    }
    let within = (least_m..=most_m).contains(&range_m);
    let quality = match quality {
        _ if !within => Some(0.0),
        INVALID => Some(0.0),
        quality => Some(quality).filter(|quality| *quality > 0.0),
    };
    let known = variance > 0.0 && variance < UNKNOWN_VARIANCE;
    let sigma_m = known.then(|| 0.01 * variance.sqrt());
    to.range(place, RangeReading { time, range_m, sigma_m, quality });
}

fn imu(message: Message, row: &[f64], time: Time, place: u64, to: &mut Assembly) {
    let &[_, p, q, r, x, y, z, mx, my, mz, pressure_pa, updated, ..] = row else { return };
    let motion = Motion::Rates {
        angular_rate_radps: Vector::new(p, q, r),
        specific_force_mps2: Vector::new(x, y, z),
    };
    // HIGHRES_IMU has a bit mask of updated fields; 0x1C0 is the magnetometer, 0x200 the barometer.
    let updated = if message == Message::HighresImu { updated as u16 } else { u16::MAX };
    let field = [mx, my, mz];
    let is_field = updated & 0x1C0 != 0 && field.iter().any(|&component| component != 0.0);
    if message == Message::HighresImu
        && updated & 0x200 != 0
        && let Some(height_m) = pressure_altitude_m(pressure_pa)
    {
        to.baro(place, time, height_m);
    }
    let magnetic_field_gauss = is_field.then(|| field.into());
    to.imu(place, ImuSample { magnetic_field_gauss, ..ImuSample::new(time, motion) });
}
