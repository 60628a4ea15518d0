//! Clocks of foreign loggers: repeated times, times out of order, times of day and of week.

use approx::assert_abs_diff_eq;
use hovernav_dataset::Dataset;

use crate::mapped::mapped;

const NAMES: &str = "gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z";

/// Different samples of an IMU at rest; `time` gives the time fields for a sample number.
fn unit(name: &str, time: impl Fn(u32) -> String) -> String {
    let rows = (0..6000).map(|k| {
        let noise = f64::from(k * 37 % 101) * 1e-3;
        let rates = format!("{:.4},{:.4},{:.4}", 0.01 * noise, -0.02 * noise, 0.03 * noise);
        format!(
            "{},{rates},{noise:.3},{:.3},{:.4}\n",
            time(k),
            0.2 - noise,
            -9.8 - 1e-5 * f64::from(k)
        )
    });
    format!("{name},{NAMES}\n{}", rows.collect::<String>())
}

/// Fixes at 4 Hz along a meridian; `time` gives the time fields for a fix number.
fn receiver(names: &str, time: impl Fn(u32) -> String) -> String {
    let rows = (0..240).map(|k| {
        let latitude_deg = 47.0 + 1e-5 * f64::from(k);
        format!("{},{latitude_deg:.7},8.5,410.25\n", time(k))
    });
    format!("{names},lat,lon,alt\n{}", rows.collect::<String>())
}

fn of_unit(text: String) -> (String, Dataset) {
    let (report, _, dataset) = mapped(&[("imu.csv", text)]);
    (report, dataset)
}

/// Time of day `milliseconds` after 23:58:30.5: hh, mm and ss, separated by `sign`, and the milliseconds.
fn of_day(milliseconds: u32, sign: &str) -> (String, u32) {
    let after = 86_310_500 + milliseconds;
    let (second, thousandths) = (after / 1000 % 86_400, after % 1000);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    (format!("{hour:02}{sign}{minute:02}{sign}{second:02}"), thousandths)
}

fn hhmmss(milliseconds: u32) -> String {
    let (whole, thousandths) = of_day(milliseconds, "");
    format!("{whole}.{thousandths:03}")
}

#[test]
fn repeated_times_are_read_and_reported() {
    let second = |k: u32| f64::from(k) * 0.01;
    for (what, text, samples, rows) in [
        ("every row twice", unit("time_s", |k| format!("{:.2}", second(k))), 6000, 2),
        ("batches of 4", unit("time_s", |k| format!("{:.2}", second(k / 4 * 4))), 1500, 4),
        ("batches of 10", unit("time_ms", |k| format!("{}", k / 10 * 100)), 600, 10),
        ("tenths", unit("t", |k| format!("{:.1}", f64::from(k / 10) * 0.1)), 600, 10),
    ] {
        let twice = |text: String| -> String {
            let mut lines = text.lines();
            let names = lines.next().unwrap_or_default();
            format!(
                "{names}\n{}",
                lines.map(|line| format!("{line}\n{line}\n")).collect::<String>()
            )
        };
        let text = if samples == 6000 { twice(text) } else { text };
        let (report, dataset) = of_unit(text);
        assert_eq!(dataset.imu.len(), samples, "{what}\n{report}");
        let span_s = dataset.imu[samples - 1].time - dataset.imu[0].time;
        assert!((59.8..60.0).contains(&span_s), "{what}: {span_s} s\n{report}");
        assert!(report.contains(&format!("repeats, typically on {rows} rows")), "{what}\n{report}");
    }
}

#[test]
fn a_clock_of_whole_seconds_is_read_but_too_coarse() {
    let (report, _, dataset) = mapped(&[
        ("imu.csv", unit("time", |k| of_day(10 * k, ":").0)),
        ("gps.csv", receiver("time", |k| of_day(250 * k, ":").0)),
    ]);
    assert_eq!(dataset.imu.len(), 61, "{report}");
    assert!(report.contains("repeats, typically on 100 rows"), "{report}");
    assert!(report.contains("inertial samples: found 1.0 Hz, expected at least"), "{report}");
}

#[test]
fn rows_out_of_order_are_reported_and_sorted_in() {
    // Two of every four rows are exchanged.
    let swapped = |k: u32| if k % 4 < 2 { k ^ 1 } else { k };
    let text = unit("time_s", |k| format!("{:.2}", f64::from(swapped(k)) * 0.01));
    let (report, dataset) = of_unit(text);
    assert_eq!(dataset.imu.len(), 6000, "{report}");
    assert!(report.contains("time time_s of imu.csv goes back on 1500 rows"), "{report}");
}

#[test]
fn times_of_day_as_one_number_continue_past_minutes_and_midnight() {
    let (report, mapping, dataset) = mapped(&[
        ("imu.csv", unit("utc", |k| hhmmss(10 * k))),
        ("gps.csv", receiver("time_s", |k| hhmmss(250 * k))),
    ]);
    assert_eq!((dataset.imu.len(), dataset.fixes.len()), (6000, 240), "{report}");
    assert_eq!(mapping.matches("unit = \"hhmmss\"").count(), 2, "{mapping}");
    let [imu_s, gps_s] = [
        dataset.imu[5999].time - dataset.imu[0].time,
        dataset.fixes[239].time - dataset.fixes[0].time,
    ];
    assert_abs_diff_eq!(imu_s, 59.99, epsilon = 1e-6);
    assert_abs_diff_eq!(gps_s, 59.75, epsilon = 1e-6);
}

#[test]
fn a_column_of_dates_can_be_the_time() {
    let dated = |k: u32| {
        let (time, thousandths) = of_day(10 * k, ":");
        format!("2025-07-08 {time}.{thousandths:03}")
    };
    let (report, dataset) = of_unit(unit("date", dated));
    assert_eq!(dataset.imu.len(), 6000, "{report}");
}

#[test]
fn seconds_beyond_hundreds_are_not_times_of_day() {
    let (_, mapping, _) =
        mapped(&[("imu.csv", unit("utc", |k| format!("{:.2}", f64::from(k) * 0.01)))]);
    assert!(mapping.contains("unit = \"s\""), "{mapping}");
}

#[test]
fn dates_and_weeks_match_a_receiver_to_the_clock_of_the_imu() {
    // Both are 2025-07-08T23:58:30.5Z; GPS time is 18 s ahead.
    let unix_ms = 1_752_019_110_500_u64;
    let gps_ms = unix_ms - 315_964_800_000 + 18_000;
    let week = |k: u32| gps_ms + 250 * u64::from(k);
    let dated = |k: u32| {
        let day = if of_day(250 * k, "").0.starts_with('0') { 9 } else { 8 };
        (hhmmss(250 * k), day)
    };
    for (what, gps) in [
        ("ddmmyy", receiver("utc_time,date", |k| format!("{},{}0725", dated(k).0, dated(k).1))),
        ("signs", receiver("date,utc", |k| format!("2025-07-0{},{}", dated(k).1, dated(k).0))),
        (
            "week",
            receiver("week,tow_s", |k| {
                let of_week = week(k) % 604_800_000;
                format!("{},{}.{:03}", week(k) / 604_800_000, of_week / 1000, of_week % 1000)
            }),
        ),
    ] {
        let imu = unit("unix_ms", |k| (unix_ms + 10 * u64::from(k)).to_string());
        let (report, _, dataset) = mapped(&[("imu.csv", imu), ("gps.csv", gps)]);
        assert_eq!(dataset.fixes.len(), 240, "{what}\n{report}");
        for (at, fix) in [(0, &dataset.fixes[0]), (5975, &dataset.fixes[239])] {
            let apart_s = fix.time - dataset.imu[at].time;
            assert!(apart_s.abs() < 1e-6, "{what}: {apart_s} s apart\n{report}");
        }
        assert!(!report.contains("do not overlap in time"), "{what}\n{report}");
    }
}

#[test]
fn a_date_in_only_one_file_does_not_separate_the_files() {
    let shown = |milliseconds: u32| {
        let (time, thousandths) = of_day(milliseconds, ":");
        format!("{time}.{thousandths:03}")
    };
    let of_week = |milliseconds: u32| format!("{:.2}", 244_788.0 + f64::from(milliseconds) * 1e-3);
    for (what, imu, gps) in [
        (
            "date",
            unit("time", |k| shown(10 * k)),
            receiver("date,time", |k| format!("080725,{}", shown(250 * k))),
        ),
        (
            "week",
            unit("tow_s", |k| of_week(10 * k)),
            receiver("week,tow_s", |k| format!("2374,{}", of_week(250 * k))),
        ),
    ] {
        let (report, _, dataset) = mapped(&[("imu.csv", imu), ("gps.csv", gps)]);
        let apart_s = dataset.fixes[0].time - dataset.imu[0].time;
        assert!(apart_s.abs() < 1e-6, "{what}: {apart_s}\n{report}");
        let told = format!("the files overlap in time only without {what}, which is ignored");
        assert!(report.contains(&told), "{report}");
    }
}

#[test]
fn days_of_spreadsheets_and_of_matlab_are_times() {
    let of_day = |k: u32| (36_000.0 + 0.01 * f64::from(k)) / 86_400.0;
    for (names, unit_name, time, began_s) in [
        (
            "time",
            "excel",
            &(|k| format!("{:.10}", 45_416.0 + of_day(k))) as &dyn Fn(u32) -> String,
            1_714_816_800.0,
        ),
        ("date", "excel", &|k| format!("{:.10}", 45_416.0 + of_day(k)), 1_714_816_800.0),
        ("date,time", "days", &|k| format!("45416,{:.12}", of_day(k)), 1_714_816_800.0),
        ("time", "days", &|k| format!("{:.12}", of_day(k)), 36_000.0),
        ("t", "datenum", &|k| format!("{:.9}", 739_376.0 + of_day(k)), 1_714_816_800.0),
        ("mjd", "mjd", &|k| format!("{:.10}", 60_434.0 + of_day(k)), 1_714_816_800.0),
    ] {
        let (report, dataset) = of_unit(unit(names, time));
        assert_eq!(dataset.imu.len(), 6000, "{names}: {report}");
        assert_abs_diff_eq!(dataset.imu[0].time.seconds(), began_s, epsilon = 1e-4);
        assert_abs_diff_eq!(dataset.imu[100].time - dataset.imu[0].time, 1.0, epsilon = 1e-3);
        assert!(report.contains(&format!("  {unit_name}\n")), "{names}: {report}");
    }
}

#[test]
fn the_second_after_a_leap_second_follows_it() {
    // Labels of the milliseconds after 2016-12-31T23:59:30, with the leap second at its end.
    let label = |milliseconds: u32, day: bool, sign: &str| {
        let (second, thousandths) = (milliseconds / 1000, milliseconds % 1000);
        let (date, hour, minute, second) = match second {
            0..=29 => ("2016-12-31", 23, 59, second + 30),
            30 => ("2016-12-31", 23, 59, 60),
            _ => ("2017-01-01", 0, (second - 31) / 60, (second - 31) % 60),
        };
        let date = if day { format!("{date}T") } else { String::new() };
        format!("{date}{hour:02}{sign}{minute:02}{sign}{second:02}.{thousandths:03}")
    };
    for (what, dated, sign) in
        [("dates", true, ":"), ("times of day", false, ":"), ("hhmmss", false, "")]
    {
        for interval_ms in [250, 1000] {
            let (report, _, dataset) = mapped(&[
                ("imu.csv", unit("utc", |k| label(10 * k, dated, sign))),
                ("gps.csv", receiver("utc", |k| label(interval_ms * k, dated, sign))),
            ]);
            let what = format!("{what}, fixes every {interval_ms} ms");
            assert_eq!((dataset.imu.len(), dataset.fixes.len()), (6000, 240), "{what}\n{report}");
            for (k, fix) in dataset.fixes.iter().enumerate() {
                let off_s =
                    fix.time - dataset.imu[0].time - 1e-3 * f64::from(interval_ms) * k as f64;
                assert!(off_s.abs() < 1e-6, "{what}: fix {k} is {off_s} s off\n{report}");
            }
            assert_abs_diff_eq!(
                dataset.imu[5999].time - dataset.imu[0].time,
                59.99,
                epsilon = 1e-6
            );
        }
    }
}

#[test]
fn the_time_of_rtklib_is_converted_from_the_scale_that_its_header_names() {
    // 2024-05-05T10:00:00Z; GPS time is 18 s ahead.
    let unix_ms = 1_714_903_200_000_u64;
    let imu = || unit("unix_ms", |k| (unix_ms + 10 * u64::from(k)).to_string());
    for (what, scale, ahead_s, of_week) in [
        ("dates in UTC", "UTC", 0, false),
        ("dates", "GPST", 18, false),
        ("weeks", "GPST", 18, true),
    ] {
        let rows = (0..240).map(|k: u32| {
            let after_ms = 250 * k + 1000 * ahead_s;
            let time = match of_week {
                true => format!("2313 {:.3}", 36_000.0 + 1e-3 * f64::from(after_ms)),
                false => format!(
                    "2024/05/05 10:{:02}:{:02}.{:03}",
                    after_ms / 60_000,
                    after_ms / 1000 % 60,
                    after_ms % 1000
                ),
            };
            let latitude_deg = 47.0 + 1e-5 * f64::from(k);
            format!("{time}  {latitude_deg:.9}  8.500000000  410.2500   1  12   0.5  0.5   0.75\n")
        });
        let text = format!(
            "% program   : RTKLIB\n%  {scale}  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   \
             sdu(m)\n{}",
            rows.collect::<String>()
        );
        let (report, mapping, dataset) = mapped(&[("imu.csv", imu()), ("rover.pos", text)]);
        assert_eq!(dataset.fixes.len(), 240, "{what}\n{report}");
        let apart_s = dataset.fixes[200].time - dataset.imu[5000].time;
        assert!(apart_s.abs() < 1e-6, "{what}: {apart_s} s apart\n{report}\n{mapping}");
        assert!(!report.contains("check: time"), "{what}\n{report}");
    }
}

/// Two minutes along a circle at 5 m/s, `per_s` rows a second, with the time in `unit_s`.
fn circle(names: &str, per_s: u32, unit_s: f64) -> String {
    let rows = (0..120 * per_s).map(|k| {
        let time_s = f64::from(k) / f64::from(per_s);
        let (east, north) = (0.1 * time_s).sin_cos();
        let (lat, lon) = (47.0 + 50.0 * east / 111_170.0, 8.0 - 50.0 * north / 76_030.0);
        format!(
            "{:.0},{lat:.9},{lon:.9},410.0,{:.4},{:.4}\n",
            time_s / unit_s,
            5.0 * north,
            5.0 * east
        )
    });
    format!("{names}\n{}", rows.collect::<String>())
}

#[test]
fn the_unit_of_a_fast_time_without_an_imu_is_that_in_which_the_vehicle_moves() {
    for per_s in [50, 100, 200, 400] {
        for (name, unit_s) in [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)] {
            let (report, mapping, dataset) =
                mapped(&[("gps.csv", circle("time,lat,lon,height,vn,ve", per_s, unit_s))]);
            let span_s = dataset.fixes[dataset.fixes.len() - 1].time - dataset.fixes[0].time;
            assert!(
                (119.9..120.0).contains(&span_s),
                "{per_s} Hz in {name}: {span_s} s\n{report}\n{mapping}"
            );
        }
    }
}

#[test]
fn the_unit_of_a_fast_time_is_that_of_an_epoch_or_that_in_which_files_overlap() {
    let field = |start: u64, per_row: u64| {
        let rows = (0..6000_u64).map(|k| {
            let (y, x) = (1e-3 * k as f64).sin_cos();
            format!("{},{:.4},{:.4},0.43\n", start + per_row * k, 0.2 * x, -0.2 * y)
        });
        format!("time,mag_x,mag_y,mag_z\n{}", rows.collect::<String>())
    };
    for (what, imu, start, per_row, unit_of) in [
        ("epoch", "1714903200", 1_714_903_200_000_000_000, 10_000_000, "ns"),
        ("epoch", "1714903200", 1_714_903_200_000, 10, "ms"),
        ("overlap", "0", 0, 10, "ms"),
        ("overlap", "100", 100_000_000, 10_000, "us"),
    ] {
        let start_s: f64 = imu.parse().unwrap();
        let imu = unit("time_s", |k| format!("{:.2}", start_s + 0.01 * f64::from(k)));
        let (report, mapping, dataset) =
            mapped(&[("imu.csv", imu), ("mag.csv", field(start, per_row))]);
        assert!(mapping.contains(&format!("unit = \"{unit_of}\"")), "{what}\n{mapping}");
        assert_eq!(dataset.magnetometer.len(), 6000, "{what}\n{report}");
    }
    let (report, ..) = mapped(&[
        ("imu.csv", unit("t_s", |k| format!("{:.2}", 5e5 + 0.01 * f64::from(k)))),
        ("mag.csv", field(0, 10)),
    ]);
    let asked = "rows are 0.0100 s apart if it is in ms, as read, or 10.0000 s if it is in s";
    assert!(report.contains(asked), "{report}");
}
