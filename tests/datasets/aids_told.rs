//! Findings for an additional sensor that pauses, ends early, begins late, repeats its values or uses another unit.

use hovernav::earth::Geodetic;
use hovernav::event::RangeReading;
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_findings::{Finding, FindingKind, Sensor, check_setup, findings};
use hovernav_replay::estimate;
use hovernav_sim::{
    BaroConfig, DmuConfig, FlightPlan, GpsConfig, SimulatedBaro, fly, sensor_manifest,
};

/// Three minutes of hover with four climbs and descents of 20 m, with a barometer at 10 Hz and a separate
/// magnetometer.
fn flight(seed: u64) -> Dataset {
    let start = Geodetic::from_degrees(1.352, 103.82, 50.0).unwrap();
    let mut plan = FlightPlan::hover_at(start, 0.7).hold(30.0);
    for _ in 0..2 {
        plan = plan.climb(20.0, 1.5).hold(15.0).climb(-20.0, 1.5).hold(15.0);
    }
    let plan = plan.hold(30.0);
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let recording = fly(&plan.build().unwrap(), &dmu, &gps, seed).unwrap();
    let mut baro = SimulatedBaro::new(&BaroConfig::default(), seed).unwrap();
    let every_third = recording.truth.iter().step_by(3);
    let magnetometer =
        recording.imu.iter().filter_map(|sample| Some((sample.time, sample.magnetic_field_gauss?)));
    Dataset {
        manifest: sensor_manifest("simulated".into(), &dmu, &gps),
        baro: every_third.map(|at| (at.time, baro.measure(at.position.height_m))).collect(),
        magnetometer: magnetometer.collect(),
        imu: recording.imu,
        fixes: recording.fixes,
        ..Dataset::default()
    }
}

/// The warnings of a run over `dataset` about `sensor`.
fn warnings(dataset: &mut Dataset, sensor: Sensor) -> Vec<Finding> {
    let config = dataset.settings().unwrap();
    let run = estimate(dataset, &config, |_| {});
    let mut found = findings(dataset, &run);
    found.retain(|finding| finding.is_warning() && finding.sensor == sensor);
    found
}

fn is_within(time: Time, from_s: f64, to_s: f64) -> bool {
    (from_s..to_s).contains(&time.seconds())
}

#[track_caller]
fn assert_told(found: &[Finding], kind: FindingKind, from_s: f64, to_s: f64, words: &str) {
    let is_it = |finding: &&Finding| {
        finding.kind == kind
            && (finding.start_s - from_s).abs() < 2.0
            && (finding.end_s - to_s).abs() < 2.0
    };
    let Some(finding) = found.iter().find(is_it) else { panic!("{found:?}") };
    assert!(finding.words.contains(words), "{}", finding.words);
}

#[test]
fn a_pause_an_early_end_and_a_late_start_of_an_aid_are_reported_with_their_span() {
    let end_s = flight(1).imu.last().unwrap().time.seconds();
    for (from_s, to_s, cause) in
        [(60.0, 90.0, "paused"), (100.0, 999.0, "until the end of the log"), (-1.0, 60.0, "late")]
    {
        let mut dataset = flight(1);
        let start_s = if from_s < 0.0 { 3.0 } else { from_s };
        dataset.baro.retain(|(time, _)| !is_within(*time, from_s, to_s));
        dataset.magnetometer.retain(|(time, _)| !is_within(*time, from_s, to_s));
        for sample in dataset.imu.iter_mut().filter(|at| is_within(at.time, from_s, to_s)) {
            sample.attitude = None;
        }
        for sensor in [Sensor::Barometer, Sensor::Magnetometer, Sensor::InertialUnit] {
            let found = warnings(&mut dataset, sensor);
            assert_told(&found, FindingKind::ReadingsAbsent, start_s, to_s.min(end_s), cause);
        }
    }
}

#[test]
fn short_pauses_and_gaps_of_the_whole_log_are_no_fault_of_an_aid() {
    let mut dataset = flight(1);
    dataset.baro.retain(|(time, _)| !is_within(*time, 60.0, 64.0));
    assert!(warnings(&mut dataset, Sensor::Barometer).is_empty());
    let mut dataset = flight(1);
    dataset.baro.retain(|(time, _)| !is_within(*time, 60.0, 70.0));
    dataset.imu.retain(|sample| !is_within(sample.time, 60.0, 70.0));
    let found = warnings(&mut dataset, Sensor::Barometer);
    assert!(found.iter().all(|finding| finding.kind != FindingKind::ReadingsAbsent), "{found:?}");
}

#[test]
fn a_rangefinder_above_its_reach_is_no_fault_and_one_that_stops_within_it_is() {
    let start_m = 50.0;
    for (reach_m, stops_s, is_told) in
        [(15.0, 999.0, false), (999.0, 999.0, false), (999.0, 60.0, true)]
    {
        let mut dataset = flight(1);
        let heights = dataset.baro.iter().map(|(time, height_m)| (*time, height_m - start_m + 5.0));
        let seen = heights.filter(|(time, range_m)| {
            (0.3..reach_m).contains(range_m) && is_within(*time, 0.0, stops_s)
        });
        let reading =
            |(time, range_m)| RangeReading { time, range_m, sigma_m: None, quality: None };
        dataset.ranges = seen.map(reading).collect();
        dataset.baro.clear();
        let found = warnings(&mut dataset, Sensor::Rangefinder);
        let is_absent = found.iter().any(|finding| finding.kind == FindingKind::ReadingsAbsent);
        assert_eq!(is_absent, is_told, "{reach_m} m, until {stops_s} s: {found:?}");
    }
}

#[test]
fn a_barometer_that_freezes_in_a_climb_is_reported_and_a_coarse_one_is_not() {
    for seed in 1..4 {
        let mut dataset = flight(seed);
        let held = dataset.baro.iter().find(|(time, _)| time.seconds() > 40.0).unwrap().1;
        for (_, height_m) in dataset.baro.iter_mut().filter(|at| is_within(at.0, 40.0, 70.0)) {
            *height_m = held;
        }
        let found = warnings(&mut dataset, Sensor::Barometer);
        assert_told(&found, FindingKind::BarometerFrozen, 40.0, 70.0, "repeat");
        for resolution_m in [0.1, 0.5, 1.0] {
            let mut dataset = flight(seed);
            for (_, height_m) in &mut dataset.baro {
                *height_m = (*height_m / resolution_m).round() * resolution_m;
            }
            let found = warnings(&mut dataset, Sensor::Barometer);
            assert!(found.is_empty(), "seed {seed}, {resolution_m} m: {found:?}");
        }
    }
}

#[test]
fn a_barometer_in_another_unit_or_of_the_wrong_sign_is_named_where_the_vehicle_climbs() {
    let hectopascal = |height_m: f64| 1013.25 - height_m / 8.4;
    let causes: [(&dyn Fn(f64) -> f64, &str); 4] = [
        (&|height_m| height_m / 0.3048, "feet"),
        (&|height_m| 300.0 - height_m, "counts downwards"),
        (&|height_m| 100.0 * height_m, "centimetres"),
        (&hectopascal, "hPa"),
    ];
    for seed in 1..6 {
        let sound = flight(seed);
        let found = check_setup(&sound);
        assert!(found.iter().all(|finding| finding.sensor != Sensor::Barometer), "{found:?}");
        for (wrong, cause) in causes {
            let mut dataset = sound.clone();
            dataset.baro.iter_mut().for_each(|(_, height_m)| *height_m = wrong(*height_m));
            let found = check_setup(&dataset);
            let named = found.iter().find(|finding| finding.sensor == Sensor::Barometer);
            let Some(finding) = named else { panic!("seed {seed}, {cause}: {found:?}") };
            assert!(finding.cause.contains(cause) && finding.is_certain, "{finding}");
        }
    }
}
