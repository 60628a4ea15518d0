//! A recorded flight through the estimator, and its errors.
//!
//! `cargo run --release --example 01_estimate_a_log`

use std::error::Error;
use std::path::Path;

use hovernav_dataset::{Dataset, Reference};
use hovernav_replay::estimate;
use hovernav_score::{Axis, score};

/// Axes that are compared with the reference of the dataset; the estimator never reads it.
const AXES: [Axis; 3] = [Axis::VelocityNorth, Axis::VelocityEast, Axis::VelocityDown];

/// Root mean square error of the velocity north, east and down, m/s.
fn velocity_errors(log: &Path) -> Result<[f64; 3], Box<dyn Error>> {
    let mut dataset = Dataset::open(log)?;
    let config = dataset.settings()?;
    let run = estimate(&dataset, &config, |_| {});

    let reference = Reference::open(log, &dataset.manifest)?.ok_or("the log has no reference")?;
    let first = dataset.imu.first().ok_or("the log has no inertial samples")?.time;
    let score = score(&run.solutions, &reference, first);
    Ok(AXES.map(|axis| score.axis(axis).map_or(f64::NAN, |score| score.statistics.rmse)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let log = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover");
    let [north, east, down] = velocity_errors(log.as_ref())?;
    println!("velocity error: north {north:.3}, east {east:.3}, down {down:.3} m/s");
    Ok(())
}

#[test]
fn the_velocity_is_as_good_as_the_readme_says() {
    let log = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover");
    let errors = velocity_errors(log.as_ref()).unwrap();
    for (error, limit) in errors.into_iter().zip([0.080, 0.085, 0.11]) {
        assert!(error <= limit, "{errors:?}");
    }
}
