//! Inertial samples that stay in their file give the same bits as samples in memory.

use std::fs;
use std::path::{Path, PathBuf};

use hovernav::time::Time;
use hovernav_dataset::{Dataset, Reference};
use hovernav_findings::{Finding, check_setup, findings};
use hovernav_replay::{Keep, Run, estimate_each, smooth};
use hovernav_testing::shared;

fn heli_hover() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/heli-hover")
}

/// The dataset with its samples in memory, and with all of them in their file.
fn both(log: &Path) -> [Dataset; 2] {
    let [whole, left] = [usize::MAX, 0].map(|most| Dataset::open_within(log, most).unwrap());
    assert!(whole.imu_file.is_none() && left.imu_file.is_some() && left.imu.is_empty());
    [whole, left]
}

/// Results that must be equal.
fn assert_same([whole, left]: &[Dataset; 2]) {
    assert_eq!(left.samples().collect::<Vec<_>>(), whole.imu);
    assert_eq!(left.warnings, whole.warnings);
    assert_eq!(left.sample_count(), whole.sample_count());
    assert_eq!(left.sample_span(), whole.sample_span());
    assert_eq!(left.sample_interval_s(), whole.sample_interval_s());
    assert_eq!(left.imu_rate_hz(), whole.imu_rate_hz());
    let setup =
        |log: &Dataset| check_setup(log).iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(setup(left), setup(whole));
    left.ensure_read().unwrap();
}

fn run(dataset: &mut Dataset) -> (Run, Vec<String>) {
    let config = dataset.settings().unwrap();
    let run = estimate_each(
        dataset,
        &config,
        Keep::Thinned,
        |_| {},
        |_| Ok::<(), std::convert::Infallible>(()),
    )
    .unwrap();
    let findings = findings(dataset, &run);
    (run, findings.into_iter().map(|Finding { words, .. }| words).collect())
}

#[test]
fn a_flight_is_the_same_to_the_last_bit() {
    let names = ["quad-gps-glitch-aided", "quad-ardupilot-5hz", "uav-thor75-1hz"];
    let logs = names.into_iter().filter_map(|name| shared(format!("datasets/{name}")));
    for log in logs.chain([heli_hover()]) {
        let mut both = both(&log);
        assert_same(&both);
        let [(whole, told), (left, told_of_left)] = both.each_mut().map(run);
        assert_eq!(left.solutions, whole.solutions);
        assert_eq!(left.notices, whole.notices);
        assert_eq!(told_of_left, told);
        both[1].ensure_read().unwrap();
    }
}

#[test]
fn smoothing_is_the_same_to_the_last_bit() {
    let mut both = both(&heli_hover());
    let [whole, left] = both.each_mut().map(|dataset| {
        let config = dataset.settings().unwrap();
        smooth(dataset, &config, |_| {})
    });
    assert!(whole.solutions.len() > 9_000);
    assert_eq!(left.solutions, whole.solutions);
}

/// The flight with every row of its samples replaced by `change` of the row and its number.
fn changed(change: impl Fn(usize, &str) -> String) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::copy(heli_hover().join("gps.csv"), place.path().join("gps.csv")).unwrap();
    let text = fs::read_to_string(heli_hover().join("imu.csv")).unwrap();
    let rows = text.lines().enumerate().map(|(number, row)| change(number, row));
    fs::write(place.path().join("imu.csv"), rows.collect::<String>()).unwrap();
    place
}

/// The replacement of a row, by its number.
type Change = Box<dyn Fn(usize, &str) -> String>;

fn later(row: &str, by_s: f64) -> String {
    let (time, rest) = row.split_once(',').unwrap();
    format!("{:.6},{rest}\n", time.parse::<f64>().unwrap() + by_s)
}

#[test]
fn a_damaged_file_is_mended_the_same_way() {
    let plain = |row: &str| format!("{row}\n");
    let damages: [(&str, Change); 7] = [
        (
            "a mark, blank lines and other line ends",
            Box::new(|number, row| match number {
                0 => format!("\u{feff}\n\n{row}\r\n"),
                _ if number % 100 == 3 => format!("\r\n{row}\r\n\n"),
                _ => format!("{row}\r\n"),
            }),
        ),
        (
            "rows with the time of the row before",
            Box::new(move |number, row| match number {
                0 => plain(row),
                _ if number % 7 == 0 => plain(row) + &plain(row),
                _ => plain(row),
            }),
        ),
        (
            "rows without values",
            Box::new(move |number, row| match number % 11 {
                5 => row.split(',').next().unwrap().to_owned() + ",,,,,,,,,\n",
                6 => "1,2\n".to_owned(),
                _ => plain(row),
            }),
        ),
        (
            "times that jump ahead and back",
            Box::new(move |number, row| match number {
                500 | 501 | 2000 => later(row, 30.0),
                3000..3020 => later(row, -20.0),
                _ => plain(row),
            }),
        ),
        (
            "rows hours from the rest",
            Box::new(move |number, row| match number {
                1..4 => later(row, -9_000.0),
                9_898.. => later(row, 9_000.0),
                _ => plain(row),
            }),
        ),
        (
            "a unit that was stuck, and a gap",
            Box::new(move |number, row| match number {
                0 => plain(row),
                4000..4100 => String::new(),
                5000..5040 => format!(
                    "{},0.1,0.2,0.3,0.4,0.5,-9.8,0,0,0,0.2,0.1,0.3\n",
                    row.split(',').next().unwrap()
                ),
                _ => plain(row),
            }),
        ),
        (
            "a last row that was cut off",
            Box::new(move |number, row| match number {
                9_899 => row[..20].to_owned(),
                _ => plain(row),
            }),
        ),
    ];
    for (what, change) in damages {
        println!("{what}");
        let place = changed(change);
        let mut both = both(place.path());
        assert_same(&both);
        let [(whole, told), (left, told_of_left)] = both.each_mut().map(run);
        assert_eq!((left.solutions, told_of_left), (whole.solutions, told));
    }
}

#[test]
fn other_axes_that_a_later_file_reports_turn_samples_in_a_file_too() {
    let place = tempfile::tempdir().unwrap();
    let config = place.path().join("mine.toml");
    fs::write(&config, "[imu]\naxes = \"flu\"\ngyro_unit = \"degps\"\n").unwrap();
    let mut both = both(&heli_hover());
    both.iter_mut().for_each(|dataset| dataset.configure(&config).unwrap());
    assert_same(&both);
}

#[test]
fn a_file_that_is_changed_in_use_is_reported() {
    let place = changed(|_, row| format!("{row}\n"));
    let path = place.path().join("imu.csv");
    let [_, dataset] = both(place.path());
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() / 2]).unwrap();
    let half = dataset.samples().count();
    assert!((4_000..6_000).contains(&half), "{half}");
    let error = dataset.ensure_read().unwrap_err().to_string();
    assert!(
        error.ends_with("imu.csv: found the file changed while in use, expected it unchanged"),
        "{error}"
    );
    fs::remove_file(&path).unwrap();
    assert_eq!(dataset.samples().count(), 0);
    assert!(dataset.ensure_read().is_err());
    // Rows appended by a logger after opening are ignored.
    fs::write(&path, format!("{text}400,0,0,0,0,0,-9.8,0,0,0,0.2,0.1,0.3\n")).unwrap();
    assert_eq!(dataset.samples().count(), 9_899);
    dataset.ensure_read().unwrap();
}

/// A dataset whose `file` contains `text`, with the flight's samples and fixes.
fn with(file: &str, text: &str) -> tempfile::TempDir {
    let place = changed(|_, row| format!("{row}\n"));
    fs::write(place.path().join(file), text).unwrap();
    place
}

/// `file` of the flight with every row replaced by `change` of the row and its number.
fn rows_of(file: &str, change: impl Fn(usize, &str) -> String) -> String {
    let text = fs::read_to_string(heli_hover().join(file)).unwrap();
    text.lines().enumerate().map(|(number, row)| change(number, row)).collect()
}

/// Faults of a table, as changes of its rows; its first column is the time.
fn damages() -> [Change; 4] {
    let plain = |row: &str| format!("{row}\n");
    [
        Box::new(move |_, row| plain(row)),
        Box::new(move |number, row| match number {
            0 => plain(row),
            _ if number % 7 == 0 => plain(row) + &plain(row),
            _ if number % 11 == 5 => {
                row.split(',').next().unwrap().to_owned() + &",".repeat(15) + "\n"
            }
            4000..4100 => String::new(),
            _ => plain(row),
        }),
        Box::new(move |number, row| match number {
            500 | 501 | 2000 => later(row, 30.0),
            3000..3020 => later(row, -20.0),
            _ => plain(row),
        }),
        Box::new(move |number, row| match number {
            1..4 => later(row, -9_000.0),
            _ => plain(row),
        }),
    ]
}

#[test]
fn sticks_in_their_file_are_those_in_memory() {
    for change in damages() {
        let place = with("controls.csv", &rows_of("controls.csv", change));
        let [whole, left] = both(place.path());
        assert!(left.controls.is_empty() && left.controls_file.is_some());
        assert!(whole.controls.len() > 8_000 && whole.controls_file.is_none());
        let mut found = Vec::new();
        left.each_control(|time, sticks| found.push((time, sticks))).unwrap();
        assert_eq!(found, whole.controls);
        assert_eq!(left.warnings, whole.warnings);
        let [one, other] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        whole.write(one.path(), &[]).unwrap();
        left.write(other.path(), &[]).unwrap();
        let [one, other] =
            [one, other].map(|dir| fs::read(dir.path().join("controls.csv")).unwrap());
        assert!(one == other);
    }
}

#[test]
fn sticks_that_are_changed_in_use_are_reported() {
    let text = rows_of("controls.csv", |_, row| format!("{row}\n"));
    let place = with("controls.csv", &text);
    let [_, left] = both(place.path());
    let path = place.path().join("controls.csv");
    fs::write(&path, format!("{text}400,0,0,0,0\n")).unwrap();
    let mut count = 0;
    left.each_control(|_, _| count += 1).unwrap();
    assert_eq!(count, 9_899);
    for half in [&text[..text.len() / 2], ""] {
        fs::write(&path, half).unwrap();
        assert!(left.each_control(|_, _| ()).is_err());
    }
    fs::remove_file(&path).unwrap();
    let error = left.each_control(|_, _| ()).unwrap_err().to_string();
    assert!(error.contains("controls.csv: found the file changed while in use"), "{error}");
}

#[test]
fn a_reference_read_for_some_moments_is_the_whole_one_there() {
    // Attitude once a second, velocity with a gap, and no velocity in body axes.
    let sparse: Change = Box::new(|number, row| {
        let mut fields: Vec<&str> = row.split(',').collect();
        if number > 0 {
            if number % 33 != 0 {
                fields[7..10].fill("");
            }
            if (2_000..2_100).contains(&number) {
                fields[4..7].fill("nan");
            }
            fields[10..13].fill("");
        }
        fields.join(",") + "\n"
    });
    for change in damages().into_iter().chain([sparse]) {
        let place = with("reference.csv", &rows_of("reference.csv", change));
        let manifest = Dataset::open(place.path()).unwrap().manifest;
        let whole = Reference::open(place.path(), &manifest).unwrap().unwrap();
        // Times on rows, between rows, in gaps, before the first row and after the last row.
        let times = |step_ns: i64| {
            (-500_000_000..310_000_000_000).step_by(step_ns as usize).map(Time::from_nanoseconds)
        };
        for moments in [times(30_303_030).collect(), times(5_000_000_000).collect(), Vec::new()] {
            let part = Reference::open_at(place.path(), &manifest, &moments).unwrap().unwrap();
            assert_eq!(part.warnings, whole.warnings);
            for moment in moments {
                let [a, b] = [&part, &whole].map(|reference| {
                    let at = reference.at(moment);
                    let all = [at.position, at.velocity_mps, at.attitude_rad, at.body_velocity_mps];
                    all.map(|of| of.map(f64::to_bits))
                });
                assert_eq!(a, b, "{moment}");
            }
        }
    }
}
