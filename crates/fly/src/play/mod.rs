//! A flight played back as its sensors sent it: devices behind pseudo-terminals, for a flight computer
//! that need not know. Needs the feature `serial`, and a Unix.
//!
//! A [`Player`] gives each [`Outlet`]'s device a pseudo-terminal and puts a link to it at the path
//! that the flight computer is told to open. Lines can be cut on the way, silently or like an adapter
//! that is pulled out ([`Cut`]).
//!
//! ```no_run
//! use hovernav::gps::Protocol;
//! use hovernav_log::Dataset;
//! use hovernav_fly::play;
//! use hovernav_fly::play::{Begin, Outlet, Player};
//!
//! let dataset = Dataset::open("datasets/heli-hover".as_ref())?;
//! let (dmu, gps) = (play::dmu(&dataset)?, play::gps(&dataset, Protocol::Ubx));
//! let outlets = vec![Outlet::new("/tmp/dmu", dmu), Outlet::new("/tmp/gps", gps)];
//! let player = Player::start(outlets, 1.0, Begin::WhenAsked)?;
//! while !player.is_finished() {
//!     std::thread::sleep(std::time::Duration::from_millis(100));
//! }
//! for counts in player.stop()? {
//!     println!("{} bytes sent", counts.sent);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod flight;
mod terminal;

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::devices::{Device, DmuDevice, GpsDevice};
use flight::Flight;
use hovernav::dmu::{Calibration, RangeError};
use hovernav::gps::Protocol;
use hovernav::time::Time;
use hovernav_log::Dataset;
use terminal::{Heard, Terminal};

/// Full scale of the inertial unit where its dataset does not name one: °/s and g.
pub const DEFAULT_RANGES: (f64, f64) = (200.0, 4.0);

/// How soon a line hears of the end, of a cut or of the flight's beginning.
const ATTENTION: Duration = Duration::from_millis(20);

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
    /// No device has anything to tell.
    #[error("nothing to play: no device has anything to send")]
    Nothing,
    /// A speed outside 0.001 to 1000.
    #[error("speed {0}, expected 0.001 to 1000")]
    Speed(f64),
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
pub struct Outlet {
    /// Where the link to its pseudo-terminal is made. Nothing may be there but such a link, left over.
    pub path: PathBuf,
    /// The device.
    pub device: Box<dyn Device>,
    /// When its line is cut.
    pub cuts: Vec<Cut>,
}

impl Outlet {
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

/// What passed through an outlet, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutletCounts {
    /// Sent to the host.
    pub sent: u64,
    /// Not sent: the port was not open, its buffer was full, or the line was cut.
    pub lost: u64,
    /// Heard from the host.
    pub heard: u64,
}

/// A flight that is being played. It ends when this is dropped.
#[derive(Debug)]
pub struct Player {
    flight: Arc<Flight>,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<Result<OutletCounts, PlayError>>>,
}

impl Player {
    /// Makes the ports of all `outlets` and plays `speed` times as fast as it was.
    ///
    /// When this returns, the ports can be opened. The host's clock has to run as fast
    /// ([`Clock::at_speed`](crate::serial::Clock::at_speed)).
    ///
    /// # Errors
    /// [`PlayError`] tells which port cannot be made, or that there is nothing to play.
    pub fn start(outlets: Vec<Outlet>, speed: f64, begin: Begin) -> Result<Self, PlayError> {
        if !(0.001..=1e3).contains(&speed) {
            return Err(PlayError::Speed(speed));
        }
        let spans = || outlets.iter().filter_map(|outlet| outlet.device.span());
        let first = spans().map(|(first, _)| first).min().ok_or(PlayError::Nothing)?;
        let last = spans().map(|(_, last)| last).max().ok_or(PlayError::Nothing)?;
        let awaited_from = match begin {
            Begin::WhenAsked => outlets.len(),
            Begin::After(_) => usize::MAX,
        };
        let terminals = outlets
            .iter()
            .map(|outlet| Terminal::open(&outlet.path))
            .collect::<Result<Vec<_>, _>>()?;
        let flight = Arc::new(Flight::new(first, last, speed, awaited_from));
        let stop = Arc::new(AtomicBool::new(false));
        let mut player = Self { flight, stop, threads: Vec::new() };
        if let Begin::After(wait) = begin {
            player.flight.begin_after(wait);
        }
        for (outlet, terminal) in outlets.into_iter().zip(terminals) {
            let (flight, stop) = (Arc::clone(&player.flight), Arc::clone(&player.stop));
            let name = format!("play {}", outlet.path.display());
            let thread = thread::Builder::new()
                .name(name)
                .spawn(move || play(outlet, terminal, &flight, &stop))
                .map_err(PlayError::NoThread)?;
            player.threads.push(thread);
        }
        Ok(player)
    }

    /// Seconds of flight; `None` before it begins.
    #[must_use]
    pub fn flown_s(&self) -> Option<f64> {
        self.flight.flown_s()
    }

    /// Whether everything has been sent, or an outlet has failed.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.flight.is_over() || self.threads.iter().any(JoinHandle::is_finished)
    }

    /// Ends it, and takes the ports away.
    ///
    /// # Errors
    /// What made an outlet fail.
    pub fn stop(mut self) -> Result<Vec<OutletCounts>, PlayError> {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.threads.drain(..).map(JoinHandle::join);
        // A thread that panicked has already said so.
        ended.map(|ended| ended.unwrap_or(Ok(OutletCounts::default()))).collect()
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Plays one outlet until it is to stop.
fn play(
    mut outlet: Outlet,
    terminal: Terminal,
    flight: &Flight,
    stop: &AtomicBool,
) -> Result<OutletCounts, PlayError> {
    let mut terminal = Some(terminal);
    let mut counts = OutletCounts::default();
    let (mut wire, mut buffer) = (Vec::new(), [0; 256]);
    let (mut opened, mut asked) = (false, false);
    while !stop.load(Ordering::Relaxed) {
        let now = flight.now();
        let cut = cut_at(&outlet.cuts, now);
        match cut {
            Some(CutKind::Adapter) => terminal = None,
            _ if terminal.is_none() => terminal = Some(Terminal::open(&outlet.path)?),
            _ => {}
        }

        outlet.device.transmit(now, &mut wire);
        let sent = match &mut terminal {
            Some(terminal) if cut.is_none() => terminal.send(&wire)?,
            _ => 0,
        };
        counts.sent += sent as u64;
        counts.lost += (wire.len() - sent) as u64;
        wire.clear();

        let next = outlet.device.next_transmission().unwrap_or(Time::from_nanoseconds(i64::MAX));
        let wait = flight.until(next).min(ATTENTION);
        let heard = match &mut terminal {
            None => {
                thread::sleep(wait);
                Heard::Nobody
            }
            Some(terminal) => terminal.hear(&mut buffer, wait)?,
        };
        match heard {
            // The host let go of the port. Had it been killed, the port would stay locked for as long
            // as this end is held.
            Heard::Nobody if opened => (opened, terminal) = (false, None),
            Heard::Nobody => {}
            Heard::Nothing => opened = true,
            Heard::Bytes(count) => {
                opened = true;
                counts.heard += count as u64;
                if cut.is_none() {
                    outlet.device.receive(&buffer[..count], flight.now());
                }
            }
        }
        if !asked && opened && outlet.device.is_awaited() {
            asked = true;
            flight.awaited();
        }
    }
    Ok(counts)
}

fn cut_at(cuts: &[Cut], now: Time) -> Option<CutKind> {
    let covers = |cut: &&Cut| now >= cut.start && now - cut.start < cut.duration_s;
    cuts.iter().find(covers).map(|cut| cut.kind)
}
