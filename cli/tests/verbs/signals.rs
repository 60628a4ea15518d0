//! Effect of signals on a flight: most are ignored, and the others end the flight in order.
#![cfg(all(feature = "fly", target_os = "linux"))]

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use crate::common::place;

fn send(signals: &[&str], flight: &Child) {
    let to = flight.id().to_string();
    let sends: Vec<String> = signals.iter().map(|signal| format!("kill -{signal} {to}")).collect();
    let sent = Command::new("bash").args(["-c", &sends.join(" && ")]).status().unwrap();
    assert!(sent.success(), "{signals:?}");
}

#[test]
fn a_flight_outlives_stray_signals_and_one_request_sent_twice_ends_it_in_order() {
    let directory = place("signals");
    let config = directory.join("fly.toml");
    // The ports do not exist: the loop retries and continues.
    let ports = "[dmu]\nport = \"no-unit\"\n[receiver]\nport = \"no-receiver\"\nprotocol = \"ubx\"\n\
                 [site]\nlatitude_deg = 1.3521\nlongitude_deg = 103.8198\nheight_m = 0.0\n";
    fs::write(&config, ports).unwrap();
    let record = directory.join("flight.mcap");
    for asked in ["INT", "TERM"] {
        let mut flight = Command::new(env!("CARGO_BIN_EXE_hovernav"))
            .current_dir(&directory)
            .args(["fly", "--config", "fly.toml", "--record", "flight.mcap"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while !record.exists() {
            thread::sleep(Duration::from_millis(20));
        }
        send(&["HUP", "TSTP", "TTOU", "XCPU", "USR1"], &flight);
        thread::sleep(Duration::from_millis(300));
        assert_eq!(flight.try_wait().unwrap(), None, "a stray signal ended the flight");
        send(&[asked, asked], &flight);
        let ended = flight.wait_with_output().unwrap();
        let report = String::from_utf8_lossy(&ended.stdout).into_owned();
        assert!(ended.status.success(), "{asked}: {}", ended.status);
        assert!(report.contains("missed deadlines"), "{asked}: {report}");
        fs::remove_file(&record).unwrap();
    }
}

/// A flight of an armed vehicle: its servos are driven.
fn armed_flight(name: &str, error: Stdio) -> (Child, std::path::PathBuf) {
    let directory = place(name);
    let text = "[dmu]\nport = \"no-unit\"\n[receiver]\nport = \"no-receiver\"\nprotocol = \"ubx\"\n\
                [servo.stream]\nport = \"no-servos\"\n\
                [site]\nlatitude_deg = 1.3521\nlongitude_deg = 103.8198\nheight_m = 0.0\n";
    fs::write(directory.join("fly.toml"), text).unwrap();
    let record = directory.join("flight.mcap");
    let flight = Command::new(env!("CARGO_BIN_EXE_hovernav"))
        .current_dir(&directory)
        .args(["fly", "--config", "fly.toml", "--record", "flight.mcap"])
        .stdout(Stdio::piped())
        .stderr(error)
        .spawn()
        .unwrap();
    while !record.exists() {
        thread::sleep(Duration::from_millis(20));
    }
    (flight, directory)
}

#[test]
fn one_stray_ctrl_c_does_not_end_the_flight_of_an_armed_vehicle() {
    let (mut flight, directory) = armed_flight("stray", Stdio::piped());
    // Two signals more than 2 s apart count as two separate signals, and do not end the flight.
    for _ in 0..2 {
        send(&["INT"], &flight);
        thread::sleep(Duration::from_millis(2500));
        assert_eq!(flight.try_wait().unwrap(), None, "one Ctrl-C ended the flight");
    }
    send(&["INT"], &flight);
    thread::sleep(Duration::from_millis(300));
    send(&["INT"], &flight);
    let ended = flight.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.success(), "{}: {told}", ended.status);
    assert_eq!(told.matches("press Ctrl-C again within 2 s").count(), 3, "{told}");
    fs::remove_file(directory.join("flight.mcap")).unwrap();

    let (flight, _) = armed_flight("stray", Stdio::null());
    send(&["TERM"], &flight);
    assert!(flight.wait_with_output().unwrap().status.success());
}

#[test]
fn a_full_pipe_at_the_start_blocks_neither_the_flight_nor_its_end() {
    let directory = place("stuck");
    fs::write(
        directory.join("fly.toml"),
        "[dmu]\nport = \"no-unit\"\n[receiver]\nport = \"no-receiver\"\nprotocol = \"ubx\"\n\
         [site]\nlatitude_deg = 1.3521\nlongitude_deg = 103.8198\nheight_m = 0.0\n",
    )
    .unwrap();
    // A full pipe without a reader.
    let script = format!(
        "mkfifo full; exec 3<>full; dd if=/dev/zero of=/proc/self/fd/3 bs=4096 count=16 2>/dev/null; \
         exec timeout 30 {} fly --config fly.toml --record flight.mcap --duration 1.5 >&3 2>&3",
        env!("CARGO_BIN_EXE_hovernav")
    );
    let ended =
        Command::new("bash").current_dir(&directory).args(["-c", &script]).output().unwrap();
    assert!(ended.status.success(), "{ended:?}");
    let record = hovernav_record::Record::open(&directory.join("flight.mcap")).unwrap();
    assert!(record.is_ended && record.events.len() > 1, "{:?}", record.events);
}
