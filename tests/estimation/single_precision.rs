//! Accuracy of the filter in `f32`, compared with the filter in `f64`.

use std::path::Path;

use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig, Solution};
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::imu::{ImuErrors, ImuSample, Motion};
use hovernav::ins::{Integrator, NavState};
use hovernav::scalar::Scalar;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, Outage, Reference};
use hovernav_score::{Axis, outage_drift, score};
use hovernav_testing::shared;

/// Axes whose errors `docs/embedded.md` compares.
const AXES: [Axis; 7] = [
    Axis::VelocityNorth,
    Axis::VelocityEast,
    Axis::VelocityDown,
    Axis::Roll,
    Axis::Pitch,
    Axis::Yaw,
    Axis::Horizontal,
];

fn solutions<T: Scalar>(dataset: &Dataset, config: &EstimatorConfig) -> Vec<Solution> {
    let mut estimator = Box::new(Estimator::<Full, 28, T>::with_layout(*config));
    let mut solutions = Vec::with_capacity(dataset.imu.len());
    for event in dataset.events() {
        estimator.push(&event, |_| {});
        if matches!(event, Event::Imu(_)) {
            solutions.extend(estimator.solution().map(|solution| solution.cast()));
        }
    }
    solutions
}

/// Root mean square errors of [`AXES`] from `start` on, and the median drift over the outages, m.
fn errors(
    solutions: &[Solution],
    reference: &Reference,
    start: Time,
    outages: &[Outage],
) -> [Option<f64>; AXES.len() + 1] {
    let scored = &solutions[solutions.partition_point(|solution| solution.time < start)..];
    let found = score(scored, reference, start);
    let mut errors = [None; AXES.len() + 1];
    for (error, axis) in errors.iter_mut().zip(AXES) {
        *error = found.axis(axis).map(|axis| axis.statistics.rmse);
    }
    let drifts = outages
        .iter()
        .filter_map(|outage| outage_drift(solutions, reference, outage.start, outage.duration_s));
    let drifts: Vec<f64> = drifts.collect();
    errors[AXES.len()] = hovernav_score::Statistics::of(&drifts).map(|drifts| drifts.median);
    errors
}

/// Dataset, and outages of a given number of seconds from the given times on.
const SETS: [(&str, f64, &[f64]); 10] = [
    ("heli-hover", 0.0, &[]),
    ("car-rtk", 15.0, &[100.0, 143.0, 186.0, 229.0, 272.0, 315.0, 358.0, 401.0, 444.0, 487.0]),
    ("car-rtk", 30.0, &[113.0, 188.0, 263.0, 338.0, 413.0, 488.0]),
    (
        "uav-thor75-1hz",
        10.0,
        &[240.0, 278.0, 316.0, 354.0, 392.0, 430.0, 468.0, 506.0, 544.0, 582.0, 620.0, 658.0],
    ),
    ("quad-p4rtk-vibration", 10.0, &[200.0, 220.0, 240.0, 260.0, 280.0, 300.0, 320.0, 340.0]),
    ("uav-thor75-1hz", 0.0, &[]),
    ("quad-hover-aided", 0.0, &[]),
    ("quad-gps-glitch", 0.0, &[]),
    ("quad-gps-glitch-aided", 0.0, &[]),
    ("quad-ardupilot-5hz", 0.0, &[]),
];

#[test]
fn single_precision_is_as_accurate_as_double_on_every_known_flight() {
    for (name, duration_s, starts) in SETS {
        let own = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets")).join(name);
        let own = own.exists().then_some(own);
        let Some(path) = own.or_else(|| shared(format!("datasets/{name}"))) else { continue };
        let mut dataset = Dataset::open(&path).unwrap();
        let config = dataset.settings().unwrap();
        let starts = starts.iter().filter_map(|&start| Time::try_from_seconds(start));
        let outages: Vec<Outage> = starts.map(|start| Outage { start, duration_s }).collect();
        dataset.withhold(&outages, None);
        let reference = Reference::open(&path, &dataset.manifest).unwrap().unwrap();
        let double = solutions::<f64>(&dataset, &config);
        let single = solutions::<f32>(&dataset, &config);
        assert_eq!(double.len(), single.len(), "{name}");
        // The evaluation starts when both solutions have the heading. Before it is found at rest, either solution may
        // have any heading.
        let first = dataset.imu[0].time;
        let starts = [&double, &single]
            .map(|solutions| score(solutions, &reference, first).heading_known.unwrap_or(first));
        let start = starts[0].max(starts[1]);
        let double = errors(&double, &reference, start, &outages);
        let single = errors(&single, &reference, start, &outages);
        let row = |errors: &[Option<f64>]| -> String {
            errors.iter().map(|error| error.map_or("| ".into(), |e| format!("| {e:.3} "))).collect()
        };
        println!("| {name}, {} x {duration_s} s | f64 {}|", outages.len(), row(&double));
        println!("| | f32 {}|", row(&single));
        for (single, double) in single.into_iter().zip(double) {
            let (single, double) = (single.unwrap_or(0.0), double.unwrap_or(0.0));
            assert!((single - double).abs() <= 0.02 * double + 1e-3, "{name}: {single} {double}");
        }
    }
}

/// An hour of turning flight with strapdown navigation alone; returns the final state.
fn flown<T: Scalar>(rate_hz: i64) -> NavState {
    let start: NavState = NavState {
        time: Time::ZERO,
        position: Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap(),
        velocity_mps: Vector::new(12.0, 0.0, 0.0),
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(7.0, 2.0, 0.0)),
    };
    let mut state = start.cast::<T>();
    let mut integrator = Integrator::<T>::default();
    for k in 0..=3600 * rate_hz {
        let t = k as f64 / rate_hz as f64;
        let (fast, slow) = ((40.0 * t).sin(), (0.7 * t).sin());
        let sample = ImuSample::new(
            Time::ZERO + t,
            Motion::Rates {
                angular_rate_radps: Vector::new(0.05 * fast, 0.03 * slow, 0.1 + 0.04 * fast),
                specific_force_mps2: Vector::new(0.4 * slow, 0.3 * fast, -9.82 + 2.0 * fast),
            },
        );
        if let Some(increment) = integrator.push(&sample, &ImuErrors::default()) {
            state.advance(sample.time, &increment);
        }
    }
    state.cast()
}

/// Final position after an hour at 12 m/s north and 9 m/s east, in steps of the given rate.
fn carried<T: Scalar>(rate_hz: u32) -> Geodetic {
    let travel_m = Vector::new(12.0, 9.0, -0.01).cast::<T>() * T::of(1.0 / f64::from(rate_hz));
    (0..3600 * rate_hz).fold(Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap(), |place, _| {
        LocalEarth::<T>::about(&place).carried(&place, travel_m)
    })
}

#[test]
fn a_position_that_single_precision_adds_to_for_an_hour_is_millimetres_off() {
    for rate_hz in [33, 200] {
        let off_m = carried::<f32>(rate_hz).displacement_from(&carried::<f64>(rate_hz));
        println!("{rate_hz} Hz: {off_m:?} m after 54 km");
        assert!(off_m.norm() < 0.01, "{rate_hz} Hz: {off_m:?} m");
    }
}

/// An hour without fixes: rounding acts like a gyro drift of 0.01 and 0.3°/h.
#[test]
fn an_hour_of_strapdown_in_single_precision_drifts_far_less_than_any_unit() {
    for (rate_hz, max_deg) in [(33, 0.02), (200, 0.5)] {
        let (single, double) = (flown::<f32>(rate_hz), flown::<f64>(rate_hz));
        let off_m = single.position.displacement_from(&double.position);
        let off = (single.body_to_ned * double.body_to_ned.inverse()).rotation_vector();
        let off_deg = off.norm().to_degrees();
        println!("{rate_hz} Hz: {off_deg:.4}°, {off_m:?} m");
        assert!(off_deg < max_deg, "{rate_hz} Hz: {off_deg}°");
    }
}
