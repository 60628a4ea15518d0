//! An open serial line of the operating system or of an emulation.

use std::io;
use std::path::Path;
use std::time::Duration;

use serialport::{ClearBuffer, DataBits, FlowControl, SerialPort, StopBits};

use super::Clock;
use super::port_config::{PortConfig, PortFault};
use super::wire_end::HostEnd;
use hovernav::time::Time;

/// An open line; dropping it closes the line.
pub(super) enum Line {
    System(Box<dyn SerialPort>),
    Emulated(HostEnd),
}

impl Line {
    /// Opens the line of `config` and discards earlier input, whose age is unknown.
    pub fn open(config: &PortConfig, clock: &Clock) -> Result<Self, PortFault> {
        if clock.is_emulated() {
            let mut line = HostEnd::open(Path::new(&config.path), clock)?;
            line.clear_input();
            return Ok(Self::Emulated(line));
        }
        let line = serialport::new(&config.path, config.baud)
            .parity(config.parity)
            .data_bits(DataBits::Eight)
            .stop_bits(StopBits::One)
            .flow_control(FlowControl::None)
            .timeout(Duration::ZERO)
            .open()?;
        let _ = line.clear(ClearBuffer::Input);
        Ok(Self::System(line))
    }

    /// Reads the available bytes, waiting until `deadline` for the first.
    pub fn read(&mut self, buffer: &mut [u8], clock: &Clock, deadline: Time) -> io::Result<usize> {
        match self {
            Self::System(line) => {
                line.set_timeout(clock.until(deadline))?;
                line.read(buffer)
            }
            Self::Emulated(line) => line.read(buffer, deadline),
        }
    }

    /// Writes as many bytes as the line accepts, waiting until `deadline` for room.
    pub fn write(&mut self, bytes: &[u8], clock: &Clock, deadline: Time) -> io::Result<usize> {
        match self {
            Self::System(line) => {
                line.set_timeout(clock.until(deadline))?;
                line.write(bytes)
            }
            Self::Emulated(line) => line.write(bytes, deadline),
        }
    }

    /// Discards unsent output: otherwise a driver may wait for it when the line is closed.
    pub fn clear_output(&self) {
        if let Self::System(line) = self {
            let _ = line.clear(ClearBuffer::Output);
        }
    }
}
