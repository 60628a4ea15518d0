//! Encoders of receiver messages, the counterpart of the decoders in [`gps`](hovernav::gps).

use chrono::{DateTime, Datelike, TimeDelta, Timelike, Utc};

/// The GPS week of [`Epoch::flying`]: it begins on 15 March 2026.
pub const WEEK: u16 = 2_410;
/// Duration of a week, ms.
const WEEK_MS: i64 = 604_800_000;
/// GPS time minus UTC, s, since 2017.
pub const LEAP_SECONDS: u8 = 18;
/// Height of the geoid above the ellipsoid in all messages, m.
pub const GEOID_SEPARATION_M: f64 = 7.5;

/// One-sigma that a u-blox receiver sends for an unknown velocity, m/s.
const UNKNOWN_SPEED_SIGMA_MPS: f64 = 1e3;

/// The measurement of a receiver at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Epoch {
    /// GPS weeks since 6 January 1980.
    pub week: u16,
    /// Milliseconds since the start of the week.
    pub time_of_week_ms: u32,
    /// Geodetic latitude, °.
    pub latitude_deg: f64,
    /// Longitude, °.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// Velocity north, east and down, m/s, if known.
    pub velocity_ned_mps: Option<[f64; 3]>,
    /// Standard deviation of the horizontal position, m.
    pub horizontal_sigma_m: f64,
    /// Standard deviation of the height, m.
    pub vertical_sigma_m: f64,
    /// Standard deviation of the velocity, m/s.
    pub speed_sigma_mps: f64,
    /// Satellites used, 1 to 12.
    pub satellites: u8,
}

impl Epoch {
    /// A vehicle that climbs and turns, at the `index`-th second of a flight.
    #[must_use]
    pub fn flying(index: u32) -> Self {
        let t = f64::from(index);
        Self {
            week: WEEK,
            time_of_week_ms: (446_988 + index) * 1_000,
            latitude_deg: 1.342_5 + 4e-5 * t,
            longitude_deg: 103.681_25 - 6e-5 * t,
            height_m: 41.0 + 2.0 * t,
            velocity_ned_mps: Some([4.4 + 0.25 * t, -6.6 + 0.5 * t, -2.0 + 0.125 * t]),
            horizontal_sigma_m: 1.1,
            vertical_sigma_m: 1.6,
            speed_sigma_mps: 0.17,
            satellites: 8 + (index % 4) as u8,
        }
    }

    /// The same data, `time_ms` later.
    #[must_use]
    pub fn later_by(self, time_ms: i64) -> Self {
        let time_ms = i64::from(self.time_of_week_ms) + time_ms;
        Self {
            week: (i64::from(self.week) + time_ms.div_euclid(WEEK_MS)) as u16,
            time_of_week_ms: time_ms.rem_euclid(WEEK_MS) as u32,
            ..self
        }
    }

    /// Seconds since the start of the week, in single precision as in TSIP.
    fn time_of_week_s(&self) -> f32 {
        (f64::from(self.time_of_week_ms) / 1e3) as f32
    }

    pub(super) fn utc(&self) -> DateTime<Utc> {
        // The start of GPS time, 6 January 1980, in Unix time.
        let start = DateTime::from_timestamp_nanos(315_964_800_000_000_000);
        start
            + TimeDelta::weeks(self.week.into())
            + TimeDelta::milliseconds(self.time_of_week_ms.into())
            - TimeDelta::seconds(LEAP_SECONDS.into())
    }
}

/// A TSIP packet: `id` and `payload` with their frame; 0x10 is doubled in the payload.
#[must_use]
pub fn tsip_packet(id: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0x10, id];
    for byte in payload {
        wire.push(*byte);
        if *byte == 0x10 {
            wire.push(0x10);
        }
    }
    wire.extend([0x10, 0x03]);
    wire
}

/// 0x41, time of week, week and leap seconds.
#[must_use]
pub fn tsip_time(epoch: &Epoch) -> Vec<u8> {
    let mut payload = Vec::new();
    payload.extend(epoch.time_of_week_s().to_be_bytes());
    payload.extend(epoch.week.to_be_bytes());
    payload.extend(f32::from(LEAP_SECONDS).to_be_bytes());
    tsip_packet(0x41, &payload)
}

/// A clock bias, m, that every position report carries.
const CLOCK_BIAS_M: f64 = -19_221.3;

fn lla(epoch: &Epoch) -> [f64; 4] {
    let [latitude, longitude] = [epoch.latitude_deg, epoch.longitude_deg].map(f64::to_radians);
    [latitude, longitude, epoch.height_m, CLOCK_BIAS_M]
}

/// 0x84, position in double precision.
#[must_use]
pub fn tsip_lla(epoch: &Epoch) -> Vec<u8> {
    let mut payload: Vec<u8> = lla(epoch).into_iter().flat_map(f64::to_be_bytes).collect();
    payload.extend(epoch.time_of_week_s().to_be_bytes());
    tsip_packet(0x84, &payload)
}

/// 0x4A, position in single precision.
#[must_use]
pub fn tsip_coarse_lla(epoch: &Epoch) -> Vec<u8> {
    let mut payload: Vec<u8> =
        lla(epoch).into_iter().flat_map(|value| (value as f32).to_be_bytes()).collect();
    payload.extend(epoch.time_of_week_s().to_be_bytes());
    tsip_packet(0x4A, &payload)
}

/// 0x56, velocity; no bytes if the velocity is unknown.
#[must_use]
pub fn tsip_enu(epoch: &Epoch) -> Vec<u8> {
    let Some([north, east, down]) = epoch.velocity_ned_mps else { return Vec::new() };
    let mut payload = Vec::new();
    for value in [east, north, -down, 123.4] {
        payload.extend((value as f32).to_be_bytes());
    }
    payload.extend(epoch.time_of_week_s().to_be_bytes());
    tsip_packet(0x56, &payload)
}

/// 0x6D, satellites and dilutions.
#[must_use]
pub fn tsip_satellites(epoch: &Epoch) -> Vec<u8> {
    let mut payload = vec![epoch.satellites << 4 | 4];
    for dilution in [2.9f32, 2.3, 1.7, 1.6] {
        payload.extend(dilution.to_be_bytes());
    }
    payload.extend(1..=epoch.satellites);
    tsip_packet(0x6D, &payload)
}

/// Position, velocity, satellites, and 0x82, the end of the second.
#[must_use]
pub fn tsip_epoch(epoch: &Epoch) -> Vec<u8> {
    let mut wire = tsip_lla(epoch);
    wire.extend(tsip_enu(epoch));
    wire.extend(tsip_satellites(epoch));
    wire.extend(tsip_packet(0x82, &[2]));
    wire
}

/// 0x8F-20, the combined fix; an unknown velocity is sent as an overflow.
#[must_use]
pub fn tsip_superpacket(epoch: &Epoch) -> Vec<u8> {
    let semicircles = |degrees: f64| (degrees / 180.0 * f64::from(1u32 << 31)).round() as i64;
    let velocity = epoch.velocity_ned_mps.map_or([i16::MIN; 3], |[north, east, down]| {
        [east, north, -down].map(|value| (value / 0.005).round() as i16)
    });
    let mut payload = vec![0x20, 0];
    payload.extend(velocity.into_iter().flat_map(i16::to_be_bytes));
    payload.extend(epoch.time_of_week_ms.to_be_bytes());
    payload.extend((semicircles(epoch.latitude_deg) as i32).to_be_bytes());
    let longitude = semicircles(epoch.longitude_deg).rem_euclid(1 << 32);
    payload.extend((longitude as u32).to_be_bytes());
    payload.extend(((epoch.height_m * 1e3).round() as i32).to_be_bytes());
    payload.extend([0, 0, 1, 0, epoch.satellites, LEAP_SECONDS]);
    payload.extend(epoch.week.to_be_bytes());
    payload.extend([0; 32]);
    tsip_packet(0x8F, &payload)
}

/// A UBX message with its frame and checksum.
#[must_use]
pub fn ubx_message(class: u8, id: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0xB5, 0x62, class, id];
    wire.extend((payload.len() as u16).to_le_bytes());
    wire.extend(payload);
    let checksum = ubx_checksum(&wire[2..]);
    wire.extend(checksum);
    wire
}

/// The checksum of a UBX message. `bytes` are the message from its class to the end of its payload.
#[must_use]
pub fn ubx_checksum(bytes: &[u8]) -> [u8; 2] {
    let (mut a, mut b) = (0u8, 0u8);
    for byte in bytes {
        a = a.wrapping_add(*byte);
        b = b.wrapping_add(a);
    }
    [a, b]
}

/// NAV-PVT: a 3-D fix, date and time valid.
#[must_use]
pub fn ubx_pvt(epoch: &Epoch) -> Vec<u8> {
    let utc = epoch.utc();
    let mut payload = Vec::new();
    payload.extend(epoch.time_of_week_ms.to_le_bytes());
    payload.extend((utc.year() as u16).to_le_bytes());
    let fields = [utc.month(), utc.day(), utc.hour(), utc.minute(), utc.second(), 0x37];
    payload.extend(fields.map(|field| field as u8));
    payload.extend(30u32.to_le_bytes());
    // Times of real receivers differ from whole milliseconds by some hundred nanoseconds.
    payload.extend((utc.nanosecond() as i32 - 133).to_le_bytes());
    payload.extend([3, 0x01, 0, epoch.satellites]);
    payload.extend(scaled(epoch.longitude_deg, 1e7));
    payload.extend(scaled(epoch.latitude_deg, 1e7));
    payload.extend(scaled(epoch.height_m, 1e3));
    payload.extend(scaled(epoch.height_m - GEOID_SEPARATION_M, 1e3));
    payload.extend(scaled(epoch.horizontal_sigma_m, 1e3));
    payload.extend(scaled(epoch.vertical_sigma_m, 1e3));
    let ([north, east, down], sigma) = known_velocity(epoch);
    for value in [north, east, down, north.hypot(east)] {
        payload.extend(scaled(value, 1e3));
    }
    payload.extend(scaled(0.0, 1e5));
    payload.extend(scaled(sigma, 1e3));
    payload.extend(scaled(20.0, 1e5));
    payload.extend(145u16.to_le_bytes());
    payload.resize(92, 0);
    ubx_message(0x01, 0x07, &payload)
}

/// NAV-POSLLH, NAV-STATUS and NAV-VELNED, as sent by receivers before 2012.
#[must_use]
pub fn ubx_older(epoch: &Epoch) -> Vec<u8> {
    let time = epoch.time_of_week_ms.to_le_bytes();
    let mut position = time.to_vec();
    position.extend(scaled(epoch.longitude_deg, 1e7));
    position.extend(scaled(epoch.latitude_deg, 1e7));
    position.extend(scaled(epoch.height_m, 1e3));
    position.extend(scaled(epoch.height_m - GEOID_SEPARATION_M, 1e3));
    position.extend(scaled(epoch.horizontal_sigma_m, 1e3));
    position.extend(scaled(epoch.vertical_sigma_m, 1e3));
    let mut status = time.to_vec();
    status.extend([3, 0x0D, 0, 0]);
    status.extend([0; 8]);
    let mut velocity = time.to_vec();
    let ([north, east, down], sigma) = known_velocity(epoch);
    for value in [north, east, down, 0.0, north.hypot(east)] {
        velocity.extend(scaled(value, 1e2));
    }
    velocity.extend(scaled(0.0, 1e5));
    velocity.extend(scaled(sigma, 1e2));
    velocity.extend(scaled(0.0, 1e5));
    let mut wire = ubx_message(0x01, 0x02, &position);
    wire.extend(ubx_message(0x01, 0x03, &status));
    wire.extend(ubx_message(0x01, 0x12, &velocity));
    wire
}

fn known_velocity(epoch: &Epoch) -> ([f64; 3], f64) {
    match epoch.velocity_ned_mps {
        Some(velocity) => (velocity, epoch.speed_sigma_mps),
        None => ([0.0; 3], UNKNOWN_SPEED_SIGMA_MPS),
    }
}

fn scaled(value: f64, per_unit: f64) -> [u8; 4] {
    ((value * per_unit).round() as i32).to_le_bytes()
}

/// An NMEA sentence with `body` between `$` and `*`.
#[must_use]
pub fn nmea_sentence(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

/// Latitude and longitude as NMEA fields, `ddmm.mmmmmm,N,dddmm.mmmmmm,E`.
#[must_use]
pub fn nmea_place(latitude_deg: f64, longitude_deg: f64) -> String {
    // In whole 1e-6 minutes, so that 59.9999999 is not printed as 60.
    let parts = |degrees: f64| {
        let units = (degrees.abs() * 60e6).round() as u64;
        (units / 60_000_000, units / 1_000_000 % 60, units % 1_000_000)
    };
    let (lat_d, lat_m, lat_f) = parts(latitude_deg);
    let (lon_d, lon_m, lon_f) = parts(longitude_deg);
    let north = if latitude_deg < 0.0 { 'S' } else { 'N' };
    let east = if longitude_deg < 0.0 { 'W' } else { 'E' };
    format!("{lat_d:02}{lat_m:02}.{lat_f:06},{north},{lon_d:03}{lon_m:02}.{lon_f:06},{east}")
}

/// RMC: position, speed and course over ground, date.
#[must_use]
pub fn nmea_rmc(epoch: &Epoch) -> Vec<u8> {
    let (time, utc) = (nmea_time(epoch), epoch.utc());
    let date = format!("{:02}{:02}{:02}", utc.day(), utc.month(), utc.year() % 100);
    let place = nmea_place(epoch.latitude_deg, epoch.longitude_deg);
    let [knots, course] = speed_and_course(epoch);
    nmea_sentence(&format!("GPRMC,{time},A,{place},{knots},{course},{date},,,A"))
}

/// GGA: position with height, satellites.
#[must_use]
pub fn nmea_gga(epoch: &Epoch) -> Vec<u8> {
    let (time, satellites) = (nmea_time(epoch), epoch.satellites);
    let place = nmea_place(epoch.latitude_deg, epoch.longitude_deg);
    let altitude = epoch.height_m - GEOID_SEPARATION_M;
    nmea_sentence(&format!(
        "GPGGA,{time},{place},1,{satellites:02},0.9,{altitude:.2},M,{GEOID_SEPARATION_M},M,,"
    ))
}

/// GSA: a 3-D fix with its dilutions.
#[must_use]
pub fn nmea_gsa(_epoch: &Epoch) -> Vec<u8> {
    nmea_sentence("GPGSA,A,3,01,02,03,04,05,06,07,08,,,,,1.6,0.9,1.3")
}

/// VTG: speed and course over ground.
#[must_use]
pub fn nmea_vtg(epoch: &Epoch) -> Vec<u8> {
    let [knots, course] = speed_and_course(epoch);
    nmea_sentence(&format!("GPVTG,{course},T,,M,{knots},N,,K,A"))
}

/// The sentences RMC, GGA, GSA and VTG of one epoch.
#[must_use]
pub fn nmea_epoch(epoch: &Epoch) -> Vec<u8> {
    [nmea_rmc, nmea_gga, nmea_gsa, nmea_vtg].iter().flat_map(|sentence| sentence(epoch)).collect()
}

fn nmea_time(epoch: &Epoch) -> String {
    let utc = epoch.utc();
    let (hour, minute, second) = (utc.hour(), utc.minute(), utc.second());
    format!("{hour:02}{minute:02}{second:02}.{:02}", utc.nanosecond() / 10_000_000)
}

/// Speed, knots, and course, ° from north; both empty if the velocity is unknown.
fn speed_and_course(epoch: &Epoch) -> [String; 2] {
    epoch.velocity_ned_mps.map_or_else(Default::default, |[north, east, _]| {
        let knots = north.hypot(east) * 3_600.0 / 1_852.0;
        let course = east.atan2(north).to_degrees().rem_euclid(360.0);
        [format!("{knots:.3}"), format!("{course:.2}")]
    })
}
