//! A layout without the states of absent sensors gives the same results as the full one.

use std::path::Path;

use hovernav::ekf::layout::{Full, Layout, WithoutHeightAids};
use hovernav::ekf::{Aid, Estimator, EstimatorConfig, Notice, Solution, Unusable};
use hovernav::event::{BaroReading, Event};
use hovernav_dataset::Dataset;
use hovernav_sim::faults::{Fault, Log};

/// `heli-hover` with these faults: its events and settings.
fn flight(faults: &[&str]) -> (Vec<Event>, EstimatorConfig) {
    let log = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let faults: Vec<Fault> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    let dir = tempfile::tempdir().unwrap();
    Log::open(log).unwrap().with_faults(&faults, 3).unwrap().write(dir.path()).unwrap();
    let mut dataset = Dataset::open(dir.path()).unwrap();
    let config = dataset.settings().unwrap();
    (dataset.events().collect(), config)
}

fn solutions<L: Layout<N>, const N: usize>(
    events: &[Event],
    config: &EstimatorConfig,
) -> Vec<Solution> {
    let mut estimator = Box::new(Estimator::<L, N>::with_layout(*config));
    let mut solutions = Vec::new();
    for event in events {
        estimator.push(event, |_| {});
        if matches!(event, Event::Imu(_)) {
            solutions.extend(estimator.solution());
        }
    }
    solutions
}

/// All numbers of a solution as text that differs if one bit does.
fn words(solution: &Solution) -> String {
    format!("{solution:?}")
}

#[track_caller]
fn assert_alike(faults: &[&str], with_attitude: bool) {
    let (events, mut config) = flight(faults);
    config.aiding.attitude = with_attitude;
    config.aiding.magnetometer = with_attitude;
    let full = solutions::<Full, 28>(&events, &config);
    let lean = solutions::<WithoutHeightAids, 26>(&events, &config);
    assert!(full.len() > 1_000, "{} solutions", full.len());
    assert_eq!(full.len(), lean.len());
    for (full, lean) in full.iter().zip(&lean) {
        assert_eq!(words(full), words(lean));
    }
}

#[test]
fn without_height_aids_a_flight_comes_to_the_same_bits() {
    assert_alike(&[], true);
}

#[test]
fn gaps_outages_glitches_and_blows_come_to_the_same_bits() {
    assert_alike(&["gap=3@60", "outage@120:20", "glitch-step=60@200:15", "clip-burst@250:1"], true);
}

#[test]
fn a_heading_that_is_searched_for_comes_to_the_same_bits() {
    assert_alike(&[], false);
}

#[test]
fn a_height_of_a_barometer_is_refused_aloud_where_there_is_no_state_for_it() {
    let (events, config) = flight(&[]);
    let mut estimator = Box::new(Estimator::<WithoutHeightAids, 26>::with_layout(config));
    let mut refused = 0;
    for event in &events[..3_000] {
        estimator.push(event, |_| {});
        if let Event::Imu(sample) = event {
            let baro = Event::Baro(BaroReading::new(sample.time, 100.0));
            estimator.push(&baro, |notice| {
                refused += usize::from(matches!(
                    notice,
                    Notice::NotUsed { aid: Aid::Baro, reason: Unusable::NoState, .. }
                ));
            });
        }
    }
    assert!(refused > 100, "{refused}");
}
