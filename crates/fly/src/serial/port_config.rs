//! Settings of a serial line, and reasons why it is not open.

use std::path::Path;
use std::{fmt, io};

use serialport::{ErrorKind, Parity};

/// Path and settings of a line: eight data bits, one stop bit, no flow control.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PortConfig {
    /// The device, such as `/dev/ttyUSB0` or `COM3`; a link is resolved each time the port is opened.
    pub path: String,
    /// Bits per second.
    pub baud: u32,
    /// The parity bit.
    pub parity: Parity,
}

impl PortConfig {
    /// The line at `path` with `baud` bits per second, without a parity bit.
    pub fn new(path: impl AsRef<Path>, baud: u32) -> Self {
        let path = path.as_ref().to_string_lossy().into_owned();
        Self { path, baud, parity: Parity::None }
    }

    /// The same settings with another parity bit.
    #[must_use]
    pub fn with_parity(self, parity: Parity) -> Self {
        Self { parity, ..self }
    }
}

/// Reasons why a port is not open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortFault {
    /// There is no such device.
    Missing,
    /// No permission to open the device.
    Denied,
    /// Another program uses the device.
    Busy,
    /// The device was disconnected.
    HungUp,
    /// Any other error, as text of the operating system.
    Other(String),
}

impl fmt::Display for PortFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "there is no such device",
            Self::Denied => "permission denied",
            Self::Busy => "another program has it",
            Self::HungUp => "the device went away",
            Self::Other(text) => text,
        })
    }
}

impl std::error::Error for PortFault {}

impl From<serialport::Error> for PortFault {
    fn from(error: serialport::Error) -> Self {
        match error.kind() {
            ErrorKind::NoDevice => Self::Busy,
            ErrorKind::Io(kind) => Self::of(kind, || error.description),
            _ => Self::Other(error.description),
        }
    }
}

impl From<io::Error> for PortFault {
    fn from(error: io::Error) -> Self {
        Self::of(error.kind(), || error.to_string())
    }
}

impl PortFault {
    fn of(kind: io::ErrorKind, text: impl FnOnce() -> String) -> Self {
        match kind {
            io::ErrorKind::NotFound => Self::Missing,
            io::ErrorKind::PermissionDenied => Self::Denied,
            io::ErrorKind::ResourceBusy => Self::Busy,
            io::ErrorKind::BrokenPipe => Self::HungUp,
            _ => Self::Other(text()),
        }
    }
}
