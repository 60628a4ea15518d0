//! Solutions in the formats of other programs, and scores of trajectories of other programs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use hovernav_testing::python;
use serde_json::Value;

use crate::common::{self, HELI, hovernav, place, refusal, succeeds, text};

/// The helicopter's solution in every format, exported once for all tests.
fn exported() -> &'static Path {
    static EXPORTED: LazyLock<PathBuf> = LazyLock::new(|| {
        let out = place("exported");
        let mut formats = String::from("kml,gpx,pos,tum,euroc,mcap");
        if cfg!(feature = "parquet") {
            formats += ",parquet";
        }
        let columns = "covariance,quaternion,local";
        let arguments =
            ["estimate", HELI, "--no-report", "--out", text(&out), "--export", &formats];
        succeeds(&[&arguments[..], &["--columns", columns]].concat());
        out
    });
    &EXPORTED
}

fn score(arguments: &[&str]) -> Value {
    serde_json::from_str(&succeeds(&[&["score", "--json"], arguments].concat())).expect("JSON")
}

fn rmse(score: &Value, axis: &str) -> f64 {
    score["error"][axis]["rmse"].as_f64().unwrap_or_else(|| panic!("{axis} in {score}"))
}

#[test]
fn what_is_exported_scores_as_the_solution_does() {
    let out = exported();
    let file = |name: &str| out.join(name);
    let own = score(&[text(out), HELI, "--align"]);
    for name in ["solution.tum", "solution.euroc.csv"] {
        let other = score(&[text(&file(name)), HELI, "--align"]);
        for axis in ["north_m", "east_m", "down_m", "roll_deg", "pitch_deg", "yaw_deg"] {
            let difference = rmse(&own, axis) - rmse(&other, axis);
            assert!(difference.abs() < 2e-4, "{name} {axis} differs by {difference}");
        }
    }
    // Both files define their axes. Wrong axes would cause an error of half a turn.
    let between = score(&[text(&file("solution.tum")), text(&file("solution.euroc.csv"))]);
    assert!(rmse(&between, "north_m") < 1e-4 && rmse(&between, "yaw_deg") < 1e-4, "{between}");
    let origin = fs::read_to_string(file("solution.csv")).expect("a solution");
    let origin: Vec<&str> = origin.lines().nth(1).expect("a row").split(',').collect();
    let placed = score(&[text(&file("solution.tum")), HELI, "--origin", &origin[1..4].join(",")]);
    let by_itself = score(&[text(&file("solution.tum")), HELI]);
    let own = score(&[text(out), HELI]);
    for axis in ["north_m", "east_m", "down_m"] {
        for other in [&placed, &by_itself] {
            let difference = rmse(other, axis) - rmse(&own, axis);
            assert!(difference.abs() < 1e-3, "{axis} differs by {difference}");
        }
    }
}

#[test]
fn what_cannot_be_scored_is_refused_with_what_would_help() {
    let euroc = exported().join("solution.euroc.csv");
    let out = place("not_scored");
    assert!(refusal(&["score", text(&euroc), HELI]).contains("expected --align, or --origin"));
    let short = out.join("short.tum");
    fs::write(&short, "# t x y z\n1.0 2.0 3.0\n").expect("writable");
    assert!(refusal(&["score", text(&short), HELI]).contains("short.tum:2"));
    fs::write(&short, "1 0 0 0 0 0 0 1\n2 x 0 0 0 0 0 1\n").expect("writable");
    assert!(refusal(&["score", text(&short), HELI]).contains("short.tum:2: column 2: found \"x\""));
    fs::write(&short, "time,lat,lon,alt\n1,2,3,4\n").expect("writable");
    let refused = refusal(&["score", text(&short), HELI]);
    assert!(refused.contains("short.tum:1: expected a header with t_s"), "{refused}");
    let other_clock = out.join("later.tum");
    fs::write(&other_clock, "1e6 0 0 0 0 0 0 1\n1000001 0 0 0 0 0 0 1\n").expect("writable");
    assert!(refusal(&["score", text(&other_clock), HELI, "--align"]).contains("the same clock"));
    for arguments in [
        &["score", "a", "b", "--origin", "1,2"][..],
        &["estimate", HELI, "--export", "dwg"],
        &["estimate", HELI, "--export", "-"],
        &["estimate", HELI, "--columns", "colour"],
    ] {
        assert_eq!(hovernav(arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn a_dataset_is_scored_from_where_its_own_estimate_is() {
    let out = exported();
    let summary = common::summary(out);
    let own = score(&[text(out), HELI]);
    for axis in ["north_m", "down_m", "vn_mps", "yaw_deg"] {
        let difference = rmse(&summary, axis) - rmse(&own, axis);
        assert!(difference.abs() < 5e-5, "{axis} differs by {difference}");
    }
    // `--skip` counts from the first solution.
    let from = |score: &Value| score["from_s"].as_f64().expect("a number");
    let skipped = score(&[text(out), HELI, "--skip", "40"]);
    assert!((from(&own) - 30.05).abs() < 1e-3, "{own}");
    assert!((from(&skipped) - 42.02).abs() < 0.01, "{skipped}");
}

#[test]
fn what_no_vehicle_does_is_not_scored() {
    let out = exported();
    let files = ["dataset.toml", "imu.csv", "reference.csv"];
    let dataset = common::changed(HELI, "absurd_reference", &files, |file, content| {
        let mut lines: Vec<String> = content.lines().map(str::to_owned).collect();
        if file == "reference.csv" {
            for (line, column, value) in
                [(2000, 4, "1e300"), (2001, 1, "1e300"), (2002, 9, "-1e300")]
            {
                let mut fields: Vec<&str> = lines[line].split(',').collect();
                fields[column] = value;
                lines[line] = fields.join(",");
            }
        }
        Some(lines.join("\n") + "\n")
    });
    let csv = dataset.join("reference.csv");
    let own = score(&[text(out), HELI]);
    for reference in [text(&dataset), text(&csv)] {
        let found = score(&[text(out), reference, "--skip", "28.03"]);
        for axis in ["north_m", "vn_mps", "u_mps", "yaw_deg"] {
            let difference = rmse(&own, axis) - rmse(&found, axis);
            assert!(difference.abs() < 1e-3, "{axis} differs by {difference}: {found}");
        }
        let told = found["warnings"].to_string();
        for said in [
            "reference.csv: line 2001 with a velocity beyond any vehicle's",
            "reference.csv: line 2002 rejected: not a position on Earth",
            "reference.csv: line 2003 with an angle beyond 360°",
        ] {
            assert!(told.contains(said), "{said}: {told}");
        }
    }
}

#[cfg(feature = "formats")]
#[test]
fn a_table_with_names_of_its_own_is_scored_by_its_mapping() {
    let solution = exported();
    let rows = fs::read_to_string(solution.join("solution.csv")).expect("a solution");
    let mut foreign = String::from(
        "Timestamp [ms];Latitude [deg];Longitude [deg];Altitude [m];Vel N [km/h];Vel E [km/h];Vel D [km/h];\
         Roll [rad];Pitch [rad];Yaw [rad]\n",
    );
    for row in rows.lines().skip(1) {
        let values: Vec<f64> =
            row.split(',').take(10).map(|value| value.parse().expect("a number")).collect();
        let (velocity, attitude) = (&values[4..7], &values[7..10]);
        let velocity = velocity.iter().map(|mps| format!("{:.7}", 3.6 * mps));
        let attitude = attitude.iter().map(|degrees| format!("{:.9}", degrees.to_radians()));
        let place = values[1..4].iter().map(|value| format!("{value:.10}"));
        let time = format!("{:.4}", 1000.0 * values[0]);
        let fields: Vec<String> =
            [time].into_iter().chain(place).chain(velocity).chain(attitude).collect();
        foreign += &(fields.join(";") + "\n");
    }
    let out = place("mapped");
    let file = out.join("theirs.csv");
    fs::write(&file, foreign).expect("writable");
    assert!(refusal(&["score", text(&file), HELI]).contains("hovernav init"));
    let mapped = out.join("theirs");
    let told = succeeds(&["init", text(&file), "--out", text(&mapped)]);
    assert!(told.contains("next: hovernav score"), "{told}");
    let (own, theirs) = (score(&[text(solution), HELI]), score(&[text(&mapped), HELI]));
    for axis in ["north_m", "east_m", "down_m", "vn_mps", "vd_mps", "roll_deg", "yaw_deg"] {
        let difference = rmse(&own, axis) - rmse(&theirs, axis);
        assert!(difference.abs() < 2e-4, "{axis} differs by {difference}");
    }
    let compared = out.join("compared");
    succeeds(&["compare", text(solution), text(&mapped), "--out", text(&compared)]);
    assert!(compared.join("report.html").exists());
}

#[test]
fn a_solution_can_go_down_a_pipe() {
    let out = place("piped");
    let tum =
        succeeds(&["estimate", HELI, "--no-report", "--out", text(&out), "--export", "tum,-"]);
    assert!(tum.lines().all(|line| line.starts_with('#') || line.split(' ').count() == 8));
    assert!(tum.lines().count() > 9_800);
}

#[track_caller]
fn runs(python: &Path, script: &str, out: &Path) -> String {
    let run = Command::new(python).args(["-c", script]).current_dir(out).output().expect("python");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).expect("text")
}

#[test]
fn evo_reads_the_trajectories() {
    let Some(python) = python(&["evo"]) else { return };
    let said = runs(
        &python,
        "from evo.tools import file_interface as f\n\
         from evo.core import metrics, sync\n\
         a = f.read_tum_trajectory_file('solution.tum')\n\
         b = f.read_euroc_csv_trajectory('solution.euroc.csv')\n\
         assert a.check()[0], a.check()\n\
         a, b = sync.associate_trajectories(a, b)\n\
         m = metrics.APE(metrics.PoseRelation.full_transformation)\n\
         m.process_data((a, b))\n\
         print(a.num_poses, m.get_statistic(metrics.StatisticsType.max))",
        exported(),
    );
    let numbers: Vec<f64> = said.split_whitespace().map(|n| n.parse().expect("a number")).collect();
    assert!(numbers[0] > 9_800.0 && numbers[1] < 1e-4, "{said}");
}

#[test]
fn the_mcap_reader_checks_every_message() {
    let Some(python) = python(&["mcap"]) else { return };
    let said = runs(
        &python,
        "import json\n\
         from mcap.reader import make_reader\n\
         r = make_reader(open('solution.mcap', 'rb'), validate_crcs=True)\n\
         s = r.get_summary()\n\
         names = {c.topic: s.schemas[c.schema_id].name for c in s.channels.values()}\n\
         last, n = 0, 0\n\
         for schema, channel, message in r.iter_messages():\n\
         \x20   assert message.log_time >= last; last = message.log_time; n += 1\n\
         \x20   d, w = json.loads(message.data), json.loads(schema.data)\n\
         \x20   assert set(d) == set(w['properties']), channel.topic\n\
         assert n == s.statistics.message_count\n\
         print(n, names['/fix'], names['/pose'], names['/tf'], names['/solution'])",
        exported(),
    );
    assert!(said.contains("foxglove.LocationFix foxglove.PoseInFrame"), "{said}");
    assert!(said.contains("foxglove.FrameTransform hovernav.Solution"), "{said}");
}

#[test]
fn maps_and_tables_are_what_their_formats_ask_for() {
    let Some(python) = python(&["pyarrow"]) else { return };
    let out = exported();
    runs(
        &python,
        "import xml.etree.ElementTree as E, csv\n\
         k = '{http://www.opengis.net/kml/2.2}'; g = '{http://www.google.com/kml/ext/2.2}'\n\
         t = E.parse('solution.kml').getroot().find(f'{k}Document/{k}Placemark/{g}Track')\n\
         n = [len(t.findall(x)) for x in (f'{k}when', f'{g}coord', f'{g}angles')]\n\
         assert n[0] == n[1] == n[2] > 1000, n\n\
         lon, lat, up = map(float, t.find(f'{g}coord').text.split())\n\
         x = '{http://www.topografix.com/GPX/1/1}'\n\
         p = E.parse('solution.gpx').getroot().findall(f'{x}trk/{x}trkseg/{x}trkpt')\n\
         assert abs(float(p[0].get('lat')) - lat) < 1e-7 and p[0].find(f'{x}time').text[-1] == 'Z'\n\
         rows = [l.split() for l in open('solution.pos') if l[0] != '%']\n\
         assert all(len(r) == 15 for r in rows) and abs(float(rows[0][2]) - lat) < 1e-7\n\
         c = list(csv.DictReader(open('solution.csv')))\n\
         assert list(c[0])[31] == 'q_w' and list(c[0])[-1] == 'var_yaw_rad2', list(c[0])",
        out,
    );
    if cfg!(feature = "parquet") {
        runs(
            &python,
            "import pyarrow.parquet as q, csv\n\
             t = q.read_table('solution.parquet').to_pydict()\n\
             c = list(csv.DictReader(open('solution.csv')))\n\
             for k in list(c[0])[:31]:\n\
             \x20   assert len(t[k]) == len(c)\n\
             \x20   assert all(abs(a - float(r[k])) < 6e-5 for a, r in zip(t[k], c)), k",
            out,
        );
    }
}

#[test]
fn solutions_lie_over_each_other() {
    let out = exported();
    let place = place("compared");
    let (to, smooth) = (place.join("compare"), place.join("smooth"));
    succeeds(&["estimate", HELI, "--smooth", "--no-report", "--out", text(&smooth)]);
    succeeds(&["compare", text(out), text(&smooth), "--out", text(&to)]);
    let summary = common::summary(&to);
    let differences = summary["differences"].as_array().expect("pairs");
    let north_m = differences[0]["difference"]["north_m"]["rmse"].as_f64().expect("a number");
    assert!(differences.len() == 1 && north_m > 0.0 && north_m < 2.0, "{summary}");
    let relative = &differences[0]["relative"];
    let size = |part: &str| relative[part]["rmse"].as_f64().expect("a number");
    assert!(size("translation_m") > 0.0 && size("translation_m") < 1.0, "{relative}");
    assert!(size("rotation_deg") > 0.0 && size("rotation_deg") < 5.0, "{relative}");
    let page = std::fs::read_to_string(to.join("report.html")).expect("a page");
    for drawn in ["data-figure=\"differences\"", "coloured by its distance from", "\"shade\":"] {
        assert!(page.contains(drawn), "{drawn}");
    }
    let (tum, euroc) = (out.join("solution.tum"), out.join("solution.euroc.csv"));
    succeeds(&["compare", text(out), text(&tum), "--out", text(&to)]);
    let by_itself = &common::summary(&to)["differences"][0]["difference"]["down_m"]["max"];
    assert!(by_itself.as_f64().expect("a number") < 1e-3, "{by_itself}");
    let refused = refusal(&["compare", text(out), text(&euroc), "--out", text(&to)]);
    assert!(refused.contains("expected --align"), "{refused}");
    let all = ["compare", text(out), text(&tum), text(&smooth), "--align", "--out", text(&to)];
    succeeds(&all);
    assert_eq!(common::summary(&to)["differences"].as_array().expect("pairs").len(), 3);
}
