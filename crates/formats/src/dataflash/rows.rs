//! Converts messages to samples, fixes and moments of the onboard estimator.

use super::inputs;
use super::item::Item;
use super::message::Message;
use super::used::index;
use crate::assembly::Assembly;
use crate::integrals::Integrals;
use crate::onboard::{OnboardInnovation, OnboardMoment};
use crate::utc::{UtcAtZero, of_gps_week};
use hovernav::earth::Geodetic;
use hovernav::ekf::Channel;
use hovernav::event::RangeReading;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::glam::DQuat;
use hovernav::gps::AntennaHeading;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::{Dimensions, StatedFix};

/// The chosen sensors, and the state kept between rows.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// The message and instance of each sensor that is read.
    pub imu: Option<(Message, usize)>,
    pub gps: Option<usize>,
    pub baro: Option<usize>,
    pub magnetometer: Option<usize>,
    pub rangefinder: Option<usize>,
    /// The cores of the onboard estimator whose velocity the log has.
    pub cores: Vec<usize>,
    /// The primary one of them.
    pub core: usize,
    /// Whether onboard attitudes come as quaternions.
    pub has_quaternion: bool,
    /// The clock at the start of the log, s.
    pub start_s: f64,
    /// Time from the validity of a fix to its message, s.
    pub latency_s: f64,
    /// Pulse at the trim of each of the first four channels, µs.
    pub trims_us: [f64; 4],
    /// Contributions of each motor to roll, pitch, throttle and yaw; `None` for a frame that is not mapped.
    pub mixer: Option<[[f64; 4]; 4]>,
    /// Stick of the current system identification, and the sign of its signal.
    pub identified: Option<(usize, f64)>,
    /// Fraction of the time that the intervals of the increments cover.
    pub integrals: Integrals,
    /// UTC of the start of the log, from the fixes with GPS week and time.
    pub utc_at_zero: UtcAtZero,
    /// Number of fixes; their heights are above mean sea level.
    pub fixes: usize,
    /// Time of messages without a time field, s.
    pub current_s: f64,
    /// The previous fix, until its accuracies arrive: byte offset or line, clock, s, and fix.
    pub pending: Option<(u64, f64, StatedFix)>,
    /// The two-antenna heading of the pending fix.
    pub pending_heading: Option<AntennaHeading>,
}

/// Half the travel of a channel, µs.
const HALF_TRAVEL_US: f64 = 500.0;

impl Rows {
    /// Reads an item of the log.
    pub fn take(&mut self, item: &Item<'_>, to: &mut Assembly) {
        let &Item::Row { message, instance, place, ref row } = item else { return };
        let clock_s = self.clock_s(message, row);
        let Some(time) = Time::try_from_seconds(clock_s - self.start_s) else { return };
        let row = &row[..];
        match message {
            Message::Time => self.current_s = row[0],
            Message::Imu if self.imu == Some((message, instance)) => imu(row, time, place, to),
            Message::Imt if self.imu == Some((message, instance)) => {
                self.increments(row, time, place, to);
            }
            Message::Gps if self.gps == Some(instance) => {
                self.flush(to);
                self.gps(row, clock_s, time, place);
            }
            Message::GpsAccuracy if self.gps == Some(instance) => self.accuracy(row, clock_s),
            Message::Baro if self.baro == Some(instance) => match row[3..5].contains(&0.0) {
                true => to.skip_other(place, UNHEALTHY_BARO),
                false => to.baro(place, time, row[2]),
            },
            Message::Rangefinder if self.rangefinder == Some(instance) => {
                distance(row, time, place, to);
            }
            Message::Magnetometer if self.magnetometer == Some(instance) => {
                match row[5..6].contains(&0.0) {
                    true => to.skip_other(place, UNHEALTHY_FIELD),
                    false => to.magnetometer(place, time, [row[2], row[3], row[4]]),
                }
            }
            Message::RcIn => {
                let stick =
                    |channel: usize| (row[2 + channel] - self.trims_us[channel]) / HALF_TRAVEL_US;
                // Forward stick is the short pulse.
                to.controls("RCIN", place, time, [stick(0), -stick(1), stick(2), stick(3)]);
            }
            // ArduPilot counts nose up as positive, hovernav the forward stick.
            Message::Rate => {
                to.controls("RATE", place, time, [row[2], -row[3], row[4], row[5]]);
            }
            Message::RcOut => {
                if let Some(mixer) = self.mixer {
                    to.controls("RCOU", place, time, inputs::of_motors(&mixer, &row[2..6]));
                }
            }
            Message::SidSettings => self.identified = inputs::stick_of_axis(row[2]),
            Message::SidData => {
                if let Some((stick, sign)) = self.identified {
                    to.injected(time, stick, sign * row[2]);
                }
            }
            Message::Attitude if !self.has_quaternion => {
                let [roll, pitch, yaw] = [row[2], row[3], row[4]];
                // PX4's messages of this name have angles in radians, and also rates.
                let angles = if row[5].is_nan() {
                    EulerAngles::from_degrees(roll, pitch, yaw)
                } else {
                    EulerAngles { roll_rad: roll, pitch_rad: pitch, yaw_rad: yaw }
                };
                let body_to_ned = angles.is_finite().then(|| Rotation::from_euler(angles));
                to.moment(OnboardMoment { body_to_ned, ..OnboardMoment::at(time) });
            }
            Message::Quaternion if instance == self.core => {
                let attitude = DQuat::from_xyzw(row[3], row[4], row[5], row[2]);
                let body_to_ned = Some(Rotation::claim(attitude));
                to.moment(OnboardMoment { body_to_ned, ..OnboardMoment::at(time) });
            }
            Message::Velocity if instance == self.core => {
                let velocity_mps = Some(Vector::new(row[2], row[3], row[4]));
                to.moment(OnboardMoment { velocity_mps, ..OnboardMoment::at(time) });
            }
            Message::Core => {
                let primary = index(row[2]).filter(|core| self.cores.contains(core));
                self.core = primary.unwrap_or(self.core);
            }
            Message::Innovations if instance == self.core => innovations(row, time, to),
            Message::Position => {
                let position = Geodetic::from_degrees(row[2], row[3], row[4]);
                to.moment(OnboardMoment { position, ..OnboardMoment::at(time) });
            }
            _ => {}
        }
    }

    /// The time of a message, s.
    pub fn clock_s(&self, message: Message, row: &[f64]) -> f64 {
        if message == Message::Time {
            return row[0];
        }
        // In old logs with both, `TimeMS` is the receiver's time and `T` the autopilot's.
        let of_gps = (message == Message::Gps).then(|| row[2]);
        let mut times = [Some(row[0]), of_gps, Some(row[1])].into_iter().flatten();
        times.find(|time| time.is_finite()).unwrap_or(self.current_s)
    }

    fn increments(&mut self, row: &[f64], time: Time, place: u64, to: &mut Assembly) {
        let &[_, _, p, q, r, x, y, z, angle_s, velocity_s, ..] = row else { return };
        if !(angle_s > 0.0 && velocity_s > 0.0) {
            return to.skip_imu(place, "skipped: the time of an increment is zero or missing");
        }
        self.integrals.sample(time, angle_s);
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(p, q, r) * (1.0 / angle_s),
            specific_force_mps2: Vector::new(x, y, z) * (1.0 / velocity_s),
        };
        to.imu(place, ImuSample::new(time, motion));
    }

    fn gps(&mut self, row: &[f64], clock_s: f64, time: Time, place: u64) {
        let &[_, _, _, status, fix_type, lat, lng, lon, height_m, ref rest @ ..] = row else {
            return;
        };
        let &[speed, course, vz, vn, ve, vd, satellites, week, in_week_s, eph, epv, yaw, ..] = rest
        else {
            return;
        };
        let or = |one: f64, other: f64| if one.is_nan() { other } else { one };
        let time = time.offset_by(-self.latency_s);
        let dimensions = Dimensions::of_type(or(status, fix_type));
        if dimensions != Dimensions::None && week > 0.0 && in_week_s >= 0.0 {
            self.utc_at_zero.push(of_gps_week(week, in_week_s), time);
        }
        let stated = StatedFix::at(Some(time), [lat, or(lng, lon), height_m]);
        let [north, east, down] = stated.moving(speed, course.to_radians()).velocity_mps;
        let fix = StatedFix {
            dimensions,
            position_sigma_m: [eph, eph, epv],
            velocity_mps: [or(vn, north), or(ve, east), or(or(vz, vd), down)],
            satellites,
            ..stated
        };
        self.pending = Some((place, clock_s, fix));
        // Yaw 0 means unknown; north is 360.
        self.pending_heading =
            (yaw > 0.0 && yaw <= 360.0).then(|| AntennaHeading::new(time, yaw.to_radians(), None));
    }

    /// Adds accuracies to the pending fix, if their times agree within 0.05 s.
    fn accuracy(&mut self, row: &[f64], clock_s: f64) {
        let &[_, _, horizontal, vertical, speed, has_vertical, yaw, ..] = row else { return };
        let Some((_, of_s, fix)) = &mut self.pending else { return };
        if (clock_s - *of_s).abs() > 0.05 {
            return;
        }
        if horizontal.is_finite() && vertical.is_finite() {
            fix.position_sigma_m = [horizontal, horizontal, vertical];
        }
        if speed.is_finite() {
            fix.velocity_sigma_mps = [speed; 3];
        }
        if has_vertical == 0.0 {
            fix.velocity_mps[2] = f64::NAN;
        }
        if let Some(heading) = &mut self.pending_heading {
            heading.sigma_rad = (yaw > 0.0).then(|| yaw.to_radians());
        }
    }

    /// Adds the pending fix to `to`.
    pub fn flush(&mut self, to: &mut Assembly) {
        if let Some((place, _, fix)) = self.pending.take() {
            self.fixes += usize::from(to.fix(place, fix));
            if let Some(heading) = self.pending_heading.take() {
                to.heading(place, heading);
            }
        }
    }
}

/// ArduPilot's innovations, without variances: prediction minus measurement, heading in degrees.
fn innovations(row: &[f64], time: Time, to: &mut Assembly) {
    let channels = [
        (Channel::PositionNorth, 2, -1.0),
        (Channel::PositionEast, 3, -1.0),
        (Channel::PositionDown, 4, -1.0),
        (Channel::VelocityNorth, 5, -1.0),
        (Channel::VelocityEast, 6, -1.0),
        (Channel::VelocityDown, 7, -1.0),
        (Channel::Yaw, 8, -(1f64.to_radians())),
    ];
    for (channel, column, scale) in channels {
        let innovation = scale * row[column];
        to.innovation(OnboardInnovation { time, channel, innovation, sigma: None });
    }
}

const UNHEALTHY_BARO: &str = "skipped: the log marks the barometer as unhealthy (Health, H)";
const UNHEALTHY_FIELD: &str = "skipped: the log marks the magnetometer as unhealthy (Health)";

/// ArduPilot's orientation of a downward sensor.
const DOWNWARD: f64 = 25.0;
/// ArduPilot's state of a valid reading.
const GOOD: f64 = 4.0;

fn distance(row: &[f64], time: Time, place: u64, to: &mut Assembly) {
    let &[_, _, distance, first, state, orientation, percent, ..] = row else { return };
    if !(orientation.is_nan() || orientation == DOWNWARD) {
        return;
    }
    let range_m = if distance.is_nan() { first } else { distance };
    let bad = state < GOOD;
    let quality = if bad { Some(0.0) } else { Some(percent / 100.0) };
    to.range(place, RangeReading { quality, ..RangeReading::new(time, range_m) });
}

fn imu(row: &[f64], time: Time, place: u64, to: &mut Assembly) {
    if row[14..16].contains(&0.0) {
        return to.skip_imu(
            place,
            "skipped: the log marks the gyro or the accelerometer as unhealthy (GH, AH)",
        );
    }
    let &[_, _, p, q, r, x, y, z, p_px4, q_px4, r_px4, mx, my, mz, ..] = row else { return };
    let or = |one: f64, other: f64| if one.is_nan() { other } else { one };
    let motion = Motion::Rates {
        angular_rate_radps: Vector::new(or(p, p_px4), or(q, q_px4), or(r, r_px4)),
        specific_force_mps2: Vector::new(x, y, z),
    };
    let field = [mx, my, mz];
    // The components are NaN in logs without a magnetic field.
    let is_field = field.iter().all(|component| !component.is_nan());
    let magnetic_field_gauss = is_field.then(|| field.into());
    to.imu(place, ImuSample { magnetic_field_gauss, ..ImuSample::new(time, motion) });
}
