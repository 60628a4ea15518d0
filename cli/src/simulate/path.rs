//! A path flown exactly, and what the sensors say of it.

use std::path::Path;
use std::time::Instant;

use hovernav_log::Dataset;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, MagnetometerConfig, sensor_manifest};
use serde_json::json;

use super::arguments::{Arguments, FlightPath, OUT};

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
    let dataset = Dataset {
        manifest: sensor_manifest(vehicle, &dmu, &gps),
        imu: recording.imu,
        fixes: recording.fixes,
        ..Dataset::default()
    };
    dataset.write(&out, &recording.truth)?;
    write_summary(&out.join("summary.json"), &dataset, started)?;
    crate::output::say(format_args!(
        "{}: {:.0} s, {} inertial samples, {} fixes, seed {}",
        out.display(),
        plan.duration_s(),
        dataset.imu.len(),
        dataset.fixes.len(),
        arguments.seed
    ));
    Ok(())
}

fn write_summary(path: &Path, dataset: &Dataset, started: Instant) -> anyhow::Result<()> {
    let duration_s = match (dataset.imu.first(), dataset.imu.last()) {
        (Some(first), Some(last)) => last.time - first.time,
        _ => 0.0,
    };
    let summary = json!({
        "tool": "hovernav",
        "version": env!("CARGO_PKG_VERSION"),
        "input": dataset.manifest.vehicle,
        "duration_s": duration_s,
        "wall_s": started.elapsed().as_secs_f64(),
        "imu_samples": dataset.imu.len(),
        "gps_fixes_used": dataset.fixes.len(),
        "gps_fixes_rejected": 0,
    });
    crate::output::write_json(&summary, path)
}
