//! The link to the vehicle: a serial port or UDP, read by its own thread.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use hovernav_fly::serial::{Clock, Port, PortConfig, Read};

use crate::decode::Protocol;
use crate::station::Station;
use crate::store::TextLevel;

/// Longest wait for bytes before the thread checks for other work, s.
const WAIT_S: f64 = 0.02;
/// Interval between two requests for frames while no telemetry arrives.
const ASK: Duration = Duration::from_millis(500);
/// Interval between attempts to open a socket.
const RETRY: Duration = Duration::from_millis(500);
/// Largest size of a datagram, bytes.
const DATAGRAM: usize = 65_536;

/// The source of telemetry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A serial port.
    Serial {
        /// The device.
        path: String,
        /// Baud rate.
        baud: u32,
    },
    /// UDP datagrams that arrive at this address. A port without an address means the loopback address, which only
    /// programs on this computer reach.
    Udp(SocketAddr),
}

/// A text that is not a valid link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "found \"{0}\", expected a serial port with an optional speed, such as /dev/ttyUSB0:57600, or udp:PORT for programs on this computer, or udp:ADDRESS:PORT with this computer's address in the vehicle's network"
)]
pub struct SourceError(String);

impl FromStr for Source {
    type Err = SourceError;

    fn from_str(text: &str) -> Result<Self, SourceError> {
        let error = || SourceError(text.chars().take(80).collect());
        if let Some(address) = text.strip_prefix("udp:") {
            let address = match address.parse::<u16>() {
                Ok(port) => SocketAddr::from((Ipv4Addr::LOCALHOST, port)),
                Err(_) => address.parse().map_err(|_| error())?,
            };
            return if address.port() == 0 { Err(error()) } else { Ok(Self::Udp(address)) };
        }
        let (path, baud) = match text.rsplit_once(':') {
            Some((path, baud)) => (path, baud.parse().map_err(|_| error())?),
            None => (text, 57_600),
        };
        if path.is_empty() || !(300..=4_000_000).contains(&baud) {
            return Err(error());
        }
        Ok(Self::Serial { path: path.to_owned(), baud })
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { path, baud } => write!(f, "{path} at {baud} baud"),
            Self::Udp(address) => write!(f, "UDP {address}"),
        }
    }
}

/// A station that several threads use.
pub type SharedStation = Arc<Mutex<Station>>;

/// Locks a station. A station whose lock was poisoned by a panic is still used.
pub fn lock(station: &SharedStation) -> MutexGuard<'_, Station> {
    station.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The link, open until dropped.
pub struct Link {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Link {
    /// Opens the link to `source` and feeds `station`.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn open(source: &Source, station: SharedStation) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let (theirs, source) = (Arc::clone(&stop), source.clone());
        let thread = thread::Builder::new().name("link".into()).spawn(move || match source {
            Source::Serial { path, baud } => serial(&path, baud, &station, &theirs),
            Source::Udp(address) => udp(address, &station, &theirs),
        })?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The panic message was already printed.
            let _ = thread.join();
        }
    }
}

/// The state of the requests `#` (send frames) and `$` (stop) to the vehicle.
struct Asking {
    said: Option<(bool, Instant)>,
}

impl Asking {
    /// The command to send now, if any.
    fn word(&mut self, station: &Station) -> Option<u8> {
        if station.protocol() == Some(Protocol::Mavlink) {
            return None;
        }
        let wanted = station.wants_frames();
        let due = match self.said {
            None => true,
            Some((said, at)) => {
                let is_unheard = wanted == station.is_silent();
                said != wanted || is_unheard && at.elapsed() >= ASK
            }
        };
        if !due {
            return None;
        }
        self.said = Some((wanted, Instant::now()));
        Some(if wanted { b'#' } else { b'$' })
    }
}

fn serial(path: &str, baud: u32, station: &SharedStation, stop: &AtomicBool) {
    let clock = Clock::start();
    let mut port = Port::new(PortConfig::new(path, baud), &clock);
    let mut asking = Asking { said: None };
    let mut buffer = [0; 4096];
    while !stop.load(Ordering::Relaxed) {
        match port.read_until(&mut buffer, clock.now() + WAIT_S) {
            Read::Bytes { count, .. } => {
                let mut station = lock(station);
                let now_s = station.now_s();
                station.receive(&buffer[..count], now_s);
            }
            Read::Silent => {}
            Read::Changed(event) => {
                let level = if port.is_open() { TextLevel::Info } else { TextLevel::Warning };
                lock(station).report_port(level, &format!("port {event}"));
                asking.said = None;
            }
        }
        let word = {
            let mut station = lock(station);
            let now_s = station.now_s();
            station.tick(now_s);
            port.is_open().then(|| asking.word(&station)).flatten()
        };
        if let Some(word) = word {
            // A lost command is sent again.
            let _ = port.write(&[word], clock.now() + WAIT_S);
        }
    }
}

fn udp(address: SocketAddr, station: &SharedStation, stop: &AtomicBool) {
    let mut asking = Asking { said: None };
    let mut buffer = vec![0; DATAGRAM];
    let mut vehicle = None;
    let mut socket: Option<UdpSocket> = None;
    while !stop.load(Ordering::Relaxed) {
        let Some(open) = &socket else {
            let opened = UdpSocket::bind(address).and_then(|socket| {
                socket.set_read_timeout(Some(Duration::from_secs_f64(WAIT_S)))?;
                Ok(socket)
            });
            match opened {
                Ok(opened) => {
                    lock(station).report_port(TextLevel::Info, "address open");
                    socket = Some(opened);
                }
                Err(error) => {
                    let text = format!("cannot open the address: {error}");
                    lock(station).report_port(TextLevel::Warning, &text);
                    thread::sleep(RETRY);
                }
            }
            continue;
        };
        if let Ok((count, from)) = open.recv_from(&mut buffer) {
            let mut station = lock(station);
            // The link follows one vehicle at a time. Another vehicle is accepted only after the present one has been
            // silent.
            if vehicle.is_none_or(|known| known == from) || station.is_silent() {
                if vehicle != Some(from) {
                    asking.said = None;
                }
                vehicle = Some(from);
                let now_s = station.now_s();
                station.receive(&buffer[..count], now_s);
            }
        }
        let word = {
            let mut station = lock(station);
            let now_s = station.now_s();
            station.tick(now_s);
            vehicle.and_then(|vehicle| Some((asking.word(&station)?, vehicle)))
        };
        if let Some((word, vehicle)) = word {
            let _ = open.send_to(&[word], vehicle);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_named_by_a_port_or_an_address() {
        let serial = |path: &str, baud| Ok(Source::Serial { path: path.into(), baud });
        assert_eq!("/dev/ttyUSB0".parse(), serial("/dev/ttyUSB0", 57_600));
        assert_eq!("COM3:115200".parse(), serial("COM3", 115_200));
        assert_eq!("udp:14550".parse(), Ok(Source::Udp(([127, 0, 0, 1], 14_550).into())));
        assert_eq!("udp:0.0.0.0:9".parse(), Ok(Source::Udp(([0, 0, 0, 0], 9).into())));
        assert_eq!("udp:127.0.0.1:9".parse(), Ok(Source::Udp(([127, 0, 0, 1], 9).into())));
        for bad in ["", "udp:", "udp:0", "udp:nowhere:3", "/dev/x:fast", "/dev/x:5", ":9600"] {
            let error = bad.parse::<Source>().unwrap_err();
            assert!(error.to_string().contains("expected a serial port"), "{bad}");
        }
    }
}
