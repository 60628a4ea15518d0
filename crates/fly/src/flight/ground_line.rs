//! The line to the ground: a serial port or UDP.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, ToSocketAddrs as _, UdpSocket};
use std::path::PathBuf;
use std::time::Duration;

use crate::serial::{Clock, Port, PortConfig, PortEvent, Read};
use hovernav::time::Time;

/// Time after which an unresolved name or a failed socket is tried again, s.
const RETRY_S: f64 = 1.0;
/// Shortest timeout of a socket read: a timeout of zero is not allowed.
const MIN_WAIT: Duration = Duration::from_millis(1);

/// The line to the ground.
pub enum GroundLine {
    /// A serial port.
    Serial(Serial),
    /// Datagrams.
    Udp(Udp),
}

/// A serial port, its baud rate, and an unreported change of its state.
pub struct Serial {
    port: Port,
    baud: u32,
    changed: Option<PortEvent>,
}

/// Datagrams to one address, one for each write. A datagram that cannot be sent is lost, as on a radio.
pub struct Udp {
    address: String,
    clock: Clock,
    socket: Option<UdpSocket>,
    retry: Time,
}

impl GroundLine {
    /// The line to `udp`, as `host:port`, if set, else at `port`.
    pub fn new(port: Option<&PathBuf>, baud: u32, udp: Option<&String>, clock: &Clock) -> Self {
        match udp {
            Some(address) => {
                let retry = clock.now();
                let (address, clock) = (address.clone(), clock.clone());
                Self::Udp(Udp { address, clock, socket: None, retry })
            }
            None => {
                let path = port.cloned().unwrap_or_default();
                let port = Port::new(PortConfig::new(path, baud), clock);
                Self::Serial(Serial { port, baud, changed: None })
            }
        }
    }

    /// Capacity of the line, bytes per second, with a margin of 15 %; `None` without a limit.
    pub fn budget(&self) -> Option<f64> {
        match self {
            Self::Serial(serial) => Some(0.85 * f64::from(serial.baud) / 10.0),
            Self::Udp(_) => None,
        }
    }

    /// Reads into `buffer`, waiting until `deadline`; returns the number of bytes.
    pub fn read_until(&mut self, buffer: &mut [u8], deadline: Time) -> usize {
        match self {
            Self::Serial(serial) => match serial.port.read_until(buffer, deadline) {
                Read::Bytes { count, .. } => count,
                Read::Changed(event) => {
                    serial.changed = Some(event);
                    0
                }
                Read::Silent => 0,
            },
            Self::Udp(udp) => udp.read_until(buffer, deadline),
        }
    }

    /// Writes `bytes`, waiting until `deadline`; returns whether all were accepted.
    pub fn write(&mut self, bytes: &[u8], deadline: Time) -> bool {
        match self {
            Self::Serial(serial) => serial.port.write(bytes, deadline).is_ok(),
            Self::Udp(udp) => udp.socket.as_ref().is_some_and(|socket| socket.send(bytes).is_ok()),
        }
    }

    pub fn is_open(&self) -> bool {
        match self {
            Self::Serial(serial) => serial.port.is_open(),
            Self::Udp(udp) => udp.socket.is_some(),
        }
    }

    /// A change of the port since the last call.
    pub fn take_change(&mut self) -> Option<PortEvent> {
        match self {
            Self::Serial(serial) => serial.changed.take(),
            Self::Udp(_) => None,
        }
    }
}

impl Udp {
    fn open(&self) -> io::Result<UdpSocket> {
        let mut outcome = Err(io::ErrorKind::NotFound.into());
        for ground in self.address.to_socket_addrs()? {
            // A connected socket receives only datagrams from the ground. If the ground is on this computer, the socket
            // is bound to the loopback address, so that before the connection it receives only datagrams from this
            // computer.
            let own: IpAddr = match ground.ip() {
                IpAddr::V4(ip) if ip.is_loopback() => Ipv4Addr::LOCALHOST.into(),
                IpAddr::V6(ip) if ip.is_loopback() => Ipv6Addr::LOCALHOST.into(),
                IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
                IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
            };
            outcome = UdpSocket::bind((own, 0)).and_then(|socket| {
                socket.connect(ground)?;
                Ok(socket)
            });
            if outcome.is_ok() {
                break;
            }
        }
        outcome
    }

    fn read_until(&mut self, buffer: &mut [u8], deadline: Time) -> usize {
        let now = self.clock.now();
        if self.socket.is_none() && now >= self.retry {
            self.socket = self.open().ok();
            self.retry = now + RETRY_S;
        }
        let Some(socket) = &self.socket else {
            self.clock.sleep_until(deadline);
            return 0;
        };
        let wait = self.clock.until(deadline).max(MIN_WAIT);
        let read = socket.set_read_timeout(Some(wait)).and_then(|()| socket.recv(buffer));
        read.unwrap_or_else(|_| {
            // The read returns at once if no program listens at the other end. A read also does not advance an
            // emulated clock. Therefore this waits until the deadline.
            self.clock.sleep_until(deadline);
            0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ground_at_an_address_of_version_6_is_reached_and_only_it_is_received() {
        let Ok(ground) = UdpSocket::bind("[::1]:0") else { return };
        ground.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let clock = Clock::start();
        let address = ground.local_addr().unwrap().to_string();
        let mut line = GroundLine::new(None, 0, Some(&address), &clock);
        let mut buffer = [0; 16];
        line.read_until(&mut buffer, clock.now() + 0.002);
        assert!(line.write(b"frame", clock.now()));
        let (_, vehicle) = ground.recv_from(&mut buffer).unwrap();
        assert!(vehicle.ip().is_loopback());
        let stranger = UdpSocket::bind("[::1]:0").unwrap();
        stranger.send_to(b"$$$", vehicle).unwrap();
        ground.send_to(b"#", vehicle).unwrap();
        assert_eq!(line.read_until(&mut buffer, clock.now() + 5.0), 1);
        assert_eq!(buffer[0], b'#');
    }

    #[test]
    fn datagrams_reach_the_address_and_its_answer_is_received() {
        let ground = UdpSocket::bind("127.0.0.1:0").unwrap();
        ground.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let clock = Clock::start();
        let address = ground.local_addr().unwrap().to_string();
        let mut line = GroundLine::new(None, 0, Some(&address), &clock);
        let mut buffer = [0; 16];
        assert_eq!(line.read_until(&mut buffer, clock.now() + 0.002), 0);
        assert!(line.is_open() && line.budget().is_none());
        assert!(line.write(b"frame", clock.now()));
        let (count, vehicle) = ground.recv_from(&mut buffer).unwrap();
        assert_eq!(&buffer[..count], b"frame");
        ground.send_to(b"#", vehicle).unwrap();
        let mut buffer = [0; 16];
        assert_eq!(line.read_until(&mut buffer, clock.now() + 5.0), 1);
        assert_eq!(buffer[0], b'#');
    }
}
