//! The two ends of a serial line of an emulation.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Clock;
use super::signal::lock;
use super::wire::{Wire, put, take};
use hovernav::time::Time;

/// The host's end; dropping it closes the line.
#[derive(Debug)]
pub(super) struct HostEnd {
    wire: Arc<Wire>,
    clock: Clock,
}

/// The device's end of an emulated line; dropping it removes the line.
#[cfg(unix)]
#[derive(Debug)]
pub(crate) struct DeviceEnd {
    wire: Arc<Wire>,
    clock: Clock,
    path: PathBuf,
}

impl HostEnd {
    /// Opens the line at `path`.
    ///
    /// # Errors
    /// `NotFound` if there is no such line, `ResourceBusy` if it is already open.
    pub fn open(path: &Path, clock: &Clock) -> io::Result<Self> {
        let wire = clock.emulation().and_then(|emulation| emulation.wire(path));
        let wire = wire.ok_or(ErrorKind::NotFound)?;
        let is_busy = std::mem::replace(&mut lock(&wire.state).is_open, true);
        if is_busy {
            return Err(ErrorKind::ResourceBusy.into());
        }
        clock.raise(&wire.changed);
        Ok(Self { wire, clock: clock.clone() })
    }

    /// Reads the available bytes, waiting until `deadline` for the first.
    pub fn read(&mut self, buffer: &mut [u8], deadline: Time) -> io::Result<usize> {
        let Self { wire, clock } = self;
        let mut state = lock(&wire.state);
        loop {
            if !state.to_host.is_empty() {
                return Ok(take(&mut state.to_host, buffer));
            }
            if state.is_gone {
                return Err(ErrorKind::BrokenPipe.into());
            }
            if clock.now() >= deadline {
                return Err(ErrorKind::TimedOut.into());
            }
            state = clock.wait(&wire.changed, &wire.state, state, deadline);
        }
    }

    /// Writes as many bytes as there is room for, waiting until `deadline` for room.
    pub fn write(&mut self, bytes: &[u8], deadline: Time) -> io::Result<usize> {
        let Self { wire, clock } = self;
        let mut state = lock(&wire.state);
        loop {
            if state.is_gone {
                return Err(ErrorKind::BrokenPipe.into());
            }
            let count = put(bytes, &mut state.to_device);
            if count > 0 {
                clock.raise(&wire.changed);
                return Ok(count);
            }
            if clock.now() >= deadline {
                return Err(ErrorKind::TimedOut.into());
            }
            state = clock.wait(&wire.changed, &wire.state, state, deadline);
        }
    }

    /// Discards unread input.
    pub fn clear_input(&mut self) {
        lock(&self.wire.state).to_host.clear();
    }
}

impl Drop for HostEnd {
    fn drop(&mut self) {
        let mut state = lock(&self.wire.state);
        state.is_open = false;
        state.to_host.clear();
        self.clock.raise(&self.wire.changed);
    }
}

#[cfg(unix)]
impl DeviceEnd {
    /// Creates a line at `path`; `None` unless `clock` is emulated and the path is free.
    pub fn new(path: &Path, clock: &Clock) -> Option<Self> {
        let mut wires = clock.emulation()?.wires();
        if wires.contains_key(path) {
            return None;
        }
        let wire = Arc::<Wire>::default();
        wires.insert(path.into(), Arc::clone(&wire));
        Some(Self { wire, clock: clock.clone(), path: path.into() })
    }

    /// Sends as many bytes to the host as there is room for; returns their number.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        let mut state = lock(&self.wire.state);
        if !state.is_open {
            return 0;
        }
        let count = put(bytes, &mut state.to_host);
        if count > 0 {
            self.clock.raise(&self.wire.changed);
        }
        count
    }

    /// Reads bytes from the host, waiting until `deadline`; `None` while the host has not opened the line.
    pub fn receive(&mut self, buffer: &mut [u8], deadline: Time) -> Option<usize> {
        let Self { wire, clock, .. } = self;
        let mut state = lock(&wire.state);
        if state.to_device.is_empty() && clock.now() < deadline {
            state = clock.wait(&wire.changed, &wire.state, state, deadline);
        }
        let count = take(&mut state.to_device, buffer);
        (count > 0 || state.is_open).then_some(count)
    }
}

#[cfg(unix)]
impl Drop for DeviceEnd {
    fn drop(&mut self) {
        if let Some(emulation) = self.clock.emulation() {
            emulation.wires().remove(&self.path);
        }
        lock(&self.wire.state).is_gone = true;
        self.clock.raise(&self.wire.changed);
    }
}
