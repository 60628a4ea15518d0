//! What cannot be staged within one process: a flight computer that is not let run, one whose record finds
//! no room, and one whose ground is gone. Each as the command flies it, at three moments.
#![cfg(all(feature = "lines", target_os = "linux"))]

mod common;

use std::fs;
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{designed, place, summary};
use hovernav_log::record::Record;

/// When it happens: after six seconds of hover, while a stick steers, just after engagement; s.
const MOMENTS: [(&str, f64); 3] = [("hover", 14.0), ("manoeuvre", 14.0), ("engagement", 8.4)];
const LENGTH_S: u32 = 22;
/// What a record grows by, bytes a second; a limit of its file puts its end at a moment.
const RECORD_PER_S: f64 = 125e3;

/// What is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lost {
    Time,
    Record,
    Telemetry,
}

/// A flight in a directory of its own.
struct Scene {
    lost: Lost,
    moment: &'static str,
    second: f64,
    directory: std::path::PathBuf,
}

impl Scene {
    fn at(&self, name: &str) -> String {
        self.directory.join(name).display().to_string()
    }

    /// Flies it, and what the flight computer said on the terminal.
    fn fly(&self) -> String {
        let ground = UdpSocket::bind("127.0.0.1:0").unwrap();
        ground.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let mut text = include_str!("../../examples/loop.toml")
            .replace("/tmp/hovernav-", &self.at("line-"))
            .replace("../out/raptor60/autopilot.toml", "../design/autopilot.toml");
        if self.moment == "manoeuvre" {
            text = text.replace("pilot = \"override\"", "pilot = \"steer\"");
        }
        let address = ground.local_addr().unwrap();
        text += &format!("\n[telemetry]\nudp = \"{address}\"\n");
        fs::write(self.at("loop.toml"), text).unwrap();
        let acts = ["--do", "engage@8:12", "--do", "stick-longitudinal=0.3@12.5:2"];
        let acts = &acts[..if self.moment == "manoeuvre" { 4 } else { 2 }];
        let (config, length) = (self.at("loop.toml"), LENGTH_S.to_string());
        let mut helicopter = Command::new(env!("CARGO_BIN_EXE_hovernav"))
            .args(["simulate", "--lines", "--config", &config, "--duration", &length])
            .args(acts)
            .args(["--out", &self.at("truth")])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let kibibytes = match self.lost {
            Lost::Record => (self.second * RECORD_PER_S / 1024.0).to_string(),
            _ => "unlimited".to_owned(),
        };
        let whole = kibibytes.split('.').next().unwrap_or_default();
        let limited = format!("ulimit -f {whole}; exec \"$0\" \"$@\"");
        let computer = Command::new("bash")
            .args(["-c", &limited, env!("CARGO_BIN_EXE_hovernav")])
            .args(["fly", "--config", &config, "--record", &self.at("flight.mcap")])
            .args(["--duration", &length])
            .stderr(fs::File::create(self.at("terminal")).unwrap())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        let mut heard = [0; 2048];
        let (_, aboard) = ground
            .recv_from(&mut heard)
            .map_or_else(|error| panic!("no telemetry: {error}"), |(count, from)| (count, from));
        ground.send_to(b"#", aboard).unwrap();
        self.lose(&computer, ground, begun);
        assert!(computer.wait_with_output().unwrap().status.success(), "{:?}", self.lost);
        helicopter.wait().unwrap();
        fs::read_to_string(self.at("terminal")).unwrap()
    }

    /// Makes it happen.
    fn lose(&self, computer: &Child, ground: UdpSocket, begun: Instant) {
        let until = Duration::from_secs_f64(self.second).saturating_sub(begun.elapsed());
        thread::sleep(until);
        match self.lost {
            Lost::Telemetry => drop(ground),
            Lost::Record => {}
            // Let run for long enough to ask for a packet and have it, too late each time.
            Lost::Time => {
                let signal = |name: &str| {
                    let id = computer.id().to_string();
                    assert!(Command::new("kill").args([name, &id]).status().unwrap().success());
                };
                for _ in 0..20 {
                    signal("-STOP");
                    thread::sleep(Duration::from_millis(26));
                    signal("-CONT");
                    thread::sleep(Duration::from_millis(18));
                }
            }
        }
    }
}

fn fly_all(directory: &Path) -> Vec<(Scene, String)> {
    fs::create_dir(directory.join("design")).unwrap();
    fs::copy(designed().join("autopilot.toml"), directory.join("design/autopilot.toml")).unwrap();
    let scenes = [Lost::Time, Lost::Record, Lost::Telemetry].into_iter().flat_map(|lost| {
        MOMENTS.map(|(moment, second)| {
            let directory = directory.join(format!("{lost:?}-{moment}"));
            fs::create_dir_all(&directory).unwrap();
            Scene { lost, moment, second, directory }
        })
    });
    let scenes: Vec<Scene> = scenes.collect();
    thread::scope(|scope| {
        let running: Vec<_> = scenes
            .into_iter()
            .map(|scene| {
                scope.spawn(|| {
                    let told = scene.fly();
                    (scene, told)
                })
            })
            .collect();
        running.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Half a minute. `chrt -f 40` keeps other programs from making it too late.
#[test]
#[ignore = "needs a quiet machine"]
fn a_late_loop_hands_back_and_nothing_waits_for_record_or_ground() {
    for (scene, told) in fly_all(&place("lost-by-processes")) {
        let Scene { lost, moment, .. } = &scene;
        let truth = summary(Path::new(&scene.at("truth")));
        assert!(truth["crashed_s"].is_null(), "{lost:?}, {moment}: {truth}\n{told}");
        let record = Record::open(Path::new(&scene.at("flight.mcap"))).unwrap();
        if *lost == Lost::Time {
            let late = record.cycles.iter().find(|one| one.cycle.late_cycles >= 3);
            let late = late.unwrap_or_else(|| panic!("{moment}: three cycles late\n{told}"));
            let event =
                record.events.iter().find(|event| event.text.contains("late again and again"));
            let event = event.unwrap_or_else(|| panic!("{moment}\n{told}"));
            println!("{lost:?}, {moment}: the pilot flies {:.3} s later", event.time - late.time);
            assert_eq!(event.time, late.time, "{moment}");
            continue;
        }
        println!("{lost:?}, {moment}: flown on for {} s", truth["engaged_s"]);
        assert!(truth["engaged_s"].as_f64().unwrap() > 11.0, "{lost:?}, {moment}: {truth}\n{told}");
        if *lost == Lost::Record {
            assert!(told.contains("the record is not written: File too large"), "{told}");
            assert!(!record.is_ended && record.cycles.len() > 200, "it opens up to there");
        }
    }
}
