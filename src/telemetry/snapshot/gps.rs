//! The receiver's last fix.

use crate::frames::Vector;
use crate::gps::{Correction, Dimension, ReceiverFix};
use crate::time::Time;

/// Kind of the receiver's fix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FixKind {
    /// No data from the receiver yet.
    #[default]
    NoReceiver,
    /// The receiver sends data but has no fix.
    NoFix,
    /// Latitude and longitude only.
    TwoD,
    /// Latitude, longitude and height.
    ThreeD,
    /// Latitude, longitude and height, with code corrections.
    Differential,
    /// Carrier phase with unresolved (float) ambiguities.
    RtkFloat,
    /// Carrier phase with resolved (integer) ambiguities.
    RtkFixed,
}

impl FixKind {
    /// All kinds, in the order of their codes.
    const ALL: [Self; 7] = [
        Self::NoReceiver,
        Self::NoFix,
        Self::TwoD,
        Self::ThreeD,
        Self::Differential,
        Self::RtkFloat,
        Self::RtkFixed,
    ];

    /// Code of the kind in a frame, equal to MAVLink's.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The kind of a code in a frame.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}

/// Summary of the receiver's last fix, as received.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpsSummary {
    /// Kind of the fix.
    pub fix: FixKind,
    /// Number of satellites used.
    pub satellites: Option<u8>,
    /// Time since the fix arrived, s.
    pub age_s: Option<f64>,
    /// Latitude and longitude, °, WGS-84.
    pub latitude_longitude_deg: Option<[f64; 2]>,
    /// Height above the ellipsoid, m.
    pub height_m: Option<f64>,
    /// Height above mean sea level by the receiver's geoid, m.
    pub altitude_msl_m: Option<f64>,
    /// Velocity north and east, m/s.
    pub horizontal_velocity_mps: Option<[f64; 2]>,
    /// Velocity downwards, m/s.
    pub down_velocity_mps: Option<f64>,
    /// Horizontal dilution of precision.
    pub hdop: Option<f64>,
    /// Vertical dilution of precision.
    pub vdop: Option<f64>,
    /// One-sigma of the horizontal position, m, as the receiver reports it. The packed frames do not contain it.
    pub horizontal_sigma_m: Option<f64>,
    /// One-sigma of the height, m, as the receiver reports it. The packed frames do not contain it.
    pub vertical_sigma_m: Option<f64>,
    /// Largest one-sigma of the velocity on any axis, m/s, as the receiver reports it. The packed frames do not contain
    /// it.
    pub velocity_sigma_mps: Option<f64>,
}

impl GpsSummary {
    /// Summary of `fix` at `now`, on the clock of its arrival.
    #[must_use]
    pub fn of(fix: &ReceiverFix, now: Time) -> Self {
        let kind = match (fix.correction, fix.dimension) {
            (Some(Correction::RtkFixed), _) => FixKind::RtkFixed,
            (Some(Correction::RtkFloat), _) => FixKind::RtkFloat,
            (_, Some(Dimension::TwoD)) => FixKind::TwoD,
            (Some(Correction::Differential), _) => FixKind::Differential,
            _ => FixKind::ThreeD,
        };
        let latitude_deg = fix.latitude_rad.to_degrees();
        Self {
            fix: kind,
            satellites: fix.satellites,
            age_s: Some((now - fix.arrival).max(0.0)),
            latitude_longitude_deg: Some([latitude_deg, fix.longitude_rad.to_degrees()]),
            height_m: fix.height_m,
            altitude_msl_m: fix.altitude_msl_m,
            horizontal_velocity_mps: fix.horizontal_velocity_mps,
            down_velocity_mps: fix.down_velocity_mps,
            hdop: fix.dilution.horizontal,
            vdop: fix.dilution.vertical,
            horizontal_sigma_m: fix.position_sigma_m.map(|sigma_m| sigma_m.x().max(sigma_m.y())),
            vertical_sigma_m: fix.position_sigma_m.map(Vector::z),
            velocity_sigma_mps: fix.velocity_sigma_mps.map(|sigma_mps| {
                let [north, east, down] = sigma_mps.to_array();
                north.max(east).max(down)
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_names_one_kind_of_fix() {
        for code in 0..=u8::MAX {
            assert!(FixKind::from_code(code).is_none_or(|kind| kind.code() == code));
        }
        assert!(FixKind::ALL.iter().all(|kind| FixKind::from_code(kind.code()) == Some(*kind)));
    }
}
