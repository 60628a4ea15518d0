//! Reads reports from the bytes of packets.

use super::report::{
    Compact, Differential, GpsTime, Health, IoOptions, LastFix, MachineStatus, PositionLla,
    PositionXyz, Report, SatelliteIssue, SatelliteSelection, Superpacket, Tracking, VelocityEnu,
    VelocityXyz, Version, velocity_step_mps,
};
use crate::buffer::Bytes;
use crate::frames::Vector;

/// Reason why a packet is not a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportError {
    /// A report that this module does not read.
    Unknown {
        /// The packet's id.
        id: u8,
    },
    /// A known report of an impossible length: bytes were lost or added.
    Length {
        /// The packet's id.
        id: u8,
        /// The payload's length, bytes.
        found: usize,
    },
}

impl Report {
    /// Reads a packet whose length must be exactly that of its kind. Values are as sent, without a range check.
    ///
    /// # Errors
    /// [`ReportError::Unknown`] for unused packets, [`ReportError::Length`] for damaged packets.
    pub fn read(id: u8, payload: &[u8]) -> Result<Self, ReportError> {
        Self::parse(id, payload).ok_or_else(|| match (id, payload.first()) {
            (0x8F, None | Some(0x20 | 0x23))
            | (0x41..=0x43 | 0x45 | 0x46 | 0x4A | 0x4B | 0x55..=0x57 | 0x5C, _)
            | (0x6D | 0x82..=0x84, _) => ReportError::Length { id, found: payload.len() },
            _ => ReportError::Unknown { id },
        })
    }

    fn parse(id: u8, payload: &[u8]) -> Option<Self> {
        let mut data: Reader<'_> = Bytes(payload);
        Some(match (id, payload.len()) {
            (0x41, 10) => Self::GpsTime(GpsTime {
                time_of_week_s: data.f32()?,
                week: data.i16()?,
                utc_offset_s: data.f32()?,
            }),
            (0x42, 16) => Self::PositionXyz(PositionXyz {
                position_m: Vector::new(
                    f64::from(data.f32()?),
                    f64::from(data.f32()?),
                    f64::from(data.f32()?),
                ),
                clock_bias_m: None,
                time_of_fix_s: data.f32()?,
            }),
            (0x83, 36) => Self::PositionXyz(PositionXyz {
                position_m: Vector::new(data.f64()?, data.f64()?, data.f64()?),
                clock_bias_m: Some(data.f64()?),
                time_of_fix_s: data.f32()?,
            }),
            (0x43, 20) => Self::VelocityXyz(VelocityXyz {
                velocity_mps: Vector::new(
                    f64::from(data.f32()?),
                    f64::from(data.f32()?),
                    f64::from(data.f32()?),
                ),
                clock_bias_rate_mps: data.f32()?,
                time_of_fix_s: data.f32()?,
            }),
            (0x45, 10) => Self::Version(Version { navigation: data.take()?, signal: data.take()? }),
            (0x46, 2) => Self::Health(Health { status: data.u8()?, errors: data.u8()? }),
            (0x4A, 20) => Self::CoarsePositionLla(PositionLla {
                latitude_rad: f64::from(data.f32()?),
                longitude_rad: f64::from(data.f32()?),
                height_m: f64::from(data.f32()?),
                clock_bias_m: f64::from(data.f32()?),
                time_of_fix_s: data.f32()?,
            }),
            (0x4A, 9) => {
                let height_m = data.f32()?;
                data.take::<4>()?;
                Self::ReferenceHeight { height_m, active: data.u8()? != 0 }
            }
            (0x84, 36) => Self::PositionLla(PositionLla {
                latitude_rad: data.f64()?,
                longitude_rad: data.f64()?,
                height_m: data.f64()?,
                clock_bias_m: data.f64()?,
                time_of_fix_s: data.f32()?,
            }),
            (0x4B, 3) => Self::MachineStatus(MachineStatus {
                machine: data.u8()?,
                status_1: data.u8()?,
                status_2: data.u8()?,
            }),
            (0x55, 4) => Self::IoOptions(IoOptions {
                position: data.u8()?,
                velocity: data.u8()?,
                timing: data.u8()?,
                auxiliary: data.u8()?,
            }),
            (0x56, 20) => Self::VelocityEnu(VelocityEnu {
                east_mps: data.f32()?,
                north_mps: data.f32()?,
                up_mps: data.f32()?,
                clock_bias_rate_mps: data.f32()?,
                time_of_fix_s: data.f32()?,
            }),
            (0x57, 8) => Self::LastFix(LastFix {
                source: data.u8()?,
                diagnostic: data.u8()?,
                time_of_week_s: data.f32()?,
                week: data.i16()?,
            }),
            (0x5C, 24) => Self::Tracking(Tracking {
                prn: data.u8()?,
                channel: data.u8()?,
                acquisition: data.u8()?,
                ephemeris: data.u8()?,
                signal: data.f32()?,
                time_of_week_s: data.f32()?,
                elevation_rad: data.f32()?,
                azimuth_rad: data.f32()?,
                flags: data.take()?,
            }),
            (0x6D, _) => Self::SatelliteSelection(data.satellite_selection()?),
            (0x82, 1) => Self::Differential(Differential { mode: data.u8()? }),
            (0x8F, 56 | 64) if payload.first() == Some(&0x20) => {
                Self::Superpacket(data.superpacket()?)
            }
            (0x8F, 29) if payload.first() == Some(&0x23) => Self::Compact(data.compact()?),
            _ => return None,
        })
    }
}

/// Values from the front of a payload, big-endian.
type Reader<'a> = Bytes<'a, true>;

impl Reader<'_> {
    fn satellite_selection(&mut self) -> Option<SatelliteSelection> {
        let first = self.u8()?;
        let dilution = [self.f32()?, self.f32()?, self.f32()?, self.f32()?];
        let mut prn = [0; 15];
        if usize::from(first >> 4) != self.0.len() {
            return None;
        }
        for (slot, byte) in prn.iter_mut().zip(self.0) {
            *slot = byte.cast_signed();
        }
        Some(SatelliteSelection {
            dimension: first & 0x07,
            manual: first & 0x08 != 0,
            dilution,
            prn,
            count: first >> 4,
        })
    }

    /// Reads a superpacket: 56 bytes with 8 slots for satellites, or 64 bytes with 12 slots. Both end with 8 bytes on
    /// the ionosphere.
    ///
    /// Navigation needs only the first 32 bytes. Without a checksum, however, the exact length is the only sign of
    /// lost or added bytes.
    fn superpacket(&mut self) -> Option<Superpacket> {
        self.take::<2>()?;
        let velocity_counts = [self.i16()?, self.i16()?, self.i16()?];
        let time_of_week_ms = self.u32()?;
        let latitude_semicircles = self.i32()?;
        let longitude_semicircles = self.u32()?;
        let height_mm = self.i32()?;
        let coarse = self.u8()? & 0x01 != 0;
        self.take::<1>()?;
        let datum = self.u8()?;
        let fix = self.u8()?;
        let satellites = self.u8()?;
        let leap_seconds = self.u8()?;
        let week = self.u16()?;
        let mut issues = [SatelliteIssue::default(); 12];
        let slots = (self.0.len().saturating_sub(8) / 2).min(issues.len());
        for issue in issues.iter_mut().take(slots) {
            *issue = SatelliteIssue { prn: self.u8()? & 0x3F, issue: self.u8()? };
        }
        Some(Superpacket {
            velocity_counts,
            velocity_step_mps: velocity_step_mps(coarse),
            time_of_week_ms,
            latitude_semicircles,
            longitude_semicircles,
            height_mm,
            datum,
            fix,
            satellites,
            leap_seconds,
            week,
            issues,
            slots: slots as u8,
        })
    }

    fn compact(&mut self) -> Option<Compact> {
        self.take::<1>()?;
        Some(Compact {
            time_of_week_ms: self.u32()?,
            week: self.u16()?,
            leap_seconds: self.u8()?,
            fix: self.u8()?,
            latitude_semicircles: self.i32()?,
            longitude_semicircles: self.u32()?,
            height_mm: self.i32()?,
            velocity_counts: [self.i16()?, self.i16()?, self.i16()?],
        })
    }
}
