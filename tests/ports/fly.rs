//! A flight computer without hardware: `fly` against emulated devices, in emulated time.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex};

use hovernav::controls::{Channel, Channels};
use hovernav::gps::Protocol;
use hovernav::servo::packet::ServoPacket;
use hovernav::telemetry::{Snapshot, SystemMode, frame};
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_fly::devices::{Device, RecordedDevice};
use hovernav_fly::play;
use hovernav_fly::play::{Begin, Cut, CutKind, EmulatedPort, Player};
use hovernav_fly::serial::Clock;
use hovernav_fly::{FlightReport, Notification, fly};
use hovernav_record::{FlyConfig, FlyConfigError, Level, Record};
use hovernav_replay::estimate;

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

/// The pilot: every 20 ms all sticks at 1.5 ms except the lateral one, at 1.6 ms.
fn pilot(start: Time) -> RecordedDevice {
    let packet = |number: u32| {
        let width_ticks = Channels::from_fn(|channel| {
            Some(ServoPacket::ticks(if channel == Channel::Lateral { 1.6 } else { 1.5 }))
        });
        let packet = ServoPacket { sequence: number as u8, width_ticks, ..ServoPacket::default() };
        (start + 0.02 * f64::from(number), packet.encode().to_vec())
    };
    RecordedDevice::new((0..1200).map(packet).collect())
}

/// Data received by the ground.
#[derive(Default)]
struct Ground {
    snapshots: Vec<Snapshot>,
    damaged: usize,
    bytes_while_paused: usize,
    decoder: frame::Decoder,
    /// Time of the last request for frames.
    asked: Option<Time>,
    paused: Option<Time>,
    has_paused: bool,
}

/// The ground's modem: requests frames, pauses them for two seconds after 100 frames, and requests them again.
struct GroundModem(Arc<Mutex<Ground>>);

impl Device for GroundModem {
    fn receive(&mut self, bytes: &[u8], now: Time) {
        let mut ground = self.0.lock().unwrap();
        // Frames that are in transit still arrive.
        if ground.paused.is_some_and(|since| now - since > 0.05) {
            ground.bytes_while_paused += bytes.len();
            return;
        }
        for byte in bytes {
            match ground.decoder.push(*byte) {
                Some(Ok(frame)) => ground.snapshots.push(frame.snapshot),
                Some(Err(_)) => ground.damaged += 1,
                None => {}
            }
        }
    }

    fn next_transmission(&self) -> Option<Time> {
        None
    }

    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>) {
        let mut ground = self.0.lock().unwrap();
        // Bytes sent before the flight computer listens are lost.
        if ground.snapshots.is_empty() && ground.asked.is_none_or(|asked| now - asked > 0.2) {
            wire.push(b'#');
            ground.asked = Some(now);
        }
        if !ground.has_paused && ground.snapshots.len() >= 100 {
            wire.push(b'$');
            (ground.paused, ground.has_paused) = (Some(now), true);
        }
        if ground.paused.is_some_and(|since| now - since > 2.0) {
            wire.push(b'#');
            ground.paused = None;
        }
    }

    fn span(&self) -> Option<(Time, Time)> {
        None
    }

    fn is_started(&self) -> bool {
        true
    }
}

/// A modem that stores the bytes.
struct Keeper(Arc<Mutex<Vec<u8>>>);

impl Device for Keeper {
    fn receive(&mut self, bytes: &[u8], _now: Time) {
        self.0.lock().unwrap().extend_from_slice(bytes);
    }

    fn next_transmission(&self) -> Option<Time> {
        None
    }

    fn transmit(&mut self, _now: Time, _wire: &mut Vec<u8>) {}

    fn span(&self) -> Option<(Time, Time)> {
        None
    }

    fn is_started(&self) -> bool {
        true
    }
}

/// Number of each message in a MAVLink 2 stream, by its id.
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

/// Flies in emulated time until `is_over`; returns the events.
fn flown(
    config: &FlyConfig,
    record: &Path,
    clock: &Clock,
    is_over: impl Fn() -> bool,
) -> (FlightReport, Vec<Notification>) {
    let stop = Arc::new(AtomicBool::new(false));
    let (console, told) = sync_channel(1024);
    let computer = clock.spawn("flight computer", {
        let (config, record) = (config.clone(), record.to_owned());
        let (clock, stop) = (clock.clone(), Arc::clone(&stop));
        move || fly(&config, &record, &clock, &stop, console)
    });
    while !is_over() {
        clock.sleep_until(clock.now() + 0.02);
    }
    stop.store(true, Ordering::Relaxed);
    let report = computer.unwrap().join().unwrap().unwrap();
    println!("{report}");
    (report, told.iter().collect())
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
    let (ground, mavlink) = (Arc::<Mutex<Ground>>::default(), Arc::<Mutex<Vec<u8>>>::default());
    let ports = ports.into_iter().chain([
        EmulatedPort::new(path("pilot"), pilot(start)),
        EmulatedPort::new(path("ground"), GroundModem(Arc::clone(&ground))),
        EmulatedPort::new(path("mavlink"), Keeper(Arc::clone(&mavlink))),
    ]);
    let config = configuration(place.path(), "");
    let record = path("flight.mcap");
    let clock = Clock::emulated();
    let player = Player::start(ports.collect(), &clock, Begin::WhenAsked).unwrap();
    let (report, _) = flown(&config, &record, &clock, || {
        player.elapsed_s().is_some_and(|flown_s| flown_s >= 22.0)
    });
    player.stop().unwrap();
    let (ground, mavlink) = (ground.lock().unwrap(), mavlink_messages(&mavlink.lock().unwrap()));

    // The IMU is connected for 20 s, at 33 Hz.
    assert!((580..=730).contains(&report.cycles), "{} cycles", report.cycles);
    assert!((14..=19).contains(&report.fixes), "{} fixes", report.fixes);
    assert_eq!((report.dmu_port.lost, report.dmu_port.opened), (1, 2));
    assert_eq!((report.record.lost_raw, report.record.lost_decoded), (0, 0));

    // The ground received everything except the pause, at 33 Hz. The pilot's sticks are within one resolution step of
    // the line.
    assert_eq!(ground.damaged, 0);
    assert_eq!(ground.bytes_while_paused, 0, "bytes after $");
    assert!(ground.snapshots.len() > 500, "{} frames", ground.snapshots.len());
    assert!(ground.snapshots.iter().any(|snapshot| snapshot.mode == SystemMode::Pilot));
    assert!(ground.snapshots.iter().any(|snapshot| !snapshot.status.gps));
    let without_unit: Vec<_> = ground
        .snapshots
        .iter()
        .skip_while(|snapshot| snapshot.position.is_none())
        .filter(|snapshot| !snapshot.status.imu)
        .collect();
    assert!(without_unit.len() > 20, "{} cycles without the unit", without_unit.len());
    assert!(without_unit.iter().all(|snapshot| snapshot.position.is_none()), "the past is sent");
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

    // The record reproduces the flight.
    let record = Record::open(&record).unwrap();
    assert!(record.is_ended && record.warnings.is_empty(), "{:?}", record.warnings);
    assert_eq!(
        record.controls.last().unwrap().1.map(|stick| (1e3 * stick).round()),
        [200.0, 0.0, 0.0, 0.0]
    );
    let mut replayed = record.dataset().unwrap();
    assert_eq!(replayed.imu.len() as u64, report.cycles);
    let settings = replayed.settings().unwrap();
    let run = estimate(&replayed, &settings, |_| {});
    let reproduction = record.reproduced_by(&run.solutions);
    assert!(reproduction.compared > 550, "{} solutions flown", reproduction.compared);
    assert_eq!(reproduction.first_difference, None);
    for kind in ["gps_fixes", "dmu_port", "pilot_signal"] {
        assert!(record.events.iter().any(|event| event.kind == kind), "no event {kind}");
    }
}

#[test]
fn a_flight_without_any_device_flies_on_reports_it_and_ends() {
    let place = tempfile::tempdir().unwrap();
    let config = configuration(place.path(), "");
    let record = place.path().join("nothing.mcap");
    let clock = Clock::emulated();
    let (report, told) = flown(&config, &record, &clock, || clock.now().seconds() >= 1.5);
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
fn no_record_is_written_over_and_no_flight_begins_without_a_required_one() {
    let place = tempfile::tempdir().unwrap();
    let mut config = configuration(place.path(), "");
    config.record.required = true;
    let record = place.path().join("taken.mcap");
    std::fs::write(&record, "something").unwrap();
    for (path, said) in
        [(record, "exists already"), (place.path().join("no/such/x.mcap"), "No such")]
    {
        let (console, _told) = sync_channel(1);
        let error = fly(&config, &path, &Clock::start(), &AtomicBool::new(true), console);
        let error = error.unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn a_flight_whose_record_cannot_be_written_goes_on_and_reports_it() {
    let place = tempfile::tempdir().unwrap();
    let config = configuration(place.path(), "");
    let clock = Clock::emulated();
    let record = place.path().join("no/such/x.mcap");
    let (report, told) = flown(&config, &record, &clock, || clock.now().seconds() >= 1.5);
    assert!(!record.exists() && report.record.lost_raw > 0, "{report}");
    let told: Vec<_> = told.iter().map(|line| (line.level, line.text.as_str())).collect();
    let said = |(level, text): &&(Level, &str)| {
        *level == Level::Error
            && text.contains("the flight is not recorded")
            && text.contains("x.mcap")
    };
    assert_eq!(told.iter().filter(said).count(), 1, "{told:?}");
    // The message appears only once: nothing changes afterwards.
    assert_eq!(told.iter().filter(|(_, text)| text.contains("record")).count(), 1, "{told:?}");
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
