//! The ground station with a flight computer and the simulated helicopter: three programs, as in the field.

#[path = "../../../ground/tests/common/browser.rs"]
mod browser;

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use self::browser::{Browser, chromium};
use crate::common::{example, hovernav, place, refusal, succeeds, summary, text};

/// A program that ends with the test.
struct Running(Child);

impl Running {
    fn start(arguments: &[&str]) -> Self {
        let child = Command::new(env!("CARGO_BIN_EXE_hovernav"))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        Self(child)
    }

    /// The first line of output.
    fn first_line(&mut self) -> String {
        let mut line = String::new();
        BufReader::new(self.0.stdout.take().unwrap()).read_line(&mut line).unwrap();
        line
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// `examples/loop.toml` with every path in `directory`, an autopilot, and telemetry to `port`.
fn config(directory: &Path, port: u16) -> String {
    let text = example(directory, "aboard");
    let path = directory.join("loop.toml").display().to_string();
    fs::write(&path, format!("{text}\n[telemetry]\nudp = \"127.0.0.1:{port}\"\n")).unwrap();
    path
}

/// A free port.
fn free() -> u16 {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// A ground station that waits for a vehicle.
struct Field<'a> {
    directory: &'a Path,
    config: String,
    station: Running,
    /// The address of the page.
    page: String,
}

impl<'a> Field<'a> {
    fn new(directory: &'a Path, more: &[&str]) -> Self {
        let port = free();
        let config = config(directory, port);
        let folder = directory.join("records").display().to_string();
        let link = format!("udp:127.0.0.1:{port}");
        let mut all =
            vec!["ground", &link, "--config", &config, "--folder", &folder, "--port", "0"];
        all.extend(more);
        let mut station = Running::start(&all);
        let ready = station.first_line();
        let page = ready.split_whitespace().last().unwrap().to_owned();
        assert!(page.starts_with("http://127.0.0.1:"), "{ready}");
        Self { directory, config, station, page }
    }

    /// Starts the simulated helicopter and the flight computer.
    fn take_off(&self, seconds: &str, acts: &[String]) -> [Running; 2] {
        let at = |name: &str| self.directory.join(name).display().to_string();
        let (truth, aboard, config) = (at("truth"), at("aboard.mcap"), self.config.as_str());
        let mut simulate = vec!["simulate", "--lines", "--config", config, "--out", &truth];
        simulate.extend(["--duration", seconds]);
        simulate.extend(acts.iter().flat_map(|act| ["--do", act]));
        let helicopter = Running::start(&simulate);
        let fly = ["fly", "--config", config, "--record", &aboard, "--duration", seconds];
        [helicopter, Running::start(&fly)]
    }
}

#[test]
fn what_a_flight_reports_by_udp_is_recorded_and_identified_from() {
    let directory = place("ground-udp");
    let mut field = Field::new(&directory, &["--record", "hover"]);
    let [mut helicopter, _computer] = field.take_off("16", &[]);
    helicopter.0.wait().unwrap();
    // Ctrl-C sends SIGINT.
    let station = field.station.0.id().to_string();
    assert!(Command::new("kill").args(["-INT", &station]).status().unwrap().success());
    assert!(field.station.0.wait().unwrap().success());
    let record = directory.join("records/hover.mcap");
    let (store, is_cut) = hovernav_ground::record::read(&record).unwrap();
    let (from_s, to_s) = store.span().unwrap();
    let told = store.texts_from(0).0.any(|line| line.text.contains("aligned"));
    println!("{:.1} s recorded", to_s - from_s);
    assert!(!is_cut && to_s - from_s > 12.0 && told);

    // The telemetry is sufficient for navigation.
    let manifest = hovernav_dataset::Manifest::default();
    let dataset = hovernav_ground::evaluate::dataset(&store, &manifest);
    assert!(dataset.fixes.len() >= 8, "{} fixes", dataset.fixes.len());
    let (log, out) = (directory.join("dataset"), directory.join("estimate"));
    dataset.write(&log, &[]).unwrap();
    let (log, out) = (log.display().to_string(), out.display().to_string());
    succeeds(&["estimate", &log, "--out", &out, "--no-report"]);
    let summary = summary(out.as_ref());
    assert!(summary["gps_fixes_used"].as_u64().unwrap() >= 6, "{summary}");
}

#[test]
fn what_a_vehicle_without_its_inertial_unit_no_longer_measures_is_not_sent() {
    use hovernav_ground::channel::Id;
    let directory = place("ground-without-unit");
    let mut field = Field::new(&directory, &["--record", "cut"]);
    let [mut helicopter, _computer] = field.take_off("14", &["dmu-cut@8:4".into()]);
    helicopter.0.wait().unwrap();
    let station = field.station.0.id().to_string();
    assert!(Command::new("kill").args(["-INT", &station]).status().unwrap().success());
    assert!(field.station.0.wait().unwrap().success());
    let (store, _) = hovernav_ground::record::read(&directory.join("records/cut.mcap")).unwrap();
    let (from_s, to_s) = store.span().unwrap();
    let has_unit = |t: f64| store.at(Id::Status, t) as u16 & 1 != 0;
    let moments: Vec<f64> =
        (0..).map(|k| from_s + 0.1 * f64::from(k)).take_while(|t| *t < to_s).collect();
    let first_s = moments.iter().copied().find(|t| has_unit(*t)).unwrap();
    // A second after the last sample, no value is younger than two of its periods.
    let is_without = |t: &f64| (0..10).all(|k| !has_unit(t - 0.1 * f64::from(k)));
    let without: Vec<f64> =
        moments.into_iter().filter(|t| *t > first_s + 2.0 && is_without(t)).collect();
    assert!(without.len() > 10, "{without:?}");
    for t in without {
        for id in [Id::RateP, Id::AccelZ, Id::Roll, Id::VelN, Id::Latitude, Id::SigmaTilt] {
            let value = store.at(id, t);
            assert!(value.is_nan(), "{} is {value} at {:.1} s", id.channel().name, t - from_s);
        }
    }
}

#[test]
fn a_station_that_cannot_be_is_refused_with_what_was_expected() {
    let folder = place("ground-refused");
    let folder = text(&folder);
    for (arguments, expected) in [
        (&["--config", "/nowhere/fly.toml"][..], "/nowhere/fly.toml"),
        (&["--address", "203.0.113.7"], "cannot serve at 203.0.113.7:8033"),
        (&["--record", "../x"], "expected 1 to 64 letters"),
    ] {
        let all = [&["ground", "--folder", folder][..], arguments].concat();
        let message = refusal(&all);
        assert!(message.contains(expected), "{message}");
    }
    for wrong in [&["udp:nowhere"][..], &["/dev/x:5"], &["--token", "short"], &["--port", "70000"]]
    {
        let all = [&["ground", "--folder", folder][..], wrong].concat();
        assert_eq!(hovernav(&all).status.code(), Some(2), "{wrong:?}");
    }
}

/// The mission of the pictures in `docs/ground.md`. `SCREENSHOTS=DIR` saves the pictures in DIR.
#[test]
#[ignore = "three minutes in real time, on a machine with nothing else to do"]
fn a_mission_from_connecting_to_identifying() {
    let Some(chromium) = chromium() else { return };
    let directory = place("ground-mission");
    let steps = ["lateral", "longitudinal", "pedal"];
    let mut acts: Vec<String> = Vec::new();
    for (place, stick) in steps.iter().enumerate() {
        for time in 0..3 {
            let (at, sign) = (18 + 21 * place + 7 * time, if time == 1 { "-" } else { "" });
            acts.push(format!("stick-{stick}={sign}0.125@{at}:1.5"));
            // The pilot does not respond to gusts during a test point.
            acts.push(format!("still@{}.7:2", at - 1));
        }
    }
    acts.extend(["engage@90:50".into(), "no-fix@108:10".into()]);
    let field = Field::new(&directory, &[]);
    let mut page = Browser::open(&chromium, &field.page, 1400, 950);
    let [mut helicopter, _computer] = field.take_off("150", &acts);

    // Connect, and watch the pilot hover.
    page.wait("document.getElementById('link').textContent.includes('Hz')");
    page.key("r");
    page.wait("document.getElementById('asker').open");
    page.eval("document.getElementById('reply').value = ''");
    page.write("mission");
    page.key("Enter");
    page.wait("!document.getElementById('recording').hidden");
    page.wait("document.getElementById('flies').textContent.startsWith('the pilot')");
    thread::sleep(Duration::from_secs(12));
    keep(&mut page, "ground-1-hover");

    // Fly the test points.
    page.key("3");
    thread::sleep(Duration::from_secs(60));
    keep(&mut page, "ground-2-points");
    thread::sleep(Duration::from_secs(5));
    let good = "[...document.querySelectorAll('#progress tr.good')].length";
    println!("{} of 3 test points are good", page.eval(good));
    assert!(page.eval(good).as_u64().unwrap() >= 2);

    // Engage; hold through the gusts.
    page.key("2");
    patiently(&mut page, 90, "document.getElementById('mode').textContent.includes('autopilot')");
    thread::sleep(Duration::from_secs(10));
    keep(&mut page, "ground-3-engaged");

    // Lose GPS and regain it.
    patiently(&mut page, 40, "document.getElementById('alarms').textContent.includes('GPS')");
    page.key("m");
    page.write("GPS lost");
    page.key("Enter");
    page.wait("document.getElementById('markers').textContent.includes('GPS lost')");
    thread::sleep(Duration::from_secs(4));
    keep(&mut page, "ground-4-gps-lost");
    patiently(&mut page, 40, "!document.getElementById('alarms').textContent.includes('GPS')");

    // Hand back, land, end the record.
    patiently(
        &mut page,
        40,
        "document.getElementById('flies').textContent.startsWith('the pilot')",
    );
    page.key("5");
    thread::sleep(Duration::from_secs(2));
    keep(&mut page, "ground-5-log");
    helicopter.0.wait().unwrap();
    page.key("r");
    page.wait("document.getElementById('recording').hidden");

    // Retrieve the record and identify from it.
    page.key("4");
    page.wait("document.querySelector('#list button')");
    page.click("#list button");
    page.wait("!document.getElementById('player').hidden");
    page.key("1");
    thread::sleep(Duration::from_secs(2));
    keep(&mut page, "ground-6-record");
    page.key("4");
    page.wait("document.querySelectorAll('#list button').length >= 2");
    page.eval("document.querySelectorAll('#list button')[1].click()");
    patiently(&mut page, 600, "document.querySelector('#job .large')?.textContent === 'done'");
    keep(&mut page, "ground-7-identified");
    println!("{}", page.eval("document.getElementById('job').innerText"));
    assert_eq!(page.eval("document.querySelectorAll('#job a').length"), 2);
    assert!(page.said.is_empty(), "{:?}", page.said);
}

/// Widths and heights of the pictures: a screen, a tablet, and a phone.
const SCREENS: [(u32, u32, bool); 3] = [(1400, 950, false), (820, 1180, true), (390, 844, true)];

/// Saves the page at three widths in `$SCREENSHOTS`, if that is set. Nothing may be cut off.
fn keep(page: &mut Browser, name: &str) {
    for (width, height, mobile) in SCREENS {
        page.size(width, height, mobile);
        page.wait("document.documentElement.scrollWidth <= innerWidth");
        page.wait(
            "[...document.querySelectorAll('.card')].every((one) => one.scrollWidth <= one.clientWidth)",
        );
        thread::sleep(Duration::from_millis(700));
        page.keep(&format!("{name}-{width}"));
    }
    let (width, height, mobile) = SCREENS[0];
    page.size(width, height, mobile);
}

/// Waits for a slow condition, up to `seconds`.
fn patiently(page: &mut Browser, seconds: u64, script: &str) {
    for _ in 0..5 * seconds {
        if page.eval(&format!("Boolean({script})")) == true {
            return;
        }
        thread::sleep(Duration::from_millis(200));
    }
    page.keep("ground-failed");
    panic!("timeout after {seconds} s: {script}");
}
