//! The flight computer and the simulated helicopter as two programs with one configuration, and the evaluation of the
//! record.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;

use crate::common::{assert_keys, example, hovernav, place, refusal, said, succeeds, summary};
use hovernav_fly::fly;
use hovernav_fly::serial::Clock;
use hovernav_hil::{LinePaths, LiveConfig, LiveFlight, Scene};
use hovernav_record::FlyConfig;
use hovernav_sim::FlightConfig;

/// The last line on standard error of a command that fails with exit status 1. Earlier lines may concern the magnetic
/// model.
fn last_line(arguments: &[&str]) -> String {
    let run = hovernav(arguments);
    let told = said(&run.stderr);
    assert_eq!(run.status.code(), Some(1), "{told}");
    told.lines().last().unwrap_or_default().to_owned()
}

/// Sends a signal to a program.
fn send(signal: &str, program: &Child) {
    let asked = Command::new("kill").args([signal, &program.id().to_string()]).status();
    assert!(asked.unwrap().success());
}

/// The result does not depend on the machine's load: the test waits for ten seconds of flight, for any wall time.
#[test]
fn two_commands_fly_together_and_leave_a_record_a_dataset_and_pages() {
    let directory = place("two-commands");
    let at = |name: &str| directory.join(name).display().to_string();
    let config = at("loop.toml");
    fs::write(&config, example(&directory, "records")).unwrap();

    let mut simulated = Command::new(env!("CARGO_BIN_EXE_hovernav"))
        .args(["simulate", "--lines", "--config", &config, "--out", &at("truth")])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let record = at("flight.mcap");
    let mut flown = Command::new(env!("CARGO_BIN_EXE_hovernav"))
        .args(["fly", "--config", &config, "--record", &record])
        .stdout(Stdio::null())
        .stderr(fs::File::create(at("told")).unwrap())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(simulated.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(said.any(|line| line.contains("10 s  speed")), "it flies");
    // A single Ctrl-C does not end a flight with servos.
    send("-TERM", &flown);
    assert!(flown.wait().unwrap().success());
    let told = fs::read_to_string(at("told")).unwrap();
    assert!(
        told.contains("good fixes arrive") && told.contains("the pilot's signal is good"),
        "{told}"
    );
    send("-INT", &simulated);
    let said: Vec<String> = said.collect();
    assert!(simulated.wait().unwrap().success(), "{said:?}");

    succeeds(&["report", &record, "--out", &at("report")]);
    assert!(!summary(&directory.join("truth"))["servo_packets"]["longest_gap_s"].is_null());
    for written in ["truth", "report"] {
        assert_keys(&summary(&directory.join(written)), &[]);
        let page = fs::metadata(directory.join(written).join("report.html")).expect("a page");
        assert!(page.len() > 1_000_000, "{written}");
    }
    let estimated = succeeds(&["estimate", &at("truth"), "--no-report", "--out", &at("again")]);
    assert!(estimated.contains("fixes"), "{estimated}");
    assert!(refusal(&["report", &at("truth")]).contains("expected a flight record"));
}

/// Flies the configuration over lines in emulated time, with the autopilot engaged from 25 to 34 s of 37 s.
fn hovered(path: &Path, record: &Path) {
    let mut config = FlyConfig::read(path).unwrap();
    config.settle(1_774_000_000).unwrap();
    config.load_autopilot(path.parent().unwrap()).unwrap();
    let mut flight = FlightConfig::new(config.autopilot.as_ref().unwrap().flown.unwrap());
    flight.duration_s = 37.0;
    flight.dmu.lever_arm_m = config.navigation.imu.lever_arm_m;
    flight.gps.lever_arm_m = config.navigation.gps.antenna_lever_arm_m;
    let (dmu, gps) = config.sensors().unwrap();
    let live = LiveConfig {
        flight,
        calibration: dmu.calibration,
        channels: config.servo.channels,
        swashplate: config.servo.swashplate,
        scene: Scene { acts: vec!["engage@25:9".parse().unwrap()] },
    };
    let clock = Clock::emulated();
    let line = |name: &str| config.dmu.port.with_file_name(name);
    let lines = LinePaths {
        dmu: line("line-dmu"),
        gps: line("line-gps"),
        pilot: line("line-pilot"),
        servos: line("line-servos"),
    };
    let flying = LiveFlight::start(live, gps.protocol, &lines, &clock).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let computer = clock.spawn("flight computer", {
        let (record, clock, stop) = (record.to_owned(), clock.clone(), Arc::clone(&stop));
        move || fly(&config, &record, &clock, &stop, sync_channel(1).0)
    });
    while !flying.is_finished() {
        clock.sleep_until(clock.now() + 0.02);
    }
    stop.store(true, Ordering::Relaxed);
    computer.unwrap().join().unwrap().unwrap();
    assert_eq!(flying.crashed_s(), None);
}

#[test]
fn the_record_of_a_hover_over_the_lines_reports_how_it_went() {
    let directory = place("told-hover");
    let at = |name: &str| directory.join(name).display().to_string();
    fs::write(at("loop.toml"), example(&directory, "records")).unwrap();
    hovered(at("loop.toml").as_ref(), at("flight.mcap").as_ref());
    let reported = succeeds(&["report", &at("flight.mcap"), "--out", &at("report")]);
    assert!(reported.contains("identical to the bit, and so are the sticks of"), "{reported}");
    // The verdict comes first.
    assert!(reported.starts_with("Good: the autopilot was engaged once and flew"), "{reported}");
    let page = fs::read_to_string(at("report/report.html")).unwrap();
    assert!(page.contains("class=\"verdict good\""));
    assert_eq!(summary(&directory.join("report"))["verdict"]["level"], "good");
    for section in ["Modes", "Position", "Sticks", "Readiness", "Events"] {
        assert!(page.contains(section), "{section}");
    }
}

#[test]
fn a_simulation_that_no_flight_computer_opens_ends_after_its_duration() {
    let directory = place("nobody-there");
    let config = directory.join("loop.toml");
    fs::write(&config, example(&directory, "records")).unwrap();
    let config = config.display().to_string();
    let message = last_line(&["simulate", "--lines", "--config", &config, "--duration", "1"]);
    assert!(message.contains("no flight computer opened all lines within 1 s"), "{message}");
    // An unwritable output is reported before the flight.
    let under_a_file = format!("{config}/truth");
    let asked = ["simulate", "--lines", "--config", &config, "--out", &under_a_file];
    let message = last_line(&asked);
    assert!(message.starts_with(&format!("hovernav: cannot create {under_a_file}")), "{message}");
}

#[test]
fn what_cannot_be_flown_is_refused_with_the_key() {
    let directory = place("refused-flights");
    let good = example(&directory, "records");
    let site = "[site]\nlatitude_deg = 1.3521\nlongitude_deg = 103.8198\nheight_m = 0.0\n";
    for (from, to, expected) in [
        (
            "[receiver]\n",
            "rate_hz = 50.0\n[receiver]\n",
            "[autopilot] file: found gains for 33.00 Hz",
        ),
        ("pilot = \"override\"", "override_travel = 0.1", "[autopilot] override_travel"),
        ("radius_m = 60", "radius_m = nan", "[autopilot.geofence] radius_m: found NaN"),
        (site, "", "[autopilot] geofence: found no [site]"),
        (
            "[autopilot]\n",
            "[servo.swashplate]\nkind = 'ccpm120'\ncollective = 0.9\nlateral = 1.0\n\
          [servo.channels.lateral]\nmax_ms = 1.6\n[autopilot]\n",
            "[servo] swashplate",
        ),
        ("design/autopilot.toml", "nowhere.toml", "nowhere.toml"),
        (
            "[autopilot]\n",
            "[autopilot]\nswitch = { pulses = 0 }\n",
            "[autopilot.switch] pulses: found 0",
        ),
        ("[autopilot]\n", "[autopilot]\nready = { speed_mps = nan }\n", "ready] speed_mps"),
        ("[autopilot]\n", "[autopilot]\nswich = 3\n", "swich"),
    ] {
        assert!(good.contains(from), "{from}");
        let config = directory.join("bad.toml");
        fs::write(&config, good.replacen(from, to, 1)).unwrap();
        let message =
            last_line(&["fly", "--config", &config.display().to_string(), "--duration", "1"]);
        assert!(message.contains(expected), "{to}: {message}");
    }
}

#[test]
fn gains_that_are_unstable_on_the_vehicles_model_are_refused() {
    let directory = place("unstable-gains");
    let at = |name: &str| directory.join(name).display().to_string();
    let good = example(&directory, "records");
    let designed = fs::read_to_string(at("design/autopilot.toml")).unwrap();
    let turned = designed.replacen("proportional = ", "proportional = -", 1).replace("--", "");
    fs::write(at("design/autopilot.toml"), turned).unwrap();
    fs::write(at("loop.toml"), &good).unwrap();
    let fly = ["fly", "--config", &at("loop.toml"), "--duration", "1"];
    let message = last_line(&fly);
    let expected = "loop.toml: [autopilot] file: found gains that are unstable with raptor60 in the mode velocity";
    assert!(message.contains(expected), "{message}");
    fs::write(at("loop.toml"), good.replace("model = \"raptor60\"", "model = \"nowhere.toml\""))
        .unwrap();
    let message = last_line(&fly);
    assert!(message.contains("[autopilot] model") && message.contains("nowhere.toml"), "{message}");
}

#[test]
fn a_model_that_is_not_to_be_flown_by_is_refused_by_the_flight_too() {
    let directory = place("unflyable-flight");
    let at = |name: &str| directory.join(name).display().to_string();
    let named =
        example(&directory, "records").replace("model = \"raptor60\"", "model = \"model.toml\"");
    fs::write(at("loop.toml"), named).unwrap();
    let by_hand = include_str!("../../../crates/model/src/data/raptor60.toml");
    let identified = "parameters = [{ name = \"Nr\", value = -4.0, unit = \"1/s\" }]\n\
                      parameter_covariance = [[0.01]]\nstates = [";
    for (more, expected) in [
        ("verdict = \"do not fly\"\nreasons = [\"Lb has the wrong sign\"]\nstates = [", "Lb has"),
        (identified, "no verdict"),
    ] {
        fs::write(at("model.toml"), by_hand.replacen("states = [", more, 1)).unwrap();
        let message = last_line(&["fly", "--config", &at("loop.toml"), "--duration", "1"]);
        assert!(message.contains("[autopilot] model") && message.contains(expected), "{message}");
    }
}
