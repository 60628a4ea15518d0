//! Checks the values of the reports and converts them to values of a fix.

use core::f64::consts::PI;

use super::{Compact, PositionLla, PositionXyz, Superpacket, VelocityEnu, VelocityXyz};
use crate::earth::Geodetic;
use crate::frames::{Ecef, Ned, Vector};
use crate::gps::Correction;
use crate::gps::receiver_fix::{Horizontal, plausible_height, plausible_velocity};
use crate::gps::receiver_time::time_of_week_ns;

#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    pub place: Horizontal,
    pub height_m: f64,
    pub above_ellipsoid: bool,
}

impl Position {
    pub fn from_lla(report: &PositionLla, above_ellipsoid: bool) -> Option<Self> {
        Some(Self {
            place: Horizontal::new(report.latitude_rad, report.longitude_rad)?,
            height_m: plausible_height(report.height_m)?,
            above_ellipsoid,
        })
    }

    pub fn from_xyz(report: &PositionXyz) -> Option<Self> {
        let place = Geodetic::from_ecef(report.position_m)?;
        Some(Self {
            place: Horizontal::new(place.latitude_rad, place.longitude_rad)?,
            height_m: plausible_height(place.height_m)?,
            above_ellipsoid: true,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Velocity {
    EastNorthUp([f64; 3]),
    EarthFixed(Vector<Ecef>),
}

impl Velocity {
    pub fn from_enu(report: &VelocityEnu) -> Option<Self> {
        let enu = [report.east_mps, report.north_mps, report.up_mps].map(f64::from);
        plausible_velocity(enu).map(Self::EastNorthUp)
    }

    pub fn from_xyz(report: &VelocityXyz) -> Option<Self> {
        let xyz = plausible_velocity(report.velocity_mps.to_array())?;
        Some(Self::EarthFixed(xyz.into()))
    }

    pub fn at(self, position: &Position) -> Vector<Ned> {
        match self {
            Self::EastNorthUp([east, north, up]) => Vector::new(north, east, -up),
            Self::EarthFixed(velocity) => {
                let Horizontal { latitude_rad, longitude_rad } = position.place;
                let place = Geodetic { latitude_rad, longitude_rad, height_m: position.height_m };
                place.ecef_to_ned() * velocity
            }
        }
    }
}

/// A complete fix in one packet: the data that 0x8F-20 and 0x8F-23 have in common.
pub(super) struct CompleteFix {
    pub time_of_week_s: f64,
    pub week: u16,
    pub leap_seconds: u8,
    pub fix_flags: u8,
    pub satellites: Option<u8>,
    pub position: Position,
    pub velocity: Option<Velocity>,
}

impl CompleteFix {
    /// The fix of a superpacket. `None` for impossible values and for a datum other than WGS-84 (0 means that no datum
    /// is given).
    pub fn from_superpacket(packet: &Superpacket) -> Option<Self> {
        let complete = Self {
            time_of_week_s: in_week(f64::from(packet.time_of_week_ms) * 1e-3)?,
            week: packet.week,
            leap_seconds: packet.leap_seconds,
            fix_flags: packet.fix,
            satellites: Some(packet.satellites),
            position: semicircles(
                packet.latitude_semicircles,
                packet.longitude_semicircles,
                packet.height_mm,
            )?,
            velocity: counts(packet.velocity_counts, packet.velocity_step_mps),
        };
        (packet.datum <= 1).then_some(complete)
    }

    pub fn from_compact(packet: &Compact) -> Option<Self> {
        Some(Self {
            time_of_week_s: in_week(f64::from(packet.time_of_week_ms) * 1e-3)?,
            week: packet.week,
            leap_seconds: packet.leap_seconds,
            fix_flags: packet.fix,
            satellites: None,
            position: semicircles(
                packet.latitude_semicircles,
                packet.longitude_semicircles,
                packet.height_mm,
            )?,
            velocity: counts(packet.velocity_counts, packet.velocity_step_mps()),
        })
    }
}

/// The time of week, s, if it is within one week.
pub(super) fn in_week(seconds: f64) -> Option<f64> {
    time_of_week_ns(seconds).map(|_| seconds)
}

fn semicircles(latitude: i32, longitude: u32, height_mm: i32) -> Option<Position> {
    const RADIANS: f64 = PI / (1u32 << 31) as f64;
    let place = Horizontal::new(f64::from(latitude) * RADIANS, f64::from(longitude) * RADIANS)?;
    let height_m = plausible_height(f64::from(height_mm) * 1e-3)?;
    Some(Position { place, height_m, above_ellipsoid: true })
}

/// Velocity from counts; `None` if one of them is the overflow value.
fn counts(counts: [i16; 3], step_mps: f64) -> Option<Velocity> {
    (!counts.contains(&i16::MIN))
        .then(|| Velocity::EastNorthUp(counts.map(|count| f64::from(count) * step_mps)))
}

/// GPS time minus UTC, if it is plausible: receivers send 0 while it is unknown.
pub(super) fn leap_seconds(seconds: f64) -> Option<u8> {
    (1.0..=60.0).contains(&seconds).then(|| libm::round(seconds) as u8)
}

pub(super) fn correction(corrected: bool) -> Correction {
    if corrected { Correction::Differential } else { Correction::None }
}
