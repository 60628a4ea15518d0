//! Failsafes flown in the loop: the flight computer on real pseudo-terminals, in real time, every scene
//! beside the others.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::Duration;

use hovernav::autopilot::HoverConfig;
use hovernav::gps::Protocol;
use hovernav_design::hover::HoverDesign;
use hovernav_fly::fly;
use hovernav_hil::{LinePaths, LiveConfig, LiveFlight, LiveStatistics, Scene};
use hovernav_log::FlyConfig;
use hovernav_log::record::Record;
use hovernav_model::shipped;
use hovernav_sim::FlightConfig;

const LENGTH_S: f64 = 24.0;
const ENGAGED: &str = "engage@8:13";

/// What was told, with its time, and what the flight came to.
struct Flown {
    told: Vec<(f64, String)>,
    statistics: LiveStatistics,
    crashed_s: Option<f64>,
}

impl Flown {
    /// When this was told.
    fn at(&self, text: &str) -> Option<f64> {
        self.told.iter().find(|(_, told)| told.contains(text)).map(|(time_s, _)| *time_s)
    }

    /// How long after the act at `act_s` of the flight this was told.
    fn after(&self, act_s: f64, text: &str) -> f64 {
        // The flight's clock began as the unit was first asked for a packet, the computer's just before.
        let told_s = self.at(text).unwrap_or_else(|| panic!("\"{text}\" in {:#?}", self.told));
        told_s - act_s
    }
}

fn autopilot() -> HoverConfig {
    let model = shipped::open("raptor60").unwrap();
    let design = HoverDesign::for_model(&model);
    HoverConfig::new(design.period_s, design.synthesise(&model).unwrap())
}

fn configuration(directory: &Path, pilot: &str) -> FlyConfig {
    let at = |name: &str| directory.join(name).display().to_string();
    hovernav_log::write_autopilot(&autopilot(), &directory.join("autopilot.toml"), "").unwrap();
    let text = format!(
        "[dmu]\nport = '{}'\n[receiver]\nport = '{}'\nprotocol = 'ubx'\n\
         [servo.capture]\nserial = {{ port = '{}' }}\n[servo.stream]\nport = '{}'\n\
         [servo.channels.throttle]\nfailsafe_ms = 1.0\n\
         [autopilot]\nfile = 'autopilot.toml'\npilot = '{pilot}'\n\
         [navigation.imu]\nlever_arm_m = [0.0, 0.0, 0.28]\nmagnetic_declination_deg = 0.14\n\
         [navigation.gps]\nantenna_lever_arm_m = [-0.35, 0.0, 0.2]\n",
        at("dmu"),
        at("gps"),
        at("pilot"),
        at("servos")
    );
    let mut config = FlyConfig::parse(&text, "fly.toml".as_ref()).unwrap();
    config.load_autopilot(directory).unwrap();
    config
}

/// More cycles that were late than this, and the machine is too busy to fly in real time.
const MOST_LATE: u64 = 3;

/// The flight of a scene; `None` where the machine was too busy.
fn flown(acts: &[&str], pilot: &str) -> Option<Flown> {
    let directory = tempfile::tempdir().unwrap();
    let config = configuration(directory.path(), pilot);
    let mut flight = FlightConfig::new(autopilot());
    flight.dmu.lever_arm_m = config.navigation.imu.lever_arm_m;
    flight.gps.lever_arm_m = config.navigation.gps.antenna_lever_arm_m;
    flight.duration_s = LENGTH_S;
    flight.start.height_m = 60.0;
    let scene = Scene { acts: acts.iter().map(|act| act.parse().unwrap()).collect() };
    let live = LiveConfig {
        flight,
        calibration: config.sensors().unwrap().0.calibration,
        channels: config.servo.channels,
        swashplate: config.servo.swashplate,
        scene,
    };
    let lines = LinePaths::within(directory.path());
    let flying = LiveFlight::start(live, Protocol::Ubx, &lines).unwrap();
    let (sender, notifications) = sync_channel(4096);
    let stop = AtomicBool::new(false);
    let record = directory.path().join("flight.mcap");
    let (crashed_s, late) = thread::scope(|scope| {
        let computer = scope.spawn(|| fly(&config, &record, &stop, sender));
        while !flying.is_finished() && !computer.is_finished() {
            thread::sleep(Duration::from_millis(20));
        }
        stop.store(true, Ordering::Relaxed);
        let report = computer.join().unwrap().unwrap();
        (flying.crashed_s(), report.missed_deadlines)
    });
    let (_, samples) = flying.end().unwrap();
    let recorded = Record::open(&record).unwrap();
    let sticks = recorded.sticks_reproduced().unwrap().unwrap();
    assert!(sticks.compared > 300 && sticks.first_difference.is_none(), "{acts:?}: {sticks:?}");
    let told = notifications
        .iter()
        .map(|told| (told.time.seconds(), told.text.as_str().to_owned()))
        .collect();
    let flown = Flown { told, statistics: LiveStatistics::of(&samples), crashed_s };
    (late <= MOST_LATE).then_some(flown)
}

/// From an act to the word of it: its own delay, a cycle, what lines and a loaded machine add.
const SLACK_S: f64 = 0.6;

#[test]
fn every_failsafe_answers_in_time_and_nothing_crashes() {
    let scenes: Vec<(&str, Vec<&str>, &str)> = vec![
        ("held", vec![ENGAGED], "override"),
        ("silence", vec![ENGAGED, "pilot-lost@12:4"], "override"),
        ("failsafe", vec![ENGAGED, "failsafe@12:4"], "override"),
        ("aux", vec![ENGAGED, "aux-lost@12"], "override"),
        ("unit", vec![ENGAGED, "dmu-cut@12:3"], "override"),
        ("frozen unit", vec![ENGAGED, "frozen-imu@12:3"], "override"),
        ("satellites", vec!["engage@8:15", "gps-cut@10:11"], "override"),
        ("hands", vec![ENGAGED, "stick-pedal=0.3@12:1"], "override"),
        ("steered", vec![ENGAGED, "stick-longitudinal=0.3@12:3"], "steer"),
        ("not ready", vec!["no-fix@3", "engage@9:8"], "override"),
    ];
    let flights: Vec<(&str, Option<Flown>)> = thread::scope(|scope| {
        let running: Vec<_> = scenes
            .iter()
            .map(|(name, acts, pilot)| (*name, scope.spawn(|| flown(acts, pilot))))
            .collect();
        running.into_iter().map(|(name, thread)| (name, thread.join().unwrap())).collect()
    });
    let in_time: Option<Vec<(&str, Flown)>> =
        flights.into_iter().map(|(name, flown)| Some((name, flown?))).collect();
    let Some(flights) = in_time else {
        println!("skipped: the machine is too busy to fly in real time");
        return;
    };
    let of = |wanted: &str| &flights.iter().find(|(name, _)| *name == wanted).unwrap().1;
    for (name, flown) in &flights {
        assert_eq!(flown.crashed_s, None, "{name}: {:#?}", flown.told);
        let engaged = flown.at("the autopilot flies").is_some();
        assert_eq!(engaged, *name != "not ready", "{name}: {:#?}", flown.told);
    }
    let in_time = |name: &str, act_s: f64, delay_s: f64, text: &str| {
        let after_s = of(name).after(act_s, text);
        assert!(
            (-0.1..delay_s + SLACK_S).contains(&after_s),
            "{name}: \"{text}\" {after_s} s later"
        );
    };
    for name in ["silence", "failsafe"] {
        in_time(name, 12.0, 0.1, "the pilot's signal is lost: the autopilot holds");
        in_time(name, 16.0, 0.1, "the pilot's signal is back");
        assert!(of(name).statistics.engaged_s > 11.0, "{name}");
    }
    in_time("aux", 12.0, 0.1, "the pilot flies: the switch is open");
    in_time("unit", 12.0, 0.2, "the pilot flies: the attitude is not known");
    in_time("frozen unit", 12.0, 0.2, "the pilot flies: the attitude is not known");
    in_time("hands", 12.0, 0.0, "the pilot flies: a stick was moved");
    in_time("satellites", 10.0, 9.5, "Distrust");
    assert!(of("satellites").at("the pilot flies: the attitude").is_none());
    in_time("not ready", 9.0, 0.1, "the autopilot does not take over");
    in_time("not ready", 9.0, 0.1, "age of the last fix");
    assert!(of("steered").at("a stick was moved").is_none());
    assert!(of("steered").statistics.place_m > 2.0, "it went where the stick pointed");
    let held = of("held").statistics;
    let fastest_mps = held.velocity_rms_mps.into_iter().fold(0.0, f64::max);
    assert!(fastest_mps < 0.5 && held.heading_rad < 0.15, "{held:?}");
}
