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
