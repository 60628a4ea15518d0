//! A flight computer and the simulated helicopter at the two ends of serial lines, in one process. Time is
//! emulated, or real with pseudo-terminals.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use hovernav::autopilot::HoverConfig;
use hovernav::gps::Protocol;
use hovernav::time::Time;
use hovernav_dataset::Manifest;
use hovernav_design::hover::HoverDesign;
use hovernav_fly::devices::RecordedDevice;
use hovernav_fly::play::{Begin, Cut, CutKind, EmulatedPort, Player};
use hovernav_fly::serial::Clock;
use hovernav_fly::{DurationHistogram, FlightReport, Notification, fly};
use hovernav_hil::{LinePaths, LiveConfig, LiveFlight, LiveSample, LiveStatistics, Scene};
use hovernav_model::shipped;
use hovernav_record::{FlyConfig, Record};
use hovernav_sim::FlightConfig;
use rustix::process::{Resource, Rlimit, setrlimit};

/// The autopilot of the 60-class helicopter.
pub fn autopilot() -> HoverConfig {
    static DESIGNED: OnceLock<HoverConfig> = OnceLock::new();
    *DESIGNED.get_or_init(|| {
        let model = shipped::open("raptor60").unwrap();
        let design = HoverDesign::for_model(&model);
        HoverConfig::new(design.period_s, design.synthesise(&model).unwrap())
    })
}

/// Interval at which the end of a flight is checked, s.
const LOOK_S: f64 = 0.02;

/// The setup of a flight over the lines.
pub struct Setup {
    /// The acts of the flight.
    pub acts: Vec<String>,
    /// Effect of the sticks while the autopilot flies: `override` or `steer`.
    pub pilot: &'static str,
    /// The autopilot.
    pub autopilot: HoverConfig,
    /// Largest one-sigma of the gyro bias for an engagement, rad/s. The default is so large that the filter reaches it
    /// in a short flight.
    pub gyro_bias_sigma_radps: f64,
    /// Additional text of `fly.toml`, beginning with a section header.
    pub keys: String,
    /// Vehicle, wind, sensors, duration and seed.
    pub flight: FlightConfig,
    /// The sensors as configured in the flight computer, if not the defaults.
    pub navigation: Option<Manifest>,
    /// Start and duration of a hold of the flight computer's processor, s.
    pub held: Vec<(f64, f64)>,
    /// Time at which the ground's port is unplugged, s, in a flight with telemetry.
    pub ground_lost_s: Option<f64>,
    /// Time at which the disk is full, s.
    pub disk_full_s: Option<f64>,
    /// Protocol of the receiver, and its name in `fly.toml`.
    pub protocol: (Protocol, &'static str),
}

impl Setup {
    /// A flight of `duration_s` with `acts`.
    pub fn new(duration_s: f64, acts: &[&str]) -> Self {
        let mut flight = FlightConfig::new(autopilot());
        flight.duration_s = duration_s;
        flight.start.height_m = 60.0;
        Self {
            acts: acts.iter().map(|act| (*act).to_owned()).collect(),
            pilot: "override",
            autopilot: autopilot(),
            gyro_bias_sigma_radps: 0.1,
            keys: String::new(),
            flight,
            navigation: None,
            held: Vec::new(),
            ground_lost_s: None,
            disk_full_s: None,
            protocol: (Protocol::Ubx, "ubx"),
        }
    }
}

/// The results of a flight.
pub struct Flown {
    pub record: Record,
    /// Start of the flight computer's clock, on the clock of the vehicle, s.
    begun_s: f64,
    pub samples: Vec<LiveSample>,
    pub crashed_s: Option<f64>,
    pub report: FlightReport,
    /// Notifications of the flight computer.
    pub said: Vec<Notification>,
    /// Time from the last byte of an inertial packet to the first byte at the servos.
    pub over_lines: DurationHistogram,
}

impl Flown {
    /// A time of the flight computer, on the vehicle's clock, s.
    pub fn second(&self, time: Time) -> f64 {
        self.begun_s + time.seconds()
    }

    /// Time, on the vehicle's clock, s, and text of each event.
    pub fn told(&self) -> impl Iterator<Item = (f64, &str)> {
        self.record.events.iter().map(|event| (self.second(event.time), event.text.as_str()))
    }

    /// Time of the first event with this text.
    pub fn at(&self, text: &str) -> Option<f64> {
        self.told().find(|(_, told)| told.contains(text)).map(|(second, _)| second)
    }

    /// Time from `start_s` to the next event with this text, s.
    pub fn after(&self, start_s: f64, text: &str) -> f64 {
        let mut told =
            self.told().filter(|(second, told)| *second > start_s - 0.1 && told.contains(text));
        let first = told.next().unwrap_or_else(|| {
            panic!("\"{text}\" after {start_s} s in {:#?}", self.told().collect::<Vec<_>>())
        });
        first.0 - start_s
    }

    pub fn statistics(&self) -> LiveStatistics {
        LiveStatistics::of(&self.samples)
    }
}

fn configuration(directory: &Path, setup: &Setup) -> FlyConfig {
    let at = |name: &str| directory.join(name).display().to_string();
    let file = directory.join("autopilot.toml");
    hovernav_record::write_autopilot(&setup.autopilot, &file, "").unwrap();
    let mut text = format!(
        "[dmu]\nport = '{}'\n[receiver]\nport = '{}'\nprotocol = '{}'\n\
         [servo.capture]\nserial = {{ port = '{}' }}\n[servo.stream]\nport = '{}'\n\
         [servo.channels.throttle]\nfailsafe_ms = 1.0\n\
         [autopilot]\nfile = 'autopilot.toml'\npilot = '{}'\n\
         [autopilot.ready]\ngyro_bias_sigma_radps = {}\n\
         [navigation.imu]\nlever_arm_m = [0.0, 0.0, 0.28]\nmagnetic_declination_deg = 0.14\n\
         [navigation.gps]\nantenna_lever_arm_m = [-0.35, 0.0, 0.2]\n{}",
        at("dmu"),
        at("gps"),
        setup.protocol.1,
        at("pilot"),
        at("servos"),
        setup.pilot,
        setup.gyro_bias_sigma_radps,
        setup.keys
    );
    if setup.ground_lost_s.is_some() {
        text += &format!("[telemetry]\nport = '{}'\n", at("ground"));
    }
    let mut config = FlyConfig::parse(&text, "fly.toml".as_ref()).unwrap();
    if let Some(navigation) = &setup.navigation {
        config.navigation = navigation.clone();
    }
    config.load_autopilot(directory).unwrap();
    config
}

/// Flies `setup` with emulated time. The replay of the record must give bitwise equal sticks.
pub fn flown(setup: &Setup) -> Flown {
    flown_by(&Clock::emulated(), setup)
}

/// Flies `setup` with `clock`.
pub fn flown_by(clock: &Clock, setup: &Setup) -> Flown {
    let directory = tempfile::tempdir().unwrap();
    let config = configuration(directory.path(), setup);
    let mut flight = setup.flight.clone();
    flight.dmu.lever_arm_m = config.navigation.imu.lever_arm_m;
    flight.gps.lever_arm_m = config.navigation.gps.antenna_lever_arm_m;
    let live = LiveConfig {
        flight,
        calibration: config.sensors().unwrap().0.calibration,
        channels: config.servo.channels,
        swashplate: config.servo.swashplate,
        scene: Scene { acts: setup.acts.iter().map(|act| act.parse().unwrap()).collect() },
    };
    let lines = LinePaths::within(directory.path());
    let flying = LiveFlight::start(live, setup.protocol.0, &lines, clock).unwrap();
    let path = directory.path().join("flight.mcap");
    let stop = Arc::new(AtomicBool::new(false));
    let aboard = clock.on_another_processor();
    let (sender, said) = sync_channel(4096);
    let computer = {
        let (path, aboard, stop) = (path.clone(), aboard.clone(), Arc::clone(&stop));
        let fly = move || fly(&config, &path, &aboard, &stop, sender);
        clock.spawn("flight computer", fly).unwrap()
    };
    let ground = setup.ground_lost_s.map(|lost_s| ground(directory.path(), clock, lost_s));
    let mut held = setup.held.iter().peekable();
    let mut disk_full_s = setup.disk_full_s;
    let mut filled = None;
    while !flying.is_finished() && !computer.is_finished() {
        let (now, flown_s) = (clock.now(), flying.elapsed_s().unwrap_or_default());
        if let Some((_, duration_s)) = held.next_if(|(second, _)| flown_s >= *second) {
            aboard.hold_until(now + *duration_s);
        }
        if disk_full_s.take_if(|second| flown_s >= *second).is_some() {
            filled = Some((now, fill_disk(&path, now)));
        }
        if let Some((_, length)) = filled.take_if(|(since, _)| now - *since > 0.1) {
            wait_until(|| path.metadata().unwrap().len() == length);
        }
        let wait_s = held.peek().map_or(LOOK_S, |(second, _)| (second - flown_s).min(LOOK_S));
        clock.sleep_until(now + wait_s);
    }
    let begun_s = flying.elapsed_s().expect("it began") - clock.now().seconds();
    stop.store(true, Ordering::Relaxed);
    let report = computer.join().unwrap().unwrap();
    drop(ground);
    let (crashed_s, over_lines) = (flying.crashed_s(), flying.turnaround());
    let (_, samples) = flying.end().unwrap();
    let record = Record::open(&path).unwrap();
    let sticks = record.sticks_reproduced().unwrap().unwrap();
    assert!(
        sticks.compared > 200 && sticks.first_difference.is_none(),
        "{:?}: {sticks:?}",
        setup.acts
    );
    Flown { record, begun_s, samples, crashed_s, report, said: said.iter().collect(), over_lines }
}

/// Sets the limit of the file size to one byte more than the size of the record at `path`, as soon as the record
/// contains the flight until `now`. Returns the size of the record when its writer has reached the limit.
fn fill_disk(path: &Path, now: Time) -> u64 {
    let until_now = |record: Record| record.cycles.last().is_some_and(|last| now - last.time < 0.1);
    wait_until(|| Record::open(path).is_ok_and(until_now));
    let length = path.metadata().unwrap().len() + 1;
    setrlimit(Resource::Fsize, Rlimit { current: Some(length), maximum: None }).unwrap();
    length
}

/// Waits for the writer of the record. The emulated time does not advance during this wait, so the load of the machine
/// does not change the record.
fn wait_until(is_written: impl Fn() -> bool) {
    while !is_written() {
        thread::sleep(Duration::from_millis(5));
    }
}

/// A ground station that requests frames every second, until its port is unplugged.
fn ground(directory: &Path, clock: &Clock, lost_s: f64) -> Player {
    let asks = (0..100).map(|second| (Time::ZERO + f64::from(second), b"#".to_vec()));
    let cut = Cut { start: Time::ZERO + lost_s, duration_s: f64::INFINITY, kind: CutKind::Adapter };
    let modem = EmulatedPort::new(directory.join("ground"), RecordedDevice::new(asks.collect()));
    let ports = vec![EmulatedPort { cuts: vec![cut], ..modem }];
    Player::start(ports, clock, Begin::After(Duration::ZERO)).unwrap()
}

/// Flies all `flights`, in parallel on all processors.
pub fn all_flown<T: Sync>(flights: &[T], setup: impl Fn(&T) -> Setup + Sync) -> Vec<Flown> {
    let next = AtomicUsize::new(0);
    let fly_some = || {
        let mut some = Vec::new();
        while let number = next.fetch_add(1, Ordering::Relaxed)
            && let Some(flight) = flights.get(number)
        {
            some.push((number, flown(&setup(flight))));
        }
        some
    };
    let processors = thread::available_parallelism().map_or(1, usize::from);
    let mut all: Vec<(usize, Flown)> = thread::scope(|scope| {
        let running: Vec<_> = (0..processors).map(|_| scope.spawn(fly_some)).collect();
        running.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    all.sort_by_key(|(number, _)| *number);
    all.into_iter().map(|(_, flown)| flown).collect()
}
