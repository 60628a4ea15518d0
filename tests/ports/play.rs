//! A played flight equals the original. A link and a receiver read the data of the dataset from the lines, to the
//! resolution of the line. This includes cuts and unplugging. Time-dependent tests use emulated time; pseudo-terminals
//! show that bytes and ports pass through the system.

use std::path::PathBuf;
use std::time::Duration;

use approx::assert_abs_diff_eq;
use hovernav::dmu::{
    Calibration, ClockFault, Flow, Link, LinkAction, LinkFault, Mode, SampleClock,
};
use hovernav::earth::Geodetic;
use hovernav::frames::{Body, EulerAngles, Ned, Vector};
use hovernav::gps::tsip::Startup;
use hovernav::gps::ubx::Configuration;
use hovernav::gps::{Fix, Protocol, Receiver, ReceiverFix};
use hovernav::imu::Motion;
use hovernav::imu::{ImuAxes, ImuSample};
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_fly::devices::RecordedDevice;
use hovernav_fly::play;
use hovernav_fly::play::{Begin, Cut, CutKind, EmulatedPort, PlayError, Player};
use hovernav_fly::serial::{Clock, Item, Port, PortConfig, Read, Reader};
use tempfile::TempDir;

/// A flight of `seconds` at 33 Hz with fixes at 1 Hz, in which every sample contains its own number.
fn flight(seconds: u32) -> Dataset {
    let imu = (0..seconds * 33).map(|index| {
        let time = Time::ZERO + 100.0 + f64::from(index) / 33.0;
        let phase = f64::from(index) * 0.05;
        ImuSample {
            time,
            motion: Motion::Rates {
                angular_rate_radps: Vector::<Body>::new(0.5 * phase.sin(), 0.3 * phase.cos(), 0.1),
                specific_force_mps2: Vector::new(phase.sin(), 0.2, -9.81 + 0.5 * phase.cos()),
            },
            attitude: Some(EulerAngles {
                roll_rad: 0.1 * phase.sin(),
                pitch_rad: 0.05,
                // The heading turns through south, where the angle wraps.
                yaw_rad: hovernav::frames::wrap_angle(3.0 + 0.2 * phase),
            }),
            magnetic_field_gauss: Some(Vector::new(0.2, 0.1 * phase.cos(), 0.4)),
            clipped: ImuAxes::NONE,
        }
    });
    let fixes = (0..seconds).map(|second| Fix {
        position_sigma_m: Some(Vector::<Ned>::new(1.0, 1.0, 2.0)),
        horizontal_velocity_mps: Some([1.0 + f64::from(second), -2.0]),
        down_velocity_mps: Some(0.25),
        velocity_sigma_mps: Some(Vector::new(0.1, 0.1, 0.1)),
        satellites: Some(9),
        ..Fix::at(
            Time::ZERO + 100.5 + f64::from(second),
            Geodetic::from_degrees(1.35 + 1e-5 * f64::from(second), 103.8, 50.0).unwrap(),
        )
    });
    Dataset { imu: imu.collect(), fixes: fixes.collect(), ..Dataset::default() }
}

fn port(path: &std::path::Path, clock: &Clock) -> Port {
    let path = path.to_str().unwrap().to_string();
    Port::new(PortConfig::new(path, 38_400), clock)
}

struct Place {
    directory: TempDir,
}

impl Place {
    fn new() -> Self {
        Self { directory: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }
}

/// Data of the IMU as received by a flight computer.
#[derive(Default)]
struct Listened {
    samples: Vec<ImuSample>,
    /// The IMU's timer at each sample.
    timers: Vec<u16>,
    faults: Vec<LinkFault>,
    /// Number of samples since the last fault.
    since_fault: usize,
}

/// Exchanges data with the IMU until `enough` or for 60 s of flight.
fn listen(
    mut port: Port,
    clock: &Clock,
    flow: Flow,
    enough: impl Fn(&Listened) -> bool,
) -> Listened {
    let mut link = Link::new(Mode::Angle, flow, clock.now());
    let calibration = Calibration::new(200.0, 4.0).unwrap();
    let mut stamps = SampleClock::new(Mode::Angle.transfer_time_s());
    let mut listened = Listened::default();
    let end = clock.now() + 60.0;
    while !enough(&listened) && clock.now() < end {
        match link.next_action(clock.now()) {
            LinkAction::Write(command) => {
                let _ = port.write(&[command.byte()], clock.now() + 0.1);
            }
            LinkAction::Lost(fault) => {
                listened.faults.push(fault);
                listened.since_fault = 0;
            }
            LinkAction::ReadUntil(deadline) => {
                let mut buffer = [0; 256];
                if let Read::Bytes { count, arrival } = port.read_until(&mut buffer, deadline) {
                    let mut bytes = &buffer[..count];
                    while let Some(received) = link.next_packet(&mut bytes, arrival) {
                        let timer = received.packet.timer();
                        let stamp = stamps.stamp(timer, received.sequence, arrival);
                        assert!(!matches!(stamp, Err(ClockFault::TimerStopped { .. })));
                        let time = stamp.map_or(arrival, |stamp| stamp.time);
                        let measurement = calibration.measure(&received.packet).unwrap();
                        listened.samples.push(measurement.at(time));
                        listened.timers.push(timer);
                        listened.since_fault += 1;
                    }
                }
            }
        }
    }
    listened
}

fn rate(sample: &ImuSample) -> Vector<Body> {
    let Motion::Rates { angular_rate_radps, .. } = sample.motion else { panic!() };
    angular_rate_radps
}

/// Whether two samples are equal to half a resolution step of the line.
fn same(found: &ImuSample, sent: &ImuSample) -> bool {
    let turn = hovernav::frames::wrap_angle(
        found.attitude.unwrap().yaw_rad - sent.attitude.unwrap().yaw_rad,
    );
    (rate(found) - rate(sent)).norm() < 1.5e-4 && turn.abs() < 5e-5
}

#[test]
fn a_continuous_unit_sends_every_sample_once_with_its_time() {
    let (place, dataset, clock) = (Place::new(), flight(4), &Clock::emulated());
    let ports = vec![EmulatedPort::new(place.path("dmu"), play::dmu(&dataset).unwrap())];
    let player = Player::start(ports, clock, Begin::WhenAsked).unwrap();
    let count = dataset.imu.len();
    let heard = listen(port(&place.path("dmu"), clock), clock, Flow::Continuous, |listened| {
        listened.samples.len() >= count
    });
    assert_eq!((heard.samples.len(), heard.faults.as_slice()), (count, &[][..]));
    for (found, sent) in heard.samples.iter().zip(&dataset.imu) {
        assert!(same(found, sent), "{found:?} {sent:?}");
    }
    for pair in heard.timers.windows(2) {
        let step_s = f64::from(pair[0].wrapping_sub(pair[1])) * 0.79e-6;
        assert_abs_diff_eq!(step_s, 1.0 / 33.0, epsilon = 1e-6);
    }
    let counts = player.stop().unwrap()[0];
    assert_eq!((counts.sent, counts.lost), (2 + 30 * count as u64, 0));
    assert_eq!(counts.received, 4, "stop, ping, mode, start");
}

#[test]
fn a_polled_unit_never_says_the_same_twice() {
    let (place, dataset, clock) = (Place::new(), flight(6), &Clock::emulated());
    let ports = vec![EmulatedPort::new(place.path("dmu"), play::dmu(&dataset).unwrap())];
    let _player = Player::start(ports, clock, Begin::WhenAsked).unwrap();
    let flow = Flow::Polled { cycle_s: 0.0303 };
    let heard = listen(port(&place.path("dmu"), clock), clock, flow, |listened| {
        listened.samples.len() >= 100
    });
    assert!(heard.samples.len() >= 100, "{}", heard.samples.len());
    assert!(heard.samples.windows(2).all(|pair| rate(&pair[0]) != rate(&pair[1])));
    // Between samples the emulated IMU measures interpolated values.
    let within = |found: &ImuSample| {
        dataset.imu.windows(2).any(|pair| {
            let (a, b, x) = (rate(&pair[0]).y(), rate(&pair[1]).y(), rate(found).y());
            x >= a.min(b) - 2e-4 && x <= a.max(b) + 2e-4
        })
    };
    assert!(heard.samples.iter().all(within));
}

#[test]
fn a_cut_wire_and_a_pulled_adapter_are_gaps_from_which_the_link_recovers() {
    for kind in [CutKind::Wire, CutKind::Adapter] {
        let (place, dataset, clock) = (Place::new(), flight(12), &Clock::emulated());
        let mut emulated = EmulatedPort::new(place.path("dmu"), play::dmu(&dataset).unwrap());
        emulated.cuts = vec![Cut { start: Time::ZERO + 102.0, duration_s: 2.0, kind }];
        let _player = Player::start(vec![emulated], clock, Begin::WhenAsked).unwrap();
        let heard = listen(port(&place.path("dmu"), clock), clock, Flow::Continuous, |listened| {
            !listened.faults.is_empty() && listened.since_fault >= 20
        });
        assert!(heard.faults.contains(&LinkFault::NoData), "{kind:?} {:?}", heard.faults);
        assert!(heard.since_fault >= 20, "{kind:?} {:?}", heard.faults);
        let steps = heard.samples.windows(2).map(|pair| pair[1].time - pair[0].time);
        let gap_s = steps.fold(0.0, f64::max);
        assert!(gap_s > 1.5, "{kind:?}: {gap_s}");
    }
}

/// Configures the receiver and reads `count` fixes.
fn fixes(path: PathBuf, clock: &Clock, protocol: Protocol, count: usize) -> Vec<ReceiverFix> {
    let reader = Reader::spawn(port(&path, clock), clock, 64).unwrap();
    let mut receiver = Receiver::new(protocol);
    let (mut startup, mut configuration) = (Startup::default(), Configuration::new(1).unwrap());
    let mut found = Vec::new();
    let end = clock.now() + 60.0;
    while found.len() < count && clock.now() < end {
        match reader.receive(clock.now() + 0.1) {
            Some(Item::Bytes { arrival, bytes }) => {
                let mut rest = &bytes[..];
                if rest.is_empty() {
                    found.extend(receiver.flush());
                }
                while let Some(fix) = receiver.read(&mut rest, arrival) {
                    found.push(fix);
                }
            }
            Some(Item::NotWritten(error)) => panic!("{error}"),
            Some(Item::Changed(_)) | None => {}
        }
        if reader.counts().opened == 0 {
            continue;
        }
        match &mut receiver {
            Receiver::Tsip(decoder) => {
                if let Some(frame) = startup.poll(decoder, clock.now()) {
                    assert!(reader.write(frame.as_bytes()));
                }
            }
            Receiver::Ubx(decoder) => {
                if let Some(message) = configuration.poll(decoder, clock.now()) {
                    assert!(reader.write(message.as_bytes()));
                }
            }
            Receiver::Nmea(_) => {}
        }
    }
    assert_eq!(reader.dropped().items, 0);
    found
}

#[test]
fn a_receiver_of_each_protocol_is_set_and_sends_the_fixes_of_the_flight() {
    for protocol in [Protocol::Nmea, Protocol::Tsip, Protocol::Ubx] {
        let (place, dataset, clock) = (Place::new(), flight(40), &Clock::emulated());
        let ports = vec![EmulatedPort::new(place.path("gps"), play::gps(&dataset, protocol))];
        // Configuring a receiver costs some seconds of its fixes.
        let _player =
            Player::start(ports, clock, Begin::After(Duration::from_millis(100))).unwrap();
        let found = fixes(place.path("gps"), clock, protocol, 7);
        assert_eq!(found.len(), 7, "{protocol:?}");
        for pair in found.windows(2) {
            let step = pair[1].time.unwrap().since(&pair[0].time.unwrap()).unwrap();
            assert!((step - 1.0).abs() < 0.011, "{protocol:?}: {step}");
        }
        assert_eq!(found.last().unwrap().satellites, Some(9), "{protocol:?}");
        for found in &found {
            let of_flight = dataset.fixes.iter().any(|fix| {
                let [north, east] = fix.horizontal_velocity_mps.unwrap();
                let [n, e] = found.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
                (found.latitude_rad - fix.position.latitude_rad).abs() < 2e-9
                    && (found.height_m.unwrap() - fix.position.height_m).abs() < 0.006
                    && (n - north).hypot(e - east) < 0.003
            });
            assert!(of_flight, "{protocol:?} {found:?}");
        }
    }
}

#[test]
fn recorded_bytes_come_as_they_came() {
    let (place, clock) = (Place::new(), &Clock::start());
    let pieces: Vec<(Time, Vec<u8>)> =
        (0..50u8).map(|k| (Time::ZERO + 0.01 * f64::from(k), vec![k; 20])).collect();
    let expected = pieces.iter().flat_map(|(_, bytes)| bytes.clone()).collect::<Vec<_>>();
    let ports = vec![EmulatedPort::new(place.path("gps"), RecordedDevice::new(pieces))];
    let player = Player::start(ports, clock, Begin::WhenAsked).unwrap();
    let (mut port, mut found, mut buffer) =
        (port(&place.path("gps"), clock), Vec::<u8>::new(), [0; 64]);
    let end = clock.now() + 60.0;
    while found.len() < expected.len() && clock.now() < end {
        if let Read::Bytes { count, .. } = port.read_until(&mut buffer, end) {
            found.extend(&buffer[..count]);
        }
    }
    assert_eq!(found, expected);
    while !player.is_finished() {
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_host_that_does_not_read_does_not_hold_the_player() {
    let (place, clock) = (Place::new(), &Clock::start());
    let pieces = (0..300).map(|k| (Time::ZERO + 1e-3 * f64::from(k), vec![0; 1000])).collect();
    let ports = vec![EmulatedPort::new(place.path("gps"), RecordedDevice::new(pieces))];
    let player = Player::start(ports, clock, Begin::WhenAsked).unwrap();
    let mut port = port(&place.path("gps"), clock);
    // This opens the port and does not read further.
    let _opened = port.read_until(&mut [0; 1], clock.now() + 5.0);
    while !player.is_finished() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let counts = player.stop().unwrap()[0];
    assert_eq!(counts.sent + counts.lost, 300_000);
    assert!(counts.lost > 100_000, "{counts:?}");
}

#[test]
fn a_host_that_lets_go_finds_the_port_again() {
    let (place, dataset, clock) = (Place::new(), flight(60), &Clock::start());
    let ports = vec![EmulatedPort::new(place.path("dmu"), play::dmu(&dataset).unwrap())];
    let _player = Player::start(ports, clock, Begin::WhenAsked).unwrap();
    for count in [20, 40] {
        let heard = listen(port(&place.path("dmu"), clock), clock, Flow::Continuous, |listened| {
            listened.samples.len() >= count
        });
        assert!(heard.samples.len() >= count, "{} of {count}", heard.samples.len());
    }
}

#[test]
fn a_port_takes_no_files_place_and_a_link_left_over_is_replaced() {
    let (place, dataset) = (Place::new(), flight(1));
    let path = place.path("dmu");
    let start = || {
        let ports = vec![EmulatedPort::new(&path, play::dmu(&dataset).unwrap())];
        Player::start(ports, &Clock::start(), Begin::WhenAsked)
    };
    std::fs::write(&path, "mine").unwrap();
    assert!(matches!(start(), Err(PlayError::Occupied { .. })));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    std::fs::remove_file(&path).unwrap();
    std::os::unix::fs::symlink(place.path("nowhere"), &path).unwrap();
    let player = start().unwrap();
    assert!(path.exists());
    assert!(matches!(start(), Err(PlayError::Occupied { .. })));
    drop(player);
    assert!(!path.is_symlink());
}

#[test]
fn what_cannot_be_played_is_refused() {
    let place = Place::new();
    let nothing = vec![EmulatedPort::new(place.path("gps"), RecordedDevice::new(Vec::new()))];
    let refused = Player::start(nothing, &Clock::start(), Begin::WhenAsked);
    assert!(matches!(refused, Err(PlayError::Nothing)));
    assert!(!place.path("gps").is_symlink());
}
