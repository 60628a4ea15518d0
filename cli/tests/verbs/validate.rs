//! The table of all datasets contains the numbers of the command.

use std::path::Path;

use hovernav_validate::{Set, Windows, run};
use serde_json::Value;

use crate::common::{HELI, place, succeeds, summary, text};

fn estimate(name: &str, arguments: &[&str]) -> Value {
    let out = place(name);
    succeeds(&[&["estimate", HELI, "--no-report", "--out", text(&out)], arguments].concat());
    summary(&out)
}

#[test]
fn a_row_of_the_table_has_the_numbers_of_the_summary() {
    let windows = Windows { duration_s: 12.0, documented: Some((100.0, 1.0, 1)) };
    let set = Set { name: "heli".into(), path: Path::new(HELI).into(), windows: vec![windows] };
    let rows = run(&[set], &[]);
    let [causal, smoothed, outages] = &rows[..] else { panic!("{rows:?}") };

    for (row, arguments) in [(causal, &[][..]), (smoothed, &["--smooth"])] {
        let summary = estimate(&format!("row-{}", row.run), arguments);
        for (axis, quantity) in [
            ("vn_mps", "vn"),
            ("ve_mps", "ve"),
            ("vd_mps", "vd"),
            ("roll_deg", "roll"),
            ("pitch_deg", "pitch"),
            ("yaw_deg", "yaw"),
        ] {
            assert_eq!(summary["error"][axis]["rmse"], row.numbers[axis], "{axis}");
            let over_sigma = row.numbers[&format!("{quantity}_over_sigma")];
            assert_eq!(summary["error_over_sigma"][axis], over_sigma, "{axis}");
        }
        assert_eq!(summary["error"]["horizontal_m"]["rmse"], row.numbers["horizontal_m"]);
        for (group, axes) in [
            ("position", ["north_m", "east_m", "down_m"]),
            ("velocity", ["vn_mps", "ve_mps", "vd_mps"]),
            ("attitude", ["roll_deg", "pitch_deg", "yaw_deg"]),
        ] {
            let share = |axis| summary["within_3_sigma"][axis].as_f64().expect("scored");
            let worst = axes.map(share).into_iter().fold(1.0, f64::min);
            assert_eq!(worst, row.numbers[&format!("{group}_within_3_sigma")], "{group}");
        }
        let count = |key: &str| summary[key].as_f64().expect("counted");
        assert_eq!(count("gps_fixes_used"), row.numbers["fixes_used"]);
        assert_eq!(count("gps_fixes_rejected"), row.numbers["fixes_rejected"]);
        let findings = summary["findings"].as_array().expect("findings");
        assert_eq!(findings.len() as f64, row.numbers["findings"]);
    }

    let summary = estimate("row-outage", &["--outage", "100:12"]);
    assert_eq!(summary["outages"][0]["max_horizontal_m"], outages.numbers["documented_worst_m"]);
}
