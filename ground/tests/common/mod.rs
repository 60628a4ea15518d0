//! A station with a server, and a vehicle that flies circles.
#![allow(dead_code, reason = "each test uses a part")]

pub mod browser;
pub mod sender;

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hovernav::autopilot::Mode;
use hovernav::controls::{Channel, Channels};
use hovernav::earth::Geodetic;
use hovernav::flight_control::Geofence;
use hovernav::frames::{EulerAngles, Vector};
use hovernav::telemetry::{
    FixKind, GpsSummary, Innovations, LoopTiming, Sigmas, Snapshot, StatusFlags, Supplement,
    SystemMode, frame,
};
use hovernav::time::Time;
use hovernav_dataset::Manifest;
use hovernav_ground::channel::Id;
use hovernav_ground::folder::Folder;
use hovernav_ground::frames::Rigging;
use hovernav_ground::link::{SharedStation, lock};
use hovernav_ground::server::{Access, Bound, ServerConfig};
use hovernav_ground::station::{Clock, Station, now_s};
use hovernav_ground::tiles::Tiles;
use serde_json::Value;
use tungstenite::{Message, WebSocket};

/// The snapshot at `time_s`, with a value in every channel of telemetry.
pub fn snapshot(time_s: f64) -> Snapshot {
    let (sin, cos) = (0.5 * time_s).sin_cos();
    let three = |scale: f64| Vector::new(scale * sin, scale * cos, scale);
    // Every 7 s a step of 12 % of the lateral stick, and the roll rate in response.
    let since_s = (time_s - 6.0) % 7.0;
    let (steps, held_s) = (time_s >= 6.0, 1.5);
    let stick = if steps && since_s < held_s { 0.12 } else { 0.0 };
    let rise = |s: f64| 1.0 - (-6.0 * s).exp();
    let answer = match since_s {
        _ if !steps => 0.0,
        s if s < held_s => 0.4 * rise(s),
        s => 0.4 * rise(held_s) * (-6.0 * (s - held_s)).exp(),
    };
    let slow = 0.01 * (0.1 * time_s).sin();
    let widths = |add: f64| {
        Channels::from_fn(|channel| {
            let step = if channel == Channel::Lateral { 0.5 * stick } else { 0.0 };
            Some(1.5 + add + slow + step)
        })
    };
    Snapshot {
        mode: SystemMode::Pilot,
        status: StatusFlags::from_bits(0b111_0111_1111),
        angular_rate_radps: Some(Vector::new(answer + 0.01 * sin, 0.1 * cos, 0.1)),
        specific_force_mps2: Some(three(1.0)),
        magnetic_field_gauss: Some(three(0.3)),
        temperature_degc: Some(31.5),
        attitude: Some(EulerAngles::from_degrees(10.0 * sin, 10.0 * cos, 90.0 * sin)),
        position: Geodetic::from_degrees(1.35 + 1e-4 * sin, 103.82 + 1e-4 * cos, 50.0),
        velocity_mps: Some(Vector::new(2.0 * sin, 2.0 * cos, 2.0)),
        sigmas: Sigmas {
            horizontal_m: Some(0.8),
            vertical_m: Some(1.2),
            horizontal_velocity_mps: Some(0.07),
            vertical_velocity_mps: Some(0.09),
            tilt_rad: Some(0.01),
            heading_rad: Some(0.03),
        },
        commanded_ms: widths(0.0),
        pilot_ms: widths(0.01),
        gps: GpsSummary {
            fix: FixKind::ThreeD,
            satellites: Some(9),
            age_s: Some(0.4),
            latitude_longitude_deg: Some([1.35, 103.82]),
            height_m: Some(50.0),
            altitude_msl_m: Some(42.0),
            horizontal_velocity_mps: Some([1.0, 0.5]),
            down_velocity_mps: Some(0.1),
            hdop: Some(1.1),
            vdop: Some(1.8),
            ..GpsSummary::default()
        },
        innovations: Innovations {
            position: Some(1.0),
            velocity: Some(0.5),
            attitude: Some(0.5),
            heading: Some(0.5),
            baro: Some(0.5),
            rejected: 1,
        },
        timing: LoopTiming {
            period_s: Some(0.0303),
            work_s: Some(0.002),
            longest_work_s: Some(0.004),
            overruns: 0,
        },
        ..Snapshot::at(Time::from_seconds(time_s))
    }
}

/// The supplement at `time_s`.
pub fn supplement(time_s: f64) -> Supplement {
    Supplement {
        mode: Some(Mode::Manual),
        failed_checks: 1 << 6,
        aux_ms: Some(1.2),
        gyro_bias_radps: Some(Vector::new(1e-3, 2e-3, -1e-3)),
        accel_bias_mps2: Some(Vector::new(0.1, 0.2, -0.1)),
        gyro_bias_sigma_radps: Some(Vector::new(1e-4, 1e-4, 1e-4)),
        accel_bias_sigma_mps2: Some(Vector::new(0.01, 0.01, 0.01)),
        ..Supplement::at(Time::from_seconds(time_s))
    }
}

/// The bytes of one cycle of the vehicle.
pub fn cycle(number: u32) -> Vec<u8> {
    let time_s = f64::from(number) / 33.0;
    let mut bytes = frame::pack(&snapshot(time_s), (2 * number) as u8).to_vec();
    bytes.extend(frame::pack_supplement(&supplement(time_s), (2 * number + 1) as u8));
    bytes
}

pub fn station() -> SharedStation {
    Arc::new(Mutex::new(Station::new(Rigging::default(), None, "test")))
}

/// A server on a free port of loopback, until dropped.
pub struct Served {
    pub address: SocketAddr,
    pub station: SharedStation,
    pub place: tempfile::TempDir,
    /// Start time of the server, seconds since the start of 1970.
    pub start_s: f64,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

pub fn serve(token: Option<&str>) -> Served {
    serve_with(token, None)
}

/// As [`serve`], with tiles for the map.
pub fn serve_with(token: Option<&str>, tiles: Option<Tiles>) -> Served {
    let place = tempfile::tempdir().unwrap();
    let station = station();
    let config = ServerConfig {
        address: "127.0.0.1:0".parse().unwrap(),
        access: Access::new(true, token.map(str::to_owned)).unwrap(),
        folder: Folder::open(&place.path().join("records")).unwrap(),
        command: None,
        manifest: Manifest::default(),
        geofence: Some(Geofence {
            centre: Geodetic::from_degrees(1.35, 103.82, 0.0).unwrap(),
            radius_m: 40.0,
            height_m: 50.0,
        }),
        tiles,
    };
    let bound = Bound::new(config, Arc::clone(&station)).unwrap();
    let address = bound.address();
    let stop = Arc::new(AtomicBool::new(false));
    let theirs = Arc::clone(&stop);
    let thread = Some(std::thread::spawn(move || bound.run(&theirs).unwrap()));
    Served { address, station, place, start_s: now_s(), stop, thread }
}

impl Served {
    /// Receives bytes at `at_s` and stops the station's clock at this time, so that values stay present on a busy
    /// machine.
    pub fn receive(&self, bytes: &[u8], at_s: f64) {
        let mut station = lock(&self.station);
        station.clock = Clock::Stopped(at_s);
        station.receive(bytes, at_s);
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Number of messages of the server within which an answer is expected.
const MAX_MESSAGES: usize = 1000;

/// A client of the server.
pub struct Client(pub WebSocket<TcpStream>);

impl Client {
    pub fn connect(served: &Served, query: &str) -> Result<Self, Box<tungstenite::Error>> {
        let stream = TcpStream::connect(served.address).unwrap();
        let url = format!("ws://{}/socket{query}", served.address);
        match tungstenite::client(url, stream) {
            Ok((socket, _)) => Ok(Self(socket)),
            Err(tungstenite::HandshakeError::Failure(error)) => Err(Box::new(error)),
            Err(tungstenite::HandshakeError::Interrupted(_)) => panic!("no answer"),
        }
    }

    pub fn ask(&mut self, request: &str) {
        self.0.send(Message::text(request)).unwrap();
    }

    /// The next message with `key`. The limit is a number of messages and not a time, because a busy machine sends
    /// later.
    pub fn observe(&mut self, key: &str) -> Value {
        for _ in 0..MAX_MESSAGES {
            let Message::Text(text) = self.0.read().unwrap() else { continue };
            let message: Value = serde_json::from_str(&text).unwrap();
            if let Some(found) = message.get(key) {
                return found.clone();
            }
        }
        panic!("no message with {key} among {MAX_MESSAGES}");
    }
}

/// Waits until `is_so`, at most 20 s.
pub fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(20);
    while !is_so() {
        assert!(Instant::now() < end, "{what}: not within 20 s");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends raw bytes and returns the answer of the server.
pub fn raw(served: &Served, request: &str) -> String {
    let mut stream = TcpStream::connect(served.address).unwrap();
    // If a request is too long, the server closes the connection within it, before or after its last byte.
    let _ = stream.write_all(request.as_bytes());
    let stays_open = !request.contains("Connection: close");
    let (mut answer, mut buffer) = (String::new(), [0; 4096]);
    // If the connection stays open, the answer ends with its headers.
    while let Ok(count @ 1..) = stream.read(&mut buffer) {
        answer.push_str(&String::from_utf8_lossy(&buffer[..count]));
        if stays_open && answer.contains("\r\n\r\n") {
            break;
        }
    }
    answer
}

/// The answer to a request for `path`.
pub fn get(served: &Served, path: &str) -> String {
    let host = served.address;
    raw(served, &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"))
}

/// Resident memory of this process, bytes.
pub fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap();
    4096 * text.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
}

/// Runs the ignored test `name` of this program in its own process, and asserts that it passes.
#[track_caller]
pub fn passes_alone(name: &str) {
    let mut alone = std::process::Command::new(std::env::current_exe().unwrap());
    let run = alone.args(["--exact", name, "--ignored", "--nocapture"]).output().unwrap();
    let told = String::from_utf8_lossy(&run.stdout);
    println!("{told}{}", String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success() && told.contains("test result: ok. 1 passed"), "{name}");
}

/// The value of a channel at the time of the newest data; NaN if unknown.
pub fn newest(station: &Station, id: Id) -> f64 {
    station.store.span().map_or(f64::NAN, |(_, to_s)| station.store.latest(id, to_s))
}
