//! Plays back a flight from emulated devices behind pseudo-terminals. To the flight computer they look like real
//! devices. Needs Unix.
//!
//! A [`Player`] creates a pseudo-terminal for the device of each [`EmulatedPort`], and a link to it at the path
//! that the flight computer opens. Lines can be cut during the flight, silently or like an unplugged adapter
//! ([`Cut`]).
//!
//! ```no_run
//! use hovernav::gps::Protocol;
//! use hovernav_dataset::Dataset;
//! use hovernav_fly::play;
//! use hovernav_fly::play::{Begin, EmulatedPort, Player};
//! use hovernav_fly::serial::Clock;
//!
//! let dataset = Dataset::open("datasets/heli-hover".as_ref())?;
//! let (dmu, gps) = (play::dmu(&dataset)?, play::gps(&dataset, Protocol::Ubx));
//! let ports = vec![EmulatedPort::new("/tmp/dmu", dmu), EmulatedPort::new("/tmp/gps", gps)];
//! let player = Player::start(ports, &Clock::start(), Begin::WhenAsked)?;
//! while !player.is_finished() {
//!     std::thread::sleep(std::time::Duration::from_millis(100));
//! }
//! for counts in player.stop()? {
//!     println!("{} bytes sent", counts.sent);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod far_end;
mod flight_clock;
mod terminal;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::devices::{Device, DmuDevice, GpsDevice};
use crate::serial::{Clock, Task};
pub use error::PlayError;
use far_end::FarEnd;
use flight_clock::FlightClock;
use hovernav::dmu::{Calibration, RangeError};
use hovernav::gps::Protocol;
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use terminal::Received;

/// Full scale of the IMU if the dataset has none: °/s and g.
pub const DEFAULT_RANGES: (f64, f64) = (200.0, 4.0);

/// Longest interval, s, at which the thread of a serial line checks for the start, an interruption or the end.
const ATTENTION_S: f64 = 0.02;

/// An emulated IMU that sends the samples of a dataset, with the ranges of its manifest, else [`DEFAULT_RANGES`].
/// Its yaw has the same reference (true or magnetic north) as the dataset's.
///
/// # Errors
/// An impossible range.
pub fn dmu(dataset: &Dataset) -> Result<DmuDevice, RangeError> {
    let (rate_degps, acceleration_g) = DEFAULT_RANGES;
    let imu = &dataset.manifest.imu;
    let calibration = Calibration::new(
        imu.gyro_range_degps.unwrap_or(rate_degps),
        imu.accel_range_g.unwrap_or(acceleration_g),
    )?;
    Ok(DmuDevice::measuring(&dataset.imu, &calibration))
}

/// An emulated receiver that sends the fixes of a dataset, each delayed by the latency in the manifest.
#[must_use]
pub fn gps(dataset: &Dataset, protocol: Protocol) -> GpsDevice {
    GpsDevice::new(protocol, &dataset.fixes, dataset.manifest.gps.latency_s)
}

/// A temporary cut of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Start of the cut, on the clock of the dataset.
    pub start: Time,
    /// Duration, s.
    pub duration_s: f64,
    /// Kind of the cut.
    pub kind: CutKind,
}

/// Kinds of cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutKind {
    /// The wire to the device: the port stays open, and no data pass.
    Wire,
    /// The adapter: the port disappears and returns as a new one.
    Adapter,
}

/// A device and the path of its port.
pub struct EmulatedPort {
    /// Path of the link to its pseudo-terminal. It must not exist, except as a stale link.
    pub path: PathBuf,
    /// The device.
    pub device: Box<dyn Device>,
    /// Cuts of its line.
    pub cuts: Vec<Cut>,
}

impl EmulatedPort {
    /// A device whose line is never cut.
    pub fn new(path: impl Into<PathBuf>, device: impl Device + 'static) -> Self {
        Self { path: path.into(), device: Box::new(device), cuts: Vec::new() }
    }
}

/// Start of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Begin {
    /// As soon as every port is open and the IMU has received a request for packets.
    WhenAsked,
    /// After a time from the creation of the ports, whether or not they are open.
    After(Duration),
}

/// Statistics of a port, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EmulatedPortCounts {
    /// Bytes sent to the host.
    pub sent: u64,
    /// Bytes not sent: the port was not open, its buffer was full, or the line was cut.
    pub lost: u64,
    /// Bytes received from the host.
    pub received: u64,
}

/// A flight during playback. Dropping it ends the playback.
#[derive(Debug)]
pub struct Player {
    flight: Arc<FlightClock>,
    stop: Arc<AtomicBool>,
    tasks: Vec<Task<Result<EmulatedPortCounts, PlayError>>>,
}

impl Player {
    /// Creates all `ports` and plays at the speed of `clock`. In an emulation the ports are emulated too.
    ///
    /// The ports can be opened when this returns. The clock of the host must run at the same speed.
    ///
    /// # Errors
    /// [`PlayError`] for a port that cannot be created, or without data to play.
    pub fn start(ports: Vec<EmulatedPort>, clock: &Clock, begin: Begin) -> Result<Self, PlayError> {
        let spans = || ports.iter().filter_map(|port| port.device.span());
        let first = spans().map(|(first, _)| first).min().ok_or(PlayError::Nothing)?;
        let last = spans().map(|(_, last)| last).max().ok_or(PlayError::Nothing)?;
        let not_started = match begin {
            Begin::WhenAsked => ports.len(),
            Begin::After(_) => usize::MAX,
        };
        let ends = ports.iter().map(|port| FarEnd::open(&port.path, clock));
        let ends = ends.collect::<Result<Vec<_>, _>>()?;
        let flight = Arc::new(FlightClock::new(clock.clone(), first, last, not_started));
        let stop = Arc::new(AtomicBool::new(false));
        let mut player = Self { flight, stop, tasks: Vec::new() };
        if let Begin::After(wait) = begin {
            player.flight.begin_after(wait);
        }
        for (port, end) in ports.into_iter().zip(ends) {
            let (flight, stop) = (Arc::clone(&player.flight), Arc::clone(&player.stop));
            let name = format!("play {}", port.path.display());
            let task = clock.spawn(name, move || play(port, end, &flight, &stop));
            player.tasks.push(task.map_err(PlayError::NoThread)?);
        }
        Ok(player)
    }

    /// Time since the start of the flight, s; `None` before.
    #[must_use]
    pub fn elapsed_s(&self) -> Option<f64> {
        self.flight.elapsed_s()
    }

    /// Whether everything has been sent, or a port has failed.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.flight.is_over() || self.tasks.iter().any(Task::is_finished)
    }

    /// Ends the playback and removes the ports.
    ///
    /// # Errors
    /// The error of the first port that failed.
    pub fn stop(mut self) -> Result<Vec<EmulatedPortCounts>, PlayError> {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.tasks.drain(..).map(Task::join);
        // A panic has already printed its message.
        ended.map(|ended| ended.unwrap_or(Ok(EmulatedPortCounts::default()))).collect()
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for task in self.tasks.drain(..) {
            let _ = task.join();
        }
    }
}

/// Plays one port until `stop` is set.
fn play(
    mut port: EmulatedPort,
    end: FarEnd,
    flight: &FlightClock,
    stop: &AtomicBool,
) -> Result<EmulatedPortCounts, PlayError> {
    let (mut end, host) = (Some(end), flight.host());
    let mut counts = EmulatedPortCounts::default();
    let (mut wire, mut buffer) = (Vec::new(), [0; 256]);
    let (mut opened, mut asked) = (false, false);
    while !stop.load(Ordering::Relaxed) {
        let now = flight.now();
        let cut = cut_at(&port.cuts, now);
        match cut {
            Some(CutKind::Adapter) => end = None,
            _ if end.is_none() => end = Some(FarEnd::open(&port.path, host)?),
            _ => {}
        }

        port.device.transmit(now, &mut wire);
        let sent = match &mut end {
            Some(end) if cut.is_none() => end.send(&wire)?,
            _ => 0,
        };
        counts.sent += sent as u64;
        counts.lost += (wire.len() - sent) as u64;
        wire.clear();

        let attention = host.now() + ATTENTION_S * host.speed();
        let next = port.device.next_transmission().map(|next| flight.on_host(next));
        let deadline = next.map_or(attention, |next| next.min(attention));
        let received = match &mut end {
            None => {
                host.sleep_until(deadline);
                Received::Closed
            }
            Some(end) => end.receive(&mut buffer, host, deadline)?,
        };
        match received {
            // The host closed the port. This end is closed too: if the host was killed, the port would otherwise
            // stay locked.
            Received::Closed if opened => (opened, end) = (false, None),
            Received::Closed => {}
            Received::Nothing => opened = true,
            Received::Bytes(count) => {
                opened = true;
                counts.received += count as u64;
                if cut.is_none() {
                    port.device.receive(&buffer[..count], flight.now());
                }
            }
        }
        if !asked && opened && port.device.is_started() {
            asked = true;
            flight.device_started();
        }
    }
    Ok(counts)
}

fn cut_at(cuts: &[Cut], now: Time) -> Option<CutKind> {
    let covers = |cut: &&Cut| now >= cut.start && now - cut.start < cut.duration_s;
    cuts.iter().find(covers).map(|cut| cut.kind)
}
