//! A prescribed path, and the measurements of the sensors on it.

use std::time::Instant;

use hovernav_dataset::Dataset;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, MagnetometerConfig, sensor_manifest};

use super::arguments::{Arguments, FlightPath, OUT};
use super::estimate::Estimate;
use crate::output;

pub fn run(arguments: &Arguments, flight: FlightPath) -> anyhow::Result<()> {
    let started = Instant::now();
    let out = arguments.out.clone().unwrap_or_else(|| OUT.into());
    let (start, heading_rad) = (arguments.place, arguments.heading.to_radians());
    let plan = match flight {
        FlightPath::Hover => FlightPlan::hover_at(start, heading_rad).hold(300.0),
        FlightPath::TestPoints => {
            FlightPlan::hover_at(start, heading_rad).hold(30.0).test_points().hold(10.0)
        }
        FlightPath::Tour => FlightPlan::test_flight(start, heading_rad),
    };
    let magnetometer = Some(MagnetometerConfig::at(&start));
    let (dmu, gps) = (DmuConfig { magnetometer, ..DmuConfig::default() }, GpsConfig::default());
    let recording = hovernav_sim::fly(&plan.build()?, &dmu, &gps, arguments.seed)?;

    let vehicle = format!("simulated helicopter, thesis-grade sensors, seed {}", arguments.seed);
    let mut dataset = Dataset {
        manifest: sensor_manifest(vehicle, &dmu, &gps),
        imu: recording.imu,
        fixes: recording.fixes,
        ..Dataset::default()
    };
    dataset.write(&out, &recording.truth)?;
    let mut estimate = Estimate::of(&mut dataset, &out, |_| ())?;
    if arguments.no_report {
        output::remove_stale(&out, [output::REPORT]);
    } else {
        estimate.write_page("Simulated flight on a path", &dataset, &out)?;
    }
    estimate.summary.wall_s = started.elapsed().as_secs_f64();
    output::write_json(&estimate.summary, &out.join("summary.json"))?;
    output::say(format_args!(
        "{}: {:.0} s, {} inertial samples, {} fixes, seed {}",
        out.display(),
        plan.duration_s(),
        dataset.imu.len(),
        dataset.fixes.len(),
        arguments.seed
    ));
    Ok(())
}
