//! Foreign text files: a mapped and estimated file gives the solution of the original.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use approx::assert_abs_diff_eq;
use hovernav::ekf::Solution;
use hovernav_dataset::Dataset;
use hovernav_formats::{Format, Options, Proposal, open};
use hovernav_replay::estimate;

const ORIGINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../datasets/heli-hover");

/// Format in which a foreign logger writes the same flight.
#[derive(Clone, Copy)]
struct Foreign {
    delimiter: &'static str,
    decimal_comma: bool,
    /// Units are degrees, g, milliseconds and microtesla.
    other_units: bool,
    forward_left_up: bool,
    /// The attitude is from forward-left-up to east-north-up.
    attitude_enu: bool,
    header: bool,
    remarks: bool,
    /// Each sensor has a separate file.
    apart: bool,
}

const PLAIN: Foreign = Foreign {
    delimiter: ",",
    decimal_comma: false,
    other_units: true,
    forward_left_up: true,
    attitude_enu: false,
    header: true,
    remarks: false,
    apart: false,
};

fn rows(file: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(Path::new(ORIGINAL).join(file)).unwrap();
    text.lines().skip(1).map(|l| l.split(',').map(|f| f.parse().unwrap()).collect()).collect()
}

impl Foreign {
    /// Writes the flight to `directory` and returns its files.
    fn write(&self, directory: &Path) -> Vec<PathBuf> {
        let flip = if self.forward_left_up { -1.0 } else { 1.0 };
        let (rate, force, field) = if self.other_units {
            (1f64.to_degrees(), 1.0 / 9.80665, 100.0)
        } else {
            (1.0, 1.0, 1.0)
        };
        let imu_names = "gx gy gz ax ay az roll pitch yaw mx my mz";
        let gps_names = "lat lon height vn ve vd sigma_h sigma_v sigma_vh sigma_vv";
        let imu = rows("imu.csv").into_iter().map(|row| {
            let mut values = vec![row[1] * rate, row[2] * flip * rate, row[3] * flip * rate];
            values.extend([row[4] * force, row[5] * flip * force, row[6] * flip * force]);
            match self.attitude_enu {
                true => values.extend([row[7], -row[8], 90.0 - row[9]]),
                false => values.extend(&row[7..10]),
            }
            values.extend([row[10] * field, row[11] * flip * field, row[12] * flip * field]);
            (row[0], values)
        });
        let gps = rows("gps.csv").into_iter().map(|row| (row[0], row[1..].to_vec()));
        if self.apart {
            let (imu, gps): (Vec<_>, Vec<_>) = (imu.collect(), gps.collect());
            return vec![
                self.table(directory, "imu.csv", imu_names, &imu),
                self.table(directory, "gps.csv", gps_names, &gps),
            ];
        }
        let wide = |before: usize, values: Vec<f64>, after: usize| -> Vec<f64> {
            [vec![f64::NAN; before], values, vec![f64::NAN; after]].concat()
        };
        let mut all: Vec<(f64, Vec<f64>)> = imu.map(|(t, v)| (t, wide(0, v, 10))).collect();
        all.extend(gps.map(|(t, v)| (t, wide(12, v, 0))));
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        vec![self.table(directory, "flight.csv", &format!("{imu_names} {gps_names}"), &all)]
    }

    fn table(
        &self,
        directory: &Path,
        name: &str,
        names: &str,
        rows: &[(f64, Vec<f64>)],
    ) -> PathBuf {
        let mut text = String::new();
        if self.remarks {
            text.push_str("# a logger's remark\n# and another; with signs, in it\n");
        }
        if self.header {
            let time = if self.other_units { "time_ms" } else { "t" };
            let names: Vec<&str> = [time].into_iter().chain(names.split(' ')).collect();
            let _ = writeln!(text, "{}", names.join(self.delimiter));
        }
        for (time, values) in rows {
            let time = if self.other_units { 1000.0 * time } else { *time };
            let mut row = vec![format!("{time:.5}")];
            let shown =
                |value: &f64| if value.is_nan() { String::new() } else { value.to_string() };
            row.extend(values.iter().map(shown));
            let mut line = row.join(self.delimiter);
            if self.decimal_comma {
                line = line.replace('.', ",");
            }
            let _ = writeln!(text, "{line}");
        }
        let path = directory.join(name);
        fs::write(&path, text).unwrap();
        path
    }
}

fn solutions(mut dataset: Dataset) -> Vec<Solution> {
    let config = dataset.settings().unwrap();
    estimate(&dataset, &config, |_| {}).solutions
}

/// The dataset from a proposed mapping of `foreign`, with the original's manifest.
fn mapped(foreign: Foreign) -> (Dataset, String) {
    let place = tempfile::tempdir().unwrap();
    let files = foreign.write(place.path());
    let proposal = Proposal::of(&files).unwrap();
    let out = place.path().join("mapped");
    fs::create_dir(&out).unwrap();
    fs::copy(Path::new(ORIGINAL).join("dataset.toml"), out.join("dataset.toml")).unwrap();
    proposal.write(&out, false).unwrap();
    (open(&out, &Options::default()).unwrap().dataset, proposal.to_string())
}

#[test]
fn every_foreign_format_gives_the_solution_of_the_original() {
    let original = solutions(Dataset::open(ORIGINAL.as_ref()).unwrap());
    for (what, foreign) in [
        ("degrees, g, milliseconds, forward-left-up", PLAIN),
        ("semicolons, decimal commas", Foreign { delimiter: ";", decimal_comma: true, ..PLAIN }),
        ("tabs, remarks", Foreign { delimiter: "\t", remarks: true, ..PLAIN }),
        ("ENU attitude", Foreign { attitude_enu: true, ..PLAIN }),
        ("own units", Foreign { other_units: false, ..PLAIN }),
        ("forward-right-down", Foreign { forward_left_up: false, ..PLAIN }),
        ("two files", Foreign { apart: true, ..PLAIN }),
        (
            "two files, decimal commas",
            Foreign { apart: true, delimiter: "\t", decimal_comma: true, ..PLAIN },
        ),
    ] {
        let (dataset, report) = mapped(foreign);
        let found = solutions(dataset);
        assert_eq!(found.len(), original.len(), "{what}\n{report}");
        for (a, b) in found.iter().zip(&original) {
            assert_eq!(a.time, b.time, "{what}");
            let apart_m = a.position.displacement_from(&b.position).norm();
            let apart_mps = (a.velocity_mps - b.velocity_mps).norm();
            let turn = (a.body_to_ned.inverse() * b.body_to_ned).rotation_vector().norm();
            assert!(
                apart_m < 1e-4 && apart_mps < 1e-5 && turn < 1e-5,
                "{what}: {apart_m} {report}"
            );
        }
    }
}

#[test]
fn a_manifest_next_to_a_mapping_corrects_a_tilted_imu() {
    let manifest = "[imu]\naxes = \"flu\"\nmounting_deg = [2.0, 12.5, -30.0]\n";
    let place = tempfile::tempdir().unwrap();
    for file in ["imu.csv", "gps.csv"] {
        fs::copy(Path::new(ORIGINAL).join(file), place.path().join(file)).unwrap();
    }
    fs::write(place.path().join("dataset.toml"), manifest).unwrap();
    let expected = Dataset::open(place.path()).unwrap();
    let files = Foreign { forward_left_up: false, apart: true, ..PLAIN }.write(place.path());
    let out = place.path().join("mapped");
    Proposal::of(&files).unwrap().write(&out, false).unwrap();
    fs::write(out.join("dataset.toml"), manifest).unwrap();
    let found = open(&out, &Options::default()).unwrap().dataset;
    assert_eq!(found.imu.len(), expected.imu.len());
    for (a, b) in found.imu.iter().zip(&expected.imu) {
        let (a, b) = (a.motion.mean_rates(1.0), b.motion.mean_rates(1.0));
        let turn = (a.angular_rate_radps - b.angular_rate_radps).norm();
        let force = (a.specific_force_mps2 - b.specific_force_mps2).norm();
        assert!(turn < 1e-9 && force < 1e-9, "{turn} {force}");
    }
    // The written dataset is already in body axes and is not converted again.
    let written = place.path().join("written");
    fs::create_dir(&written).unwrap();
    found.write(&written, &[]).unwrap();
    let again = Dataset::open(&written).unwrap();
    let force = |dataset: &Dataset| dataset.imu[500].motion.mean_rates(1.0).specific_force_mps2;
    assert!((force(&again) - force(&found)).norm() < 1e-6);
}

#[test]
fn the_fixes_reveal_accelerometers_with_the_opposite_sign() {
    // The axes are forward-right-down with positive gravity; at rest this equals forward-left-up.
    let place = tempfile::tempdir().unwrap();
    let files = Foreign { apart: true, forward_left_up: false, ..PLAIN }.write(place.path());
    let text = fs::read_to_string(&files[0]).unwrap();
    let mut lines = text.lines();
    let mut reversed = format!("{}\n", lines.next().unwrap());
    for line in lines {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        for field in &mut fields[4..7] {
            *field = (-field.parse::<f64>().unwrap()).to_string();
        }
        reversed.push_str(&fields.join(","));
        reversed.push('\n');
    }
    fs::write(&files[0], reversed).unwrap();
    let out = place.path().join("mapped");
    let proposal = Proposal::of(&files).unwrap();
    proposal.write(&out, false).unwrap();
    let mapping = fs::read_to_string(out.join("mapping.toml")).unwrap();
    assert!(mapping.contains("axes = [\"-x\", \"-y\", \"-z\"]"), "{mapping}\n{proposal}");
}

#[test]
fn a_mapping_applies_to_a_foreign_imu_csv() {
    let place = tempfile::tempdir().unwrap();
    let files = Foreign { apart: true, ..PLAIN }.write(place.path());
    Proposal::of(&files).unwrap().write(place.path(), false).unwrap();
    let log = open(place.path(), &Options::default()).unwrap();
    assert_eq!((log.format, log.dataset.imu.len()), (Format::Text, imu_rows()));
    for file in ["imu.csv", "gps.csv"] {
        fs::copy(Path::new(ORIGINAL).join(file), place.path().join(file)).unwrap();
    }
    assert_eq!(open(place.path(), &Options::default()).unwrap().format, Format::Dataset);
}

#[test]
fn a_latitude_beyond_any_latitude_is_a_longitude() {
    let place = tempfile::tempdir().unwrap();
    let files = Foreign { apart: true, ..PLAIN }.write(place.path());
    let text = fs::read_to_string(&files[1]).unwrap();
    fs::write(&files[1], text.replacen("lat,lon", "lon,lat", 1)).unwrap();
    let proposal = Proposal::of(&files).unwrap();
    let told = "check: gps: lat reaches 103.8°, more than any latitude, and lon does not";
    assert!(proposal.to_string().contains(told), "{proposal}");
    let out = place.path().join("mapped");
    proposal.write(&out, false).unwrap();
    let dataset = open(&out, &Options::default()).unwrap().dataset;
    let original = Dataset::open(ORIGINAL.as_ref()).unwrap();
    assert_eq!(dataset.fixes[0].position, original.fixes[0].position);
}

#[test]
fn numbers_in_quotes_may_have_decimal_commas() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("log.csv");
    let mut text = String::from("\"clock\",\"gx\",\"gy\",\"gz\",\"ax\",\"ay\",\"az\"\n");
    for k in 0..200 {
        // Midnight is in the middle of the log.
        let (of_day, hundredths) = ((86_399 + k / 100) % 86_400, k % 100);
        let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
        let _ = write!(text, "\"{hour:02}:{minute:02}:{second:02},{hundredths:02}\",");
        let _ = writeln!(text, "\"0,01\",\"-0,02\",\"0,03\",\"0,1\",\"0,2\",\"-9,{k}\"");
    }
    fs::write(&file, text).unwrap();
    let out = place.path().join("mapped");
    Proposal::of(&[file]).unwrap().write(&out, false).unwrap();
    let imu = open(&out, &Options::default()).unwrap().dataset.imu;
    assert_eq!(imu.len(), 200);
    assert_abs_diff_eq!(imu[199].time - imu[0].time, 1.99, epsilon = 1e-9);
    let force = imu[150].motion.mean_rates(0.01).specific_force_mps2;
    assert_eq!(force.to_array(), [0.1, 0.2, -9.15]);
}

#[test]
fn an_existing_mapping_is_not_overwritten_without_force() {
    let place = tempfile::tempdir().unwrap();
    let files = Foreign { apart: true, ..PLAIN }.write(place.path());
    let proposal = Proposal::of(&files).unwrap();
    let out = place.path().join("mapped");
    proposal.write(&out, false).unwrap();
    fs::write(out.join("dataset.toml"), "name = \"mine\"\n").unwrap();
    let refusal = proposal.write(&out, false).unwrap_err().to_string();
    assert!(refusal.contains("mapping.toml") && refusal.contains("--force"), "{refusal}");
    proposal.write(&out, true).unwrap();
    assert_eq!(fs::read_to_string(out.join("dataset.toml")).unwrap(), "name = \"mine\"\n");
}

#[test]
fn errors_of_unmappable_files_have_a_reason_and_a_line() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("log.csv");
    let refused = |text: &str| {
        fs::write(&file, text).unwrap();
        Proposal::of(std::slice::from_ref(&file)).unwrap_err().to_string()
    };
    assert!(refused("").contains("fewer than two columns"));
    assert!(refused("hello\nworld\n").contains("fewer than two columns"));
    assert!(refused("t,foo\n1,2\n2,3\n").contains("no gyro"), "{}", refused("t,foo\n1,2\n2,3\n"));
    let still = refused("ax,ay,az,gx,gy,gz\n1,1,9,0,0,0\n1,1,9,0,0,0\n");
    assert!(still.contains("increases like a time"), "{still}");
    assert!(refused(&"1".repeat(100_000)).contains("longer than"));
    assert!(
        refused("FMT, 128, 89, FMT, BBnNZ, Type\n").contains("DataFlash log, text, which needs no")
    );
    fs::write(&file, b"\xff\xfet\0,\0x\0\n\0").unwrap();
    let wide = Proposal::of(std::slice::from_ref(&file)).unwrap_err().to_string();
    assert!(wide.contains("found text in UTF-16: save it as UTF-8 first"), "{wide}");

    // A second recording follows the first; the error names the file and the line.
    let rows = |from: u32| -> String {
        (from..from + 50).map(|k| format!("{k},0,0,0,0,0,-9.8\n")).collect()
    };
    let twice = refused(&format!("t,gx,gy,gz,ax,ay,az\n{}{}", rows(0), rows(0)));
    assert!(twice.contains("log.csv:52: time goes back"), "{twice}");

    fs::write(&file, "t,x\n1,2\n").unwrap();
    let bare = open(&file, &Options::default()).unwrap_err().to_string();
    assert!(bare.contains("hovernav init"), "{bare}");

    let mapping = place.path().join("mapping.toml");
    let opened = |text: &str| {
        fs::write(&mapping, text).unwrap();
        open(place.path(), &Options::default()).map(|log| log.dataset).unwrap_err().to_string()
    };
    let table = "[[table]]\nfile = 'log.csv'\nheader_line = 1\n[table.time]\ncolumn = 't'\n";
    let baro = |column: &str| format!("{table}[table.baro]\ncolumn = '{column}'\n");
    assert!(opened(&baro("y")).contains("log.csv:1: expected column y"));
    let axes = format!(
        "{table}[table.gyro]\ncolumns = ['x', 'x', 'x']\nunit = 'rad/s'\naxes = ['x', 'x', 'z']\n"
    );
    assert!(opened(&axes).contains("each of x, y and z once"), "{}", opened(&axes));
    let no_file = "[[table]]\nfile = 'none.csv'\n[table.time]\ncolumn = 't'\n";
    assert!(opened(no_file).contains("none.csv"));
}

/// The columns have no names, as in KF-GINS and NaveGo.
#[test]
fn files_without_names_are_mapped_by_their_values() {
    let original = solutions(Dataset::open(ORIGINAL.as_ref()).unwrap());
    let (imu, gps) = (rows("imu.csv"), rows("gps.csv"));
    let text = |rows: Vec<Vec<f64>>| -> String {
        let line =
            |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join("  ") + "\n";
        rows.iter().map(line).collect()
    };
    let mut before = imu[0][0] - 0.0303;
    let increments = imu.iter().map(|row| {
        let interval = row[0] - before;
        before = row[0];
        let mut values = vec![604_700.0 + row[0]];
        values.extend(row[1..7].iter().map(|value| value * interval));
        values
    });
    let kf_imu = text(increments.collect());
    let kf_gnss = gps.iter().map(|r| vec![604_700.0 + r[0], r[1], r[2], r[3], r[7], r[7], r[8]]);
    let navego_imu = imu.iter().map(|r| vec![r[0], r[4], r[5], r[6], r[1], r[2], r[3]]);
    let navego_gnss = gps
        .iter()
        .map(|r| vec![r[0], r[1].to_radians(), r[2].to_radians(), r[3], r[4], r[5], r[6]]);
    for (what, imu, gnss) in [
        ("KF-GINS", kf_imu, text(kf_gnss.collect())),
        ("NaveGo", text(navego_imu.collect()), text(navego_gnss.collect())),
    ] {
        let place = tempfile::tempdir().unwrap();
        let files = ["imu.txt", "gnss.txt"].map(|name| place.path().join(name));
        fs::write(&files[0], imu).unwrap();
        fs::write(&files[1], gnss).unwrap();
        let proposal = Proposal::of(&files).unwrap();
        let out = place.path().join("mapped");
        proposal.write(&out, false).unwrap();
        fs::copy(Path::new(ORIGINAL).join("dataset.toml"), out.join("dataset.toml")).unwrap();
        let dataset = open(&out, &Options::default()).unwrap().dataset;
        assert_eq!(
            (dataset.imu.len(), dataset.fixes.len()),
            (imu_rows(), 299),
            "{what}\n{proposal}"
        );
        let found = solutions(dataset);
        // Without the IMU's attitude the heading is found in flight. From then on the solutions agree.
        let (Some(a), Some(b)) = (found.last(), original.last()) else { panic!("{what}") };
        let apart_m = a.position.displacement_from(&b.position).norm();
        let turn = (a.body_to_ned.inverse() * b.body_to_ned).rotation_vector().norm();
        assert!(apart_m < 3.0 && turn < 0.2, "{what}: {apart_m} m, {turn} rad\n{proposal}");
    }
}

fn imu_rows() -> usize {
    rows("imu.csv").len()
}
