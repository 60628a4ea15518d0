//! Status of a call, as number and as text.

use core::ffi::{CStr, c_char};

use crate::output::Output;

/// Status of a call. 0 is success, 1 is "not yet", the others are errors of the caller; a call with an error changes
/// nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// Success.
    Ok = 0,
    /// No result yet: alignment has not ended, or all notices are read.
    NotYet = 1,
    /// A required pointer is null.
    NullPointer = -1,
    /// A pointer lacks the alignment of its type.
    Misaligned = -2,
    /// The memory is smaller than hovernav_size().
    MemoryTooSmall = -3,
    /// No object was created at this address, or it was destroyed.
    NotCreated = -4,
    /// Header and library are of different versions of the binary interface.
    AbiMismatch = -5,
    /// A value is out of its range. If the function has a HovernavFault, this names the value.
    OutOfRange = -6,
    /// An unknown code, kind or flag.
    UnknownCode = -7,
    /// hovernav_start_autopilot() was not called.
    NoAutopilot = -8,
    /// hovernav_start_lines() was not called.
    NoLines = -9,
    /// The library was built without this receiver protocol, or without height-aids.
    NotBuilt = -10,
    /// A set-point is not finite, not a valid position, or faster than the configuration allows.
    SetPointRefused = -11,
    /// The configuration has no notch: its notch has no harmonics.
    NoNotch = -12,
}

impl Status {
    const ALL: [Self; 14] = [
        Self::Ok,
        Self::NotYet,
        Self::NullPointer,
        Self::Misaligned,
        Self::MemoryTooSmall,
        Self::NotCreated,
        Self::AbiMismatch,
        Self::OutOfRange,
        Self::UnknownCode,
        Self::NoAutopilot,
        Self::NoLines,
        Self::NotBuilt,
        Self::SetPointRefused,
        Self::NoNotch,
    ];

    const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::NotYet => c"nothing to give yet",
            Self::NullPointer => c"a required pointer is null",
            Self::Misaligned => c"a pointer lacks the alignment of its type",
            Self::MemoryTooSmall => c"the memory is smaller than hovernav_size()",
            Self::NotCreated => c"no object was created at this address, or it was destroyed",
            Self::AbiMismatch => c"header and library are of different versions",
            Self::OutOfRange => c"a value is out of its range",
            Self::UnknownCode => c"an unknown code, kind or flag",
            Self::NoAutopilot => c"hovernav_start_autopilot() was not called",
            Self::NoLines => c"hovernav_start_lines() was not called",
            Self::NotBuilt => c"the library was built without this receiver protocol or aid",
            Self::SetPointRefused => {
                c"the set-point is not finite, not a valid position, or too fast"
            }
            Self::NoNotch => c"the configuration has no notch",
        }
    }

    /// Writes the fault `wrong` to `fault`, unless the caller passed null, and returns `OutOfRange`.
    pub(crate) fn reject(wrong: Fault, fault: Option<Output<'_, Fault>>) -> Self {
        if let Some(slot) = fault {
            slot.write(wrong);
        }
        Self::OutOfRange
    }

    /// `Ok`, or the error of the result.
    pub(crate) fn of(result: Result<(), Self>) -> Self {
        result.err().unwrap_or(Self::Ok)
    }
}

/// The text of a status: static, ends with a zero byte, never null.
#[unsafe(no_mangle)]
pub extern "C" fn hovernav_status_text(status: i32) -> *const c_char {
    Status::ALL
        .into_iter()
        .find(|known| *known as i32 == status)
        .map_or(c"an unknown status", Status::text)
        .as_ptr()
}

/// Longest text in a HovernavFault, bytes, its zero byte included.
pub const HOVERNAV_FAULT_TEXT: usize = 64;

/// The value of a configuration that is out of range. Texts are UTF-8 and end with a zero byte.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Fault {
    /// Path of the field in the configuration: "imu.gap_s". An array, or the gains of one regulator, count as one
    /// field.
    pub what: [c_char; HOVERNAV_FAULT_TEXT],
    /// The value found.
    pub found: f64,
    /// The expected range, as text.
    pub expected: [c_char; HOVERNAV_FAULT_TEXT],
}

impl Fault {
    pub(crate) fn new(what: &[&str], found: f64, expected: &str) -> Self {
        Self { what: text(what), found, expected: text(&[expected]) }
    }
}

fn text(parts: &[&str]) -> [c_char; HOVERNAV_FAULT_TEXT] {
    let mut all = [0; HOVERNAV_FAULT_TEXT];
    let bytes = parts.iter().flat_map(|part| part.bytes());
    for (slot, byte) in all.iter_mut().take(HOVERNAV_FAULT_TEXT - 1).zip(bytes) {
        *slot = c_char::from_ne_bytes([byte]);
    }
    all
}
