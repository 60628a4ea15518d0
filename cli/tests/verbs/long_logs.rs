//! Output rate and memory for long logs.

use std::fs;
use std::path::Path;

use crate::common::{self, HELI, hovernav, place, succeeds, text};

fn rows(out: &Path) -> Vec<String> {
    let csv = fs::read_to_string(out.join("solution.csv")).unwrap();
    csv.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn a_rate_leaves_rows_out_and_changes_none() {
    let (all, some) = (place("rate-all"), place("rate-some"));
    succeeds(&["-q", "estimate", HELI, "--no-report", "--out", text(&all)]);
    let exports = cfg!(feature = "export");
    let rate = ["--rate", "1", "--export", "tum"];
    let rate = if exports { &rate[..] } else { &rate[..2] };
    let out = ["--no-report", "--out", text(&some)];
    succeeds(&[&["-q", "estimate", HELI][..], rate, &out].concat());
    let (all, few) = (rows(&all), rows(&some));
    assert_eq!(few.len(), 298);
    assert!(few.iter().all(|row| all.contains(row)) && few[0] == all[0]);
    if exports {
        let tum = fs::read_to_string(some.join("solution.tum")).unwrap();
        assert_eq!(tum.lines().filter(|line| !line.starts_with('#')).count(), few.len());
    }
    let refused = hovernav(&["estimate", HELI, "--rate", "0"]);
    assert_eq!(refused.status.code(), Some(2));
}

/// Without sufficient memory, smoothing does not start, and the error contains both numbers.
#[cfg(target_os = "linux")]
#[test]
fn smoothing_is_refused_before_it_runs_out_of_memory() {
    let out = place("no-memory");
    let command = "ulimit -v 80000; exec \"$0\" -q estimate --smooth \"$1\" --out \"$2\"";
    let program = env!("CARGO_BIN_EXE_hovernav");
    let run = std::process::Command::new("sh")
        .args(["-c", command, program, HELI, text(&out)])
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(1), "{message}");
    let told = "smoothing 9899 samples takes 0.09 GB of memory in addition to the log, found 0.0";
    assert!(message.contains(told), "{message}");
    assert!(!out.join("solution.csv").exists());
}

/// Fifty minutes at 200 Hz of a vehicle at rest with vibration, with sticks and reference at the same rate. In memory:
/// 82 MB of samples, 43 MB of sticks, 77 MB of the reference.
#[cfg(target_os = "linux")]
fn fifty_minutes(log: &Path) {
    use std::fmt::Write as _;

    const SECONDS: u32 = 3000;
    fs::create_dir_all(log).unwrap();
    let axes = |what: &str, unit: &str| format!("{what}_x_{unit},{what}_y_{unit},{what}_z_{unit}");
    let heads = [axes("gyro", "radps"), axes("accel", "mps2")];
    let mut imu = format!("t_s,{},roll_deg,pitch_deg,yaw_deg\n", heads.join(","));
    let mut state = 1u64;
    for sample in 0..200 * SECONDS {
        write!(imu, "{:.3}", 0.005 * f64::from(sample)).unwrap();
        for (mean, size) in
            [(0.0, 0.02); 3].into_iter().chain([(0.0, 1.0), (0.0, 1.0), (-9.8, 1.0)])
        {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let noise = (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
            write!(imu, ",{:.4}", mean + size * noise).unwrap();
        }
        imu.push_str(",0.1,0.2,30.0\n");
    }
    fs::write(log.join("imu.csv"), imu).unwrap();
    let rows = |head: &str, values: &str| {
        let rows =
            (0..200 * SECONDS).map(|row| format!("{:.3},{values}\n", 0.005 * f64::from(row)));
        format!("{head}\n{}", rows.collect::<String>())
    };
    let controls = rows("t_s,lateral,longitudinal,collective,pedal", "0.1,0,0.2,-0.3");
    fs::write(log.join("controls.csv"), controls).unwrap();
    let columns = "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,yaw_deg";
    let reference = rows(columns, "1.35,103.8,50,0,0,0,0.1,0.2,30");
    fs::write(log.join("reference.csv"), reference).unwrap();
    let fixes = (1..SECONDS).map(|second| format!("{second},1.35,103.8,50,0,0,0\n"));
    let gps = "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps\n".to_owned();
    fs::write(log.join("gps.csv"), gps + &fixes.collect::<String>()).unwrap();
}

/// The memory of `estimate` does not grow with the number of samples. A command that loads all samples reports too
/// little memory beforehand.
#[cfg(target_os = "linux")]
#[test]
fn a_long_log_is_estimated_in_less_memory_than_its_samples_take() {
    let place = place("long");
    let (log, out) = (place.join("log"), place.join("out"));
    fifty_minutes(&log);
    let limited = |kilobytes: u32, command: &str| {
        let command = format!("ulimit -v {kilobytes}; exec \"$0\" -q {command}");
        let program = env!("CARGO_BIN_EXE_hovernav");
        let run = std::process::Command::new("sh")
            .args(["-c", &command, program, text(&log), text(&out)])
            .output()
            .unwrap();
        (run.status.code(), String::from_utf8_lossy(&run.stderr).into_owned())
    };
    let (code, message) = limited(140_000, "estimate \"$1\" --no-report --rate 1 --out \"$2\"");
    assert_eq!(code, Some(0), "{message}");
    let summary = common::summary(&out);
    assert_eq!(summary["imu_samples"], 600_000);
    assert!(summary["error"]["horizontal_m"]["rmse"].as_f64().unwrap() < 0.5);
    let (code, message) = limited(80_000, "info \"$1\"");
    assert_eq!(code, Some(1), "{message}");
    let told = "reading takes about 0.27 GB of memory, found 0.0";
    assert!(message.contains(told) && message.lines().count() == 1, "{message}");
}
