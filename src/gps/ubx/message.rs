//! Reads messages from their payloads, in SI units and degrees.
//!
//! # Source
//! u-blox, *u-blox 8 / M8 Receiver Description Including Protocol Specification*, UBX-13003221,
//! section 32.

use crate::buffer::Bytes;
use crate::frames::{Ecef, Vector};
use crate::gps::{DilutionOfPrecision, Dimension};

/// The receiver's answer to a configuration message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acknowledgement {
    /// Class of the answered message.
    pub class: u8,
    /// Id of the answered message.
    pub id: u8,
    /// Whether the receiver accepted the message.
    pub accepted: bool,
}

/// Class and id of NAV-PVT.
pub(super) const NAV_PVT: (u8, u8) = (0x01, 0x07);

/// Type and validity of a fix, in NAV-PVT, NAV-SOL and NAV-STATUS.
#[derive(Clone, Copy, Debug)]
pub(super) struct FixStatus {
    fix_type: u8,
    flags: u8,
}

impl FixStatus {
    /// Dimension of the fix from satellites; `None` for dead reckoning alone, for time alone, and without a fix.
    pub fn dimension(self) -> Option<Dimension> {
        match self.fix_type {
            2 => Some(Dimension::TwoD),
            // 3-D, and combined with dead reckoning.
            3 | 4 => Some(Dimension::ThreeD),
            _ => None,
        }
    }

    /// Whether `gnssFixOK` is set and satellites contributed.
    pub fn is_usable(self) -> bool {
        self.flags & 0x01 != 0 && self.dimension().is_some()
    }

    pub fn is_differential(self) -> bool {
        self.flags & 0x02 != 0
    }

    /// Whether the week is known: only in NAV-SOL and NAV-STATUS.
    pub fn week_is_known(self) -> bool {
        self.flags & 0x04 != 0
    }

    /// Whether the time of week is known: only in NAV-SOL and NAV-STATUS.
    pub fn time_of_week_is_known(self) -> bool {
        self.flags & 0x08 != 0
    }

    /// Whether the fix uses the carrier phase with unresolved (float) ambiguities: only in NAV-PVT.
    pub fn is_rtk_float(self) -> bool {
        self.flags & 0x40 != 0
    }

    /// Whether the fix uses the carrier phase with resolved (integer) ambiguities: only in NAV-PVT.
    pub fn is_rtk_fixed(self) -> bool {
        self.flags & 0x80 != 0
    }
}

/// The used fields of NAV-PVT.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pvt {
    pub time_of_week_ms: u32,
    pub utc: CalendarTime,
    pub status: FixStatus,
    pub position: Position,
    pub velocity: Velocity,
    pub satellites: u8,
    pub position_dilution: f64,
    /// Whether the position must not be used, for any status.
    pub position_is_invalid: bool,
}

/// UTC of NAV-PVT, before the range check.
#[derive(Clone, Copy, Debug)]
pub(super) struct CalendarTime {
    pub year: u16,
    pub month: u8,
    pub day: u8,
    pub hour: u8,
    pub minute: u8,
    pub second: u8,
    /// Nanosecond; it may be negative, because the second is rounded.
    pub nanosecond: i32,
    /// Whether the receiver marks date and time as valid.
    pub is_valid: bool,
}

/// Data of NAV-POSLLH, and the same data in NAV-PVT.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    pub longitude_deg: f64,
    pub latitude_deg: f64,
    pub height_m: f64,
    pub altitude_msl_m: f64,
    pub horizontal_sigma_m: f64,
    pub vertical_sigma_m: f64,
}

/// Data of NAV-VELNED, and the same data in NAV-PVT.
#[derive(Clone, Copy, Debug)]
pub(super) struct Velocity {
    pub ned_mps: [f64; 3],
    pub sigma_mps: f64,
}

/// Data of NAV-SOL.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solution {
    pub fraction_ns: i32,
    pub week: i16,
    pub status: FixStatus,
    pub position_m: Vector<Ecef>,
    pub position_sigma_m: f64,
    pub velocity_mps: [f64; 3],
    pub velocity_sigma_mps: f64,
    pub position_dilution: f64,
    pub satellites: u8,
}

/// Data of NAV-TIMEGPS; invalid fields are `None`.
#[derive(Clone, Copy, Debug)]
pub(super) struct GpsTime {
    /// Fraction to add to the time of week, ns; `None` if invalid.
    pub fraction_ns: Option<i32>,
    pub week: Option<i16>,
    pub leap_seconds: Option<i8>,
}

/// Contents of a message of an epoch, except its time of week.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    Position(Position),
    Status(FixStatus),
    Dilution(DilutionOfPrecision),
    Solution(Solution),
    Velocity(Velocity),
    Time(GpsTime),
}

/// Contents of a message.
#[derive(Clone, Copy, Debug)]
pub(super) enum Report {
    Pvt(Pvt),
    Epoch { time_of_week_ms: u32, content: Content },
    Answer(Acknowledgement),
}

impl Report {
    /// Reads a message; `None` if it is unknown or too short.
    pub fn read(class: u8, id: u8, payload: &[u8]) -> Option<Self> {
        let mut data: Reader<'_> = Bytes(payload);
        if class == 0x05 {
            let (class, answered) = (data.u8()?, data.u8()?);
            return Some(Self::Answer(Acknowledgement { class, id: answered, accepted: id == 1 }));
        }
        let time_of_week_ms = data.u32()?;
        let content = match (class, id) {
            NAV_PVT => return data.pvt(time_of_week_ms).map(Self::Pvt),
            (0x01, 0x02) => Content::Position(data.position()?),
            (0x01, 0x03) => Content::Status(data.status()?),
            (0x01, 0x04) => Content::Dilution(data.dilution()?),
            (0x01, 0x06) => Content::Solution(data.solution()?),
            (0x01, 0x12) => Content::Velocity(data.velocity()?),
            (0x01, 0x20) => Content::Time(data.gps_time()?),
            _ => return None,
        };
        Some(Self::Epoch { time_of_week_ms, content })
    }
}

/// A dilution; 99.99 means unknown.
pub(super) fn known_dilution(value: f64) -> Option<f64> {
    Some(value).filter(|value| *value > 0.0 && *value < 99.9)
}

/// Values from the front of a payload, little-endian.
type Reader<'a> = Bytes<'a, false>;

impl Reader<'_> {
    /// A signed number in steps of `step`.
    fn signed(&mut self, step: f64) -> Option<f64> {
        self.i32().map(|steps| f64::from(steps) * step)
    }

    /// An unsigned number in steps of `step`.
    fn unsigned(&mut self, step: f64) -> Option<f64> {
        self.u32().map(|steps| f64::from(steps) * step)
    }

    fn three_signed(&mut self, step: f64) -> Option<[f64; 3]> {
        Some([self.signed(step)?, self.signed(step)?, self.signed(step)?])
    }

    fn hundredths(&mut self) -> Option<f64> {
        self.u16().map(|steps| f64::from(steps) * 1e-2)
    }

    fn status(&mut self) -> Option<FixStatus> {
        Some(FixStatus { fix_type: self.u8()?, flags: self.u8()? })
    }

    fn pvt(&mut self, time_of_week_ms: u32) -> Option<Pvt> {
        let year = self.u16()?;
        let [month, day, hour, minute, second, valid] = self.take()?;
        self.take::<4>()?;
        let nanosecond = self.i32()?;
        let is_valid = valid & 0x03 == 0x03;
        let utc = CalendarTime { year, month, day, hour, minute, second, nanosecond, is_valid };
        let status = self.status()?;
        self.take::<1>()?;
        let satellites = self.u8()?;
        let position = self.position()?;
        let ned_mps = self.three_signed(1e-3)?;
        // Ground speed and heading of motion.
        self.take::<8>()?;
        let velocity = Velocity { ned_mps, sigma_mps: self.unsigned(1e-3)? };
        self.take::<4>()?;
        Some(Pvt {
            time_of_week_ms,
            utc,
            status,
            position,
            velocity,
            satellites,
            position_dilution: self.hundredths()?,
            position_is_invalid: self.u16()? & 0x01 != 0,
        })
    }

    fn position(&mut self) -> Option<Position> {
        Some(Position {
            longitude_deg: self.signed(1e-7)?,
            latitude_deg: self.signed(1e-7)?,
            height_m: self.signed(1e-3)?,
            altitude_msl_m: self.signed(1e-3)?,
            horizontal_sigma_m: self.unsigned(1e-3)?,
            vertical_sigma_m: self.unsigned(1e-3)?,
        })
    }

    fn velocity(&mut self) -> Option<Velocity> {
        let ned_mps = self.three_signed(1e-2)?;
        // Speed, ground speed and heading of motion.
        self.take::<12>()?;
        Some(Velocity { ned_mps, sigma_mps: self.unsigned(1e-2)? })
    }

    fn solution(&mut self) -> Option<Solution> {
        let (fraction_ns, week, status) = (self.i32()?, self.i16()?, self.status()?);
        let position_m = Vector::from(self.three_signed(1e-2)?);
        let position_sigma_m = self.unsigned(1e-2)?;
        let velocity_mps = self.three_signed(1e-2)?;
        let velocity_sigma_mps = self.unsigned(1e-2)?;
        let position_dilution = self.hundredths()?;
        let [_, satellites] = self.take()?;
        Some(Solution {
            fraction_ns,
            week,
            status,
            position_m,
            position_sigma_m,
            velocity_mps,
            velocity_sigma_mps,
            position_dilution,
            satellites,
        })
    }

    fn dilution(&mut self) -> Option<DilutionOfPrecision> {
        let [_geometric, position, _time, vertical, horizontal] = [
            self.hundredths()?,
            self.hundredths()?,
            self.hundredths()?,
            self.hundredths()?,
            self.hundredths()?,
        ];
        let [position, horizontal, vertical] = [position, horizontal, vertical].map(known_dilution);
        Some(DilutionOfPrecision { position, horizontal, vertical })
    }

    fn gps_time(&mut self) -> Option<GpsTime> {
        let (fraction_ns, week) = (self.i32()?, self.i16()?);
        let [leap_seconds, valid] = self.take()?;
        Some(GpsTime {
            fraction_ns: Some(fraction_ns).filter(|_| valid & 0x01 != 0),
            week: Some(week).filter(|_| valid & 0x02 != 0),
            leap_seconds: Some(leap_seconds.cast_signed()).filter(|_| valid & 0x04 != 0),
        })
    }
}
