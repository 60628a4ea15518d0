//! Clocks that step and counters that start again, in every format.

use std::fmt::Write as _;
use std::fs;

use hovernav_dataset::Dataset;
use hovernav_formats::{Options, Proposal, open};

use crate::alike::{FORMATS, Flight, warns, written};

/// Checks that all samples and the fixes with these numbers are in `dataset`. Each fix must follow its sample by the
/// same time as the first fix does.
fn are_together(dataset: &Dataset, fixes: &[usize], what: &str) {
    let counts = (dataset.imu.len(), dataset.fixes.len());
    assert_eq!(counts, (1000, fixes.len()), "{what}: {:?}", dataset.warnings);
    let apart_s: Vec<f64> = fixes
        .iter()
        .zip(&dataset.fixes)
        .map(|(number, fix)| fix.time - dataset.imu[50 * number].time)
        .collect();
    let is_alike = |later_s: &f64| (later_s - apart_s[0]).abs() < 0.002;
    assert!(apart_s.iter().all(is_alike) && apart_s[0].abs() < 0.2, "{what}: {apart_s:?} s");
}

/// A flight whose clock goes forward by `by_s` at `from_s`, without the fixes with the numbers `without`. The second
/// value lists the numbers of the other fixes.
fn stepped(start_s: f64, from_s: f64, by_s: f64, without: [usize; 2]) -> (Flight, Vec<usize>) {
    let mut flight = Flight::at_rest(start_s);
    let step = |time_s: &mut f64| *time_s += if *time_s >= from_s { by_s } else { 0.0 };
    flight.samples_s.iter_mut().for_each(step);
    let is_in_outage = |number: usize| (without[0]..without[1]).contains(&number);
    for (number, row) in flight.fixes.iter_mut().enumerate() {
        step(&mut row.time_s);
        row.has_fix = !is_in_outage(number);
    }
    (flight, (0..20).filter(|&number| !is_in_outage(number)).collect())
}

#[test]
fn fixes_follow_the_samples_over_a_step_shorter_than_their_intervals() {
    for (back_s, without) in [
        (1.3, [0, 0]),
        (2.0, [0, 0]),
        (3.5, [0, 0]),
        (4.5, [0, 0]),
        // The clock steps within an outage, or before the first fix.
        (2.0, [8, 14]),
        (3.5, [8, 16]),
        (6.0, [7, 16]),
        (2.0, [0, 14]),
        (6.0, [0, 12]),
    ] {
        let (flight, fixes) = stepped(100.0, 110.5, -back_s, without);
        for format in FORMATS {
            let what = format!("{format}, back by {back_s} s, no fixes {without:?}");
            are_together(&written(&flight, format).read(), &fixes, &what);
        }
    }
}

#[test]
fn fixes_follow_the_samples_over_the_end_of_a_counter_in_an_outage() {
    for (start_s, period_s) in
        [(4_285.0, 4_294.967_296), (55.0, 65.536), (604_790.0, 604_800.0), (86_390.0, 86_400.0)]
    {
        for without in [[8, 14], [0, 14]] {
            let (flight, fixes) = stepped(start_s, period_s, -period_s, without);
            for format in FORMATS {
                let what = format!("{format}, {period_s} s, no fixes {without:?}");
                are_together(&written(&flight, format).read(), &fixes, &what);
            }
        }
    }
}

#[test]
fn a_receiver_whose_clock_goes_on_only_gets_the_gap() {
    for back_s in [2.0, 7.0] {
        let (mut flight, _) = stepped(100.0, 110.5, -back_s, [0, 0]);
        flight.fixes = Flight::at_rest(100.0).fixes;
        for format in FORMATS {
            let dataset = written(&flight, format).read();
            let length_s = dataset.fixes[19].time - dataset.fixes[0].time;
            assert!((length_s - 24.0).abs() < 0.01, "{format}, back by {back_s} s: {length_s} s");
        }
    }
}

#[test]
fn a_step_forward_of_one_sensor_alone_is_named_and_corrected_in_every_format() {
    let steady = Flight::at_rest(100.0);
    for by_s in [3.0, 9.0] {
        let (both, all) = stepped(100.0, 110.5, by_s, [0, 0]);
        let samples = Flight { fixes: steady.fixes.clone(), ..both.clone() };
        let fixes = Flight { fixes: both.fixes.clone(), ..steady.clone() };
        for (flight, expected) in [
            (&samples, format!("the clock of the first sensor goes forward by {by_s:.2}")),
            (&fixes, format!("the clock goes forward by {by_s:.3} s")),
            (&both, String::new()),
            (&steady, String::new()),
        ] {
            for format in FORMATS {
                let dataset = written(flight, format).read();
                let is_named = warns(&dataset, "forward by");
                assert_eq!(is_named, !expected.is_empty(), "{format}: {:?}", dataset.warnings);
                assert!(
                    !is_named || warns(&dataset, &expected),
                    "{format}: {:?}",
                    dataset.warnings
                );
                are_together(&dataset, &all, &format!("{format}, {expected}"));
            }
        }
    }
}

#[test]
fn a_pause_of_one_sensor_is_no_step_of_its_clock() {
    let steady = Flight::at_rest(100.0);
    let mut samples = steady.clone();
    samples.samples_s.drain(500..650);
    let mut fixes = steady;
    fixes.fixes[8..12].iter_mut().for_each(|row| row.has_fix = false);
    for (flight, ends_s) in [(samples, [19.98, 19.01]), (fixes, [19.98, 19.01])] {
        // Tables and text keep the rows of the sensors apart. In logs the fixes would be written with later samples.
        for format in ["dataset", "text"] {
            let dataset = written(&flight, format).read();
            let (imu, fixes) = (&dataset.imu, &dataset.fixes);
            let start = imu[0].time;
            let found = [imu[imu.len() - 1].time - start, fixes[fixes.len() - 1].time - start];
            let is_near = |(found, expected): (f64, f64)| (found - expected).abs() < 1.1;
            assert!(found.into_iter().zip(ends_s).all(is_near), "{format}: {found:?} s");
            assert!(!warns(&dataset, "forward by"), "{format}: {:?}", dataset.warnings);
        }
    }
}

#[test]
fn steps_below_a_second_are_breaks_too() {
    for back_s in [0.9, 0.5] {
        let (flight, fixes) = stepped(100.0, 110.5, -back_s, [0, 0]);
        for format in FORMATS {
            let dataset = written(&flight, format).read();
            are_together(&dataset, &fixes, &format!("{format}, back by {back_s} s"));
            assert!(warns(&dataset, "the clock goes back by"), "{format}: {:?}", dataset.warnings);
        }
    }
}

#[test]
fn blocks_of_samples_written_in_the_wrong_order_are_sorted_in_every_format() {
    let steady = Flight::at_rest(100.0);
    let mut flight = steady.clone();
    flight.samples_s[300..600].rotate_left(150);
    for format in FORMATS {
        let dataset = written(&flight, format).read();
        let expected = written(&steady, format).read();
        let times = |dataset: &Dataset| dataset.imu.iter().map(|one| one.time).collect::<Vec<_>>();
        assert_eq!(times(&dataset), times(&expected), "{format}: {:?}", dataset.warnings);
        assert!(warns(&dataset, "written late"), "{format}: {:?}", dataset.warnings);
        assert!(!warns(&dataset, "the clock"), "{format}: {:?}", dataset.warnings);
    }
}

#[test]
fn a_clock_that_steps_back_is_a_named_break_in_every_format() {
    let mut flight = Flight::at_rest(100.0);
    let back = |time_s: &mut f64| *time_s -= if *time_s > 110.0 { 7.0 } else { 0.0 };
    flight.samples_s.iter_mut().for_each(back);
    flight.fixes.iter_mut().for_each(|row| back(&mut row.time_s));
    for format in FORMATS {
        let dataset = written(&flight, format).read();
        assert_eq!(
            (dataset.imu.len(), dataset.fixes.len()),
            (1000, 20),
            "{format}: {:?}",
            dataset.warnings
        );
        let intervals_s = dataset.imu.windows(2).map(|pair| pair[1].time - pair[0].time);
        let longest_s = intervals_s.fold(0.0, f64::max);
        assert!((longest_s - 5.0).abs() < 0.05, "{format}: {longest_s}");
        assert!(warns(&dataset, "the clock goes back by 6.98"), "{format}: {:?}", dataset.warnings);
        // The fixes are still at the times of their samples.
        let apart_s = dataset.fixes[15].time - dataset.imu[750].time;
        assert!(apart_s.abs() < 0.15, "{format}: {apart_s}");
    }
}

#[test]
fn counters_that_start_again_continue_in_every_format() {
    for (start_s, period_s, name) in [
        (4_285.0, 4_294.967_296, "2^32 µs"),
        (55.0, 65.536, "2^16 ms"),
        (604_790.0, 604_800.0, "a week"),
        (86_390.0, 86_400.0, "a day"),
    ] {
        let mut flight = Flight::at_rest(start_s);
        let wrapped =
            |time_s: &mut f64| *time_s -= if *time_s >= period_s { period_s } else { 0.0 };
        flight.samples_s.iter_mut().for_each(wrapped);
        flight.fixes.iter_mut().for_each(|row| wrapped(&mut row.time_s));
        for format in FORMATS {
            let dataset = written(&flight, format).read();
            let (imu, fixes) = (&dataset.imu, &dataset.fixes);
            assert_eq!(
                (imu.len(), fixes.len()),
                (1000, 20),
                "{format} {name}: {:?}",
                dataset.warnings
            );
            let length_s = imu[999].time - imu[0].time;
            assert!((length_s - 19.98).abs() < 0.01, "{format} {name}: {length_s}");
            assert!((fixes[19].time - fixes[0].time - 19.0).abs() < 0.01, "{format} {name}");
            assert!(warns(&dataset, name), "{format} {name}: {:?}", dataset.warnings);
        }
    }
}

#[test]
fn fixes_of_a_capture_follow_the_samples_over_a_step_of_both_clocks() {
    /// 10:00 on 7 January 2024, s since 1970.
    const START_S: u32 = 1_704_585_600 + 36_000;
    let stepped = |since: f64| if since > 39.9 { since - 20.0 } else { since };
    let (mut imu, mut nmea) = (String::from("time_s,gx,gy,gz,ax,ay,az\n"), String::new());
    for k in 0..4000_u32 {
        let time_s = f64::from(START_S) + stepped(0.02 * f64::from(k));
        writeln!(imu, "{time_s:.3},0.001,0,0.0{},0.01,0,-9.81", k % 7).unwrap();
        if k % 50 == 0 {
            let since = stepped(f64::from(k / 50)) as u32;
            let clock = format!("10{:02}{:02}.00", since / 60, since % 60);
            for body in [
                format!("GPRMC,{clock},A,4700.{:04},N,00800.0000,E,1.0,0.0,070124,,,A", k / 50),
                format!("GPGGA,{clock},4700.{:04},N,00800.0000,E,1,08,1.0,400.0,M,0.0,M,,", k / 50),
            ] {
                let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
                write!(nmea, "${body}*{sum:02X}\r\n").unwrap();
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let files = [folder.path().join("imu.csv"), folder.path().join("gps.nmea")];
    fs::write(&files[0], imu).unwrap();
    fs::write(&files[1], nmea).unwrap();
    let map = folder.path().join("map");
    Proposal::of(&files).unwrap().write(&map, true).unwrap();
    let dataset = open(&map, &Options::default()).unwrap().dataset;
    let counts = (dataset.imu.len(), dataset.fixes.len());
    assert_eq!(counts, (4000, 80), "{:?}", dataset.warnings);
    for (number, fix) in dataset.fixes.iter().enumerate() {
        let apart_s = fix.time - dataset.imu[50 * number].time;
        assert!(apart_s.abs() < 0.2, "fix {number}: {apart_s} s, {:?}", dataset.warnings);
    }
}
