//! A flight played back as its sensors sent it: emulated devices behind pseudo-terminals, for a flight
//! computer that cannot tell them from real ones. Needs a Unix.
//!
//! A [`Player`] gives each [`EmulatedPort`]'s device a pseudo-terminal and puts a link to it at the path
//! that the flight computer is told to open. Lines can be cut on the way, silently or like an adapter
//! that is pulled out ([`Cut`]).
//!
//! ```no_run
//! use hovernav::gps::Protocol;
//! use hovernav_log::Dataset;
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

mod far_end;
mod flight_clock;
mod terminal;

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::devices::{Device, DmuDevice, GpsDevice};
use crate::serial::{Clock, Task};
use far_end::{FarEnd, Received};
use flight_clock::FlightClock;
use hovernav::dmu::{Calibration, RangeError};
use hovernav::gps::Protocol;
use hovernav::time::Time;
use hovernav_log::Dataset;

/// Full scale of the inertial unit where its dataset does not name one: °/s and g.
pub const DEFAULT_RANGES: (f64, f64) = (200.0, 4.0);

/// How soon a line hears of the end, of a cut or of the flight's beginning, s.
const ATTENTION_S: f64 = 0.02;

/// The inertial unit that measured a dataset, with the ranges that its manifest names, or else
/// [`DEFAULT_RANGES`]. Its yaw is from the north that the dataset's is from.
///
/// # Errors
/// A range that no unit can have.
pub fn dmu(dataset: &Dataset) -> Result<DmuDevice, RangeError> {
    let (rate_degps, acceleration_g) = DEFAULT_RANGES;
    let imu = &dataset.manifest.imu;
    let calibration = Calibration::new(
        imu.gyro_range_degps.unwrap_or(rate_degps),
        imu.accel_range_g.unwrap_or(acceleration_g),
    )?;
    Ok(DmuDevice::measuring(&dataset.imu, &calibration))
}

/// A receiver that had the fixes of a dataset, each arriving as much later as the manifest says.
#[must_use]
pub fn gps(dataset: &Dataset, protocol: Protocol) -> GpsDevice {
    GpsDevice::new(protocol, &dataset.fixes, dataset.manifest.gps.latency_s)
}

/// Why a flight cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum PlayError {
    /// Something is at the path already.
    #[error("{}: exists already; expected a path at which a link to a terminal can be made", path.display())]
    Occupied {
        /// The path.
        path: PathBuf,
    },
    /// The file system refused the link.
    #[error("{}: {source}", path.display())]
    Link {
        /// The path.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The system gives no pseudo-terminal.
    #[error("{}: no pseudo-terminal: {reason}", path.display())]
    NoTerminal {
        /// The path that was to lead to it.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The pseudo-terminal failed.
    #[error("{}: the pseudo-terminal failed: {source}", path.display())]
    Terminal {
        /// The path that led to it.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The system gives no thread.
    #[error("no thread: {0}")]
    NoThread(io::Error),
    /// No device has anything to send.
    #[error("nothing to play: no device has anything to send")]
    Nothing,
}

/// A line that is cut for a while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// From when on, on the clock of the dataset.
    pub start: Time,
    /// How long, s.
    pub duration_s: f64,
    /// In what way.
    pub kind: CutKind,
}

/// In what way a line is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutKind {
    /// The wire to the device: the port stays, and nothing passes.
    Wire,
    /// The adapter: the port goes away, and comes back as another.
    Adapter,
}

/// A device, and where its port is to be found.
pub struct EmulatedPort {
    /// Where the link to its pseudo-terminal is made. Nothing may be there but such a link, left over.
    pub path: PathBuf,
    /// The device.
    pub device: Box<dyn Device>,
    /// When its line is cut.
    pub cuts: Vec<Cut>,
}

impl EmulatedPort {
    /// A device whose line is never cut.
    pub fn new(path: impl Into<PathBuf>, device: impl Device + 'static) -> Self {
        Self { path: path.into(), device: Box::new(device), cuts: Vec::new() }
    }
}

/// When the flight begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Begin {
    /// Once every port is open and the inertial unit has been asked for packets.
    WhenAsked,
    /// This long after the ports are there, whether or not anybody listens.
    After(Duration),
}

/// What passed through a port, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EmulatedPortCounts {
    /// Sent to the host.
    pub sent: u64,
    /// Not sent: the port was not open, its buffer was full, or the line was cut.
    pub lost: u64,
    /// Received from the host.
    pub received: u64,
}

/// A flight that is being played. It ends when this is dropped.
#[derive(Debug)]
pub struct Player {
    flight: Arc<FlightClock>,
    stop: Arc<AtomicBool>,
    tasks: Vec<Task<Result<EmulatedPortCounts, PlayError>>>,
}

impl Player {
    /// Makes all `ports` and plays by `clock`, as fast as that runs; in an emulation the ports are of
    /// it too.
    ///
    /// When this returns, the ports can be opened. The host's clock has to run as fast.
    ///
    /// # Errors
    /// [`PlayError`] names the port that cannot be made, or that there is nothing to play.
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

    /// Seconds since the flight began; `None` before it begins.
    #[must_use]
    pub fn elapsed_s(&self) -> Option<f64> {
        self.flight.elapsed_s()
    }

    /// Whether everything has been sent, or a port has failed.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.flight.is_over() || self.tasks.iter().any(Task::is_finished)
    }

    /// Ends it, and takes the ports away.
    ///
    /// # Errors
    /// What made a port fail.
    pub fn stop(mut self) -> Result<Vec<EmulatedPortCounts>, PlayError> {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.tasks.drain(..).map(Task::join);
        // A thread that panicked has already said so.
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

/// Plays one port until it is to stop.
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
            // The host let go of the port. Had it been killed, the port would stay locked for as long
            // as this end is held.
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
