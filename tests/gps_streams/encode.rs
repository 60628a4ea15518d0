//! Messages as receivers send them, for streams whose truth is known.

/// What a receiver measured in one second.
#[derive(Clone, Copy, Debug)]
pub struct Epoch {
    /// Whole seconds since the start of GPS week 2 410.
    pub time_of_week_s: u32,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    /// Above the ellipsoid; the geoid is 7.5 m above it.
    pub height_m: f64,
    pub velocity_ned_mps: [f64; 3],
    pub satellites: u8,
}

pub const WEEK: u16 = 2_410;
pub const LEAP_SECONDS: u8 = 18;
pub const GEOID_SEPARATION_M: f64 = 7.5;

impl Epoch {
    /// A vehicle that climbs and turns, at the `index`-th second of a flight.
    pub fn flying(index: u32) -> Self {
        let t = f64::from(index);
        Self {
            time_of_week_s: 446_988 + index,
            latitude_deg: 1.342_5 + 4e-5 * t,
            longitude_deg: 103.681_25 - 6e-5 * t,
            height_m: 41.0 + 2.0 * t,
            velocity_ned_mps: [4.4 + 0.25 * t, -6.6 + 0.5 * t, -2.0 + 0.125 * t],
            satellites: 8 + (index % 4) as u8,
        }
    }

    fn utc(&self) -> (u32, u32, u32) {
        let seconds = (self.time_of_week_s - u32::from(LEAP_SECONDS)) % 86_400;
        (seconds / 3_600, seconds / 60 % 60, seconds % 60)
    }
}

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

pub fn tsip_time(epoch: &Epoch) -> Vec<u8> {
    let mut payload = Vec::new();
    payload.extend((epoch.time_of_week_s as f32).to_be_bytes());
    payload.extend(WEEK.to_be_bytes());
    payload.extend(f32::from(LEAP_SECONDS).to_be_bytes());
    tsip_packet(0x41, &payload)
}

pub fn tsip_lla(epoch: &Epoch) -> Vec<u8> {
    let mut payload = Vec::new();
    for value in [
        epoch.latitude_deg.to_radians(),
        epoch.longitude_deg.to_radians(),
        epoch.height_m,
        -19_221.3,
    ] {
        payload.extend(value.to_be_bytes());
    }
    payload.extend((epoch.time_of_week_s as f32).to_be_bytes());
    tsip_packet(0x84, &payload)
}

pub fn tsip_enu(epoch: &Epoch) -> Vec<u8> {
    let [north, east, down] = epoch.velocity_ned_mps;
    let mut payload = Vec::new();
    for value in [east, north, -down, 123.4, f64::from(epoch.time_of_week_s)] {
        payload.extend((value as f32).to_be_bytes());
    }
    tsip_packet(0x56, &payload)
}

pub fn tsip_satellites(epoch: &Epoch) -> Vec<u8> {
    let mut payload = vec![epoch.satellites << 4 | 4];
    for dilution in [2.9f32, 2.3, 1.7, 1.6] {
        payload.extend(dilution.to_be_bytes());
    }
    payload.extend(1..=epoch.satellites);
    tsip_packet(0x6D, &payload)
}

/// Position, velocity, satellites, end of the second.
pub fn tsip_epoch(epoch: &Epoch) -> Vec<u8> {
    let mut wire = tsip_lla(epoch);
    wire.extend(tsip_enu(epoch));
    wire.extend(tsip_satellites(epoch));
    wire.extend(tsip_packet(0x82, &[2]));
    wire
}

pub fn tsip_superpacket(epoch: &Epoch) -> Vec<u8> {
    let semicircles = |degrees: f64| (degrees / 180.0 * f64::from(1u32 << 31)).round() as i64;
    let [north, east, down] = epoch.velocity_ned_mps;
    let mut payload = vec![0x20, 0];
    for value in [east, north, -down] {
        payload.extend(((value / 0.005).round() as i16).to_be_bytes());
    }
    payload.extend((epoch.time_of_week_s * 1_000).to_be_bytes());
    payload.extend((semicircles(epoch.latitude_deg) as i32).to_be_bytes());
    let longitude = semicircles(epoch.longitude_deg).rem_euclid(1 << 32);
    payload.extend((longitude as u32).to_be_bytes());
    payload.extend(((epoch.height_m * 1e3).round() as i32).to_be_bytes());
    payload.extend([0, 0, 1, 0, epoch.satellites, LEAP_SECONDS]);
    payload.extend(WEEK.to_be_bytes());
    payload.extend([0; 32]);
    tsip_packet(0x8F, &payload)
}

pub fn ubx_message(class: u8, id: u8, payload: &[u8]) -> Vec<u8> {
    let mut wire = vec![0xB5, 0x62, class, id];
    wire.extend((payload.len() as u16).to_le_bytes());
    wire.extend(payload);
    let (mut a, mut b) = (0u8, 0u8);
    for byte in &wire[2..] {
        a = a.wrapping_add(*byte);
        b = b.wrapping_add(a);
    }
    wire.extend([a, b]);
    wire
}

/// NAV-PVT: a 3-D fix, date and time valid.
pub fn ubx_pvt(epoch: &Epoch) -> Vec<u8> {
    let (hour, minute, second) = epoch.utc();
    let mut payload = Vec::new();
    payload.extend((epoch.time_of_week_s * 1_000).to_le_bytes());
    // 446 988 s of week 2 410 are on Friday, 20 March 2026.
    payload.extend(2_026u16.to_le_bytes());
    payload.extend([3, 20, hour as u8, minute as u8, second as u8, 0x37]);
    payload.extend(30u32.to_le_bytes());
    payload.extend((-133i32).to_le_bytes());
    payload.extend([3, 0x01, 0, epoch.satellites]);
    payload.extend(scaled(epoch.longitude_deg, 1e7));
    payload.extend(scaled(epoch.latitude_deg, 1e7));
    payload.extend(scaled(epoch.height_m, 1e3));
    payload.extend(scaled(epoch.height_m - GEOID_SEPARATION_M, 1e3));
    payload.extend(scaled(1.1, 1e3));
    payload.extend(scaled(1.6, 1e3));
    let [north, east, down] = epoch.velocity_ned_mps;
    for value in [north, east, down, north.hypot(east)] {
        payload.extend(scaled(value, 1e3));
    }
    payload.extend(scaled(0.0, 1e5));
    payload.extend(scaled(0.17, 1e3));
    payload.extend(scaled(20.0, 1e5));
    payload.extend(145u16.to_le_bytes());
    payload.resize(92, 0);
    ubx_message(0x01, 0x07, &payload)
}

/// NAV-POSLLH, NAV-STATUS, NAV-VELNED, as a receiver before 2012 sends them.
pub fn ubx_older(epoch: &Epoch) -> Vec<u8> {
    let time = (epoch.time_of_week_s * 1_000).to_le_bytes();
    let mut position = time.to_vec();
    position.extend(scaled(epoch.longitude_deg, 1e7));
    position.extend(scaled(epoch.latitude_deg, 1e7));
    position.extend(scaled(epoch.height_m, 1e3));
    position.extend(scaled(epoch.height_m - GEOID_SEPARATION_M, 1e3));
    position.extend(scaled(2.2, 1e3));
    position.extend(scaled(3.3, 1e3));
    let mut status = time.to_vec();
    status.extend([3, 0x0D, 0, 0]);
    status.extend([0; 8]);
    let mut velocity = time.to_vec();
    let [north, east, down] = epoch.velocity_ned_mps;
    for value in [north, east, down, 0.0, north.hypot(east)] {
        velocity.extend(scaled(value, 1e2));
    }
    velocity.extend(scaled(0.0, 1e5));
    velocity.extend(scaled(0.3, 1e2));
    velocity.extend(scaled(0.0, 1e5));
    let mut wire = ubx_message(0x01, 0x02, &position);
    wire.extend(ubx_message(0x01, 0x03, &status));
    wire.extend(ubx_message(0x01, 0x12, &velocity));
    wire
}

fn scaled(value: f64, per_unit: f64) -> [u8; 4] {
    ((value * per_unit).round() as i32).to_le_bytes()
}

pub fn nmea_sentence(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

/// `ddmm.mmmmmm,N,dddmm.mmmmmm,E`.
pub fn nmea_place(latitude_deg: f64, longitude_deg: f64) -> String {
    // In whole 1e-6 minutes, lest 59.9999999 be printed as 60.
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

/// RMC, GGA, GSA, VTG.
pub fn nmea_epoch(epoch: &Epoch) -> Vec<u8> {
    let (hour, minute, second) = epoch.utc();
    let time = format!("{hour:02}{minute:02}{second:02}.00");
    let place = nmea_place(epoch.latitude_deg, epoch.longitude_deg);
    let [north, east, _] = epoch.velocity_ned_mps;
    let knots = north.hypot(east) * 3_600.0 / 1_852.0;
    let course = east.atan2(north).to_degrees().rem_euclid(360.0);
    let altitude = epoch.height_m - GEOID_SEPARATION_M;
    let satellites = epoch.satellites;
    let mut wire =
        nmea_sentence(&format!("GPRMC,{time},A,{place},{knots:.3},{course:.2},200326,,,A"));
    wire.extend(nmea_sentence(&format!(
        "GPGGA,{time},{place},1,{satellites:02},0.9,{altitude:.2},M,{GEOID_SEPARATION_M},M,,"
    )));
    wire.extend(nmea_sentence("GPGSA,A,3,01,02,03,04,05,06,07,08,,,,,1.6,0.9,1.3"));
    wire.extend(nmea_sentence(&format!("GPVTG,{course:.2},T,,M,{knots:.3},N,,K,A")));
    wire
}
