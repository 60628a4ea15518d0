//! The reports, field by field as the receiver sends them.

use crate::frames::{Ecef, Vector};

/// 0x41: the time, every few seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpsTime {
    /// Seconds since the start of the week, GPS time; −1 while unknown.
    pub time_of_week_s: f32,
    /// Weeks since 6 January 1980; old firmware omits multiples of 1024.
    pub week: i16,
    /// GPS time minus UTC, s; 0 while unknown.
    pub utc_offset_s: f32,
}

/// 0x42 and 0x83: position in Earth-fixed coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionXyz {
    /// Position, m. It has full resolution in double precision (0x83), and steps of 0.5 m in single precision (0x42).
    pub position_m: Vector<Ecef>,
    /// Clock bias as a distance, m; 0x83 only.
    pub clock_bias_m: Option<f64>,
    /// Seconds since the start of the week; negative for a stored position, which is not a fix.
    pub time_of_fix_s: f32,
}

/// 0x43: velocity in Earth-fixed coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityXyz {
    /// Velocity, m/s.
    pub velocity_mps: Vector<Ecef>,
    /// Drift of the clock as a speed, m/s.
    pub clock_bias_rate_mps: f32,
    /// Seconds since the start of the week.
    pub time_of_fix_s: f32,
}

/// 0x45: versions of the navigation and the signal processor, as sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// Navigation processor: major, minor, month, day, year minus 1900.
    pub navigation: [u8; 5],
    /// Signal processor: major, minor, month, day, year minus 1900; later receivers count the year from 2000.
    pub signal: [u8; 5],
}

/// 0x46: health of the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Health {
    /// Status code. 0: computing fixes; 1: no GPS time; 2: needs initialisation; 3: PDOP too high. 8, 9, 10, 11: 0, 1,
    /// 2 or 3 usable satellites; 12: chosen satellite unusable.
    pub status: u8,
    /// Error bits. Bit 0: no battery back-up at start; bit 4: fault of the antenna line.
    pub errors: u8,
}

/// 0x4A and 0x84: position as latitude, longitude and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionLla {
    /// Geodetic latitude, rad, north positive.
    pub latitude_rad: f64,
    /// Longitude, rad, east positive.
    pub longitude_rad: f64,
    /// Height, m, above the ellipsoid or mean sea level according to [`IoOptions`].
    pub height_m: f64,
    /// Clock bias as a distance, m.
    pub clock_bias_m: f64,
    /// Seconds since the start of the week; negative for a stored position, which is not a fix.
    pub time_of_fix_s: f32,
}

/// 0x4B: model and additional status of the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MachineStatus {
    /// Model of the receiver.
    pub machine: u8,
    /// Status bits. Bit 1: no real-time clock at power-up; bit 3: almanac incomplete.
    pub status_1: u8,
    /// Status bits. Bit 0: superpackets supported.
    pub status_2: u8,
}

/// 0x55, and the data of command 0x35: settings of the automatic reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoOptions {
    /// Position reports. Bit 0: XYZ; 1: LLA; 2: heights above mean sea level; 4: double precision; 5: superpackets.
    pub position: u8,
    /// Velocity reports. Bit 0: XYZ; 1: ENU.
    pub velocity: u8,
    /// Timing. Bit 0: times are UTC.
    pub timing: u8,
    /// Auxiliary reports. Bit 0: raw measurements; 3: signal levels in dB-Hz.
    pub auxiliary: u8,
}

impl IoOptions {
    /// Settings for navigation: latitude, longitude and height above the ellipsoid in double precision, velocity
    /// east, north, up, GPS time.
    pub const NAVIGATION: Self =
        Self { position: 0x12, velocity: 0x02, timing: 0x00, auxiliary: 0x08 };

    /// Whether heights are above mean sea level rather than the ellipsoid.
    #[must_use]
    pub const fn heights_are_above_sea(self) -> bool {
        self.position & 0x04 != 0
    }

    /// Whether times of fix are UTC rather than GPS time.
    #[must_use]
    pub const fn times_are_utc(self) -> bool {
        self.timing & 0x01 != 0
    }
}

/// 0x56: velocity east, north, up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityEnu {
    /// East, m/s.
    pub east_mps: f32,
    /// North, m/s.
    pub north_mps: f32,
    /// Up, m/s.
    pub up_mps: f32,
    /// Drift of the clock as a speed, m/s.
    pub clock_bias_rate_mps: f32,
    /// Seconds since the start of the week.
    pub time_of_fix_s: f32,
}

/// 0x57: source of the last fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastFix {
    /// Source of the last fix: 0 no fix, 1 a regular fix.
    pub source: u8,
    /// The manufacturer's own code.
    pub diagnostic: u8,
    /// Seconds since the start of the week.
    pub time_of_week_s: f32,
    /// Weeks since 6 January 1980, as sent.
    pub week: i16,
}

/// 0x5C: tracking of one satellite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracking {
    /// PRN of the satellite.
    pub prn: u8,
    /// Slot and channel, as the receiver sent them.
    pub channel: u8,
    /// State of acquisition: 0 never acquired, 1 acquired, 2 search started again.
    pub acquisition: u8,
    /// Ephemeris flags, as the receiver sent them.
    pub ephemeris: u8,
    /// Signal level, AMU or dB-Hz according to [`IoOptions`].
    pub signal: f32,
    /// Time of the last measurement, s of the week.
    pub time_of_week_s: f32,
    /// Elevation, rad.
    pub elevation_rad: f32,
    /// Azimuth, rad.
    pub azimuth_rad: f32,
    /// Flags: old measurement, integer millisecond, bad data and data collection.
    pub flags: [u8; 4],
}

/// One slot of a list of satellites: the PRN, negative where the satellite is unhealthy.
pub type SatelliteSlot = i8;

/// 0x6D: the satellites used and the geometry they give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SatelliteSelection {
    /// Dimension of the fix, bits 0 to 2 of the first byte: 3 for a 2-D fix, 4 for a 3-D fix.
    pub dimension: u8,
    /// Whether satellites were chosen by hand.
    pub manual: bool,
    /// Dilution of precision of position, horizontal, vertical, time.
    pub dilution: [f32; 4],
    pub(super) prn: [SatelliteSlot; 15],
    pub(super) count: u8,
}

impl SatelliteSelection {
    /// The satellites in use; negative where unhealthy.
    #[must_use]
    pub fn prn(&self) -> &[SatelliteSlot] {
        self.prn.get(..usize::from(self.count)).unwrap_or_default()
    }
}

/// 0x82: differential mode, the last report of each second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Differential {
    /// Mode bits. Bit 0: this fix is corrected; bit 1: corrections are used when available.
    pub mode: u8,
}

/// One satellite of a [`Superpacket`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SatelliteIssue {
    /// Satellite, 1 to 32; 0 for an empty slot.
    pub prn: u8,
    /// Issue of the ephemeris in use.
    pub issue: u8,
}

/// 0x8F-20: a complete fix in one packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Superpacket {
    /// Velocity east, north, up, in counts of [`velocity_step_mps`](Self::velocity_step_mps);
    /// −32768 for overflow.
    pub velocity_counts: [i16; 3],
    /// Velocity of one count, m/s: 0.005 or 0.020.
    pub velocity_step_mps: f64,
    /// Milliseconds since the start of the week, GPS time.
    pub time_of_week_ms: u32,
    /// Latitude in 2⁻³¹ half-turns.
    pub latitude_semicircles: i32,
    /// Longitude in 2⁻³¹ half-turns, 0 to 2.
    pub longitude_semicircles: u32,
    /// Height above the ellipsoid, mm.
    pub height_mm: i32,
    /// Datum number plus one: 1 is WGS-84; 0: datum not given.
    pub datum: u8,
    /// Bits of the fix. Bit 0: no fix; 1: differential; 2: 2-D; 3: height fixed; 4: filtered.
    pub fix: u8,
    /// Satellites used.
    pub satellites: u8,
    /// GPS time minus UTC, s.
    pub leap_seconds: u8,
    /// Weeks since 6 January 1980, as sent.
    pub week: u16,
    pub(super) issues: [SatelliteIssue; 12],
    pub(super) slots: u8,
}

impl Superpacket {
    /// The slots for satellites: 8 or 12, the empty ones with PRN 0.
    #[must_use]
    pub fn issues(&self) -> &[SatelliteIssue] {
        self.issues.get(..usize::from(self.slots)).unwrap_or_default()
    }
}

/// 0x8F-23: a complete fix in one short packet, sent by later receivers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compact {
    /// Milliseconds since the start of the week, GPS time.
    pub time_of_week_ms: u32,
    /// Weeks since 6 January 1980, as sent.
    pub week: u16,
    /// GPS time minus UTC, s.
    pub leap_seconds: u8,
    /// Bits of the fix. Bit 0: no fix; 1: differential; 2: 2-D; 5: velocity in steps of 0.020 m/s.
    pub fix: u8,
    /// Latitude in 2⁻³¹ half-turns.
    pub latitude_semicircles: i32,
    /// Longitude in 2⁻³¹ half-turns, 0 to 2.
    pub longitude_semicircles: u32,
    /// Height, mm.
    pub height_mm: i32,
    /// Velocity east, north, up, in counts; −32768 for overflow.
    pub velocity_counts: [i16; 3],
}

impl Compact {
    /// Velocity of one count, m/s.
    #[must_use]
    pub const fn velocity_step_mps(&self) -> f64 {
        velocity_step_mps(self.fix & 0x20 != 0)
    }
}

pub(super) const fn velocity_step_mps(coarse: bool) -> f64 {
    if coarse { 0.020 } else { 0.005 }
}

/// Contents of a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "each variant's type says it")]
pub enum Report {
    GpsTime(GpsTime),
    PositionXyz(PositionXyz),
    VelocityXyz(VelocityXyz),
    Version(Version),
    Health(Health),
    /// 0x84: double precision.
    PositionLla(PositionLla),
    /// 0x4A: single precision, in steps of 2 m: not for navigation.
    CoarsePositionLla(PositionLla),
    /// The short form of 0x4A: the height used for 2-D fixes, m, and whether it is used.
    ReferenceHeight {
        height_m: f32,
        active: bool,
    },
    MachineStatus(MachineStatus),
    IoOptions(IoOptions),
    VelocityEnu(VelocityEnu),
    LastFix(LastFix),
    Tracking(Tracking),
    SatelliteSelection(SatelliteSelection),
    Differential(Differential),
    Superpacket(Superpacket),
    Compact(Compact),
}
