//! The link over a pseudo-terminal and over UDP: `#`, `$`, interruption and reconnection.
#![cfg(unix)]

use std::io::{Read as _, Write as _};
use std::net::UdpSocket;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use crate::common::{cycle, station, until};
use hovernav_ground::link::{Link, SharedStation, Source, lock};
use hovernav_ground::station::{Clock, now_s};
use serialport::{SerialPort as _, TTYPort};

/// A terminal at `path`. Returns the test's end, and the station's end, which keeps the terminal open.
fn terminal(path: &Path) -> (TTYPort, TTYPort) {
    let (mut ours, theirs) = TTYPort::pair().unwrap();
    ours.set_timeout(Duration::from_millis(5)).unwrap();
    let _ = std::fs::remove_file(path);
    symlink(theirs.name().unwrap(), path).unwrap();
    (ours, theirs)
}

/// The vehicle's side of a modem. It sends the cycles from `number` on while frames are requested, and stores the
/// received commands.
struct Modem {
    port: TTYPort,
    _other: TTYPort,
    heard: Vec<u8>,
    number: u32,
}

impl Modem {
    fn at(path: &Path, number: u32) -> Self {
        let (port, other) = terminal(path);
        Self { port, _other: other, heard: Vec::new(), number }
    }

    fn run(&mut self) {
        let mut buffer = [0; 64];
        if let Ok(count) = self.port.read(&mut buffer) {
            self.heard.extend_from_slice(&buffer[..count]);
        }
        if self.heard.last() == Some(&b'#') {
            self.port.write_all(&cycle(self.number)).unwrap();
            self.number += 1;
            thread::sleep(Duration::from_millis(20));
        }
    }
}

fn frames(station: &SharedStation) -> u64 {
    lock(station).link(now_s()).frames
}

#[test]
fn a_modem_is_asked_paused_pulled_out_and_put_back() {
    let place = tempfile::tempdir().unwrap();
    let path: PathBuf = place.path().join("modem");
    let station = station();
    let source: Source = format!("{}:57600", path.display()).parse().unwrap();
    let _link = Link::open(&source, Arc::clone(&station)).unwrap();
    until("a missing port is reported", || {
        lock(&station).link(now_s()).port.contains("there is no such device")
    });

    let mut modem = Modem::at(&path, 0);
    until("frames come", || {
        modem.run();
        frames(&station) > 40
    });
    lock(&station).want_frames(false);
    until("the vehicle is told to pause", || {
        modem.run();
        modem.heard.last() == Some(&b'$')
    });
    until("the link is silent", || {
        modem.run();
        lock(&station).is_silent()
    });
    lock(&station).want_frames(true);
    let before = frames(&station);
    until("frames come again", || {
        modem.run();
        frames(&station) > before + 20
    });
    assert!(
        modem.heard.iter().all(|byte| matches!(byte, b'#' | b'$')),
        "no other byte is ever sent"
    );

    // Unplugged: the link reports it and reconnects with the port.
    let number = modem.number;
    drop(modem);
    until("the loss is reported", || {
        lock(&station).link(now_s()).port.contains("lost")
            || lock(&station).link(now_s()).port.contains("cannot")
    });
    let mut modem = Modem::at(&path, number + 66);
    let before = frames(&station);
    until("frames come after the loss", || {
        modem.run();
        frames(&station) > before + 20
    });
    let link = lock(&station).link(now_s());
    assert!(link.outages >= 1 && link.damaged <= 2, "{link:?}");
}

#[test]
fn a_vehicle_on_udp_is_answered_where_it_is() {
    let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let station = station();
    let source: Source = format!("udp:{free}").parse().unwrap();
    let _link = Link::open(&source, Arc::clone(&station)).unwrap();
    let vehicle = UdpSocket::bind("127.0.0.1:0").unwrap();
    vehicle.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    let (mut word, mut number) = (0, 0);
    until("frames come", || {
        let mut buffer = [0; 8];
        if vehicle.recv(&mut buffer).is_ok() {
            word = buffer[0];
        }
        // While paused, the vehicle sends a byte to announce itself.
        let bytes = if word == b'#' { cycle(number) } else { vec![0] };
        vehicle.send_to(&bytes, free).unwrap();
        number += u32::from(word == b'#');
        thread::sleep(Duration::from_millis(10));
        frames(&station) > 40
    });
    // Another sender is ignored while the vehicle is active.
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    // With a stopped clock, the vehicle stays active while a busy machine delays this thread.
    lock(&station).clock = Clock::Stopped(now_s());
    let heard = frames(&station);
    vehicle.send_to(&cycle(number), free).unwrap();
    number += 1;
    until("the vehicle is active", || frames(&station) > heard);
    let heard = frames(&station);
    let before = lock(&station).link(now_s()).lost;
    for odd in 0..20 {
        stranger.send_to(&cycle(odd * 7), free).unwrap();
        vehicle.send_to(&cycle(number), free).unwrap();
        number += 1;
        thread::sleep(Duration::from_millis(10));
    }
    until("the vehicle's frames come", || frames(&station) >= heard + 39);
    assert_eq!(lock(&station).link(now_s()).lost, before);
}
