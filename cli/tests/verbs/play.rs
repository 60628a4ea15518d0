//! `hovernav play` from the side of a flight computer: ports at the requested paths, and a clean end.
#![cfg(all(unix, feature = "fly"))]

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::common::{HELI, hovernav, place};
use hovernav::dmu::{Flow, Link, LinkAction, Mode};
use hovernav_fly::serial::{Clock, Port, PortConfig, Read};

/// The command after it has reported that it is ready, and the rest of its output.
fn play(place: &Path, more: &[&str]) -> (Child, impl Iterator<Item = String>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_hovernav"))
        .args(["play", HELI, "--dmu"])
        .arg(place.join("dmu"))
        .arg("--gps")
        .arg(place.join("gps"))
        .args(more)
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert_eq!(lines.next().as_deref(), Some("dmu: ranges 200 deg/s and 4 g"));
    let ready = lines.next().expect("it is ready");
    assert!(ready.starts_with("ready: dmu at ") && ready.contains(", gps at "), "{ready}");
    (child, lines)
}

#[test]
fn an_interrupted_play_takes_its_ports_away_and_reports_what_it_did() {
    let place = place("play");
    let (mut child, lines) = play(&place, &["--speed", "5", "--start-delay", "0"]);
    assert!(place.join("gps").exists());

    let clock = Clock::at_speed(5.0).unwrap();
    let path = place.join("dmu").to_str().unwrap().to_string();
    let mut port = Port::new(PortConfig::new(path, 38_400), &clock);
    let mut link = Link::new(Mode::Angle, Flow::Continuous, clock.now());
    let (mut packets, end) = (0, clock.now() + 60.0);
    while packets < 50 && clock.now() < end {
        match link.next_action(clock.now()) {
            LinkAction::Write(command) => {
                let _ = port.write(&[command.byte()], clock.now() + 0.1);
            }
            LinkAction::Lost(_) => {}
            LinkAction::ReadUntil(deadline) => {
                let mut buffer = [0; 256];
                if let Read::Bytes { count, arrival } = port.read_until(&mut buffer, deadline) {
                    let mut bytes = &buffer[..count];
                    while link.next_packet(&mut bytes, arrival).is_some() {
                        packets += 1;
                    }
                }
            }
        }
    }
    assert!(packets >= 50, "{packets}");

    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(interrupt.expect("kill runs").success());
    assert!(child.wait().unwrap().success());
    let told: Vec<String> = lines.collect();
    assert!(told[0].starts_with("played ") && told[1].starts_with("dmu: "), "{told:?}");
    assert!(!place.join("dmu").is_symlink() && !place.join("gps").is_symlink());
}

#[test]
fn wrong_usage_exits_with_two_and_an_occupied_path_with_one() {
    let place = place("play_refused");
    let dmu = place.join("dmu");
    std::fs::write(&dmu, "mine").unwrap();
    let dmu = dmu.to_str().unwrap();
    for (arguments, code) in [
        (&["play", HELI][..], 2),
        (&["play", HELI, "--dmu", dmu, "--pull", "dmu=5"], 2),
        (&["play", HELI, "--dmu", dmu, "--cut", "servo=5:6"], 2),
        (&["play", HELI, "--dmu", dmu, "--start-delay", "-1"], 2),
        (&["play", HELI, "--dmu", dmu], 1),
        (&["play", HELI, "--gps", place.join("gps").to_str().unwrap(), "--speed", "0"], 2),
    ] {
        let run = hovernav(arguments);
        assert_eq!(run.status.code(), Some(code), "{arguments:?} {run:?}");
    }
    assert_eq!(std::fs::read_to_string(dmu).unwrap(), "mine");
}
