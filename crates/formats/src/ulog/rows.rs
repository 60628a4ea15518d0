//! Converts the rows of each topic to samples, fixes and moments of the onboard estimator.

use super::innovations::Innovations;
use super::inputs::Inputs;
use super::topics::Topic;
use crate::assembly::Assembly;
use crate::integrals::Integrals;
use crate::onboard::OnboardMoment;
use crate::utc::UtcAtZero;
use hovernav::earth::Geodetic;
use hovernav::event::RangeReading;
use hovernav::frames::{Rotation, Vector};
use hovernav::glam::DQuat;
use hovernav::gps::AntennaHeading;
use hovernav::imu::{ImuAxes, ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::{Dimensions, StatedFix, pressure_altitude_m};

/// The state kept between rows.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// Clock at the start of the log, µs.
    pub start_us: f64,
    /// Time from the validity of a fix to its message, s.
    pub latency_s: f64,
    /// Whether the log has separate topics for magnetometer and barometer.
    pub has_magnetometer: bool,
    pub has_baro: bool,
    /// Whether the log has onboard positions as latitude and longitude.
    pub has_global_position: bool,
    /// Outputs of the controllers, and the mixer of the motors.
    pub inputs: Inputs,
    /// Innovations whose variances have not arrived yet.
    pub innovations: Innovations,
    /// Fraction of the time that the intervals of integrated samples cover.
    pub integrals: Integrals,
    /// Samples in which an accelerometer clipped.
    pub accel_clipping: Clipping,
    /// Samples in which a gyro clipped.
    pub gyro_clipping: Clipping,
    /// Number of fixes whose only height is above mean sea level.
    pub without_ellipsoid: usize,
    /// UTC of the start of the log, from the fixes.
    pub utc_at_zero: UtcAtZero,
    /// Height of mean sea level above the ellipsoid, from the last fix, m.
    undulation_m: f64,
    last_magnetometer: Option<Time>,
    last_baro: Option<Time>,
}

/// Samples at full scale: number by axis, first and last time.
#[derive(Debug, Default)]
pub(super) struct Clipping {
    pub samples: [usize; 3],
    pub span: Option<(Time, Time)>,
}

impl Clipping {
    /// Counts a sample from its bits, one per axis; NaN in logs without them.
    fn count(&mut self, bits: f64, time: Time) {
        let bits = bits as u8;
        for (axis, count) in self.samples.iter_mut().enumerate() {
            *count += usize::from(bits >> axis & 1);
        }
        if bits & 7 != 0 {
            self.span = Some((self.span.map_or(time, |(first, _)| first), time));
        }
    }
}

/// The clipped axes from a sample's bits, one per axis; NaN in logs without them.
fn marks(accel_bits: f64, gyro_bits: f64) -> ImuAxes {
    let axes = |bits: f64| [0, 1, 2].map(|axis| bits as u8 >> axis & 1 != 0);
    ImuAxes { gyro: axes(gyro_bits), accel: axes(accel_bits) }
}

/// The value `new`, in degrees or metres. Logs from before 2024 lack it and have `old`, an integer in multiples of
/// `unit`.
fn or(new: f64, old: f64, unit: f64) -> f64 {
    if new.is_nan() { old * unit } else { new }
}

/// Latitude and longitude, degrees, from the columns of a receiver's topic.
pub(super) fn place_deg(row: &[f64]) -> [f64; 2] {
    [or(row[5], row[1], 1e-7), or(row[6], row[2], 1e-7)]
}

/// PX4's relative time of missing values, µs; some logs have its negative.
const UNKNOWN_RELATIVE_US: f64 = i32::MAX as f64;
/// Smallest value that is in Pa; smaller ones are in hPa, as in older PX4 logs.
const MIN_PA: f64 = 2_000.0;

/// PX4's orientation of a downward sensor.
const DOWNWARD: f64 = 25.0;

impl Rows {
    /// Reads a row of `topic` at byte offset `place`.
    pub fn take(&mut self, topic: Topic, row: &[f64; Topic::WIDTH], place: u64, to: &mut Assembly) {
        match topic {
            Topic::SensorCombined => self.sensor_combined(row, place, to),
            Topic::VehicleImu => self.vehicle_imu(row, place, to),
            Topic::VehicleGps | Topic::SensorGps => self.gps(row, place, to),
            Topic::Magnetometer => {
                let [t, sample, x, y, z, ..] = *row;
                if let Some(time) = self.sampled(t, sample) {
                    to.magnetometer(place, time, [x, y, z]);
                }
            }
            Topic::AirData | Topic::SensorBaro => {
                let [t, sample, value, ..] = *row;
                if let Some(time) = self.sampled(t, sample) {
                    let height_m = if topic == Topic::AirData {
                        value
                    } else {
                        let pressure_pa = if value < MIN_PA { 100.0 * value } else { value };
                        pressure_altitude_m(pressure_pa).unwrap_or(f64::NAN)
                    };
                    to.baro(place, time, height_m);
                }
            }
            Topic::Distance => self.distance(row, place, to),
            Topic::Sticks => self.sticks(row, place, to),
            Topic::RateControls | Topic::Torque | Topic::Thrust | Topic::Motors => {
                if let Some(time) = self.time(row[0]) {
                    self.inputs.take(topic, time, &row[1..], place, to);
                }
            }
            Topic::Attitude => {
                let [t, sample, w, x, y, z, ..] = *row;
                if let Some(time) = self.sampled(t, sample) {
                    let attitude = Rotation::claim(DQuat::from_xyzw(x, y, z, w));
                    let body_to_ned = Some(attitude);
                    to.moment(OnboardMoment { body_to_ned, ..OnboardMoment::at(time) });
                }
            }
            Topic::LocalPosition => self.local_position(row, to),
            Topic::GlobalPosition => self.global_position(row, to),
            Topic::Innovations | Topic::InnovationVariances => {
                let &[t, sample, ref numbers @ ..] = row;
                let Some(time) = self.sampled(t, sample) else { return };
                if topic == Topic::Innovations {
                    self.innovations.take(time, numbers, to);
                } else {
                    self.innovations.variances(time, numbers, to);
                }
            }
            Topic::OldInnovations => {
                let &[t, ref numbers @ ..] = row;
                if let Some(time) = self.time(t) {
                    Innovations::old(time, numbers, to);
                }
            }
        }
    }

    /// The time since the start of the log at the clock value `clock_us`.
    fn time(&self, clock_us: f64) -> Option<Time> {
        // The clock counts whole microseconds; an f64 of seconds resolves them.
        Time::try_from_seconds((clock_us - self.start_us) / 1e6)
    }

    /// The time of the sample if the log has it, otherwise that of the message.
    fn sampled(&self, message_us: f64, sample_us: f64) -> Option<Time> {
        self.time(if sample_us > 0.0 { sample_us } else { message_us })
    }

    fn sensor_combined(&mut self, row: &[f64], place: u64, to: &mut Assembly) {
        let &[t, p, q, r, gyro_dt, accel_relative, x, y, z, accel_bits, gyro_bits, ref rest @ ..] =
            row
        else {
            return;
        };
        let Some(time) = self.time(t) else { return };
        if let &[mag_relative, mx, my, mz, baro_relative, height_m, ..] = rest {
            self.combined_others(
                t,
                [mag_relative, mx, my, mz],
                [baro_relative, height_m],
                place,
                to,
            );
        }
        if accel_relative.abs() >= UNKNOWN_RELATIVE_US {
            return to.skip_imu(place, "skipped: the specific force is missing");
        }
        // The interval is in microseconds; in logs from before 2017 it is in seconds.
        self.integrals.sample(time, if gyro_dt > 1.0 { gyro_dt / 1e6 } else { gyro_dt });
        self.accel_clipping.count(accel_bits, time);
        self.gyro_clipping.count(gyro_bits, time);
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(p, q, r),
            specific_force_mps2: Vector::new(x, y, z),
        };
        to.imu(
            place,
            ImuSample { clipped: marks(accel_bits, gyro_bits), ..ImuSample::new(time, motion) },
        );
    }

    /// Magnetometer and barometer within `sensor_combined` of older logs, where values repeat until the next
    /// measurement.
    fn combined_others(
        &mut self,
        t: f64,
        [mag_relative, x, y, z]: [f64; 4],
        [baro_relative, height_m]: [f64; 2],
        place: u64,
        to: &mut Assembly,
    ) {
        let known = |relative: f64| relative.abs() < UNKNOWN_RELATIVE_US;
        let at = self.time(t + mag_relative).filter(|_| known(mag_relative));
        if let Some(time) = at.filter(|&at| Some(at) > self.last_magnetometer)
            && !self.has_magnetometer
        {
            self.last_magnetometer = Some(time);
            to.magnetometer(place, time, [x, y, z]);
        }
        let at = self.time(t + baro_relative).filter(|_| known(baro_relative));
        if let Some(time) = at.filter(|&at| Some(at) > self.last_baro)
            && !self.has_baro
        {
            self.last_baro = Some(time);
            to.baro(place, time, height_m);
        }
    }

    fn vehicle_imu(&mut self, row: &[f64], place: u64, to: &mut Assembly) {
        let &[t, sample, p, q, r, angle_dt, x, y, z, velocity_dt, accel_bits, gyro_bits, ..] = row
        else {
            return;
        };
        let Some(time) = self.sampled(t, sample) else { return };
        if !(angle_dt > 0.0 && velocity_dt > 0.0) {
            return to.skip_imu(place, "skipped: the time of an increment is zero or missing");
        }
        self.integrals.sample(time, angle_dt / 1e6);
        self.accel_clipping.count(accel_bits, time);
        self.gyro_clipping.count(gyro_bits, time);
        // Increments are converted to mean rates, because gyro and accelerometer may integrate over different times.
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(p, q, r) * (1e6 / angle_dt),
            specific_force_mps2: Vector::new(x, y, z) * (1e6 / velocity_dt),
        };
        to.imu(
            place,
            ImuSample { clipped: marks(accel_bits, gyro_bits), ..ImuSample::new(time, motion) },
        );
    }

    fn gps(&mut self, row: &[f64], place: u64, to: &mut Assembly) {
        let &[t, _, _, alt, alt_ellipsoid, ref rest @ ..] = row else { return };
        let &[_, _, msl, ellipsoid, vn, ve, vd, velocity_valid, ref rest @ ..] = rest else {
            return;
        };
        let &[eph, epv, speed_sigma, fix_type, satellites, utc_us, ref antennas @ ..] = rest else {
            return;
        };
        // The heading is that of the vehicle: PX4 has already subtracted the direction of the antenna baseline.
        if let (Some(time), &[heading_rad, sigma_rad, ..]) = (self.time(t), antennas)
            && heading_rad.is_finite()
        {
            let time = time.offset_by(-self.latency_s);
            to.heading(place, AntennaHeading::new(time, heading_rad, Some(sigma_rad)));
        }
        let [latitude, longitude] = place_deg(row);
        let (msl_m, ellipsoid_m) = (or(msl, alt, 1e-3), or(ellipsoid, alt_ellipsoid, 1e-3));
        let has_ellipsoid = ellipsoid_m.is_finite() && (ellipsoid_m != 0.0 || msl_m == 0.0);
        let height_m = if has_ellipsoid { ellipsoid_m } else { msl_m };
        let time = self.time(t).map(|time| time.offset_by(-self.latency_s));
        let has_velocity = velocity_valid != 0.0;
        let stated = StatedFix {
            dimensions: Dimensions::of_type(fix_type),
            position_sigma_m: [eph, eph, epv],
            velocity_mps: if has_velocity { [vn, ve, vd] } else { [f64::NAN; 3] },
            velocity_sigma_mps: [speed_sigma; 3],
            satellites,
            ..StatedFix::at(time, [latitude, longitude, height_m])
        };
        if !to.fix(place, stated) {
            return;
        }
        if has_ellipsoid {
            self.undulation_m = ellipsoid_m - msl_m;
        } else if height_m.is_finite() {
            self.without_ellipsoid += 1;
        }
        if let Some(time) = time.filter(|_| utc_us > 0.0) {
            self.utc_at_zero.push((1e3 * utc_us) as i64, time);
        }
    }

    fn distance(&self, row: &[f64], place: u64, to: &mut Assembly) {
        let &[t, range_m, variance, percent, orientation, least_m, most_m, ..] = row else {
            return;
        };
        let Some(time) = self.time(t).filter(|_| orientation == DOWNWARD) else { return };
        // A quality of −1 means unknown. Readings outside the sensor's own limits have quality 0.
        let within = !(range_m < least_m || range_m > most_m);
        let quality = if within { Some(percent / 100.0) } else { Some(0.0) };
        to.range(place, RangeReading { time, range_m, sigma_m: Some(variance.sqrt()), quality });
    }

    fn sticks(&self, row: &[f64], place: u64, to: &mut Assembly) {
        let &[t, roll, pitch, throttle, yaw, y, x, z, r, ..] = row else { return };
        let Some(time) = self.time(t) else { return };
        // The forward stick is positive `x` in old logs and positive `pitch` in new ones. The throttle of old logs is 0
        // to 1.
        let or = |new: f64, old: f64| if new.is_nan() { old } else { new };
        let throttle = or(throttle, 2.0 * z - 1.0);
        let sticks = [or(roll, y), or(pitch, x), throttle, or(yaw, r)];
        to.controls(Topic::Sticks.name(), place, time, sticks);
    }

    fn local_position(&self, row: &[f64], to: &mut Assembly) {
        let &[t, sample, ref_lat, ref_lon, ref_alt, x, y, z, vx, vy, vz, ref valid @ ..] = row
        else {
            return;
        };
        let &[xy_valid, z_valid, v_xy_valid, v_z_valid, xy_global, z_global, ..] = valid else {
            return;
        };
        let Some(time) = self.sampled(t, sample) else { return };
        let is = |flags: &[f64]| flags.iter().all(|&flag| flag != 0.0);
        let velocity = Vector::new(vx, vy, vz);
        let is_place = !self.has_global_position && is(&[xy_valid, z_valid, xy_global, z_global]);
        let origin = Geodetic::from_degrees(ref_lat, ref_lon, ref_alt + self.undulation_m);
        let position =
            origin.filter(|_| is_place).map(|origin| origin.displaced(Vector::new(x, y, z)));
        to.moment(OnboardMoment {
            velocity_mps: is(&[v_xy_valid, v_z_valid]).then_some(velocity),
            position,
            ..OnboardMoment::at(time)
        });
    }

    fn global_position(&self, row: &[f64], to: &mut Assembly) {
        let &[t, sample, lat, lon, alt, alt_ellipsoid, is_place, is_height, ..] = row else {
            return;
        };
        let Some(time) = self.sampled(t, sample) else { return };
        let height_m = if alt_ellipsoid.is_nan() { alt + self.undulation_m } else { alt_ellipsoid };
        let position = Geodetic::from_degrees(lat, lon, height_m);
        let is_known = is_place != 0.0 && is_height != 0.0;
        to.moment(OnboardMoment {
            position: position.filter(|_| is_known),
            ..OnboardMoment::at(time)
        });
    }
}
