//! The messages of MAVLink's common set that are read: numbers, checksum seeds and fields.
//!
//! # Source
//! MAVLink, `common.xml`; fields are ordered by size, as MAVLink sends them.

use crate::primitive::Primitive::{self, F32, I16, I32, U8, U16, U32, U64};
use hovernav::earth::STANDARD_GRAVITY_MPS2;

/// A type of message that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Message {
    SystemTime,
    HighresImu,
    RawImu,
    ScaledImu,
    ScaledImu2,
    ScaledImu3,
    GpsRaw,
    Gps2Raw,
    GlobalPosition,
    LocalPosition,
    Attitude,
    AttitudeQuaternion,
    ScaledPressure,
    RcChannels,
    DistanceSensor,
    Rangefinder,
}

/// A thousandth of standard gravity, m/s².
const MILLI_G: f64 = 1e-3 * STANDARD_GRAVITY_MPS2;
const MILLI: f64 = 1e-3;
const CENTI: f64 = 1e-2;
const MICRO: f64 = 1e-6;

impl Message {
    /// Number of fields of the longest message.
    pub const WIDTH: usize = 13;

    const ALL: [Self; 16] = [
        Self::SystemTime,
        Self::HighresImu,
        Self::RawImu,
        Self::ScaledImu,
        Self::ScaledImu2,
        Self::ScaledImu3,
        Self::GpsRaw,
        Self::Gps2Raw,
        Self::GlobalPosition,
        Self::LocalPosition,
        Self::Attitude,
        Self::AttitudeQuaternion,
        Self::ScaledPressure,
        Self::RcChannels,
        Self::DistanceSensor,
        Self::Rangefinder,
    ];

    /// The message with this number, if it is read.
    pub fn numbered(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|message| message.number() == number)
    }

    const fn number(self) -> u32 {
        match self {
            Self::SystemTime => 2,
            Self::GpsRaw => 24,
            Self::ScaledImu => 26,
            Self::RawImu => 27,
            Self::ScaledPressure => 29,
            Self::Attitude => 30,
            Self::AttitudeQuaternion => 31,
            Self::LocalPosition => 32,
            Self::GlobalPosition => 33,
            Self::RcChannels => 65,
            Self::HighresImu => 105,
            Self::ScaledImu2 => 116,
            Self::Gps2Raw => 124,
            Self::ScaledImu3 => 129,
            Self::DistanceSensor => 132,
            Self::Rangefinder => 173,
        }
    }

    /// The seed byte that ends the checksum.
    pub const fn seed(self) -> u8 {
        match self {
            Self::SystemTime => 137,
            Self::GpsRaw => 24,
            Self::ScaledImu => 170,
            Self::RawImu => 144,
            Self::ScaledPressure => 115,
            Self::Attitude => 39,
            Self::AttitudeQuaternion => 246,
            Self::LocalPosition => 185,
            Self::GlobalPosition => 104,
            Self::RcChannels => 118,
            Self::HighresImu => 93,
            Self::ScaledImu2 => 76,
            Self::Gps2Raw => 87,
            Self::ScaledImu3 => 46,
            Self::DistanceSensor => 85,
            Self::Rangefinder => 83,
        }
    }

    /// MAVLink's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SystemTime => "SYSTEM_TIME",
            Self::GpsRaw => "GPS_RAW_INT",
            Self::ScaledImu => "SCALED_IMU",
            Self::RawImu => "RAW_IMU",
            Self::ScaledPressure => "SCALED_PRESSURE",
            Self::Attitude => "ATTITUDE",
            Self::AttitudeQuaternion => "ATTITUDE_QUATERNION",
            Self::LocalPosition => "LOCAL_POSITION_NED",
            Self::GlobalPosition => "GLOBAL_POSITION_INT",
            Self::RcChannels => "RC_CHANNELS",
            Self::HighresImu => "HIGHRES_IMU",
            Self::ScaledImu2 => "SCALED_IMU2",
            Self::Gps2Raw => "GPS2_RAW",
            Self::ScaledImu3 => "SCALED_IMU3",
            Self::DistanceSensor => "DISTANCE_SENSOR",
            Self::Rangefinder => "RANGEFINDER",
        }
    }

    /// Offset, type and factor of each field that is read. The factor converts to seconds, metres, degrees of
    /// latitude and longitude, radians, gauss or pascals. The first field is the time.
    const fn fields(self) -> &'static [(usize, Primitive, f64)] {
        match self {
            Self::SystemTime => &[(8, U32, MILLI), (0, U64, MICRO)],
            Self::HighresImu => &[
                (0, U64, MICRO),
                (20, F32, 1.0),
                (24, F32, 1.0),
                (28, F32, 1.0),
                (8, F32, 1.0),
                (12, F32, 1.0),
                (16, F32, 1.0),
                (32, F32, 1.0),
                (36, F32, 1.0),
                (40, F32, 1.0),
                (44, F32, 100.0),
                (60, U16, 1.0),
                (62, U8, 1.0),
            ],
            Self::RawImu => &[
                (0, U64, MICRO),
                (14, I16, MILLI),
                (16, I16, MILLI),
                (18, I16, MILLI),
                (8, I16, MILLI_G),
                (10, I16, MILLI_G),
                (12, I16, MILLI_G),
                (20, I16, MILLI),
                (22, I16, MILLI),
                (24, I16, MILLI),
            ],
            Self::ScaledImu | Self::ScaledImu2 | Self::ScaledImu3 => &[
                (0, U32, MILLI),
                (10, I16, MILLI),
                (12, I16, MILLI),
                (14, I16, MILLI),
                (4, I16, MILLI_G),
                (6, I16, MILLI_G),
                (8, I16, MILLI_G),
                (16, I16, MILLI),
                (18, I16, MILLI),
                (20, I16, MILLI),
            ],
            Self::GpsRaw => &[
                (0, U64, MICRO),
                (8, I32, 1e-7),
                (12, I32, 1e-7),
                (16, I32, MILLI),
                (24, U16, CENTI),
                (26, U16, CENTI),
                (28, U8, 1.0),
                (29, U8, 1.0),
                (30, I32, MILLI),
                (34, U32, MILLI),
                (38, U32, MILLI),
                (42, U32, MILLI),
                (50, U16, CENTI),
            ],
            Self::Gps2Raw => &[
                (0, U64, MICRO),
                (8, I32, 1e-7),
                (12, I32, 1e-7),
                (16, I32, MILLI),
                (28, U16, CENTI),
                (30, U16, CENTI),
                (32, U8, 1.0),
                (33, U8, 1.0),
                (37, I32, MILLI),
                (41, U32, MILLI),
                (45, U32, MILLI),
                (49, U32, MILLI),
                (35, U16, CENTI),
            ],
            Self::GlobalPosition => &[
                (0, U32, MILLI),
                (4, I32, 1e-7),
                (8, I32, 1e-7),
                (12, I32, MILLI),
                (20, I16, CENTI),
                (22, I16, CENTI),
                (24, I16, CENTI),
            ],
            Self::LocalPosition => {
                &[(0, U32, MILLI), (16, F32, 1.0), (20, F32, 1.0), (24, F32, 1.0)]
            }
            Self::Attitude => &[(0, U32, MILLI), (4, F32, 1.0), (8, F32, 1.0), (12, F32, 1.0)],
            Self::AttitudeQuaternion => {
                &[(0, U32, MILLI), (4, F32, 1.0), (8, F32, 1.0), (12, F32, 1.0), (16, F32, 1.0)]
            }
            Self::ScaledPressure => &[(0, U32, MILLI), (4, F32, 100.0)],
            Self::DistanceSensor => &[
                (0, U32, MILLI),
                (4, U16, CENTI),
                (6, U16, CENTI),
                (8, U16, CENTI),
                (12, U8, 1.0),
                (13, U8, 1.0),
                (38, U8, CENTI),
            ],
            // This message has no time.
            Self::Rangefinder => &[(8, F32, 1.0), (0, F32, 1.0)],
            Self::RcChannels => {
                &[(0, U32, MILLI), (4, U16, 1.0), (6, U16, 1.0), (8, U16, 1.0), (10, U16, 1.0)]
            }
        }
    }

    /// The fields in `payload`. MAVLink 2 omits trailing zeros.
    pub fn row(self, payload: &[u8]) -> [f64; Self::WIDTH] {
        let mut whole = [0; 255];
        let length = payload.len().min(whole.len());
        whole[..length].copy_from_slice(&payload[..length]);
        let mut row = [f64::NAN; Self::WIDTH];
        for (number, &(offset, kind, unit)) in row.iter_mut().zip(self.fields()) {
            *number = unit * kind.number(&whole, offset);
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::Message;

    #[test]
    fn no_message_is_wider_than_a_row() {
        assert!(Message::ALL.iter().all(|message| message.fields().len() <= Message::WIDTH));
    }

    #[test]
    fn omitted_trailing_zeros_are_zeros() {
        let row = Message::Attitude.row(&[0xE8, 3, 0, 0, 0, 0, 0x80, 0x3F]);
        assert_eq!(row[..4], [1.0, 1.0, 0.0, 0.0]);
    }
}
