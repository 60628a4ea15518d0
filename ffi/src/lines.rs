//! Raw bytes of the two serial lines: inertial unit and GPS receiver.

use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::time::Time;

use crate::access::{bytes as slice, input, object, optional, output};
use crate::object::Hovernav;
use crate::settings::{LinesConfig, LinesFault};
use crate::status::{Fault, Status};

/// Size of the buffer for a reply, bytes: more than any call needs.
pub const HOVERNAV_REPLY: usize = 64;

/// Result of the bytes passed from one serial line.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct LineResult {
    /// Bytes to write to the same line now; the first reply_length bytes count.
    pub reply: [u8; HOVERNAV_REPLY],
    /// Number of bytes in the reply.
    pub reply_length: u32,
    /// Number of samples or fixes in the bytes that were passed to the estimator.
    pub used: u32,
    /// Number of packets or fixes rejected because of impossible values, an unusable time or insufficient quality.
    pub refused: u32,
    /// 1 if the link to the inertial unit failed and restarts, else 0.
    pub lost: u32,
    /// For the inertial unit: time, ns, until which the caller waits for bytes. Call again when bytes arrive, or at
    /// this time without bytes.
    pub read_until_ns: i64,
}

impl LineResult {
    const NOTHING: Self = Self {
        reply: [0; HOVERNAV_REPLY],
        reply_length: 0,
        used: 0,
        refused: 0,
        lost: 0,
        read_until_ns: 0,
    };

    fn reply_with(&mut self, bytes: &[u8]) {
        let free = self.reply.iter_mut().skip(self.reply_length as usize);
        for (slot, byte) in free.zip(bytes) {
            *slot = *byte;
            self.reply_length += 1;
        }
    }

    fn note(&mut self, output: &SensorOutput) {
        match output {
            SensorOutput::WriteDmu(command) => self.reply_with(&[command.byte()]),
            SensorOutput::WriteGps(command) => self.reply_with(command.as_bytes()),
            SensorOutput::Event(_) => self.used += 1,
            SensorOutput::DmuLost(..) => self.lost = 1,
            SensorOutput::Fix(_, failures) => self.refused += u32::from(!failures.is_empty()),
            SensorOutput::DmuImplausible(_, reason) => {
                self.refused += u32::from(reason.invalidates_packet());
            }
            SensorOutput::DmuClockFault(..) | SensorOutput::FixWithoutHeight(_) => {
                self.refused += 1;
            }
            SensorOutput::Measured(..) => {}
        }
    }
}

/// Starts the protocols on both serial lines, or restarts them. `fault`, unless null, receives the first invalid value
/// of the configuration.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_start_lines(
    nav: *mut Hovernav,
    config: *const LinesConfig,
    now_ns: i64,
    fault: *mut Fault,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let config = unsafe { input(config) };
    // SAFETY: guaranteed by the caller.
    let fault = unsafe { optional(fault) };
    Status::of(nav.and_then(|nav| {
        let (config, fault) = (config?, fault?);
        let (dmu, gps) = config.core().map_err(|wrong| match wrong {
            LinesFault::NotBuilt => Status::NotBuilt,
            LinesFault::Value(wrong) => Status::reject(wrong, fault),
        })?;
        nav.lines = Some(Sensors::new(dmu, gps, Time::from_nanoseconds(now_ns)));
        Ok(())
    }))
}

/// One of the two serial lines.
#[derive(Clone, Copy)]
enum Line {
    Dmu,
    Gps,
}

/// # Safety
/// Pointers follow the rules of the crate; `bytes` has `length` bytes.
unsafe fn push(
    line: Line,
    nav: *mut Hovernav,
    bytes: *const u8,
    length: usize,
    now_ns: i64,
    result: *mut LineResult,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let bytes = unsafe { slice(bytes, length) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(result) };
    Status::of(nav.and_then(|nav| {
        let (bytes, slot, now) = (bytes?, slot?, Time::from_nanoseconds(now_ns));
        let Hovernav { lines, flight, .. } = nav;
        let lines = lines.as_mut().ok_or(Status::NoLines)?;
        let mut result = LineResult::NOTHING;
        let observe = |output: SensorOutput| {
            result.note(&output);
            if let SensorOutput::Event(event) = output {
                flight.push(&event);
            }
        };
        match line {
            Line::Dmu => {
                let until = lines.dmu(bytes, now, observe);
                result.read_until_ns = until.nanoseconds();
            }
            Line::Gps => lines.gps(bytes, now, observe),
        }
        slot.write(result);
        Ok(())
    }))
}

/// Processes `length` bytes read from the inertial unit's line; the last byte arrived at `now_ns`. Pass 0 bytes if no
/// byte arrived until the `read_until_ns` of the previous call. Samples in the bytes go to the estimator.
///
/// # Safety
/// Pointers follow the rules of the crate; `bytes` has `length` bytes, and may be null if that is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_dmu_bytes(
    nav: *mut Hovernav,
    bytes: *const u8,
    length: usize,
    now_ns: i64,
    result: *mut LineResult,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { push(Line::Dmu, nav, bytes, length, now_ns, result) }
}

/// Processes `length` bytes read from the receiver's line, which arrived at `now_ns`. Pass 0 bytes once the line is
/// silent after an epoch: this ends the epoch. Good fixes go to the estimator.
///
/// # Safety
/// Pointers follow the rules of the crate; `bytes` has `length` bytes, and may be null if that is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_push_gps_bytes(
    nav: *mut Hovernav,
    bytes: *const u8,
    length: usize,
    now_ns: i64,
    result: *mut LineResult,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { push(Line::Gps, nav, bytes, length, now_ns, result) }
}
