//! A flight computer with no hardware: `fly` against devices on pseudo-terminals, at real speed.

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::Duration;

use hovernav::controls::{Channel, Channels};
use hovernav::gps::Protocol;
use hovernav::servo::packet::ServoPacket;
use hovernav::telemetry::{Snapshot, SystemMode, frame};
use hovernav_fly::play;
use hovernav_fly::play::{Begin, Cut, CutKind, EmulatedPort, Player};
use hovernav_fly::{FlightReport, Notification, fly};
use hovernav_log::Dataset;
use hovernav_log::record::Record;
use hovernav_log::{FlyConfig, FlyConfigError};
use serialport::{SerialPort as _, TTYPort};

fn hover() -> Dataset {
    Dataset::open(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover").as_ref()).unwrap()
}

fn configuration(place: &Path, more: &str) -> FlyConfig {
    let text = format!(
        "telemetry.port = '{ground}'
         mavlink.port = '{mavlink}'
         servo.capture.serial.port = '{pilot}'
         [dmu]
         port = '{dmu}'
         [receiver]
         port = '{gps}'
         protocol = 'ubx'
         [navigation.imu]
         lever_arm_m = [0.03, -0.02, 0.28]
         heading_reference = 'true'
         magnetic_declination_deg = 0.42
         [navigation.gps]
         antenna_lever_arm_m = [-0.35, 0.0, 0.2]
         {more}",
        ground = place.join("ground").display(),
        mavlink = place.join("mavlink").display(),
        pilot = place.join("pilot").display(),
        dmu = place.join("dmu").display(),
        gps = place.join("gps").display(),
    );
    FlyConfig::parse(&text, Path::new("fly.toml")).unwrap()
}

/// A pseudo-terminal whose other end is linked to at `path`. Both ends must be kept open.
fn terminal(path: &Path) -> (TTYPort, TTYPort) {
    let (mut ours, theirs) = TTYPort::pair().unwrap();
    ours.set_timeout(Duration::from_millis(20)).unwrap();
    std::os::unix::fs::symlink(theirs.name().unwrap(), path).unwrap();
    (ours, theirs)
}

/// The pilot: every 20 ms all sticks at 1.5 ms but the lateral one, at 1.6 ms.
fn pilot(mut port: TTYPort, stop: Arc<AtomicBool>) {
    let mut sequence = 0u8;
    while !stop.load(Ordering::Relaxed) {
        let width_ticks = Channels::from_fn(|channel| {
            Some(ServoPacket::ticks(if channel == Channel::Lateral { 1.6 } else { 1.5 }))
        });
        let packet = ServoPacket { sequence, width_ticks, ..ServoPacket::default() };
        // Until the port is opened the terminal may have no room.
        let _ = port.write_all(&packet.encode());
        sequence = sequence.wrapping_add(1);
        thread::sleep(Duration::from_millis(20));
    }
}

/// What the ground saw.
#[derive(Default)]
struct Ground {
    snapshots: Vec<Snapshot>,
    damaged: usize,
    bytes_while_paused: usize,
}

/// The ground: lets frames flow, pauses them for two seconds after `pause_after` frames, and lets
/// them flow again.
fn ground(mut port: TTYPort, pause_after: usize, stop: Arc<AtomicBool>) -> Ground {
    let mut ground = Ground::default();
    let mut decoder = frame::Decoder::default();
    let mut buffer = [0; 512];
    let mut paused: Option<std::time::Instant> = None;
    let mut has_paused = false;
    let mut asked = std::time::Instant::now();
    while !stop.load(Ordering::Relaxed) {
        // What is said before the flight computer listens is lost, on a modem as here.
        if ground.snapshots.is_empty() && asked.elapsed() > Duration::from_millis(200) {
            port.write_all(b"#").unwrap();
            asked = std::time::Instant::now();
        }
        let count = port.read(&mut buffer).unwrap_or(0);
        match paused {
            // What was on its way still comes.
            Some(since) if since.elapsed() > Duration::from_millis(300) => {
                ground.bytes_while_paused += count;
            }
            _ => {
                for decoded in buffer[..count].iter().filter_map(|byte| decoder.push(*byte)) {
                    match decoded {
                        Ok(frame) => ground.snapshots.push(frame.snapshot),
                        Err(_) => ground.damaged += 1,
                    }
                }
            }
        }
        if !has_paused && ground.snapshots.len() >= pause_after {
            port.write_all(b"$").unwrap();
            (paused, has_paused) = (Some(std::time::Instant::now()), true);
        }
        if paused.is_some_and(|since| since.elapsed() > Duration::from_secs(2)) {
            port.write_all(b"#").unwrap();
            paused = None;
        }
    }
    ground
}

/// How many of each message a MAVLink 2 stream holds, by number.
fn mavlink_messages(mut bytes: &[u8]) -> BTreeMap<u32, usize> {
    let mut seen = BTreeMap::new();
    while let [0xFD, length, _, _, _, _, _, id0, id1, id2, ..] = bytes {
        let whole = 12 + usize::from(*length);
        if bytes.len() < whole {
            break;
        }
        *seen.entry(u32::from_le_bytes([*id0, *id1, *id2, 0])).or_insert(0) += 1;
        bytes = &bytes[whole..];
    }
    seen
}

/// Flies `seconds` of the hover flight.
fn flown(
    config: &FlyConfig,
    record: &Path,
    player: Player,
    seconds: f64,
    stop: &Arc<AtomicBool>,
) -> FlightReport {
    let (console, told) = sync_channel::<Notification>(1024);
    let reader = thread::spawn(move || {
        for line in told {
            println!("{:9.3} {}", line.time.seconds(), line.text.as_str());
        }
    });
    let watch = {
        let stop = Arc::clone(stop);
        thread::spawn(move || {
            while !player.is_finished()
                && player.elapsed_s().is_none_or(|elapsed_s| elapsed_s < seconds)
            {
                thread::sleep(Duration::from_millis(20));
            }
            stop.store(true, Ordering::Relaxed);
            player
        })
    };
    let report = fly(config, record, stop, console).unwrap();
    watch.join().unwrap().stop().unwrap();
    reader.join().unwrap();
    println!("{report}");
    report
}

#[test]
fn a_flight_goes_on_through_lost_sensors_and_replays_bit_for_bit() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name);
    let dataset = hover();
    let start = dataset.imu[0].time;
    let cut = |start_s: f64, duration_s, kind| Cut { start: start + start_s, duration_s, kind };
    let ports = vec![
        EmulatedPort {
            cuts: vec![cut(14.0, 2.0, CutKind::Adapter)],
            ..EmulatedPort::new(path("dmu"), play::dmu(&dataset).unwrap())
        },
        EmulatedPort {
            cuts: vec![cut(7.0, 5.0, CutKind::Wire)],
            ..EmulatedPort::new(path("gps"), play::gps(&dataset, Protocol::Ubx))
        },
    ];
    let stop = Arc::new(AtomicBool::new(false));
    let (pilot_port, _pilot_end) = terminal(&path("pilot"));
    let (ground_port, _ground_end) = terminal(&path("ground"));
    let (mut mavlink_port, _mavlink_end) = terminal(&path("mavlink"));
    let pilot = thread::spawn({
        let stop = Arc::clone(&stop);
        move || pilot(pilot_port, stop)
    });
    let ground = thread::spawn({
        let stop = Arc::clone(&stop);
        move || ground(ground_port, 100, stop)
    });
    let mavlink = thread::spawn({
        let stop = Arc::clone(&stop);
        move || {
            let (mut bytes, mut buffer) = (Vec::new(), [0; 1024]);
            while !stop.load(Ordering::Relaxed) {
                let count = mavlink_port.read(&mut buffer).unwrap_or(0);
                bytes.extend_from_slice(&buffer[..count]);
            }
            bytes
        }
    });

    let config = configuration(place.path(), "");
    let record = path("flight.mcap");
    let player = Player::start(ports, 1.0, Begin::WhenAsked).unwrap();
    let report = flown(&config, &record, player, 22.0, &stop);
    pilot.join().unwrap();
    let ground = ground.join().unwrap();
    let mavlink = mavlink_messages(&mavlink.join().unwrap());

    // 20 s with the unit there, at 33 Hz, less what a busy machine keeps from a player and a loop
    // that are ordinary programs.
    assert!((400..=730).contains(&report.cycles), "{} cycles", report.cycles);
    assert!((14..=19).contains(&report.fixes), "{} fixes", report.fixes);
    assert_eq!((report.dmu_port.lost, report.dmu_port.opened), (1, 2));
    assert_eq!((report.record.lost_raw, report.record.lost_decoded), (0, 0));

    // The ground saw all of it but the pause, at 33 Hz, the pilot's sticks within a step of the wire.
    assert_eq!(ground.damaged, 0);
    assert_eq!(ground.bytes_while_paused, 0, "bytes after $");
    assert!(ground.snapshots.len() > 350, "{} frames", ground.snapshots.len());
    assert!(ground.snapshots.iter().any(|snapshot| snapshot.mode == SystemMode::Pilot));
    assert!(ground.snapshots.iter().any(|snapshot| !snapshot.status.gps));
    let without_unit: Vec<_> = ground
        .snapshots
        .iter()
        .filter(|snapshot| snapshot.position.is_some() && !snapshot.status.imu)
        .collect();
    assert!(without_unit.len() > 20, "{} cycles without the unit", without_unit.len());
    assert!(
        without_unit.iter().all(|snapshot| {
            let lateral_ms = snapshot.commanded_ms.lateral;
            lateral_ms.is_some_and(|width_ms| (width_ms - 1.6).abs() < 1e-3)
        }),
        "the pilot kept the servos though the inertial unit was gone"
    );
    // HEARTBEAT, GPS_RAW_INT, ATTITUDE, LOCAL_POSITION_NED, SERVO_OUTPUT_RAW, HIGHRES_IMU and
    // ESTIMATOR_STATUS, by their numbers.
    for id in [0, 24, 30, 32, 36, 105, 230] {
        assert!(mavlink.get(&id).is_some_and(|&count| count > 10), "{id}: {mavlink:?}");
    }

    // The record gives back what was flown.
    let record = Record::open(&record).unwrap();
    assert!(record.is_ended && record.warnings.is_empty(), "{:?}", record.warnings);
    assert_eq!(
        record.controls.last().unwrap().1.map(|stick| (1e3 * stick).round()),
        [200.0, 0.0, 0.0, 0.0]
    );
    let mut replayed = record.dataset().unwrap();
    assert_eq!(replayed.imu.len() as u64, report.cycles);
    let settings = replayed.settings().unwrap();
    let run = replayed.estimate(&settings, |_| {});
    let reproduction = record.reproduced_by(&run.solutions);
    assert!(reproduction.compared > 350, "{} solutions flown", reproduction.compared);
    assert_eq!(reproduction.first_difference, None);
    for kind in ["gps_fixes", "dmu_port", "pilot_signal"] {
        assert!(record.events.iter().any(|event| event.kind == kind), "no event {kind}");
    }
}

#[test]
fn a_flight_without_any_device_flies_on_says_so_and_ends() {
    let place = tempfile::tempdir().unwrap();
    let config = configuration(place.path(), "");
    let record = place.path().join("nothing.mcap");
    let stop = Arc::new(AtomicBool::new(false));
    let later = {
        let stop = Arc::clone(&stop);
        thread::spawn(move || {
            thread::sleep(Duration::from_millis(1500));
            stop.store(true, Ordering::Relaxed);
        })
    };
    let (console, told) = sync_channel(64);
    let report = fly(&config, &record, &stop, console).unwrap();
    later.join().unwrap();
    assert_eq!((report.cycles, report.fixes), (0, 0));
    assert!(report.dmu_port.failed_to_open > 2);
    let told: Vec<_> = told.iter().map(|line| line.text.as_str().to_owned()).collect();
    assert!(
        told.iter().any(|line| line.contains("inertial unit: port cannot be opened")),
        "{told:?}"
    );
    assert!(Record::open(&record).unwrap().is_ended);
}

#[test]
fn no_record_is_written_over_and_no_flight_begins_without_one() {
    let place = tempfile::tempdir().unwrap();
    let config = configuration(place.path(), "");
    let record = place.path().join("taken.mcap");
    std::fs::write(&record, "something").unwrap();
    for (path, said) in
        [(record, "exists already"), (place.path().join("no/such/x.mcap"), "No such")]
    {
        let (console, _told) = sync_channel(1);
        let error = fly(&config, &path, &AtomicBool::new(true), console).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn the_examples_can_be_flown() {
    for name in ["fly.toml", "play.toml"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
        let mut config = FlyConfig::read(&path).unwrap();
        config.settle(1_760_000_000).unwrap();
    }
}

#[test]
fn a_configuration_that_cannot_be_flown_is_refused_with_the_reason() {
    let base = "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n";
    for (text, said) in [
        ("[dmu]\nprot = 'a'\n", "fly.toml: no such key: dmu.prot"),
        ("[dmu]\nrate_hz = 80\n", "[dmu] rate_hz: found 80, expected 20 to 70"),
        (
            "[dmu]\nmode = 'voltage'\n",
            "fly.toml:2: [dmu] mode: found \"voltage\", expected \"angle\" or \"scaled\"",
        ),
        ("[receiver]\nrate_hz = 11\n", "[receiver] rate_hz: found 11"),
        ("[receiver]\ngeoid_separation_m = nan\n", "[receiver] geoid_separation_m: found NaN"),
        (
            "[servo.channels.lateral]\ntrim_ms = 3\n",
            "[servo.channels.lateral] trim_ms: found 3, expected 0.5 to 2.5 ms",
        ),
        (
            "[navigation.gps]\nlatency_s = 99\n",
            "[navigation.gps] latency_s: found 99, expected 0 to 2 s",
        ),
        ("x = ", "fly.toml:1: "),
    ] {
        let error = FlyConfig::parse(text, Path::new("fly.toml")).unwrap_err().to_string();
        assert!(error.contains(said), "{text}: {error}");
        assert!(!error.contains('\n'), "{error}");
    }
    let mut config = FlyConfig::parse(base, Path::new("fly.toml")).unwrap();
    let unsettled = config.settle(0).unwrap_err();
    assert!(
        matches!(&unsettled, FlyConfigError::Value { section, .. } if section == "navigation.imu"),
        "{unsettled}"
    );

    let somewhere = format!("{base}[site]\nlatitude_deg = 1.35\nlongitude_deg = 103.8\n");
    let mut config = FlyConfig::parse(&somewhere, Path::new("fly.toml")).unwrap();
    let remark = config.settle(1_760_000_000).unwrap().unwrap();
    assert!(remark.contains("World Magnetic Model"), "{remark}");
    assert!(config.navigation.imu.magnetic_declination_deg.unwrap().abs() < 1.0);
    let again = FlyConfig::parse(&config.to_toml().unwrap(), Path::new("again.toml")).unwrap();
    assert_eq!(again, config);
    assert_eq!(config.record_path(1_760_000_000), Path::new("records/2025-10-09T08-53-20Z.mcap"));
}
